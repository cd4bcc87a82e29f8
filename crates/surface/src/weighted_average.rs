//! What the two distance-weighted surfaces share: J(x) = Σ ω_i J_i / Σ ω_i with ω_i > 0.

use crate::Data;

/// Places that are summed before they are added to what others have summed, so that one sum need not wait for the last.
pub(crate) const GROUP: usize = 8;

/// A sum of exponentials below this is computed in another way: some of its parts have vanished.
pub(crate) const LEAST_TOTAL: f64 = 1e-150;

/// One point that takes part in an average.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Datum<'a> {
    pub(crate) point: &'a [f64],
    pub(crate) value: f64,
    /// Relative to the largest weight.
    pub(crate) weight: f64,
}

/// The places of positive weight, packed row by row: coordinates, weight, weight × value, value. The points of a place
/// are one row, with their mean and the sum of their weights: next to them their differences would cancel badly.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Packed {
    n_factors: usize,
    rows: Vec<f64>,
    lowest: f64,
    highest: f64,
}

/// One packed row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    pub(crate) point: &'a [f64],
    pub(crate) weight: f64,
    pub(crate) weighted_value: f64,
}

const EXTRA: usize = 3;

impl Packed {
    pub(crate) fn new(data: &Data) -> Self {
        let mut rows = Vec::new();
        for site in data.sites() {
            let place = Place::of(data, &site);
            rows.extend_from_slice(data.point(place.point));
            rows.extend([place.weight, place.weight * place.value, place.value]);
        }
        let lowest = used(data, None).fold(f64::INFINITY, |lowest, datum| lowest.min(datum.value));
        let highest = used(data, None).fold(f64::NEG_INFINITY, |highest, datum| highest.max(datum.value));
        Self { n_factors: data.n_factors(), rows, lowest, highest }
    }

    #[inline(always)]
    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.chunks_exact(self.n_factors + EXTRA).map(|row| {
            let (point, rest) = row.split_at(self.n_factors);
            Row { point, weight: rest[0], weighted_value: rest[1] }
        })
    }

    pub(crate) fn data(&self) -> impl Iterator<Item = Datum<'_>> + Clone {
        self.rows.chunks_exact(self.n_factors + EXTRA).map(|row| {
            let (point, rest) = row.split_at(self.n_factors);
            Datum { point, weight: rest[0], value: rest[2] }
        })
    }

    /// An average lies between the lowest and the highest value; rounding is not allowed to carry it out.
    #[inline(always)]
    pub(crate) fn within(&self, average: f64) -> f64 {
        let raised = if average < self.lowest { self.lowest } else { average };
        if raised > self.highest { self.highest } else { raised }
    }
}

/// The points of one place made one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// Index of the first point.
    pub(crate) point: usize,
    /// Their weighted mean.
    pub(crate) value: f64,
    /// The sum of their weights, relative to the largest weight of a point.
    pub(crate) weight: f64,
}

impl Place {
    pub(crate) fn of(data: &Data, site: &[usize]) -> Self {
        let largest = data.weights().iter().fold(0.0, |largest: f64, &weight| largest.max(weight));
        let relative = |&point: &usize| (data.values()[point], data.weights()[point] / largest);
        let numbers = site.iter().map(relative);
        Self { point: site[0], value: mean(numbers.clone()), weight: numbers.map(|(_, weight)| weight).sum() }
    }
}

/// The points of positive weight, without one of them.
pub(crate) fn used(data: &Data, left_out: Option<usize>) -> impl Iterator<Item = Datum<'_>> + Clone {
    let largest = data.weights().iter().fold(0.0, |largest: f64, &weight| largest.max(weight));
    let numbers = data.points().zip(data.values()).zip(data.weights()).enumerate();
    numbers
        .filter(move |&(point, (_, &weight))| weight > 0.0 && left_out != Some(point))
        .map(move |(_, ((point, &value), &weight))| Datum { point, value, weight: weight / largest })
}

/// Weighted mean as an offset from the first value, so that equal values give that value exactly.
pub(crate) fn mean(numbers: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let first = numbers.clone().next().map_or(f64::NAN, |(value, _)| value);
    let (mut total, mut offset) = (0.0, 0.0);
    for (value, weight) in numbers {
        total += weight;
        offset += weight * (value - first);
    }
    first + offset / total
}

/// |x − p|² for every lane.
#[inline(always)]
pub(crate) fn squared_distances<const L: usize>(block: &[[f64; L]], point: &[f64]) -> [f64; L] {
    let mut squares = [0.0; L];
    for (x, &coordinate) in block.iter().zip(point) {
        for lane in 0..L {
            let difference = x[lane] - coordinate;
            squares[lane] = difference.mul_add(difference, squares[lane]);
        }
    }
    squares
}
