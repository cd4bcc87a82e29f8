#![doc = include_str!("../README.md")]

mod confounding;
mod criterion;
mod design;
mod error;
mod evaluate;
mod file;
mod forbidden;
mod grid;
mod information;
mod levels;
mod matrix;
mod maximum;
mod measure;
mod model;
mod parameter;
mod polynomial;
mod products;
mod region;
mod search;
mod space;
mod split;
mod term;
mod variance;
mod wording;

pub use confounding::{Confounding, confounded_terms, confounded_terms_of_design};
pub use criterion::{Criterion, Efficiency, moment_matrix};
pub use design::Design;
pub use error::Error;
pub use evaluate::{
    Alias, Coefficient, Correlations, DegreesOfFreedom, Evaluation, EvaluationSettings, FractionOfSpace, Precision,
    Predictions, Sampling, VarianceSlice, evaluate,
};
pub use file::{DesignFile, FileFault, RunOrder};
pub use forbidden::Forbidden;
pub use grid::Grid;
pub use information::Information;
pub use levels::Levels;
pub use maximum::{Maximum, Method};
pub use model::Model;
pub use parameter::Parameter;
pub use region::Region;
pub use search::{
    Effort, Found, Problem, Progress, Replicates, Report, Settings, StopReason, Watch, search, search_watched,
};
pub use space::{Axis, Over, Space};
pub use split::{Split, SplitMethod, SplitSettings, split};
pub use term::Term;
pub use variance::PredictionVariance;
