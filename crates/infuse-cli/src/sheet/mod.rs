//! Sheets: the experiments of a batch, as a table that goes to the rig and comes back.

mod book;
mod bounds;
mod cells;
mod columns;
mod decimal;
mod import;
mod read;
mod same;
mod table;
mod text;
mod workbook;
mod write;

pub(crate) use columns::point_columns;
pub(crate) use import::imported;
pub(crate) use read::{Answer, Answers, answers, setting_fault, sound_answers, to_fill_in, typed};
pub(crate) use same::check_same;
pub(crate) use table::{Fault, Row, Table, none_of};
pub(crate) use write::{check_ending, write};
