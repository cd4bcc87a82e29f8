//! Squared-exponential weighting, (34).

use multiversion::multiversion;
use serde::{Deserialize, Serialize};

use crate::exponential::short_exp_of_minus;
use crate::lanes::{is_usable, one_lane};
use crate::over_grid::Exponentials;
use crate::relative_average::{average, nearest, relative_weight};
use crate::scale_choice::SCALES;
use crate::weighted_average::{Datum, LEAST_TOTAL, Packed, Row, used};
use crate::{Data, Error, GridPoints, LANES, Lanes, LeaveOneOut, MOST_FACTORS, OverGrid, ScaleChoice, Surface};

/// The average of the values, each weighted by a squared exponential of the distance to its point.
///
/// ```text
/// Ĵ(p) = Σ w_i J_i exp(−(c d_i)²) / Σ w_i exp(−(c d_i)²)        d_i = ‖p − p_i‖
/// ```
///
/// Source: (34)
///
/// There w_i = 1.
/// Differs from the source: as printed, the square is outside of the sign, and the weight would grow with distance.
///
/// It smooths and does not interpolate: 1/c is the distance at which a weight has fallen to 1/e. Where every
/// exponential vanishes the ratio still has a limit, the value at the nearest point, and that is what is returned.
/// It never leaves the range of the values.
///
/// ```
/// use surface::{Data, SquaredExponential, Surface};
/// let data = Data::new(1, vec![0.0, 1.0], vec![2.0, 6.0])?;
/// let surface = SquaredExponential::fit(data, 1.5)?;
/// assert!((surface.predict(&[0.5]) - 4.0).abs() < 1e-15);
/// // At a datum the other counts exp(-2.25).
/// let other = (-2.25_f64).exp();
/// assert!((surface.predict(&[0.0]) - (2.0 + 6.0 * other) / (1.0 + other)).abs() < 1e-13);
/// assert_eq!(surface.predict(&[-1e9]), 2.0);
/// # Ok::<(), surface::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked", into = "Unchecked")]
pub struct SquaredExponential {
    data: Data,
    scale: f64,
    choice: Option<ScaleChoice>,
    packed: Packed,
}

impl SquaredExponential {
    /// Bounds of the scale c, far beyond use, so that no product with it overflows.
    pub const SCALES: [f64; 2] = SCALES;

    /// A surface through these data with a given scale c, in the inverse unit of the coordinates.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless c lies within [`SCALES`](Self::SCALES).
    pub fn fit(data: Data, scale: f64) -> Result<Self, Error> {
        Self::check_scale(scale)?;
        let packed = Packed::new(&data);
        Ok(Self { data, scale, choice: None, packed })
    }

    pub(crate) fn check_scale(scale: f64) -> Result<(), Error> {
        let [least, most] = Self::SCALES;
        if (least..=most).contains(&scale) {
            return Ok(());
        }
        Err(Error::Parameter { name: "scale", value: scale, expected: "a number from 1e-100 to 1e100" })
    }

    /// A surface with the scale that predicts each place best from the other places.
    ///
    /// The source leaves c to the user. This rule takes the least weighted mean square of the residuals when all
    /// points of one place are left out together: were repeats left out one by one, each would be predicted by
    /// its partners and the scale would grow without bound. [`ScaleChoice`] tells how it went.
    ///
    /// # Errors
    ///
    /// [`Error::TooFewSites`] for fewer than two different points of positive weight.
    pub fn fit_scale(data: Data) -> Result<Self, Error> {
        let choice = ScaleChoice::of(&data)?;
        let surface = Self::fit(data, choice.scale)?;
        Ok(Self { choice: Some(choice), ..surface })
    }

    /// The data it was fitted to.
    #[must_use]
    pub fn data(&self) -> &Data {
        &self.data
    }

    /// The scale c.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// How the scale was chosen; none if it was given.
    #[must_use]
    pub fn choice(&self) -> Option<&ScaleChoice> {
        self.choice.as_ref()
    }

    /// What each value differs from the estimate of the others by, with the scale as it is.
    ///
    /// A point that was measured twice is estimated with the help of its other measurement.
    ///
    /// # Errors
    ///
    /// [`Error::TooFewSites`] if there is only one point of positive weight.
    pub fn leave_one_out(&self) -> Result<LeaveOneOut, Error> {
        LeaveOneOut::of_averages(&self.data, |point, left_out| {
            self.packed.within(average(point, used(&self.data, left_out), self.scale))
        })
    }

    #[inline(always)]
    fn estimate<const L: usize>(&self, block: &[[f64; L]]) -> [f64; L] {
        let block = &block[..block.len().min(self.data.n_factors())];
        let mut sums = Sums::<L>::new(self.scale * self.scale);
        let mut rows = self.packed.rows();
        while let Some(first) = rows.next() {
            match (rows.next(), rows.next()) {
                (Some(second), Some(third)) => sums.add(block, &[first, second, third]),
                (Some(second), None) => sums.add(block, &[first, second]),
                _ => sums.add(block, &[first]),
            }
        }
        let Sums { totals, mut sums, .. } = sums;
        let mut all_plain = true;
        for lane in 0..L {
            sums[lane] = self.packed.within(sums[lane] / totals[lane]);
            all_plain &= totals[lane] >= LEAST_TOTAL;
        }
        if !all_plain {
            self.repair(block, &totals, &mut sums);
        }
        sums
    }

