//! What experiments add to a model: linear around an optimum (27), or a surface over the design space (35), (36),
//! (45)–(47).

mod coefficients;
mod field;
mod gain;
mod law;
mod local;

pub use coefficients::Coefficients;
pub use field::CorrectedField;
pub use gain::Gain;
pub use law::{CorrectionLaw, CorrectionRule, ModelStage};
pub use local::{Correction, CorrectionForm};
