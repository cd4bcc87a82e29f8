//! What holds for every parameter and every region.

#![expect(clippy::float_cmp, reason = "bounds, levels and clamped values are exact")]

use design_space::{Cell, Combinations, Grid, Model, Parameter, Region, Term};
use proptest::prelude::*;

/// Bounds of any size and sign, from a part in a million apart to twenty decades.
fn bounds() -> impl Strategy<Value = (f64, f64)> {
    (-1.0..1.0_f64, -20..20_i32, 1e-6..2.0_f64).prop_map(|(middle, exponent, width)| {
        let scale = 10.0_f64.powi(exponent);
        (middle * scale, (middle + width) * scale)
    })
}

fn parameter() -> impl Strategy<Value = Parameter> {
    (bounds(), prop::option::of(2..2000_u32)).prop_map(|((lower, upper), count)| {
        let parameter = Parameter::continuous("p", "m", lower, upper).unwrap();
        match count {
            Some(count) => parameter.with_levels(count).unwrap(),
            None => parameter,
        }
    })
}

fn region() -> impl Strategy<Value = Region> {
    regions_with(prop::option::of(2..9_u32))
}

/// Of levels alone, which are a grid.
fn region_of_levels() -> impl Strategy<Value = Region> {
    regions_with((2..9_u32).prop_map(Some))
}

fn regions_with(levels: impl Strategy<Value = Option<u32>>) -> impl Strategy<Value = Region> {
    prop::collection::vec((bounds(), levels), 1..5).prop_map(|axes| {
        let axis = |(index, ((lower, upper), count)): (usize, ((f64, f64), Option<u32>))| {
            let parameter = Parameter::continuous(format!("p{index}"), "m", lower, upper).unwrap();
            match count {
                Some(count) => parameter.with_levels(count).unwrap(),
                None => parameter,
            }
        };
        Region::new(axes.into_iter().enumerate().map(axis).collect()).unwrap()
    })
}

/// A model of up to five factors with exponents up to the largest, and a point.
fn model_and_point() -> impl Strategy<Value = (Model, Vec<f64>)> {
    (1..6_usize).prop_flat_map(|n_factors| {
        let exponents = prop::collection::vec(0..=Model::LARGEST_EXPONENT, n_factors);
        let terms = prop::collection::btree_set(exponents, 1..20);
        let model =
            terms.prop_map(move |terms| Model::new(n_factors, terms.into_iter().map(Term::new).collect()).unwrap());
        (model, prop::collection::vec(-1.5..1.5_f64, n_factors))
    })
}

