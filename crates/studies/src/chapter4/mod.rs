//! `cargo xtask reproduce-chapter4`: Table 3 and Figures 15 to 18 from flights, beside the dissertation's own figures.

mod claims;
mod figures;
mod file;
mod findings;
mod lattice;
mod loops;
mod margins;
mod page;
mod rows;
mod run;
mod seeds;
mod tables;

#[cfg(any(feature = "identification", feature = "ensemble"))]
pub(crate) use file::Setup;
#[cfg(feature = "ensemble")]
pub(crate) use lattice::Lattice;
pub(crate) use run::CHAPTER;
