//! The points that a discrete search may choose, of a grid that is never stored or of a list.

use std::collections::HashSet;

use multiversion::multiversion;
use rand::RngExt;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::runs::Regressors;
use crate::PredictionVariance;
use crate::lattice::Lattice;
use crate::measure::Measure;
use crate::nested::Nested;
use crate::products::Products;
use crate::shape::{BoxShape, List};

/// Points per block of a scan.
const BLOCK: usize = 16;

/// Grids up to this size are evaluated as a whole, larger ones part by part.
const MOST_CELLS: usize = 1 << 22;
/// Points of a part.
const PART: usize = 1 << 16;
/// A list is evaluated as part of a grid if it fills at least one in so many of its points.
const SPARSEST: usize = 8;
/// Local maxima watched, and how high they must be.
const MOST_PEAKS: usize = 250;
const PEAK_SHARE: f64 = 0.5;

/// Where runs are chosen from, and how v is evaluated on all of it.
#[derive(Debug)]
pub(crate) struct Candidates<'a> {
    points: Points<'a>,
    values: Values,
    /// Levels of the grid, or of a list that is part of one.
    lattice: Lattice,
}

#[derive(Debug)]
enum Points<'a> {
    Grid { shape: &'a BoxShape, measure: Measure },
    List(&'a List),
}

#[derive(Debug)]
enum Values {
    /// The whole grid at once.
    Whole(Nested),
    /// So many points at a time.
    Parts(Nested, usize),
    /// The quadratic form, for lists that are not part of a grid.
    Blocks(Blocks),
}

/// Points with v near its maximum.
#[derive(Debug)]
pub(crate) struct NearActive {
    pub(crate) highest: f64,
    /// Point by point, without repetition.
    pub(crate) points: Vec<f64>,
    /// The first of them are local maxima, as many as this.
    pub(crate) n_peaks: usize,
}

impl<'a> Candidates<'a> {
    pub(crate) fn grid(shape: &'a BoxShape, products: &Products) -> Self {
        let mut lattice = Lattice::whole(shape);
        let nested = Nested::of(products, lattice.levels().to_vec());
        let values = if lattice.n_points() > MOST_CELLS {
            Values::Parts(nested, PART)
        } else {
            lattice = lattice.without_forbidden(shape);
            Values::Whole(nested)
        };
        Self { points: Points::Grid { shape, measure: Measure::of(shape) }, values, lattice }
    }

    pub(crate) fn list(list: &'a List, regressors: &Regressors, products: &Products) -> Self {
        let points = Points::List(list);
        match grid_around(list) {
            Some(lattice) => {
                let values = Values::Whole(Nested::of(products, lattice.levels().to_vec()));
                Self { points, values, lattice }
            }
            None => {
                let lattice = Lattice::new(Vec::new());
                Self { points, values: Values::Blocks(Blocks::of(list, regressors)), lattice }
            }
        }
    }

    /// A random candidate.
    pub(crate) fn sample(&self, generator: &mut Pcg64) -> Vec<f64> {
        match &self.points {
            Points::Grid { measure, .. } => measure.sample(generator),
            Points::List(list) => list.point(generator.random_range(0..list.n_points())).to_vec(),
        }
    }

    /// Up to `count` candidates close to a point, the nearest first; on a grid with a nearest allowed level.
    pub(crate) fn near(&self, point: &[f64], count: usize) -> Vec<Vec<f64>> {
        match &self.points {
            Points::List(list) => {
                let near = match self.values {
                    Values::Whole(_) => near_on_grid(&self.lattice, point, count, |_| true),
                    _ => Vec::new(),
                };
                if near.len() >= count / 2 { near } else { nearest_of_list(list, point, count) }
            }
            Points::Grid { shape, .. } => {
                let near = near_on_grid(&self.lattice, point, count, |at| !shape.forbids(at));
                if !near.is_empty() {
                    return near;
                }
                // All around is forbidden: the nearest allowed point of the whole grid.
                let square = |at: &[f64]| at.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
                let points = (0..self.lattice.n_points()).map(|i| self.lattice.point(i));
                let allowed = points.filter(|at| !shape.forbids(at));
                allowed.min_by(|a, b| square(a).total_cmp(&square(b))).into_iter().collect()
            }
        }
    }

    /// The nearest of all candidates that `is_free` lets pass, the first of equals; none if it lets none pass.
    pub(crate) fn nearest_free(&self, point: &[f64], is_free: impl Fn(&[f64]) -> bool) -> Option<Vec<f64>> {
        let square = |at: &[f64]| at.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let mut order: Vec<(f64, usize)> =
            (0..self.n_indices()).map(|index| (square(&self.at(index)), index)).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let points = order.into_iter().filter(|&(_, index)| self.is_candidate(index)).map(|(_, index)| self.at(index));
        points.into_iter().find(|at| is_free(at))
    }

    /// A random one of the candidates that `is_free` lets pass: the first after a random place; none if it lets none pass.
    pub(crate) fn sample_free(&self, generator: &mut Pcg64, is_free: impl Fn(&[f64]) -> bool) -> Option<Vec<f64>> {
        let n = self.n_indices();
        let first = generator.random_range(0..n);
        let indices = (first..n).chain(0..first).filter(|&index| self.is_candidate(index));
        indices.map(|index| self.at(index)).find(|at| is_free(at))
    }

    /// Number of indices of [`at`](Self::at).
    fn n_indices(&self) -> usize {
        match &self.points {
            Points::Grid { .. } => self.lattice.n_points(),
            Points::List(list) => list.n_points(),
        }
    }

    fn at(&self, index: usize) -> Vec<f64> {
        match &self.points {
            Points::Grid { .. } => self.lattice.point(index),
            Points::List(list) => list.point(index).to_vec(),
        }
    }

    /// Whether a point of a grid is not forbidden.
    fn is_candidate(&self, index: usize) -> bool {
        match &self.points {
            Points::Grid { shape, .. } => shape.forbidden.is_empty() || !shape.forbids(&self.lattice.point(index)),
            Points::List(_) => true,
        }
    }

    /// The highest v over all candidates; its local maxima along the axes, and the candidates above a share of it, at
    /// most `most`, both the highest first. `values` is scratch.
    pub(crate) fn scan(
        &self,
        variance: &PredictionVariance,
        inverse: &[f64],
        (share, most): (f64, usize),
        values: &mut Vec<f64>,
    ) -> NearActive {
        let mut found: Vec<(f64, usize)>;
        let highest;
        let mut peaks = Vec::new();
        match (&self.values, &self.points) {
            (Values::Parts(nested, most), Points::Grid { shape, .. }) => {
                (highest, found) = self.scan_parts((nested, *most), variance.coefficients(), shape, share);
            }
            _ => {
                match &self.values {
                    Values::Blocks(blocks) => blocks.values(inverse, values),
                    Values::Parts(..) => values.clear(),
                    Values::Whole(nested) => {
                        nested.values(variance.coefficients(), values);
                        if let Some(allowed) = self.lattice.allowed() {
                            for (value, allowed) in values.iter_mut().zip(allowed) {
                                *value = if *allowed { *value } else { f64::NEG_INFINITY };
                            }
                        }
                        peaks = self.lattice.local_maxima(values, PEAK_SHARE * largest(values), MOST_PEAKS);
                    }
                }
                highest = largest(values);
                let above = values.iter().enumerate().filter(|(_, v)| **v >= share * highest);
                found = above.map(|(index, v)| (*v, index)).collect();
            }
        }
        let compare = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if found.len() > most {
            found.select_nth_unstable_by(most, compare);
            found.truncate(most);
        }
        found.sort_by(compare);
        let n_peaks = peaks.len();
        let mut seen: HashSet<usize> = peaks.iter().copied().collect();
        peaks.extend(found.iter().map(|&(_, index)| index).filter(|&index| seen.insert(index)));
        let points = match (&self.values, &self.points) {
            (Values::Blocks(_), Points::List(list)) => {
                peaks.iter().flat_map(|&index| list.point(index).to_vec()).collect()
            }
            _ => peaks.iter().flat_map(|&index| self.lattice.point(index)).collect(),
        };
        NearActive { highest, points, n_peaks }
    }

    /// The highest allowed v of a grid, and the points above a share of it with their indices.
    fn scan_parts(
        &self,
        (nested, most): (&Nested, usize),
        coefficients: &[f64],
        shape: &BoxShape,
        share: f64,
    ) -> (f64, Vec<(f64, usize)>) {
        let mut highest = 0.0_f64;
        let mut found: Vec<(f64, usize)> = Vec::new();
        nested.parts(coefficients, most, |first, values| {
            let before = highest;
            for (index, &value) in values.iter().enumerate() {
                if value >= share * highest && !shape.forbids(&self.lattice.point(first + index)) {
                    highest = highest.max(value);
                    found.push((value, first + index));
                }
            }
            if highest > before {
                found.retain(|(value, _)| *value >= share * highest);
            }
        });
        (highest, found)
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn largest(values: &[f64]) -> f64 {
    let mut lanes = [0.0; BLOCK];
    let blocks = values.chunks_exact(BLOCK);
    let rest = blocks.remainder().iter().copied().fold(0.0, f64::max);
    for block in blocks {
        for (lane, value) in lanes.iter_mut().zip(block) {
            *lane = if *value > *lane { *value } else { *lane };
        }
    }
    lanes.iter().copied().fold(rest, f64::max)
}

/// The grid that a list is part of, with its points allowed; none if they would be few among many others.
fn grid_around(list: &List) -> Option<Lattice> {
    let mut levels: Vec<Vec<f64>> = Vec::with_capacity(list.n_factors);
    let mut cells = 1_usize;
    for axis in 0..list.n_factors {
        let mut found: Vec<f64> = list.points().map(|point| point[axis] + 0.0).collect();
        found.sort_unstable_by(f64::total_cmp);
        found.dedup();
        cells = cells.saturating_mul(found.len());
        levels.push(found);
        if cells > MOST_CELLS.min(list.n_points().saturating_mul(SPARSEST)) {
            return None;
        }
    }
    let lattice = Lattice::new(levels);
    let mut allowed = vec![false; lattice.n_points()];
    let mut digits = vec![0; list.n_factors];
    for point in list.points() {
        for ((digit, levels), x) in digits.iter_mut().zip(lattice.levels()).zip(point) {
            *digit = levels.binary_search_by(|level| level.total_cmp(&(x + 0.0))).ok()? as u64;
        }
        allowed[lattice.combinations().index(&digits) as usize] = true;
    }
    Some(lattice.with_allowed(allowed))
}

/// By visiting all of the list.
fn nearest_of_list(list: &List, point: &[f64], count: usize) -> Vec<Vec<f64>> {
    let distance = |other: &[f64]| other.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    // A ball that holds about four times as many if the list fills the cube, larger until there are enough.
    let share = (4.0 * count as f64 / list.n_points() as f64).powf(1.0 / point.len() as f64);
    let mut square = share * share;
    let mut near: Vec<(f64, usize)>;
    loop {
        let within = list.points().map(distance).enumerate().filter(|(_, d)| *d <= square);
        near = within.map(|(index, d)| (d, index)).collect();
        if near.len() >= count.min(list.n_points()) {
            break;
        }
        square *= 4.0;
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(count);
    near.into_iter().map(|(_, index)| list.point(index).to_vec()).collect()
}

/// Points of a grid around a point: the products of the levels nearest along each axis, as many as give `count`.
fn near_on_grid(lattice: &Lattice, point: &[f64], count: usize, is_free: impl Fn(&[f64]) -> bool) -> Vec<Vec<f64>> {
    // Steps in units of levels from the nearest level, ordered by their squared length.
    let k = point.len();
    let reach: i64 = if k <= 3 { 3 } else { 2 };
    let nearest = |levels: &Vec<f64>, x: f64| {
        let distance = |i: &usize| (levels[*i] - x).abs();
        (0..levels.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0) as i64
    };
    let center: Vec<i64> = lattice.levels().iter().zip(point).map(|(levels, &x)| nearest(levels, x)).collect();
    let mut found: Vec<(i64, Vec<f64>)> = Vec::new();
    let (mut steps, mut digits) = (vec![0_i64; k], vec![0_u64; k]);
    // At most two axes move at once: the number of neighbors grows with the square of the number of axes.
    let mut consider = |steps: &[i64]| {
        for ((digit, &count), (center, step)) in
            digits.iter_mut().zip(lattice.combinations().counts()).zip(center.iter().zip(steps))
        {
            match u64::try_from(center + step) {
                Ok(level) if level < count => *digit = level,
                _ => return,
            }
        }
        if !lattice.is_allowed(lattice.combinations().index(&digits) as usize) {
            return;
        }
        let at: Vec<f64> =
            lattice.levels().iter().zip(&digits).map(|(levels, &digit)| levels[digit as usize]).collect();
        if is_free(&at) {
            found.push((steps.iter().map(|s| s * s).sum(), at));
        }
    };
    consider(&steps);
    for a in 0..k {
        for first in (-reach..=reach).filter(|&s| s != 0) {
            steps[a] = first;
            consider(&steps);
            for b in a + 1..k {
                for second in (-reach..=reach).filter(|&s| s != 0) {
                    steps[b] = second;
                    consider(&steps);
                }
                steps[b] = 0;
            }
        }
        steps[a] = 0;
    }
    found.sort_by_key(|(square, _)| *square);
    found.truncate(count);
    found.into_iter().map(|(_, at)| at).collect()
}

/// Regressors of a list, block by block, term by term, point by point.
#[derive(Debug)]
pub(crate) struct Blocks {
    n_terms: usize,
    n_points: usize,
    values: Vec<f64>,
}

impl Blocks {
    fn of(list: &List, regressors: &Regressors) -> Self {
        let p = regressors.n_terms;
        let mut values = vec![0.0; list.n_points().div_ceil(BLOCK) * p * BLOCK];
        let blocks = values.par_chunks_exact_mut(p * BLOCK).zip(list.coordinates.par_chunks(BLOCK * list.n_factors));
        blocks.for_each(|(block, points)| {
            let mut row = vec![0.0; p];
            for (lane, point) in points.chunks_exact(list.n_factors).enumerate() {
                regressors.fill(point, &mut row);
                for (term, value) in row.iter().enumerate() {
                    block[term * BLOCK + lane] = *value;
                }
            }
        });
        Self { n_terms: p, n_points: list.n_points(), values }
    }

    /// v at every point.
    fn values(&self, inverse: &[f64], values: &mut Vec<f64>) {
        let p = self.n_terms;
        // The upper triangle with the off-diagonal elements doubled: half of the products.
        let mut upper = Vec::with_capacity(p * (p + 1) / 2);
        for i in 0..p {
            upper.push(inverse[i * p + i]);
            upper.extend((i + 1..p).map(|j| 2.0 * inverse[i * p + j]));
        }
        values.clear();
        values.resize(self.values.len() / p, 0.0);
        let chunk = 256;
        values
            .par_chunks_mut(chunk * BLOCK)
            .zip(self.values.par_chunks(chunk * BLOCK * p))
            .for_each(|(values, blocks)| quadratic_forms(blocks, &upper, p, values));
        values.truncate(self.n_points);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2"))]
fn quadratic_forms(blocks: &[f64], upper: &[f64], p: usize, values: &mut [f64]) {
    for (block, values) in blocks.chunks_exact(p * BLOCK).zip(values.chunks_exact_mut(BLOCK)) {
        let mut sums = [0.0; BLOCK];
        let mut at = 0;
        for i in 0..p {
            let mut inner = [0.0; BLOCK];
            for j in i..p {
                let column = &block[j * BLOCK..j * BLOCK + BLOCK];
                let d = upper[at];
                at += 1;
                for lane in 0..BLOCK {
                    inner[lane] += d * column[lane];
                }
            }
            let row = &block[i * BLOCK..i * BLOCK + BLOCK];
            for lane in 0..BLOCK {
                sums[lane] += row[lane] * inner[lane];
            }
        }
        values.copy_from_slice(&sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Axis;
    use crate::{Design, Model};

    #[test]
    fn a_grid_in_parts_is_scanned_as_one_as_a_whole() {
        let model = Model::quadratic(3).expect("a model");
        let number = |i: usize| ((i * i * 7919 + i * 31) % 2003) as f64 / 1001.0 - 1.0;
        let design = Design::new(3, (0..42).map(number).collect()).expect("a design");
        let products = Products::of(&model);
        let information = crate::Information::of(&model, &design).expect("not singular");
        let variance = PredictionVariance::from_information(&model, &information).expect("a variance");
        let corner = crate::Forbidden::new(vec![Some([0.3, 1.0]), None, Some([-1.0, -0.2])]).expect("a box");
        let axes = [7, 6, 5].map(|n| Axis::equally_spaced(n).expect("levels")).to_vec();
        let shape = BoxShape { axes, forbidden: vec![corner] };
        let whole = Candidates::grid(&shape, &products);
        let scan = |candidates: &Candidates<'_>| {
            let near = candidates.scan(&variance, information.inverse(), (0.5, 1000), &mut Vec::new());
            let mut points: Vec<Vec<u64>> =
                near.points.chunks_exact(3).map(|point| point.iter().map(|x| (x + 0.0).to_bits()).collect()).collect();
            points.sort();
            (near.highest, points)
        };
        let expected = scan(&whole);
        assert!(expected.1.len() >= 5, "{}", expected.1.len());
        for most in [1, 5, 30, 210] {
            let nested = Nested::of(&products, whole.lattice.levels().to_vec());
            let points = Points::Grid { shape: &shape, measure: Measure::of(&shape) };
            let lattice = Lattice::whole(&shape);
            let (highest, points) = scan(&Candidates { points, values: Values::Parts(nested, most), lattice });
            assert!((highest - expected.0).abs() < 1e-12 * highest && points == expected.1, "{most} points at a time");
        }
    }

    #[test]
    fn a_list_that_is_part_of_a_grid_is_scanned_as_any_other_list() {
        let model = Model::quadratic(3).expect("a model");
        let number = |i: usize| ((i * i * 7919 + i * 31) % 2003) as f64 / 1001.0 - 1.0;
        let design = Design::new(3, (0..42).map(number).collect()).expect("a design");
        let products = Products::of(&model);
        let information = crate::Information::of(&model, &design).expect("not singular");
        let variance = PredictionVariance::from_information(&model, &information).expect("a variance");
        let cells = (0..7_usize.pow(3)).filter(|cell| cell % 5 != 2);
        let coordinates = cells.flat_map(|cell| [1, 7, 49].map(|stride| (cell / stride % 7) as f64 / 3.0 - 1.0));
        let list = List { n_factors: 3, coordinates: coordinates.collect() };
        let regressors = Regressors::of(&model);
        let gridded = Candidates::list(&list, &regressors, &products);
        assert!(matches!(gridded.values, Values::Whole(_)), "four in five of the points of a grid");
        let lattice = Lattice::new(Vec::new());
        let blocks = Values::Blocks(Blocks::of(&list, &regressors));
        let any = Candidates { points: Points::List(&list), values: blocks, lattice };
        let scan = |candidates: &Candidates<'_>| {
            candidates.scan(&variance, information.inverse(), (0.5, 1000), &mut Vec::new())
        };
        let (one, other) = (scan(&gridded), scan(&any));
        assert!((one.highest - other.highest).abs() < 1e-9 * other.highest, "{} {}", one.highest, other.highest);
        let sorted = |points: &[f64]| {
            let mut points: Vec<Vec<u64>> =
                points.chunks_exact(3).map(|point| point.iter().map(|x| (x + 0.0).to_bits()).collect()).collect();
            points.sort();
            points
        };
        assert_eq!(sorted(&one.points), sorted(&other.points));
        assert!(one.n_peaks > 1, "a quadratic has several maxima");
        let n_inside = list.points().filter(|point| variance.value(point) >= 0.5 * one.highest).count();
        assert_eq!(one.points.len() / 3, n_inside, "by the polynomial itself");
    }

    /// Of 2049 × 2049 points, one more than are kept as a whole; 2048 × 2048 are.
    #[test]
    fn a_grid_too_large_to_be_scanned_as_a_whole_is_scanned_in_parts() {
        let products = Products::of(&Model::quadratic(2).expect("a model"));
        let shape = |count| {
            let axes = vec![Axis::equally_spaced(count).expect("levels"); 2];
            BoxShape { axes, forbidden: Vec::new() }
        };
        assert!(matches!(Candidates::grid(&shape(2048), &products).values, Values::Whole(_)));
        assert!(matches!(Candidates::grid(&shape(2049), &products).values, Values::Parts(_, PART)));
    }

    /// The highest of them, and no more than were asked for beside the local maxima.
    #[test]
    fn a_scan_returns_as_many_points_as_are_asked_for_the_highest() {
        let model = Model::quadratic(2).expect("a model");
        let runs = [[-1.0, -0.9], [0.9, -1.0], [-0.8, 1.0], [1.0, 0.7], [0.1, -1.0], [-1.0, 0.2], [0.2, 0.1]];
        let design = Design::from_runs(&runs).expect("a design");
        let information = crate::Information::of(&model, &design).expect("not singular");
        let variance = PredictionVariance::from_information(&model, &information).expect("a variance");
        let shape = BoxShape { axes: vec![Axis::equally_spaced(9).expect("levels"); 2], forbidden: Vec::new() };
        let candidates = Candidates::grid(&shape, &Products::of(&model));
        let near = candidates.scan(&variance, information.inverse(), (0.0, 12), &mut Vec::new());
        let found: Vec<f64> = near.points.chunks_exact(2).map(|point| variance.value(point)).collect();
        let mut all: Vec<f64> = (0..81).map(|index| variance.value(&candidates.lattice.point(index))).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        assert!(found.len() >= 12 && found.len() <= 12 + near.n_peaks, "{} points", found.len());
        let twelfth = all[11];
        assert!(found[near.n_peaks..].iter().all(|value| *value >= twelfth - 1e-12), "{found:?} below {twelfth}");
        assert!((near.highest - all[0]).abs() < 1e-12 && n_above(&found, twelfth) == 12, "{found:?}");
    }

    fn n_above(values: &[f64], least: f64) -> usize {
        values.iter().filter(|value| **value >= least - 1e-12).count()
    }
}
