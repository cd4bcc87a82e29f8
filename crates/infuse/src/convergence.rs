//! How the global loop corrects its model, how far the corrected model can be from the truth, and
//! what that says about a design: Section 5.4 and Chapter 6, repaired and extended.

mod assumption;
mod bound;
mod certificate;
mod coefficients;
mod field;
mod gain;
mod input;
mod law;
mod norm;

pub use assumption::{AssumptionReport, Growth};
pub use bound::{Amplification, Bound, ErrorLevels};
pub use certificate::{RegretCertificate, possible_optima};
pub use coefficients::Coefficients;
pub use field::CorrectedField;
pub use gain::Gain;
pub(crate) use input::check_not_negative;
pub use law::{CorrectionLaw, CorrectionRule, ModelStage};
pub use norm::{Norm, NormOrder, NormScaling, coded_cell_measure};
