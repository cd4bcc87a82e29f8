//! Sections of the page that are the same for every method.

pub(crate) mod axes;
pub(crate) mod maps;
pub(crate) mod provenance;
pub(crate) mod sheets;
