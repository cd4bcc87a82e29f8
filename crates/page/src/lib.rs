#![doc = include_str!("../README.md")]

mod document;
mod error;
mod figures;
mod table;

pub use document::{Link, Page};
pub use error::Error;
pub use figures::{
    Axis, CellFigure, CellPanel, ColorScale, Group, Landscape, LineFigure, Panel, Path, Points, Reference, Series,
    Shaded, SpreadFigure, Summary, cell_figure, landscape_figure, landscape_panels_figure, line_figure, spread_figure,
};
pub use table::{Column, Table, write_columns_csv};
