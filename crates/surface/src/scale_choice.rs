//! The scale of a squared-exponential surface, chosen by the data.

use serde::{Deserialize, Serialize};

use crate::distance::Distance;
use crate::relative_average::average;
use crate::weighted_average::{Place, used};
use crate::{Data, Error};

/// How the scale c of a [`SquaredExponential`](crate::SquaredExponential) was chosen: what leaving out one place at a time says about it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaleChoice {
    /// The scale c with the least error.
    pub scale: f64,
    /// Weighted root mean square of the residuals of places left out, at that scale.
    pub rms: f64,
    /// Lower end of the range searched, a tenth of the inverse of the largest distance: nearly the mean everywhere.
    pub lower: f64,
    /// Upper end of the range searched, ten times the inverse of the median distance to a neighbor: nearly the value
    /// of the nearest place everywhere.
    pub upper: f64,
    /// Whether the least error was at an end of the range: the data then ask for a mean or for nearest neighbors,
    /// not for a surface with a scale.
    pub at_bound: bool,
}

/// Bounds of the scale.
pub(crate) const SCALES: [f64; 2] = [1e-100, 1e100];
/// Scales tried first, in equal ratios from one end to the other; the error has more than one minimum.
const N_TRIED: i32 = 65;
/// Steps of golden section around the best; the interval shrinks to 3e-9 of its length.
const N_STEPS: usize = 40;

impl ScaleChoice {
    pub(crate) fn of(data: &Data) -> Result<Self, Error> {
        let places = places(data)?;
        let [lower, upper] = range(&places);
        let step = (upper / lower).ln() / f64::from(N_TRIED - 1);
        let tried = (0..N_TRIED).map(|number| {
            let scale = if number == N_TRIED - 1 { upper } else { lower * (step * f64::from(number)).exp() };
            (number, scale, mean_square(&places, scale))
        });
        let best = tried.reduce(|a, b| if b.2 < a.2 { b } else { a });
        let (number, mut scale, mut least) = best.unwrap_or((0, lower, f64::INFINITY));
        let at_bound = number == 0 || number == N_TRIED - 1;
        if !at_bound {
            (scale, least) = golden_section(|scale| mean_square(&places, scale), scale, step, least);
        }
        Ok(Self { scale, rms: least.sqrt(), lower, upper, at_bound })
    }
}

/// The data with the points of each place made one.
fn places(data: &Data) -> Result<Data, Error> {
    let sites = data.sites();
    if sites.len() < 2 {
        return Err(Error::TooFewSites { found: sites.len(), least: 2, what: "choose a scale" });
    }
    let places: Vec<Place> = sites.iter().map(|site| Place::of(data, site)).collect();
    let coordinates = places.iter().flat_map(|place| data.point(place.point).iter().copied()).collect();
    // A weight of almost nothing would be refused; it counts as little at the smallest weight there is.
    let weights = places.iter().map(|place| place.weight.max(Data::SMALLEST_WEIGHT)).collect();
    Data::new(data.n_factors(), coordinates, places.iter().map(|place| place.value).collect())?.with_weights(weights)
}

/// Scales from nearly the mean to nearly the nearest neighbor.
fn range(places: &Data) -> [f64; 2] {
    let points: Vec<&[f64]> = places.points().collect();
    let mut farthest: f64 = 0.0;
    let mut neighbors = vec![f64::INFINITY; points.len()];
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            let distance = Distance::between(a, b).value();
            farthest = farthest.max(distance);
            neighbors[i] = neighbors[i].min(distance);
            neighbors[j] = neighbors[j].min(distance);
        }
    }
    neighbors.sort_by(f64::total_cmp);
    let [least, most] = SCALES;
    [(0.1 / farthest).clamp(least, most), (10.0 / neighbors[neighbors.len() / 2]).clamp(least, most)]
}

/// Weighted mean square of the residuals of places left out.
fn mean_square(places: &Data, scale: f64) -> f64 {
    let (mut total, mut sum) = (0.0, 0.0);
    for (place, (point, (&value, &weight))) in
        places.points().zip(places.values().iter().zip(places.weights())).enumerate()
    {
        let residual = value - average(point, used(places, Some(place)), scale);
        total += weight;
        sum += weight * residual * residual;
    }
    sum / total
}

/// The least value within a factor exp(±step) of a scale, and where.
fn golden_section(error: impl Fn(f64) -> f64, scale: f64, step: f64, least: f64) -> (f64, f64) {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut best, at) = ((scale, least), |logarithm: f64| (logarithm.exp(), error(logarithm.exp())));
    let (mut low, mut high) = (scale.ln() - step, scale.ln() + step);
    let mut left = high - golden * (high - low);
    let mut right = low + golden * (high - low);
    let (mut at_left, mut at_right) = (at(left), at(right));
    for _ in 0..N_STEPS {
        for candidate in [at_left, at_right] {
            if candidate.1 < best.1 {
                best = candidate;
            }
        }
        if at_left.1 <= at_right.1 {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = at(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = at(right);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_section_ends_at_the_minimum_of_a_valley_wherever_it_lies() {
        for shift in [-0.9, -0.4, 0.05, 0.3, 0.95] {
            // Smooth, not symmetric, least where the logarithm is 1 + shift.
            let error = |scale: f64| {
                let away = scale.ln() - 1.0 - shift;
                2.0 + away * away * (1.0 + 0.1 * away)
            };
            let start = 1.0_f64.exp();
            let (scale, least) = golden_section(error, start, 1.0, error(start));
            // Forty steps leave 4e-9 of the range; next to a minimum rounding hides less than 1e-8.
            assert!((scale.ln() - 1.0 - shift).abs() < 1e-7, "{shift}: {scale}");
            assert!((least - 2.0).abs() < 1e-13, "{shift}: {least}");
        }
    }

    #[test]
    fn mean_square_is_weighted_by_the_places_that_are_left_out() {
        // Corners of an equilateral triangle are equally far from each other: whatever the scale, the two others count by their weights,
        // and say 9, 9.6 and 2 for 0, 3 and 12.
        let corners = vec![-1.0, 0.0, 1.0, 0.0, 0.0, 3.0_f64.sqrt()];
        let places = Data::new(2, corners, vec![0.0, 3.0, 12.0]).expect("data").with_weights(vec![1.0, 2.0, 4.0]);
        let places = places.expect("weights");
        let expected = (81.0 + 2.0 * 6.6 * 6.6 + 4.0 * 100.0) / 7.0;
        for scale in [0.3, 1.0, 5.0] {
            let found = mean_square(&places, scale);
            assert!((found - expected).abs() < 1e-9, "{scale}: {found} for {expected}");
        }
    }

    #[test]
    fn range_goes_from_a_tenth_of_the_width_to_ten_times_the_median_neighbor() {
        let places = Data::new(1, vec![0.0, 1.0, 3.0, 7.0, 20.0], vec![0.0; 5]).expect("data");
        // Nearest neighbors at 1, 1, 2, 4 and 13; the farthest two are 20 apart.
        let [lower, upper] = range(&places);
        assert!((lower - 0.005).abs() < 1e-15 && (upper - 5.0).abs() < 1e-13, "{lower} and {upper}");
    }
}
