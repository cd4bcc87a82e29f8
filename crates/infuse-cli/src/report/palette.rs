//! Colors that color-blind readers can tell apart, and that a gray printer does not make equal.

pub(super) const INK: &str = "#222222";
pub(super) const PAPER: &str = "#ffffff";
pub(super) const GRID: &str = "#dddddd";
/// Behind the range of a parameter that is left.
pub(super) const LEFT: &str = "#dcebf5";

// Of Okabe and Ito.
pub(super) const BLUE: &str = "#0072b2";
pub(super) const ORANGE: &str = "#e69f00";
pub(super) const GREEN: &str = "#009e73";
pub(super) const VERMILION: &str = "#d55e00";

/// Viridis, from dark to light, in equal steps.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The color of a share of the way from dark to light.
pub(super) fn viridis(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the last but one")]
    let below = (at.floor() as usize).min(VIRIDIS.len() - 2);
    let part = at - below as f64;
    let mut color = String::from("#");
    for (&low, &high) in VIRIDIS[below].iter().zip(&VIRIDIS[below + 1]) {
        let mixed = (1.0 - part) * f64::from(low) + part * f64::from(high);
        color.push_str(&format!("{:02x}", mixed.round().clamp(0.0, 255.0) as u8));
    }
    color
}

/// The gray of what a batch dropped, lighter the earlier.
pub(super) fn dropped(batch: usize, n_batches: usize) -> String {
    let share = if n_batches > 1 { (batch - 1) as f64 / (n_batches - 1) as f64 } else { 0.0 };
    let level = (f64::from(0xec_u8) - share * f64::from(0x42_u8)).round().clamp(0.0, 255.0) as u8;
    format!("#{level:02x}{level:02x}{level:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_go_from_one_end_to_the_other() {
        assert_eq!((viridis(0.0).as_str(), viridis(1.0).as_str()), ("#440154", "#fde725"));
        assert_eq!(viridis(f64::NAN).len(), 7);
        assert_eq!(
            (dropped(1, 1).as_str(), dropped(1, 3).as_str(), dropped(3, 3).as_str()),
            ("#ececec", "#ececec", "#aaaaaa")
        );
    }
}
