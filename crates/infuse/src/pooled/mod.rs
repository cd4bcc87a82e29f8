//! The pooled loop: every experiment so far and the simulation in one surface, and a certificate of what may still be gained.

mod assessment;
mod campaign;
mod certificate;
mod designs;
mod first_batch;
mod knowledge;
mod knowledge_gradient;
mod pool;
mod recommendation;
mod settings;
mod simulated;
mod streams;

pub use assessment::{Assessment, Contradiction, Outlier, SimulationWorth, Standing};
pub use campaign::{Ask, Earlier, Loop, Record, StopReason, Trial};
pub use certificate::Certificate;
pub use settings::Settings;
pub use simulated::Simulate;
