//! Size, moments and samples of a box less its forbidden boxes, without visiting its points.
//!
//! Along each axis, values covered by the same forbidden boxes form a group, and a product of groups is forbidden
//! if one box covers all of them. Summing over groups axis by axis, with the set of boxes that can still forbid as a
//! bit mask, needs at most (2 F + 1)^K groups and usually few, because the mask soon is empty.

use rand::RngExt;

use crate::power::power;
use crate::shape::{Axis, BoxShape};

/// Groups of equal cover along every axis.
#[derive(Debug)]
pub(crate) struct Measure {
    axes: Vec<Vec<Group>>,
    n_boxes: usize,
    is_discrete: bool,
}

/// The values of one axis that the same forbidden boxes cover.
#[derive(Debug)]
struct Group {
    mask: u64,
    values: Values,
}

#[derive(Debug)]
enum Values {
    Intervals(Vec<[f64; 2]>),
    Levels(Vec<f64>),
}

impl Values {
    /// ∫ x^e dx over the intervals, or Σ x^e over the levels.
    fn moment(&self, exponent: u32) -> f64 {
        match self {
            Self::Intervals(intervals) => {
                let next = exponent + 1;
                intervals.iter().map(|[a, b]| (power(*b, next) - power(*a, next)) / f64::from(next)).sum()
            }
            Self::Levels(levels) => levels.iter().map(|level| power(*level, exponent)).sum(),
        }
    }
}

impl Measure {
    pub(crate) fn of(shape: &BoxShape) -> Self {
        let axes = (0..shape.axes.len()).map(|axis| groups(shape, axis)).collect();
        let is_discrete = shape.axes.iter().all(|axis| matches!(axis, Axis::Levels(_)));
        Self { axes, n_boxes: shape.forbidden.len(), is_discrete }
    }

    /// Volume of what is left, levels counting one each.
    pub(crate) fn total(&self) -> f64 {
        self.moment(&vec![0; self.axes.len()])
    }

    pub(crate) fn n_points(&self) -> Option<u64> {
        let total = self.total();
        // Beyond 2^53 a count in a double is no longer exact.
        (self.is_discrete && total <= 9_007_199_254_740_992.0).then_some(total as u64)
    }

    /// ∫ x^e over what is left, with these exponents, not divided by the volume.
    pub(crate) fn moment(&self, exponents: &[u32]) -> f64 {
        self.moment_from(0, exponents, self.all_boxes())
    }

    /// A point drawn uniformly from what is left.
    pub(crate) fn sample(&self, generator: &mut impl RngExt) -> Vec<f64> {
        let zeros = vec![0; self.axes.len()];
        let mut mask = self.all_boxes();
        let mut point = Vec::with_capacity(self.axes.len());
        for axis in 0..self.axes.len() {
            let groups = &self.axes[axis];
            let weight = |group: &Group| group.values.moment(0) * self.moment_from(axis + 1, &zeros, mask & group.mask);
            let weights: Vec<f64> = groups.iter().map(weight).collect();
            let mut rest = generator.random::<f64>() * weights.iter().sum::<f64>();
            let reached = weights.iter().position(|weight| {
                rest -= weight;
                rest < 0.0
            });
            let last = || weights.iter().rposition(|&weight| weight > 0.0).unwrap_or(0);
            let group = &groups[reached.unwrap_or_else(last)];
            mask &= group.mask;
            point.push(match &group.values {
                Values::Levels(levels) => levels[generator.random_range(0..levels.len())],
                Values::Intervals(intervals) => {
                    let mut at = generator.random::<f64>() * group.values.moment(0);
                    let hit = intervals.iter().find(|[a, b]| {
                        let inside = at <= b - a;
                        if !inside {
                            at -= b - a;
                        }
                        inside
                    });
                    hit.map_or(intervals[0][0], |[a, b]| (a + at).min(*b))
                }
            });
        }
        point
    }

    fn all_boxes(&self) -> u64 {
        if self.n_boxes == 64 { u64::MAX } else { (1 << self.n_boxes) - 1 }
    }

    fn moment_from(&self, axis: usize, exponents: &[u32], mask: u64) -> f64 {
        let Some(groups) = self.axes.get(axis) else {
            return if mask == 0 { 1.0 } else { 0.0 };
        };
        if mask == 0 {
            // Nothing can forbid any more: the rest is a product.
            let axes = self.axes[axis..].iter().zip(&exponents[axis..]);
            return axes.map(|(groups, &e)| groups.iter().map(|group| group.values.moment(e)).sum::<f64>()).product();
        }
        let rest = |group: &Group| {
            group.values.moment(exponents[axis]) * self.moment_from(axis + 1, exponents, mask & group.mask)
        };
        groups.iter().map(rest).sum()
    }
}

fn groups(shape: &BoxShape, axis: usize) -> Vec<Group> {
    let mask_at = |x: f64| {
        let covering = shape.forbidden.iter().enumerate().filter(|(_, forbidden)| shape.blocks(forbidden, axis, x));
        covering.fold(0_u64, |mask, (index, _)| mask | 1 << index)
    };
    let mut groups: Vec<Group> = Vec::new();
    match &shape.axes[axis] {
        Axis::Levels(levels) => {
            for &level in levels {
                let mask = mask_at(level);
                match groups.iter_mut().find(|group| group.mask == mask) {
                    Some(Group { values: Values::Levels(values), .. }) => values.push(level),
                    _ => groups.push(Group { mask, values: Values::Levels(vec![level]) }),
                }
            }
        }
        Axis::Continuous => {
            let mut cuts = vec![-1.0, 1.0];
            let ends = shape.forbidden.iter().flat_map(|forbidden| forbidden.range(axis));
            cuts.extend(ends.filter(|end| end.abs() < 1.0));
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2).filter(|pair| pair[1] > pair[0]) {
                let mask = mask_at(0.5 * (pair[0] + pair[1]));
                let interval = [pair[0], pair[1]];
                match groups.iter_mut().find(|group| group.mask == mask) {
                    Some(Group { values: Values::Intervals(values), .. }) => values.push(interval),
                    _ => groups.push(Group { mask, values: Values::Intervals(vec![interval]) }),
                }
            }
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    #[test]
    fn samples_fill_all_that_is_left_of_an_axis_evenly() {
        let forbidden = crate::Forbidden::new(vec![Some([-0.5, 0.5])]).expect("a box");
        for (forbidden, quarters) in [(Vec::new(), [1.0; 4]), (vec![forbidden], [2.0, 0.0, 0.0, 2.0])] {
            let shape = BoxShape { axes: vec![Axis::Continuous], forbidden };
            let measure = Measure::of(&shape);
            let mut generator = rand_pcg::Pcg64::seed_from_u64(5);
            let mut counts = [0_u32; 4];
            for _ in 0..4000 {
                let x = measure.sample(&mut generator)[0];
                counts[((x + 1.0) * 2.0) as usize] += 1;
            }
            for (count, quarter) in counts.into_iter().zip(quarters) {
                // A thousand of 4000 with a standard deviation of 27.
                assert!((f64::from(count) - 1000.0 * quarter).abs() < 140.0, "{counts:?}");
            }
        }
    }
}
