//! What experiments add to a model.
//!
//! | equation | home |
//! |---|---|
//! | (27), a plane around an optimum | `local`: [`Form`], [`Local`] |
//! | (35), the corrected model | `model` |
//! | (36), (45), (46), (47), how the correction grows from batch to batch | `law`: [`Law`], [`Rule`], [`ModelStage`] |
//!
//! [`Gain`] is the k of these laws, [`Coefficients`] the combination of surfaces that a law comes to, and [`Field`] the
//! same as a recursion over values at points.

mod coefficients;
mod field;
mod gain;
mod law;
mod local;
#[cfg(feature = "global")]
mod model;

pub use coefficients::Coefficients;
pub use field::Field;
pub use gain::Gain;
pub use law::{Law, ModelStage, Rule};
pub(crate) use local::Slopes;
pub use local::{Form, Local};
#[cfg(feature = "global")]
pub(crate) use model::{corrected_model, correction};
