#![doc = include_str!("../README.md")]

mod ascent;
mod confounding;
mod criterion;
mod design;
mod error;
mod evaluate;
mod file;
mod file_fault;
mod forbidden;
mod information;
mod lattice;
mod matrix;
mod maximum;
mod measure;
mod nested;
mod polynomial;
mod power;
mod products;
mod same;
mod search;
mod shape;
mod space;
mod split;
mod support;
mod variance;
mod wording;

pub use confounding::Confounding;
pub use criterion::{Criterion, Efficiency, moment_matrix};
pub use design::Design;
/// What a design is made of: parameters, regions, grids, models. The crate `design-space`, for those who need no more.
pub use design_space::Error as DesignSpaceError;
pub use design_space::{Cell, Grid, Levels, Model, Parameter, Region, Term};
pub use error::Error;
pub use evaluate::{
    Alias, Coefficient, Correlations, DegreesOfFreedom, Evaluation, EvaluationSettings, FractionOfSpace, Precision,
    Predictions, Sampling, VarianceSlice, evaluate,
};
pub use file::{DesignFile, RunOrder};
pub use file_fault::FileFault;
pub use forbidden::Forbidden;
pub use information::Information;
pub use maximum::{Maximum, Method};
pub use search::{
    Effort, Found, Problem, Progress, Replicates, Report, Settings, StopReason, Watch, polished, search, search_watched,
};
pub use shape::Axis;
pub use space::{Over, Space};
pub use split::{Split, SplitMethod, SplitSettings, split};
pub use support::{confounded_terms, confounded_terms_of_design};
pub use variance::PredictionVariance;
