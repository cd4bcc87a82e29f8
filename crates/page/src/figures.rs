//! Figures: plain data in, an SVG document out. They draw what they are given and know nothing of what it means.

mod axis;
mod canvas;
mod cells;
mod chart;
mod color_scale;
mod contours;
mod counts;
mod frame;
mod labels;
mod landscape;
mod legend;
mod lines;
mod marks;
pub mod palette;
mod panels;
mod points;
mod scale;
mod spread;
mod strips;
mod thinning;

pub use axis::{Axis, ColorScale};
pub use cells::{CellFigure, CellPanel, cell_figure};
pub use chart::{Chart, MapCell};
pub use color_scale::Bands;
pub use counts::{CountFigure, count_figure};
pub use frame::Grid;
pub use landscape::{Landscape, Path, landscape_figure, landscape_panels_figure};
pub use lines::{LineFigure, Panel, Series, Shaded, line_figure};
pub(crate) use marks::legend_markup;
pub use marks::{Key, Mark, Stroke};
pub use points::Points;
pub use spread::{Group, Reference, SpreadFigure, Summary, quantile, spread_figure};
pub use strips::{StripFigure, strip_figure};
#[cfg(test)]
mod tests;
