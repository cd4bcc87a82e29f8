//! `cargo xtask reproduce-chapter7`: Tables 5 and 6 and Figures 23, 24, 26 to 28, the loop of Chapter 5 over two and over
//! four parameters; and what the wrong choices cost.

mod alone;
mod both_loops;
mod campaigns;
mod claims;
mod figures;
mod file;
mod findings;
mod flights;
mod kept;
mod leak;
mod optima;
mod page;
mod pooled;
mod run;
mod tables;
mod wrong;

#[cfg(feature = "ensemble")]
pub(crate) use file::Case;
#[cfg(any(feature = "ensemble", feature = "benchmark"))]
pub(crate) use file::Setup;
#[cfg(feature = "calibration")]
pub(crate) use file::table_6;
pub(crate) use run::CHAPTER;
