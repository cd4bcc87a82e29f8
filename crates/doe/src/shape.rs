//! What a design space is made of: a box with continuous and gridded axes, or a list of candidates.

use design_space::{Combinations, coded_level};

use crate::same::{SAME, same_pair};
use crate::{Cell, Error, Forbidden};

/// The values one coded coordinate can take.
#[derive(Debug, Clone, PartialEq)]
pub enum Axis {
    /// All of −1 to 1.
    Continuous,
    /// These values, rising, within −1 to 1.
    Levels(Vec<f64>),
}

impl Axis {
    /// The largest number of equally spaced levels.
    pub const MOST_LEVELS: u32 = 1_000_000;

    /// `count` equally spaced levels from −1 to 1.
    ///
    /// # Errors
    ///
    /// [`Error::TooFewAxisLevels`] below two, [`Error::TooManyLevels`] above [`MOST_LEVELS`](Self::MOST_LEVELS).
    pub fn equally_spaced(count: u32) -> Result<Self, Error> {
        if count > Self::MOST_LEVELS {
            return Err(Error::TooManyLevels { count, most: Self::MOST_LEVELS });
        }
        if count < 2 {
            return Err(Error::TooFewAxisLevels { count: count as usize });
        }
        let count = u64::from(count);
        Ok(Self::Levels((0..count).map(|level| coded_level(level, count)).collect()))
    }

    /// Its levels; none where it is continuous.
    fn levels(&self) -> Option<&[f64]> {
        match self {
            Self::Levels(levels) => Some(levels),
            Self::Continuous => None,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Box(BoxShape),
    List(List),
}

/// Axes without the forbidden boxes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BoxShape {
    pub(crate) axes: Vec<Axis>,
    pub(crate) forbidden: Vec<Forbidden>,
}

/// Candidates, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct List {
    pub(crate) n_factors: usize,
    pub(crate) coordinates: Vec<f64>,
}

impl BoxShape {
    /// The box with all axes continuous.
    pub(crate) fn relaxed(&self) -> Self {
        Self { axes: vec![Axis::Continuous; self.axes.len()], forbidden: self.forbidden.clone() }
    }

    /// How many combinations of levels there are, forbidden ones included, an axis without levels counted once.
    pub(crate) fn n_combinations(&self) -> f64 {
        let count = |axis: &Axis| if let Axis::Levels(levels) = axis { levels.len() as f64 } else { 1.0 };
        self.axes.iter().map(count).product()
    }

    pub(crate) fn is_discrete(&self) -> bool {
        self.axes.iter().all(|axis| matches!(axis, Axis::Levels(_)))
    }

    pub(crate) fn is_continuous(&self) -> bool {
        self.axes.iter().all(|axis| *axis == Axis::Continuous)
    }

    /// The combinations of levels that points of the box are, counted as the cells of a grid and forbidden ones included;
    /// none if an axis is continuous, a point is off its levels, or there are more combinations than have a number.
    pub(crate) fn cells<'a>(&self, points: impl Iterator<Item = &'a [f64]>) -> Option<Vec<Cell>> {
        let axes = self.axes.iter().map(Axis::levels).collect::<Option<Vec<_>>>()?;
        let counts: Vec<u64> = axes.iter().map(|levels| levels.len() as u64).collect();
        let combinations = Combinations::new(counts).ok()?;
        let digit = |levels: &[f64], x: f64| {
            let digit = levels.partition_point(|level| *level < x - SAME);
            levels.get(digit).filter(|level| (**level - x).abs() <= SAME).map(|_| digit as u64)
        };
        let cell = |point: &[f64]| {
            let digits = axes.iter().zip(point).map(|(levels, &x)| digit(levels, x)).collect::<Option<Vec<_>>>()?;
            Some(Cell::new(combinations.index(&digits)))
        };
        points.map(cell).collect()
    }

    pub(crate) fn contains(&self, point: &[f64]) -> bool {
        let on_axes = self.axes.iter().zip(point).all(|(axis, &x)| match axis {
            Axis::Continuous => x.abs() <= 1.0 + SAME,
            Axis::Levels(levels) => levels.iter().any(|level| (level - x).abs() <= SAME),
        });
        on_axes && !self.forbids(point)
    }

    pub(crate) fn forbids(&self, point: &[f64]) -> bool {
        self.forbidden.iter().any(|forbidden| (0..point.len()).all(|j| self.blocks(forbidden, j, point[j])))
    }

    /// Whether a value of one coordinate lies in the range of a forbidden box.
    pub(crate) fn blocks(&self, forbidden: &Forbidden, axis: usize, x: f64) -> bool {
        let [lower, upper] = forbidden.range(axis);
        match self.axes[axis] {
            Axis::Continuous => lower + SAME < x && x < upper - SAME,
            Axis::Levels(_) => lower - SAME <= x && x <= upper + SAME,
        }
    }

    /// What a range of a forbidden box would have to be to forbid anything along an axis; none if it does.
    pub(crate) fn missing(&self, forbidden: &Forbidden, axis: usize) -> Option<String> {
        let [lower, upper] = forbidden.ranges()[axis]?;
        let outside = missing_of_all(forbidden, axis);
        match &self.axes[axis] {
            _ if outside.is_some() => outside,
            Axis::Continuous => {
                // Whether there is room between the ends, one of which may be a bound that goes with the range.
                let [from, to] = forbidden.range(axis);
                let is_empty = f64::max(from + SAME, -1.0) >= f64::min(to - SAME, 1.0);
                let allowed =
                    "a lower end below the upper one, within the bounds: the ends themselves are not forbidden";
                is_empty.then(|| allowed.to_owned())
            }
            Axis::Levels(levels) => {
                let above = levels.partition_point(|level| *level < lower - SAME);
                let holds = levels.get(above).is_some_and(|level| *level <= upper + SAME);
                let nearest = levels[above.saturating_sub(1)..].iter().take(2).map(|level| format!("{level:?}"));
                (!holds).then(|| format!("one of its levels, as {}", nearest.collect::<Vec<_>>().join(" or ")))
            }
        }
    }

    /// Ranges of the forbidden boxes that the line through `point` along `axis` passes.
    pub(crate) fn blocked_along(&self, point: &[f64], axis: usize) -> Vec<[f64; 2]> {
        let elsewhere =
            |forbidden: &&Forbidden| (0..point.len()).all(|j| j == axis || self.blocks(forbidden, j, point[j]));
        self.forbidden.iter().filter(elsewhere).map(|forbidden| forbidden.range(axis)).collect()
    }
}

