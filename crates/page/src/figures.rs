//! Figures: plain data in, an SVG document out. They draw what they are given and know nothing of turbines.

mod axis;
mod canvas;
mod cells;
mod chart;
mod color_scale;
mod contours;
mod labels;
mod landscape;
mod lines;
pub mod palette;
mod panels;
mod points;
mod spread;
mod thinning;

pub use axis::{Axis, ColorScale};
pub use canvas::Grid;
pub use cells::{CellFigure, CellPanel, cell_figure};
pub(crate) use chart::legend_markup;
pub use chart::{Chart, Key, MapCell, Mark, Stroke};
pub use color_scale::Bands;
pub use landscape::{Landscape, Path, landscape_figure, landscape_panels_figure};
pub use lines::{LineFigure, Panel, Series, Shaded, line_figure};
pub use points::Points;
pub use spread::{Group, Reference, SpreadFigure, Summary, spread_figure};
#[cfg(test)]
mod tests;
