//! `cargo xtask reproduce-chapter6`: the study of Section 6.2 on a truth that is known, Figures 20 to 22.

mod all_levels;
mod campaigns;
mod claims;
mod figures;
mod file;
mod findings;
mod flights;
mod page;
mod run;
mod tables;

#[cfg(feature = "ensemble")]
pub(crate) use all_levels::AllLevels;
#[cfg(feature = "ensemble")]
pub(crate) use campaigns::{Campaigns, fly};
#[cfg(feature = "ensemble")]
pub(crate) use file::{Case, Setup};
pub(crate) use run::CHAPTER;