proptest! {
    #[test]
    fn both_ways_to_a_regressor_agree_to_the_last_bit((model, point) in model_and_point()) {
        let mut filled = vec![f64::NAN; model.n_terms()];
        model.fill_regressor(&point, &mut filled);
        let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
        prop_assert_eq!(bits(filled), bits(model.regressor(&point).unwrap()));
    }

    #[test]
    fn coded_and_natural_are_inverse(parameter in parameter(), coded in -3.0..3.0_f64) {
        let natural = parameter.natural(coded);
        let size = parameter.lower().abs().max(parameter.upper().abs());
        let rounding = 8.0 * f64::EPSILON * (1.0 + size / parameter.width());
        prop_assert!((parameter.coded(natural) - coded).abs() <= rounding);
    }

    #[test]
    fn both_bounds_are_exact_in_both_directions(parameter in parameter()) {
        prop_assert_eq!(parameter.coded(parameter.lower()), -1.0);
        prop_assert_eq!(parameter.coded(parameter.upper()), 1.0);
        prop_assert_eq!(parameter.natural(-1.0), parameter.lower());
        prop_assert_eq!(parameter.natural(1.0), parameter.upper());
    }

    #[test]
    fn what_is_coded_within_is_natural_within(parameter in parameter(), coded in -1.0..=1.0_f64) {
        prop_assert!(parameter.contains(parameter.natural(coded)));
    }

    #[test]
    fn clamping_twice_is_clamping_once(parameter in parameter(), coded in -3.0..3.0_f64) {
        let once = parameter.clamp(parameter.natural(coded)).unwrap();
        prop_assert!(parameter.contains(once));
        prop_assert_eq!(parameter.clamp(once), Ok(once));
    }

    #[test]
    fn snapping_finds_the_nearest_level_and_stays_there(
        (lower, upper) in bounds(),
        count in 2..400_u32,
        coded in -1.0..=1.0_f64,
    ) {
        let parameter = Parameter::continuous("p", "m", lower, upper).unwrap();
        let parameter = parameter.with_levels(count).unwrap();
        let natural = parameter.natural(coded);
        let snapped = parameter.snap(natural).unwrap();
        prop_assert_eq!(parameter.snap(snapped), Ok(snapped));
        let distances = (0..count).map(|i| (parameter.level(i).unwrap() - natural).abs());
        let least = distances.fold(f64::INFINITY, f64::min);
        prop_assert_eq!((snapped - natural).abs(), least);
    }

    #[test]
    fn levels_rise_strictly_from_bound_to_bound(parameter in parameter()) {
        if let design_space::Levels::Count(count) = parameter.levels() {
            let levels: Vec<f64> = (0..count).map(|i| parameter.level(i).unwrap()).collect();
            prop_assert!(levels.windows(2).all(|pair| pair[0] < pair[1]));
            prop_assert_eq!(levels[0], parameter.lower());
            prop_assert_eq!(levels[levels.len() - 1], parameter.upper());
        }
    }

    #[test]
    fn a_file_keeps_every_bit(region in region()) {
        let json: Region = serde_json::from_str(&serde_json::to_string(&region).unwrap()).unwrap();
        let toml: Region = toml::from_str(&toml::to_string(&region).unwrap()).unwrap();
        for read in [json, toml] {
            prop_assert_eq!(&read, &region);
            for (read, written) in read.parameters().iter().zip(region.parameters()) {
                prop_assert_eq!(read.lower().to_bits(), written.lower().to_bits());
                prop_assert_eq!(read.upper().to_bits(), written.upper().to_bits());
            }
        }
    }

    #[test]
    fn every_cell_is_a_point_within_and_the_nearest_to_itself(region in region_of_levels(), pick in 0..1_000_000_u64) {
        let grid = Grid::of(&region).unwrap();
        let cell = Cell::new(pick % grid.n_cells());
        let point = grid.point(cell).unwrap();
        prop_assert_eq!(region.contains(&point), Ok(true));
        prop_assert_eq!(&region.snap(&point).unwrap(), &point);
        prop_assert_eq!(grid.nearest(&point), Ok(cell));
        prop_assert_eq!(grid.of_digits(&grid.digits(cell).unwrap()), Ok(cell));
        for (coded, exact) in grid.coded(cell).unwrap().into_iter().zip(region.coded(&point).unwrap()) {
            prop_assert!((coded - exact).abs() <= 1e-6, "{} is not {}", coded, exact);
        }
        prop_assert_eq!(u64::try_from(grid.cells().count()).unwrap(), grid.n_cells());
    }

    #[test]
    fn neighbors_are_mutual_and_one_digit_away(region in region_of_levels(), pick in 0..1_000_000_u64) {
        let grid = Grid::of(&region).unwrap();
        let cell = Cell::new(pick % grid.n_cells());
        let digits = grid.digits(cell).unwrap();
        for neighbor in grid.neighbors(cell).unwrap() {
            let theirs = grid.digits(neighbor).unwrap();
            let distance: u64 = digits.iter().zip(&theirs).map(|(a, b)| a.abs_diff(*b)).sum();
            prop_assert_eq!(distance, 1);
            prop_assert!(grid.neighbors(neighbor).unwrap().contains(&cell));
        }
    }

    #[test]
    fn advancing_visits_the_indices_in_order(counts in prop::collection::vec(1..5_u64, 1..5)) {
        let combinations = Combinations::new(counts).unwrap();
        let mut digits = combinations.digits(0);
        for index in 1..=combinations.len() {
            let is_on = combinations.advance(&mut digits);
            prop_assert_eq!(is_on, index < combinations.len());
            prop_assert_eq!(combinations.index(&digits), index % combinations.len());
        }
    }
}
