//! Inverse distance weighting, (32) and (33).

use multiversion::multiversion;
use serde::{Deserialize, Serialize};

use crate::distance::Distance;
use crate::lanes::is_usable;
use crate::over_grid::Squares;
use crate::quotients::{Groups, Quotients};
use crate::weighted_average::{Datum, GROUP, Packed, mean, squared_distances, used};
use crate::{Data, Error, GridPoints, LANES, Lanes, LeaveOneOut, OverGrid, Surface};

/// The average of the values, each weighted by a power of the inverse distance to its point.
///
/// ```text
/// Ĵ(p) = Σ w_i J_i d_i^−q / Σ w_i d_i^−q        d_i = ‖p − p_i‖
/// ```
///
/// Source: (32), (33)
///
/// There q = 2 and w_i = 1.
/// At a data point the estimate is the datum, at a point measured more than once the weighted mean; far away it tends
/// to the weighted mean of everything. It never leaves the range of the values.
///
/// ```
/// use surface::{Data, InverseDistance, Surface};
/// let data = Data::new(1, vec![0.0, 1.0, 1.0], vec![2.0, 5.0, 7.0])?;
/// let surface = InverseDistance::fit(data, InverseDistance::POWER)?;
/// assert_eq!(surface.predict(&[0.0]), 2.0);
/// assert_eq!(surface.predict(&[1.0]), 6.0);
/// // At 1/4 the weights are 16 and twice 16/9.
/// assert!((surface.predict(&[0.25]) - (2.0 * 9.0 + 5.0 + 7.0) / 11.0).abs() < 1e-15);
/// # Ok::<(), surface::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked", into = "Unchecked")]
pub struct InverseDistance {
    data: Data,
    power: f64,
    packed: Packed,
    groups: Groups,
    weighting: Weighting,
    /// For another power than 2: squared distances to the nearest datum between which a plain sum neither overflows nor vanishes.
    plain: [f64; 2],
}

/// How d^−q is computed from d².
#[derive(Debug, Clone, Copy, PartialEq)]
enum Weighting {
    /// q = 2, as (33).
    InverseSquare,
    /// Any other q: (d²)^(−q/2).
    Power(f64),
}

impl InverseDistance {
    /// The power in (33).
    pub const POWER: f64 = 2.0;
    /// The largest power.
    pub const LARGEST_POWER: f64 = 100.0;

    /// A surface through these data.
    ///
    /// Powers other than 2 cost a call of the platform's `powf` per datum and point.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless 0 < power ≤ [`LARGEST_POWER`](Self::LARGEST_POWER).
    pub fn fit(data: Data, power: f64) -> Result<Self, Error> {
        Self::check_power(power)?;
        let weighting =
            if (power - 2.0).abs() <= 0.0 { Weighting::InverseSquare } else { Weighting::Power(-0.5 * power) };
        // Weights of at most 1e100 and values of at most 1e100 have sums that are far from overflow.
        let plain = [1e-100_f64.powf(2.0 / power).max(1e-280), 1e100_f64.powf(2.0 / power).min(1e280)];
        let packed = Packed::new(&data);
        let groups = Groups::of(&packed, data.n_factors());
        Ok(Self { data, power, packed, groups, weighting, plain })
    }

    pub(crate) fn check_power(power: f64) -> Result<(), Error> {
        if power > 0.0 && power <= Self::LARGEST_POWER {
            return Ok(());
        }
        Err(Error::Parameter { name: "power", value: power, expected: "a number above 0, at most 100" })
    }

    /// The data it was fitted to.
    #[must_use]
    pub fn data(&self) -> &Data {
        &self.data
    }

    /// The power q.
    #[must_use]
    pub fn power(&self) -> f64 {
        self.power
    }

    /// What each value differs from the estimate of the others by.
    ///
    /// A point that was measured twice is estimated from its other measurement.
    ///
    /// # Errors
    ///
    /// [`Error::TooFewSites`] if there is only one point of positive weight.
    pub fn leave_one_out(&self) -> Result<LeaveOneOut, Error> {
        LeaveOneOut::of_averages(&self.data, |point, left_out| {
            self.packed.within(average(point, used(&self.data, left_out), self.power))
        })
    }

