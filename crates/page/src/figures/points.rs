//! Places that are marked in a figure.

use super::canvas::{Canvas, Frame, LegendEntry, Mark, PAPER};

/// Places that mean the same.
#[derive(Clone, Debug)]
pub struct Points {
    pub label: String,
    pub points: Vec<(f64, f64)>,
    pub fill: &'static str,
    pub radius_px: f64,
}

impl Points {
    /// Small white dots.
    pub fn small(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.to_owned(), points, fill: PAPER, radius_px: 2.4 }
    }

    pub(super) fn draw(&self, canvas: &mut Canvas, frame: &Frame) {
        for point in &self.points {
            canvas.dot(frame.px(*point), self.radius_px, self.fill, "#000000");
        }
    }

    pub(super) fn entry(&self) -> LegendEntry {
        LegendEntry { mark: Mark::Dot, fill: self.fill.into(), outline: "#000000".into(), text: self.label.clone() }
    }
}
