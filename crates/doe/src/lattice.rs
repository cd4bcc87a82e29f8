//! Points of a box on a lattice, by index.

use design_space::{Combinations, coded_level};
use rayon::prelude::*;

use crate::nested::{MOST_STORED, Nested};
use crate::shape::{Axis, BoxShape, spread};
use crate::{PredictionVariance, polynomial};

/// A lattice of a box: levels per axis, the last varying fastest; forbidden points are skipped.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    levels: Vec<Vec<f64>>,
    combinations: Combinations,
    allowed: Option<Vec<bool>>,
}

impl Lattice {
    /// All combinations of these levels, none of them forbidden.
    pub(crate) fn new(levels: Vec<Vec<f64>>) -> Self {
        let counts: Vec<u64> = levels.iter().map(|levels| levels.len() as u64).collect();
        Self { levels, combinations: Combinations::saturating(counts), allowed: None }
    }

    /// All levels of a box, and both ends of its continuous axes; what is forbidden is not looked at.
    pub(crate) fn whole(shape: &BoxShape) -> Self {
        Self::new(shape.axes.iter().map(level_values).collect())
    }

    /// The same lattice with its forbidden points skipped.
    pub(crate) fn without_forbidden(self, shape: &BoxShape) -> Self {
        if shape.forbidden.is_empty() {
            return self;
        }
        let allowed = (0..self.n_points()).map(|index| !shape.forbids(&self.point(index))).collect();
        self.with_allowed(allowed)
    }

    /// The same lattice with these points allowed and no others.
    pub(crate) fn with_allowed(self, allowed: Vec<bool>) -> Self {
        Self { allowed: Some(allowed), ..self }
    }

    /// As many equally spaced levels per axis as `most` points allow, an odd number from 3 to 33, with the ends of
    /// forbidden boxes among them; levels of gridded axes, thinned if there are more. Where three levels are too many
    /// already, axes that `is_convex` along which v has its maxima at the ends have those two.
    pub(crate) fn of(shape: &BoxShape, most: usize, is_convex: impl Fn(usize) -> bool) -> Self {
        let n_factors = shape.axes.len() as f64;
        let root = (most as f64).powf(1.0 / n_factors).floor() as usize;
        let count = root.saturating_sub(1 - root % 2).clamp(3, 33);
        Self::with_counts(shape, |axis| if root < 3 && is_convex(axis) { 2 } else { count })
    }

    /// About this many levels per axis.
    pub(crate) fn with_levels(shape: &BoxShape, count: usize) -> Self {
        Self::with_counts(shape, |_| count)
    }

    /// About as many levels along each axis as `count` says of it.
    pub(crate) fn with_counts(shape: &BoxShape, count: impl Fn(usize) -> usize) -> Self {
        let axis_levels = |(factor, axis): (usize, &Axis)| match (axis, count(factor)) {
            (Axis::Levels(levels), count) => {
                spread(count.min(levels.len()), levels.len()).map(|index| levels[index]).collect()
            }
            (Axis::Continuous, count) => {
                let mut levels: Vec<f64> = (0..count as u64).map(|level| coded_level(level, count as u64)).collect();
                levels.extend(shape.forbidden.iter().flat_map(|box_| box_.range(factor)).filter(|end| end.abs() < 1.0));
                levels.sort_by(f64::total_cmp);
                levels.dedup();
                levels
            }
        };
        let levels = shape.axes.iter().enumerate().map(axis_levels).collect();
        Self::new(levels).without_forbidden(shape)
    }

    pub(crate) fn n_points(&self) -> usize {
        self.combinations.len() as usize
    }

    /// The levels of each axis, rising.
    pub(crate) fn levels(&self) -> &[Vec<f64>] {
        &self.levels
    }

    pub(crate) fn combinations(&self) -> &Combinations {
        &self.combinations
    }

    /// Which points are not forbidden; none if all are allowed.
    pub(crate) fn allowed(&self) -> Option<&[bool]> {
        self.allowed.as_deref()
    }

    pub(crate) fn point(&self, index: usize) -> Vec<f64> {
        let mut point = vec![0.0; self.levels.len()];
        let digits = self.combinations.digits_from_last(index as u64);
        for ((x, levels), digit) in point.iter_mut().zip(&self.levels).rev().zip(digits) {
            *x = levels[digit as usize];
        }
        point
    }

    /// Whether a lattice point is not forbidden.
    pub(crate) fn is_allowed(&self, index: usize) -> bool {
        self.allowed.as_ref().is_none_or(|allowed| allowed[index])
    }

    /// v at every point; forbidden points at minus infinity.
    pub(crate) fn values(&self, variance: &PredictionVariance) -> Vec<f64> {
        self.values_beyond(variance, MOST_STORED)
    }

