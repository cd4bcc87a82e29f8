//! How far a corrected model can be from the truth, and what that says about a design: Section 5.4 and Chapter 6,
//! repaired and extended.

mod assumption;
mod bound;
mod certificate;
mod norm;

pub use assumption::{AssumptionReport, Growth};
pub use bound::{Amplification, Bound, ErrorLevels};
pub use certificate::{RegretCertificate, possible_optima};
pub use norm::{Norm, NormOrder, NormScaling, coded_cell_measure};
