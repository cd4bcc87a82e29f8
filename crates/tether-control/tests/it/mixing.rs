//! A and its inverse.

use proptest::prelude::*;
use tether_control::{Mixing, TetherLayout};

use crate::LAYOUTS;

/// Rounding of three additions on values below ten.
const ROUNDING: f64 = 1e-14;

fn speeds() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.0..3.0_f64)
}

#[test]
fn matrix_is_that_of_the_source() {
    let printed = [[1.0, -1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 1.0, -1.0]];
    assert_eq!(Mixing::new(TetherLayout::OneForwardTwoAft).matrix(), printed);
    let second_column_turned = printed.map(|[z, theta, phi]| [z, -theta, phi]);
    assert_eq!(Mixing::new(TetherLayout::TwoForwardOneAft).matrix(), second_column_turned);
}

proptest! {
    #[test]
    fn line_speeds_are_the_product_with_the_matrix(v in speeds()) {
        for layout in LAYOUTS {
            let mixing = Mixing::new(layout);
            let u = mixing.line_speeds_m_s(v);
            for (row, speed) in mixing.matrix().iter().zip(u) {
                let product: f64 = row.iter().zip(v).map(|(a, v)| a * v).sum();
                prop_assert!((speed - product).abs() <= ROUNDING, "{:?}", layout);
            }
        }
    }

    #[test]
    fn inverse_undoes_the_mixing_from_either_side(given in speeds()) {
        for layout in LAYOUTS {
            let mixing = Mixing::new(layout);
            let from_loops = mixing.loop_speeds_m_s(mixing.line_speeds_m_s(given));
            let from_lines = mixing.line_speeds_m_s(mixing.loop_speeds_m_s(given));
            for i in 0..3 {
                prop_assert!((from_loops[i] - given[i]).abs() <= ROUNDING, "{:?}", layout);
                prop_assert!((from_lines[i] - given[i]).abs() <= ROUNDING, "{:?}", layout);
            }
        }
    }

    #[test]
    fn mean_line_speed_also_follows_the_pitch_loop(v in speeds()) {
        for (layout, sigma) in LAYOUTS.into_iter().zip([1.0, -1.0]) {
            let mean = Mixing::new(layout).line_speeds_m_s(v).iter().sum::<f64>() / 3.0;
            prop_assert!((mean - (v[0] + sigma * v[1] / 3.0)).abs() <= ROUNDING, "{:?}", layout);
        }
    }
}