    #[inline(always)]
    fn estimate<const L: usize>(&self, block: &[[f64; L]]) -> [f64; L] {
        let mut estimates = match self.weighting {
            Weighting::InverseSquare => self.by_quotients(block),
            Weighting::Power(exponent) => self.by_powers(block, exponent),
        };
        let mut all_plain = true;
        for estimate in &mut estimates {
            *estimate = self.packed.within(*estimate);
            all_plain &= !estimate.is_nan();
        }
        if !all_plain {
            self.repair(block, &mut estimates);
        }
        estimates
    }

    /// With q = 2; not a number where a lane is at a datum, next to one or far away.
    #[inline(always)]
    fn by_quotients<const L: usize>(&self, block: &[[f64; L]]) -> [f64; L] {
        let mut quotients = Quotients::<L>::new();
        for (group, coordinates) in self.groups.with_coordinates() {
            let mut squares = [[0.0; L]; GROUP];
            for (x, of_axis) in block.iter().zip(coordinates) {
                for (square, coordinate) in squares.iter_mut().zip(of_axis) {
                    for lane in 0..L {
                        let difference = x[lane] - coordinate;
                        square[lane] = difference.mul_add(difference, square[lane]);
                    }
                }
            }
            quotients.add(|place, lane| squares[place][lane], group);
        }
        let mut averages = quotients.averages();
        for x in block {
            for lane in 0..L {
                let is_plain = self.groups.is_plain() && Groups::is_plain_coordinate(x[lane]);
                averages[lane] = if is_plain { averages[lane] } else { f64::NAN };
            }
        }
        averages
    }

    /// With (d²)^exponent; not a number as above.
    #[inline(always)]
    fn by_powers<const L: usize>(&self, block: &[[f64; L]], exponent: f64) -> [f64; L] {
        let (mut averages, nearest) = plain_average(&self.packed, block, |square| square.powf(exponent));
        for lane in 0..L {
            let is_plain = nearest[lane] >= self.plain[0] && nearest[lane] <= self.plain[1];
            averages[lane] = if is_plain { averages[lane] } else { f64::NAN };
        }
        averages
    }

    /// Estimates again with scaled distances where a lane is not a number.
    #[cold]
    fn repair<const L: usize>(&self, block: &[[f64; L]], estimates: &mut [f64; L]) {
        let mut point = [0.0; crate::MOST_FACTORS];
        let point = &mut point[..block.len()];
        for lane in 0..L {
            if estimates[lane].is_nan() {
                point.iter_mut().zip(block).for_each(|(x, coordinate)| *x = coordinate[lane]);
                estimates[lane] = self.packed.within(average(point, self.packed.data(), self.power));
            }
        }
    }
}

/// Average with weights ω(d²), and the squared distance to the nearest datum.
#[inline(always)]
fn plain_average<const L: usize>(
    packed: &Packed,
    block: &[[f64; L]],
    omega: impl Fn(f64) -> f64,
) -> ([f64; L], [f64; L]) {
    let (mut totals, mut sums, mut nearest) = ([0.0; L], [0.0; L], [f64::INFINITY; L]);
    for row in packed.rows() {
        let squares = squared_distances(block, row.point);
        for lane in 0..L {
            let square = squares[lane];
            nearest[lane] = if square < nearest[lane] { square } else { nearest[lane] };
            let omega = omega(square);
            totals[lane] += omega * row.weight;
            sums[lane] += omega * row.weighted_value;
        }
    }
    for lane in 0..L {
        sums[lane] /= totals[lane];
    }
    (sums, nearest)
}

/// (32) with all distances relative to the smallest: right at any distance. NaN without data or at a point that is
/// not finite.
fn average<'a>(point: &[f64], data: impl Iterator<Item = Datum<'a>> + Clone, power: f64) -> f64 {
    if !is_usable(point, point.len()) {
        return f64::NAN;
    }
    let Some((nearest, _)) = nearest(point, data.clone()) else {
        return f64::NAN;
    };
    let relative = |datum: Datum<'_>| (datum.value, datum.weight * relative_weight(point, &datum, nearest, power));
    mean(data.map(relative).filter(|&(_, weight)| weight > 0.0))
}

/// Distance to the nearest datum, and its value; the first of equals.
fn nearest<'a>(point: &[f64], data: impl Iterator<Item = Datum<'a>>) -> Option<(Distance, f64)> {
    let distances = data.map(|datum| (Distance::between(point, datum.point), datum.value));
    distances.reduce(|a, b| if b.0.is_below(a.0) { b } else { a })
}

