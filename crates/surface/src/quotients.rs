//! Σ w J/q and Σ w/q over many data with few divisions: four fractions are brought to one denominator, because a division costs
//! as much as ten products.

use crate::weighted_average::{GROUP, Packed, Row};

/// Where a product of four squared distances is below this, an estimate is computed in another way.
const LEAST_PRODUCT: f64 = 1e-150;
/// The largest coordinate for which no product of four squared distances, times a value, comes near an overflow.
const LARGEST_COORDINATE: f64 = 1e20;

/// The places of an average in groups of four. The last group is filled up by its last place with a weight of zero, which
/// multiplies both sums of it by the same.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Groups {
    n_factors: usize,
    /// Point by point.
    coordinates: Vec<f64>,
    groups: Vec<Group>,
    is_plain: bool,
}

/// Weights, and weights times values, of four places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Group {
    weights: [f64; GROUP],
    weighted_values: [f64; GROUP],
}

impl Groups {
    pub(crate) fn of(packed: &Packed, n_factors: usize) -> Self {
        let rows: Vec<_> = packed.rows().collect();
        let padded = rows.len().next_multiple_of(GROUP);
        let row = |place: usize| rows.get(place).or(rows.last());
        let coordinates: Vec<f64> = (0..padded).filter_map(row).flat_map(|row| row.point).copied().collect();
        let group = |first: usize| {
            let number = |of: fn(&Row<'_>) -> f64| std::array::from_fn(|place| rows.get(first + place).map_or(0.0, of));
            Group { weights: number(|row| row.weight), weighted_values: number(|row| row.weighted_value) }
        };
        let groups = (0..padded).step_by(GROUP).map(group).collect();
        let is_plain = coordinates.iter().all(|&x| Self::is_plain_coordinate(x));
        Self { n_factors, coordinates, groups, is_plain }
    }

    /// Whether all coordinates are small enough for products of squared distances.
    pub(crate) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// Whether a coordinate is small enough.
    #[inline(always)]
    pub(crate) fn is_plain_coordinate(x: f64) -> bool {
        x.abs() <= LARGEST_COORDINATE
    }

    /// The points, four for each group.
    pub(crate) fn points(&self) -> std::slice::ChunksExact<'_, f64> {
        self.coordinates.chunks_exact(self.n_factors)
    }

    #[inline(always)]
    pub(crate) fn of_four(&self) -> &[Group] {
        &self.groups
    }

    /// Each group with the coordinates of its points.
    #[inline(always)]
    pub(crate) fn with_points(&self) -> impl Iterator<Item = (&Group, std::slice::ChunksExact<'_, f64>)> {
        let of_group = self.coordinates.chunks_exact(GROUP * self.n_factors);
        self.groups.iter().zip(of_group.map(|points| points.chunks_exact(self.n_factors)))
    }
}

/// The two sums, for points side by side.
#[derive(Debug)]
pub(crate) struct Quotients<const L: usize> {
    totals: [f64; L],
    sums: [f64; L],
    /// The smallest denominator.
    least: [f64; L],
}

impl<const L: usize> Quotients<L> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { totals: [0.0; L], sums: [0.0; L], least: [f64::INFINITY; L] }
    }

    /// Adds w/q and w J/q of four places; `squares` are q.
    #[inline(always)]
    pub(crate) fn add(&mut self, squares: &[[f64; L]; GROUP], group: &Group) {
        let ([wa, wb, wc, wd], [va, vb, vc, vd]) = (group.weights, group.weighted_values);
        let [of_a, of_b, of_c, of_d] = squares;
        for lane in 0..L {
            let [a, b, c, d] = [of_a[lane], of_b[lane], of_c[lane], of_d[lane]];
            let (ab, cd) = (a * b, c * d);
            let denominator = ab * cd;
            let inverse = 1.0 / denominator;
            self.totals[lane] += inverse * ((wa * b + wb * a) * cd + (wc * d + wd * c) * ab);
            self.sums[lane] += inverse * ((va * b + vb * a) * cd + (vc * d + vd * c) * ab);
            self.least[lane] = if denominator < self.least[lane] { denominator } else { self.least[lane] };
        }
    }

    /// Σ w J/q over Σ w/q; not a number at a datum or next to one, where products vanish.
    #[inline(always)]
    pub(crate) fn averages(&self) -> [f64; L] {
        std::array::from_fn(|lane| {
            let average = self.sums[lane] / self.totals[lane];
            if self.least[lane] >= LEAST_PRODUCT { average } else { f64::NAN }
        })
    }
}
