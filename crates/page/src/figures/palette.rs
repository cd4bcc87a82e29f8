//! The colors of all figures: those that color-blind readers can tell apart, and that a gray printer does not make equal.

/// Text and lines.
pub const INK: &str = "#222222";
/// What figures are drawn on.
pub const PAPER: &str = "#ffffff";
/// Lines across a frame.
pub const GRID: &str = "#dddddd";

/// A blue of Okabe and Ito.
pub const BLUE: &str = "#0072b2";
/// An orange of Okabe and Ito.
pub const ORANGE: &str = "#e69f00";
/// A green of Okabe and Ito.
pub const GREEN: &str = "#009e73";
/// A red of Okabe and Ito.
pub const VERMILION: &str = "#d55e00";
/// A light blue, to set a range off.
pub const LIGHT_BLUE: &str = "#dcebf5";

/// The palette of Okabe and Ito, dark and light by turns; its yellow is darkened to be seen on white.
const COLORS: [&str; 8] = [BLUE, ORANGE, "#cc79a7", GREEN, VERMILION, "#56b4e9", "#000000", "#a89f10"];

/// The color of the series with this index.
pub fn color(index: usize) -> &'static str {
    COLORS[index % COLORS.len()]
}

/// The gray of a step, lighter the earlier, from 1 to the number of steps.
pub fn gray(step: usize, steps: usize) -> String {
    let share = if steps > 1 { (step.max(1) - 1) as f64 / (steps - 1) as f64 } else { 0.0 };
    let level = (236.0 - 66.0 * share).round().clamp(0.0, 255.0) as u8;
    format!("#{level:02x}{level:02x}{level:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grays_go_from_light_to_dark() {
        assert_eq!((gray(1, 1), gray(1, 3), gray(3, 3)), ("#ececec".into(), "#ececec".into(), "#aaaaaa".into()));
    }
}
