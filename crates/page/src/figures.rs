//! Figures: plain data in, an SVG document out. They draw what they are given and know nothing of turbines.

mod axis;
mod canvas;
mod cells;
mod contours;
mod labels;
mod landscape;
mod lines;
mod spread;
mod thinning;

pub use axis::Axis;
pub use cells::{CellFigure, CellPanel, cell_figure};
pub use landscape::{Landscape, Path, Points, landscape_figure, landscape_panels_figure};
pub use lines::{LineFigure, Panel, Series, Shaded, line_figure};
pub use spread::{Group, Reference, SpreadFigure, Summary, spread_figure};
#[cfg(test)]
mod tests;
