//! `cargo xtask reproduce-chapter3`: Figure 14, the open-loop cost over trim pitch and center of mass.

mod claims;
mod figures;
mod file;
mod findings;
#[cfg(feature = "global")]
mod kept;
mod page;
mod panels;
mod run;
mod tables;

#[cfg(feature = "ensemble")]
pub(crate) use claims::MATTERS;
#[cfg(feature = "ensemble")]
pub(crate) use file::Setup;
#[cfg(feature = "ensemble")]
pub(crate) use findings::is_allowed;
#[cfg(feature = "ensemble")]
pub(crate) use panels::PanelFlights;
pub(crate) use run::CHAPTER;
