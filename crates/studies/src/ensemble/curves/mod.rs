//! Figures 14, 21 and 26 over the ensemble: curves that no campaign of Chapters 4 and 7 gives.

mod claims;
mod figures;
mod fly;
mod kept;
mod tables;

pub(super) use claims::claims;
pub(super) use figures::{errors, headings, lowest};
pub(super) use fly::{fly_again, run};
pub(super) use kept::BIN_S;
pub(super) use tables::{
    errors as table_of_errors, fallen_in_words, headings as table_of_headings, lost_poses, lowest as table_of_lowest,
};
