//! How far a simulation is displaced: what it says of one design, experiments say of another.
//!
//! A model whose spring is softer than the real one, or whose sensor is off by a degree, is right about everything but the place. Neither
//! a factor nor a smooth discrepancy makes up for that where the response has features: between the simulated place of one and the real
//! one the discrepancy is as steep as the feature itself.

use design_space::Cell;

use crate::pooled::designs::Designs;

/// In levels along each axis: an experiment at a design gives what the simulation says of the design so many levels farther on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Displacement(pub(crate) Vec<i64>);

impl Displacement {
    pub(crate) fn is_none(&self) -> bool {
        self.0.iter().all(|step| *step == 0)
    }

    /// In the unit of each parameter.
    pub(crate) fn natural(&self, designs: &Designs) -> Vec<f64> {
        let counts = designs.combinations().counts();
        let axes = self.0.iter().zip(counts).zip(designs.region().parameters());
        axes.map(|((step, count), parameter)| share(*step, *count) * parameter.width()).collect()
    }

    /// In coded units along each axis of a place.
    pub(crate) fn coded(&self, designs: &Designs) -> Vec<f64> {
        let mut coded = vec![0.0; designs.n_factors()];
        let steps = self.0.iter().zip(designs.combinations().counts()).enumerate();
        for (parameter, (step, count)) in steps.filter(|(_, (step, _))| **step != 0) {
            designs.axes_of(&[parameter]).into_iter().for_each(|axis| coded[axis] = 2.0 * share(*step, *count));
        }
        coded
    }

    /// The design whose simulation tells of this one; the nearest one at a bound. Where that is none, it tells of itself.
    pub(crate) fn of(&self, designs: &Designs, cell: Cell) -> Cell {
        self.moved(designs, cell, 1)
    }

    /// The design as far within the bounds as the one of which a simulation would tell is beyond them, where that is so; else the design
    /// whose simulation tells of this one.
    pub(crate) fn inside(&self, designs: &Designs, cell: Cell) -> Cell {
        if self.is_none() {
            return cell;
        }
        let there = self.clamped(designs, cell, 1);
        if !designs.allows(there) {
            return cell;
        }
        let combinations = designs.combinations();
        let mut digits = combinations.digits(cell.index());
        for ((digit, step), count) in digits.iter_mut().zip(&self.0).zip(combinations.counts()) {
            let (moved, last) = (*digit as i64 + step, *count as i64 - 1);
            let mirrored = if moved < 0 {
                -moved
            } else if moved > last {
                2 * last - moved
            } else {
                moved
            };
            *digit = mirrored.clamp(0, last) as u64;
        }
        let inside = Cell::new(combinations.index(&digits));
        if designs.allows(inside) { inside } else { there }
    }

    /// The design of which the simulation of this one tells.
    pub(crate) fn back(&self, designs: &Designs, cell: Cell) -> Cell {
        self.moved(designs, cell, -1)
    }

    /// How far beyond the bounds, in coded units, the design is of which a simulation would tell of this one; 0 within them. One that nobody
    /// can build is as far away as all of the way there.
    pub(crate) fn beyond(&self, designs: &Designs, cell: Cell) -> f64 {
        if self.is_none() {
            return 0.0;
        }
        let combinations = designs.combinations();
        let (digits, counts) = (combinations.digits(cell.index()), combinations.counts());
        let coded = |levels: i64, count: u64| 2.0 * share(levels, count);
        let axes = || digits.iter().zip(&self.0).zip(counts);
        let over = axes().map(|((digit, step), count)| {
            let (there, last) = (*digit as i64 + step, *count as i64 - 1);
            coded((-there).max(there - last).max(0), *count)
        });
        let over = over.map(|over| over * over).sum::<f64>().sqrt();
        let is_refused = over <= 0.0 && !designs.allows(self.clamped(designs, cell, 1));
        if !is_refused {
            return over;
        }
        axes().map(|((_, step), count)| coded(*step, *count).powi(2)).sum::<f64>().sqrt()
    }

    fn moved(&self, designs: &Designs, cell: Cell, sign: i64) -> Cell {
        if self.is_none() {
            return cell;
        }
        let moved = self.clamped(designs, cell, sign);
        if designs.allows(moved) { moved } else { cell }
    }