/// (d_nearest/d)^q; 1 and 0 if the nearest is at the point itself.
fn relative_weight(point: &[f64], datum: &Datum<'_>, nearest: Distance, power: f64) -> f64 {
    let distance = Distance::between(point, datum.point);
    match (nearest.is_zero(), distance.is_zero()) {
        (true, true) => 1.0,
        (true, false) => 0.0,
        (false, _) => {
            let ratio = nearest.ratio(distance);
            if (power - 2.0).abs() <= 0.0 { ratio * ratio } else { ratio.powf(power) }
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx+avx2+fma"))]
fn estimate_lanes(surface: &InverseDistance, block: &[Lanes], estimates: &mut Lanes) {
    *estimates = surface.estimate::<LANES>(block);
}

#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx+avx2+fma"))]
fn estimate_alone(surface: &InverseDistance, block: &[[f64; 1]]) -> f64 {
    let [estimate] = surface.estimate::<1>(block);
    estimate
}

impl Surface for InverseDistance {
    fn n_factors(&self) -> usize {
        self.data.n_factors()
    }

    fn predict(&self, point: &[f64]) -> f64 {
        match crate::lanes::one_lane(point, self.n_factors()) {
            Some(block) => estimate_alone(self, &block[..point.len()]),
            None => f64::NAN,
        }
    }

    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        estimate_lanes(self, block, estimates);
    }

    fn over_grid<'a>(&'a self, grid: &'a GridPoints) -> Option<Box<dyn OverGrid + 'a>> {
        if self.weighting != Weighting::InverseSquare {
            return None;
        }
        let alone = Box::new(|point: &[f64]| self.predict(point));
        Squares::new(&self.packed, &self.groups, grid, alone).map(|squares| Box::new(squares) as Box<dyn OverGrid>)
    }

    /// ∇Ĵ = −q Σ ω_i (J_i − Ĵ)(p − p_i)/d_i² / Σ ω_i; zero at a data point if q > 1, none there if q ≤ 1.
    fn gradient(&self, point: &[f64]) -> Option<Vec<f64>> {
        if !is_usable(point, self.n_factors()) {
            return None;
        }
        let (nearest, reference) = nearest(point, self.packed.data())?;
        if nearest.is_zero() {
            return (self.power > 1.0).then(|| vec![0.0; point.len()]);
        }
        let omega = |datum: &Datum<'_>| datum.weight * relative_weight(point, datum, nearest, self.power);
        let total: f64 = self.packed.data().map(|datum| omega(&datum)).sum();
        // J_nearest − Ĵ as an average of differences: next to a datum it is small, and must not be a rest of rounding.
        let lead: f64 = self.packed.data().map(|datum| omega(&datum) / total * (reference - datum.value)).sum();
        let mut gradient = vec![0.0; point.len()];
        for datum in self.packed.data() {
            let distance = Distance::between(point, datum.point).value();
            let factor = -self.power * (omega(&datum) / total) * ((datum.value - reference) + lead) / distance;
            for (slope, (x, coordinate)) in gradient.iter_mut().zip(point.iter().zip(datum.point)) {
                *slope += factor * ((x - coordinate) / distance);
            }
        }
        gradient.iter().all(|slope| slope.is_finite()).then_some(gradient)
    }
}

/// The surface as it stands in a file: what it was fitted to.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "InverseDistance")]
struct Unchecked {
    data: Data,
    power: f64,
}

impl TryFrom<Unchecked> for InverseDistance {
    type Error = Error;

    fn try_from(unchecked: Unchecked) -> Result<Self, Error> {
        Self::fit(unchecked.data, unchecked.power)
    }
}

impl From<InverseDistance> for Unchecked {
    fn from(surface: InverseDistance) -> Self {
        Self { data: surface.data, power: surface.power }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Here they are compiled without an instruction for a product and a sum, which a function then makes up for.
        #[test]
        fn a_machine_without_fused_instructions_gives_the_same_bits(
            numbers in prop::collection::vec(-1.0..1.0, 4 * 13),
            point in prop::collection::vec(-1.2..1.2, 3),
        ) {
            let (points, values) = numbers.split_at(3 * 13);
            let data = Data::new(3, points.to_vec(), values.to_vec()).unwrap();
            let surface = InverseDistance::fit(data, 2.0).unwrap();
            let [plain] = surface.estimate::<1>(&point.iter().map(|&x| [x]).collect::<Vec<_>>());
            prop_assert_eq!(crate::surface::bits_at(&surface, &point), [plain.to_bits(); 2]);
        }
    }
}