    /// Estimates again relative to the nearest datum where a lane is far from all.
    #[cold]
    fn repair<const L: usize>(&self, block: &[[f64; L]], totals: &[f64; L], estimates: &mut [f64; L]) {
        let mut point = [0.0; MOST_FACTORS];
        let point = &mut point[..block.len()];
        for lane in 0..L {
            if totals[lane] >= LEAST_TOTAL {
                continue;
            }
            point.iter_mut().zip(block).for_each(|(x, coordinate)| *x = coordinate[lane]);
            estimates[lane] = self.packed.within(average(point, self.packed.data(), self.scale));
        }
    }
}

/// Σ w exp(−(c d)²) and Σ w J exp(−(c d)²), for points side by side.
struct Sums<const L: usize> {
    /// c².
    rate: f64,
    totals: [f64; L],
    sums: [f64; L],
}

impl<const L: usize> Sums<L> {
    #[inline(always)]
    fn new(rate: f64) -> Self {
        Self { rate, totals: [0.0; L], sums: [0.0; L] }
    }

    /// Adds so many data, one after the other: three are enough for no step to wait for another.
    #[inline(always)]
    fn add<const N: usize>(&mut self, block: &[[f64; L]], rows: &[Row<'_>; N]) {
        let mut squares = [[0.0; L]; N];
        for (axis, x) in block.iter().enumerate() {
            for (of_row, row) in squares.iter_mut().zip(rows) {
                let coordinate = row.point[axis];
                for lane in 0..L {
                    let difference = x[lane] - coordinate;
                    of_row[lane] = difference.mul_add(difference, of_row[lane]);
                }
            }
        }
        let omegas = short_exp_of_minus(self.rate, &squares);
        for (of_row, row) in omegas.iter().zip(rows) {
            for (omega, (total, sum)) in of_row.iter().zip(self.totals.iter_mut().zip(&mut self.sums)) {
                *total = omega.mul_add(row.weight, *total);
                *sum = omega.mul_add(row.weighted_value, *sum);
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx+avx2+fma"))]
fn estimate_lanes(surface: &SquaredExponential, block: &[Lanes], estimates: &mut Lanes) {
    *estimates = surface.estimate::<LANES>(block);
}

#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx+avx2+fma"))]
fn estimate_alone(surface: &SquaredExponential, block: &[[f64; 1]]) -> f64 {
    let [estimate] = surface.estimate::<1>(block);
    estimate
}

impl Surface for SquaredExponential {
    fn n_factors(&self) -> usize {
        self.data.n_factors()
    }

    fn predict(&self, point: &[f64]) -> f64 {
        match one_lane(point, self.n_factors()) {
            Some(block) => estimate_alone(self, &block[..point.len()]),
            None => f64::NAN,
        }
    }

    fn predict_lanes(&self, block: &[Lanes], estimates: &mut Lanes) {
        estimate_lanes(self, block, estimates);
    }

    fn over_grid<'a>(&'a self, grid: &'a GridPoints) -> Option<Box<dyn OverGrid + 'a>> {
        let alone = Box::new(|point: &[f64]| self.predict(point));
        Exponentials::new(&self.packed, self.scale, grid, alone)
            .map(|exponentials| Box::new(exponentials) as Box<dyn OverGrid>)
    }

    /// ∇Ĵ = 2 c² Σ ω_i (J_i − Ĵ) p_i / Σ ω_i.
    fn gradient(&self, point: &[f64]) -> Option<Vec<f64>> {
        if !is_usable(point, self.n_factors()) {
            return None;
        }
        let nearest = nearest(point, self.packed.data())?;
        let omega = |datum: &Datum<'_>| datum.weight * relative_weight(point, datum.point, nearest, self.scale);
        let total: f64 = self.packed.data().map(|datum| omega(&datum)).sum();
        let estimate = average(point, self.packed.data(), self.scale);
        let mut gradient = vec![0.0; point.len()];
        for datum in self.packed.data() {
            let factor = 2.0 * self.scale * (omega(&datum) / total) * (datum.value - estimate) * self.scale;
            // Any common origin will do, since the ω_i (J_i − Ĵ) sum to zero; the nearest point cancels least.
            for (slope, (coordinate, origin)) in gradient.iter_mut().zip(datum.point.iter().zip(nearest)) {
                *slope += factor * (coordinate - origin);
            }
        }
        gradient.iter().all(|slope| slope.is_finite()).then_some(gradient)
    }
}

/// The surface as it stands in a file: what it was fitted to, and where the scale comes from.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "SquaredExponential")]
struct Unchecked {
    data: Data,
    scale: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    choice: Option<ScaleChoice>,
}

impl TryFrom<Unchecked> for SquaredExponential {
    type Error = Error;

    fn try_from(unchecked: Unchecked) -> Result<Self, Error> {
        Ok(Self { choice: unchecked.choice, ..Self::fit(unchecked.data, unchecked.scale)? })
    }
}

impl From<SquaredExponential> for Unchecked {
    fn from(surface: SquaredExponential) -> Self {
        Self { data: surface.data, scale: surface.scale, choice: surface.choice }
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
            let surface = SquaredExponential::fit(data, 1.5).unwrap();
            let [plain] = surface.estimate::<1>(&point.iter().map(|&x| [x]).collect::<Vec<_>>());
            prop_assert_eq!(crate::surface::bits_at(&surface, &point), [plain.to_bits(); 2]);
        }
    }
}