    fn clamped(&self, designs: &Designs, cell: Cell, sign: i64) -> Cell {
        let combinations = designs.combinations();
        let mut digits = combinations.digits(cell.index());
        for ((digit, step), count) in digits.iter_mut().zip(&self.0).zip(combinations.counts()) {
            *digit = digit.saturating_add_signed(sign * step).min(count - 1);
        }
        Cell::new(combinations.index(&digits))
    }
}

/// So far beyond the bounds, in coded units, a simulation has little to do with what it says at them.
const REACH: f64 = 0.4;

/// How what a simulation says at the bounds goes with what it would say so far beyond.
pub(crate) fn correlation(beyond: f64) -> f64 {
    (-0.5 * (beyond / REACH).powi(2)).exp()
}

/// The standard deviation that is left of such a correlation, of 1 without it.
pub(crate) fn left_of(correlation: f64) -> f64 {
    (1.0 - correlation * correlation).max(0.0).sqrt()
}

/// What a simulation would say beyond the bounds if it went on as it came: as far from what it says at the bound as that is from what it
/// says as far within.
pub(crate) fn went_on(at_bound: f64, inside: f64) -> f64 {
    2.0 * at_bound - inside
}

/// Axes along which a simulation may be displaced: not those of choices, which have no order.
pub(crate) fn free(designs: &Designs) -> Vec<usize> {
    let counts = designs.combinations().counts();
    let parameters = designs.region().parameters().iter().zip(counts).enumerate();
    parameters.filter(|(_, (one, count))| one.choices().is_none() && **count > 2).map(|(axis, _)| axis).collect()
}

/// Displacements are told apart by this share of the range along an axis, or by a level if that is more.
pub(crate) const LEAST_STEP: f64 = 0.01;
/// Standard deviation of a number that was rounded to the nearest step: it is uniform over one.
pub(crate) const WITHIN_A_STEP: f64 = 0.288_675_134_594_812_9;

/// The whole number of levels nearest to a share of the range.
pub(crate) fn steps(share: f64, count: u64) -> i64 {
    (share * (count - 1) as f64).round() as i64
}

/// The designs one step from these, there and back along each axis; at a bound the same.
pub(crate) fn next_to(designs: &Designs, cells: &[Cell]) -> Vec<Vec<Cell>> {
    let counts = designs.combinations().counts();
    let one = |(axis, sign): (usize, i64)| {
        let mut next = Displacement(vec![0; counts.len()]);
        next.0[axis] = sign * steps(LEAST_STEP, counts[axis]).max(1);
        cells.iter().map(|&cell| next.of(designs, cell)).collect()
    };
    free(designs).into_iter().flat_map(|axis| [(axis, -1), (axis, 1)]).map(one).collect()
}

/// Steps as a share of the range.
pub(crate) fn share(step: i64, count: u64) -> f64 {
    step as f64 / (count - 1).max(1) as f64
}

#[cfg(test)]
mod tests {
    use design_space::{Parameter, Region};
    use rand::SeedableRng as _;

    use super::*;

    /// Of 11 levels along each of two axes.
    #[test]
    fn as_far_within_as_it_points_beyond() {
        let number = |name: &str| Parameter::continuous(name, "1", 0.0, 1.0).unwrap().with_levels(11).unwrap();
        let region = Region::new(vec![number("x"), number("y")]).unwrap();
        let designs = Designs::of(&region, &[], &mut rand_chacha::ChaCha8Rng::seed_from_u64(1)).unwrap();
        let cell = |x: u64, y: u64| Cell::new(designs.combinations().index(&[x, y]));
        let by = Displacement(vec![3, -2]);
        // Within the bounds along both axes; beyond one; beyond both; beyond by two of the ten steps along each.
        for ((x, y), of, inside) in
            [((4, 5), (7, 3), (7, 3)), ((9, 5), (10, 3), (8, 3)), ((10, 1), (10, 0), (7, 1)), ((9, 0), (10, 0), (8, 2))]
        {
            let here = cell(x, y);
            assert_eq!(
                (by.of(&designs, here), by.inside(&designs, here)),
                (cell(of.0, of.1), cell(inside.0, inside.1))
            );
        }
        assert_eq!(Displacement::default().inside(&designs, cell(10, 0)), cell(10, 0));
        assert!((went_on(3.0, 2.5) - 3.5).abs() < 1e-15);
    }
}
