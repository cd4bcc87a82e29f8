//! Study files: read by one reader, made of the same entries in every chapter.

mod checks;
mod entries;
mod reader;

#[cfg(feature = "global")]
pub(crate) use checks::{check_labels, check_seeds, check_share};
pub(crate) use checks::{check_not_empty, check_positive};
#[cfg(feature = "similarity")]
pub(crate) use entries::NamedText;
#[cfg(feature = "global")]
pub(crate) use entries::{BatchEntry, ParameterEntry};
pub(crate) use entries::{FilesEntry, NoiseEntry, NumericsEntry};
pub(crate) use reader::read;
#[cfg(test)]
pub(crate) use reader::{assert_refused, read_changed};