impl List {
    pub(crate) fn n_points(&self) -> usize {
        self.coordinates.len() / self.n_factors
    }

    pub(crate) fn points(&self) -> std::slice::ChunksExact<'_, f64> {
        self.coordinates.chunks_exact(self.n_factors)
    }

    pub(crate) fn point(&self, index: usize) -> &[f64] {
        &self.coordinates[index * self.n_factors..][..self.n_factors]
    }

    /// Index of the nearest candidate and the largest distance along an axis to it; the first of equals.
    pub(crate) fn nearest(&self, point: &[f64]) -> (usize, f64) {
        let mut best = (0, f64::INFINITY, f64::INFINITY);
        for (index, candidate) in self.points().enumerate() {
            let square: f64 = candidate.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum();
            if square < best.1 {
                let largest = candidate.iter().zip(point).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                best = (index, square, largest);
            }
        }
        (best.0, best.2)
    }

    pub(crate) fn retain(&mut self, keep: impl Fn(&[f64]) -> bool) {
        let kept: Vec<f64> = self.points().filter(|point| keep(point)).flatten().copied().collect();
        self.coordinates = kept;
    }

    /// Candidates that would be replicates of each other are the same one twice.
    pub(crate) fn check_distinct(&self) -> Result<(), Error> {
        match same_pair(self.n_factors, &self.coordinates) {
            Some((first, second)) => Err(Error::DuplicateCandidate { first, second }),
            None => Ok(()),
        }
    }
}

/// The same where nothing is known but that coordinates are coded.
pub(crate) fn missing_of_all(forbidden: &Forbidden, axis: usize) -> Option<String> {
    let [lower, upper] = forbidden.ranges()[axis]?;
    let is_outside = lower > 1.0 + SAME || upper < -1.0 - SAME;
    is_outside.then(|| "coded coordinates that meet -1 to 1".to_owned())
}

/// Whether a point lies in a forbidden box or on its surface.
pub(crate) fn within_closed(forbidden: &Forbidden, point: &[f64]) -> bool {
    (0..point.len()).all(|j| {
        let [lower, upper] = forbidden.range(j);
        lower - SAME <= point[j] && point[j] <= upper + SAME
    })
}

/// `n` indices spread evenly over those of `n_levels` levels, both ends among them.
pub(crate) fn spread(n: usize, n_levels: usize) -> impl Iterator<Item = usize> {
    let last = n_levels - 1;
    (0..n).map(move |i| (i * last + (n - 1) / 2) / (n - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_counted_with_the_last_axis_fastest() {
        let axes = vec![Axis::Levels(vec![-1.0, 0.0, 1.0]), Axis::Levels(vec![-1.0, 1.0])];
        let shape = BoxShape { axes, forbidden: Vec::new() };
        let of = |points: &[[f64; 2]]| shape.cells(points.iter().map(|point| &point[..]));
        let found = of(&[[-1.0, -1.0], [-1.0, 1.0], [0.0, -1.0], [1.0, 1.0 + 1e-12]]);
        assert_eq!(found, Some([0, 1, 2, 5].map(Cell::new).to_vec()));
        assert_eq!(of(&[[0.0, -1.0], [0.5, 1.0]]), None, "off the levels");
        assert_eq!(shape.relaxed().cells([[0.0, 0.0]].iter().map(|point| &point[..])), None, "no levels");
    }

    #[test]
    fn levels_are_spread_from_end_to_end() {
        for (n, n_levels, expected) in [(3, 5, vec![0, 2, 4]), (2, 9, vec![0, 8]), (4, 4, vec![0, 1, 2, 3])] {
            assert_eq!(spread(n, n_levels).collect::<Vec<_>>(), expected, "{n} of {n_levels}");
        }
    }
}
