//! `cargo xtask reproduce-chapter2`: dimensionless groups, Table 2 with its checks, Figures 11 and 12, the rig at full scale.

mod claims;
mod figures;
mod file;
mod findings;
mod full_scale;
mod models;
mod page;
mod run;
mod tables;

pub(crate) use run::CHAPTER;