    /// The same, line by line where points times monomials are up to `most`, and axis by axis beyond.
    fn values_beyond(&self, variance: &PredictionVariance, most: usize) -> Vec<f64> {
        if self.n_points().saturating_mul(variance.products().n_monomials()) > most {
            let mut values = Vec::new();
            Nested::of(variance.products(), self.levels.clone()).values(variance.coefficients(), &mut values);
            if let Some(allowed) = &self.allowed {
                let forbidden = values.iter_mut().zip(allowed).filter(|(_, allowed)| !**allowed);
                forbidden.for_each(|(value, _)| *value = f64::NEG_INFINITY);
            }
            return values;
        }
        let last = self.levels.len() - 1;
        let levels = &self.levels[last];
        let mut values = vec![0.0; self.n_points()];
        values.par_chunks_exact_mut(levels.len()).enumerate().with_min_len(64).for_each(|(line_index, values)| {
            let point = self.point(line_index * levels.len());
            let mut line = vec![0.0; variance.largest_power() + 1];
            variance.along(&point, last, &mut line);
            for (offset, (value, &x)) in values.iter_mut().zip(levels).enumerate() {
                let allowed = self.is_allowed(line_index * levels.len() + offset);
                *value = if allowed { polynomial::value(&line, x) } else { f64::NEG_INFINITY };
            }
        });
        values
    }

    /// Points at least as high as their neighbors along every axis and above a threshold, the highest first.
    pub(crate) fn local_maxima(&self, values: &[f64], threshold: f64, most: usize) -> Vec<usize> {
        let Some(last) = self.levels.last().map(Vec::len) else {
            return Vec::new();
        };
        let mut found = Vec::new();
        let mut digits = vec![0; self.levels.len()];
        for (number, line) in values.chunks_exact(last).enumerate() {
            for (i, &value) in line.iter().enumerate() {
                let is_maximum_of_line =
                    value >= threshold && (i == 0 || line[i - 1] <= value) && (i + 1 == last || line[i + 1] <= value);
                let index = number * last + i;
                if is_maximum_of_line && self.is_maximum_across_lines(values, index, &digits) {
                    found.push(index);
                }
            }
            // From the last point of the line to the next line, without a division.
            digits[self.levels.len() - 1] = last as u64 - 1;
            self.combinations.advance(&mut digits);
        }
        found.sort_by(|&a, &b| values[b].total_cmp(&values[a]).then(a.cmp(&b)));
        found.truncate(most);
        found
    }

    /// Whether a point is at least as high as its neighbors along every axis but the last, whose digit is not looked at.
    fn is_maximum_across_lines(&self, values: &[f64], index: usize, digits: &[u64]) -> bool {
        let value = values[index];
        (0..digits.len() - 1).rev().all(|axis| {
            let mut beside = self.combinations.neighbors_along(axis, index as u64, digits[axis]);
            beside.all(|neighbor| values[neighbor as usize] <= value)
        })
    }
}

/// The levels of an axis, or its ends.
pub(crate) fn level_values(axis: &Axis) -> Vec<f64> {
    match axis {
        Axis::Levels(levels) => levels.clone(),
        Axis::Continuous => vec![-1.0, 1.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_line_by_line_and_axis_by_axis_are_the_same() {
        let corner = crate::Forbidden::new(vec![Some([0.2, 1.0]), Some([-1.0, -0.3])]).expect("a box");
        let shape = BoxShape { axes: vec![Axis::Continuous; 2], forbidden: vec![corner] };
        let runs = [[-1.0, -1.0], [1.0, -0.9], [-0.8, 1.0], [1.0, 1.0], [0.2, -1.0], [-0.1, 1.0], [-1.0, 0.3]];
        let design = crate::Design::from_runs(&runs).expect("a design");
        let model = crate::Model::quadratic(2).expect("a model");
        let variance = PredictionVariance::of(&model, &design).expect("not singular");
        let lattice = Lattice::with_levels(&shape, 7);
        let [lines, nested] = [usize::MAX, 0].map(|most| lattice.values_beyond(&variance, most));
        assert_eq!(lines.len(), nested.len());
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a - b).abs() < 1e-12 * a.abs();
        assert!(lines.iter().zip(&nested).all(same), "{lines:?} and {nested:?}");
        assert!(nested.contains(&f64::NEG_INFINITY), "some are forbidden");
    }

    /// An odd number of levels, so that the middle is among them, and no more points than asked for.
    #[test]
    fn lattices_have_an_odd_number_of_levels_from_three_to_thirty_three() {
        let shape = BoxShape { axes: vec![Axis::Continuous; 2], forbidden: Vec::new() };
        for (most, expected) in [(49, 7), (63, 7), (64, 7), (81, 9), (5, 3), (1_000_000, 33)] {
            let lattice = Lattice::of(&shape, most, |_| false);
            assert_eq!(lattice.levels().iter().map(Vec::len).collect::<Vec<_>>(), [expected; 2], "{most} points");
            assert!((lattice.levels()[0][expected / 2]).abs() < 1e-15, "the middle");
        }
        let convex = Lattice::of(&shape, 4, |axis| axis == 1);
        assert_eq!(convex.levels()[0].len(), 3);
        assert_eq!(convex.levels()[1], [-1.0, 1.0], "ends alone where the maxima are there");
    }
}
