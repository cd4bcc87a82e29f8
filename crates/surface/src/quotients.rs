//! Σ w J/q and Σ w/q over many data with few divisions: eight fractions are brought to one denominator, because a division costs
//! as much as thirty products.

use crate::weighted_average::{GROUP, Packed, Row};

/// Where a product of eight squared distances is below this, an estimate is computed in another way.
const LEAST_PRODUCT: f64 = 1e-150;
/// The largest coordinate for which no product of eight squared distances, times a value, comes near an overflow.
const LARGEST_COORDINATE: f64 = 1e8;

/// The places of an average in groups of eight. The last group is filled up by its last place with a weight of zero, which
/// multiplies both sums of it by the same.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Groups {
    n_factors: usize,
    /// Point by point.
    coordinates: Vec<f64>,
    /// Group by group, axis by axis.
    by_axis: Vec<[f64; GROUP]>,
    groups: Vec<Group>,
    is_plain: bool,
}

/// Weights, and weights times values, of eight places, four and four.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Group {
    weights: [[f64; GROUP / 2]; 2],
    weighted_values: [[f64; GROUP / 2]; 2],
    /// All weights are 1, as those of places with a datum each: they need no product.
    is_even: bool,
}

impl Groups {
    pub(crate) fn of(packed: &Packed, n_factors: usize) -> Self {
        let rows: Vec<_> = packed.rows().collect();
        let padded = rows.len().next_multiple_of(GROUP);
        let row = |place: usize| rows.get(place).or(rows.last());
        let coordinates: Vec<f64> = (0..padded).filter_map(row).flat_map(|row| row.point).copied().collect();
        let group = |first: usize| {
            let number = |place: usize, of: fn(&Row<'_>) -> f64| rows.get(first + place).map_or(0.0, of);
            let numbers = |of: fn(&Row<'_>) -> f64| {
                std::array::from_fn(|half| std::array::from_fn(|place| number(half * (GROUP / 2) + place, of)))
            };
            let (weights, weighted_values) = (numbers(|row| row.weight), numbers(|row| row.weighted_value));
            Group { weights, weighted_values, is_even: weights == [[1.0; GROUP / 2]; 2] }
        };
        let groups = (0..padded).step_by(GROUP).map(group).collect();
        let along = |points: &[f64], axis: usize| std::array::from_fn(|place| points[place * n_factors + axis]);
        let of_groups = coordinates.chunks_exact(GROUP * n_factors);
        let by_axis = of_groups.flat_map(|points| (0..n_factors).map(move |axis| along(points, axis))).collect();
        let is_plain = coordinates.iter().all(|&x| Self::is_plain_coordinate(x));
        Self { n_factors, coordinates, by_axis, groups, is_plain }
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

    /// The points, eight for each group.
    pub(crate) fn points(&self) -> std::slice::ChunksExact<'_, f64> {
        self.coordinates.chunks_exact(self.n_factors)
    }

    #[inline(always)]
    pub(crate) fn of_eight(&self) -> &[Group] {
        &self.groups
    }

    /// Each group with the coordinates of its points, axis by axis.
    #[inline(always)]
    pub(crate) fn with_coordinates(&self) -> impl Iterator<Item = (&Group, &[[f64; GROUP]])> {
        self.groups.iter().zip(self.by_axis.chunks_exact(self.n_factors))
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

    /// Adds w/q and w J/q of eight places; `square` is q of a place and a lane. Kept in an array before, they would be packed lane by lane.
    #[inline(always)]
    pub(crate) fn add(&mut self, square: impl Fn(usize, usize) -> f64, group: &Group) {
        let ([weights, other_weights], [values, other_values]) = (&group.weights, &group.weighted_values);
        if group.is_even {
            self.add_fours(square, |q| Four::even(q, values), |q| Four::even(q, other_values));
        } else {
            self.add_fours(square, |q| Four::of(q, weights, values), |q| Four::of(q, other_weights, other_values));
        }
    }

    #[inline(always)]
    fn add_fours(
        &mut self,
        square: impl Fn(usize, usize) -> f64,
        first: impl Fn([f64; 4]) -> Four,
        second: impl Fn([f64; 4]) -> Four,
    ) {
        for lane in 0..L {
            let [a, b, c, d, e, f, g, h] = std::array::from_fn(|place| square(place, lane));
            let (one, other) = (first([a, b, c, d]), second([e, f, g, h]));
            let denominator = one.denominator * other.denominator;
            let inverse = 1.0 / denominator;
            let total = one.total.mul_add(other.denominator, other.total * one.denominator);
            let sum = one.sum.mul_add(other.denominator, other.sum * one.denominator);
            self.totals[lane] = inverse.mul_add(total, self.totals[lane]);
            self.sums[lane] = inverse.mul_add(sum, self.sums[lane]);
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

/// Σ w/q and Σ w J/q of four places over one denominator, that is to say without a division.
#[derive(Clone, Copy)]
struct Four {
    denominator: f64,
    total: f64,
    sum: f64,
}

impl Four {
    #[inline(always)]
    fn of(q: [f64; 4], weights: &[f64; 4], values: &[f64; 4]) -> Self {
        Self::with_pairs(q, Self::pairs(q, weights), values)
    }

    /// Those of weight 1, with the same bits.
    #[inline(always)]
    fn even(q: [f64; 4], values: &[f64; 4]) -> Self {
        let [a, b, c, d] = q;
        Self::with_pairs(q, [b + a, d + c], values)
    }

    /// The numerators of w_1/a + w_2/b and w_3/c + w_4/d.
    #[inline(always)]
    fn pairs([a, b, c, d]: [f64; 4], of: &[f64; 4]) -> [f64; 2] {
        [of[0].mul_add(b, of[1] * a), of[2].mul_add(d, of[3] * c)]
    }

    /// With those of the weights.
    #[inline(always)]
    fn with_pairs(q: [f64; 4], of_weights: [f64; 2], values: &[f64; 4]) -> Self {
        let [a, b, c, d] = q;
        let (ab, cd) = (a * b, c * d);
        let over_both = |[first, second]: [f64; 2]| first.mul_add(cd, second * ab);
        Self { denominator: ab * cd, total: over_both(of_weights), sum: over_both(Self::pairs(q, values)) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Places with a datum each take fewer products, and nothing else is otherwise.
        #[test]
        fn weights_of_one_need_no_product(
            q in prop::array::uniform4(1e-9..1e3), values in prop::array::uniform4(-1e3..1e3),
        ) {
            let (even, weighted) = (Four::even(q, &values), Four::of(q, &[1.0; 4], &values));
            prop_assert_eq!(
                [even.denominator, even.total, even.sum].map(f64::to_bits),
                [weighted.denominator, weighted.total, weighted.sum].map(f64::to_bits)
            );
        }
    }
}
