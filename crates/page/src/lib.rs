#![doc = include_str!("../README.md")]

mod document;
mod error;
mod figures;
mod finding;
mod table;
mod text;

pub use document::{Link, Page, findings_html, text_html};
pub use error::Error;
pub use figures::{
    Axis, Bands, CellFigure, CellPanel, Chart, ColorScale, CountFigure, Grid, Group, Key, Landscape, LineFigure,
    MapCell, Mark, Panel, Path, Points, Reference, Series, Shaded, SpreadFigure, StripFigure, Stroke, Summary,
    cell_figure, count_figure, landscape_figure, landscape_panels_figure, line_figure, palette, quantile,
    spread_figure, strip_figure,
};
pub use finding::{Finding, Number};
pub use table::{Column, Table, write_columns_csv};
