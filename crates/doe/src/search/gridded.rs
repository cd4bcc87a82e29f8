//! The grids on which a box is searched: its own, a part of a very large one, or one in place of continuous axes.

use crate::same::{SAME, SAME_RUN};
use crate::shape::{Axis, BoxShape, spread};
use crate::{Error, Forbidden};

/// Points of a grid that is searched as a whole, at most: a scan of it takes a fraction of a second.
const WHOLE_GRID_POINTS: f64 = 16_777_216.0;

/// The grid, or of a large one the part with fewer levels on its longest axes, evenly spread: both ends, and what lies
/// next to the end of a forbidden range, are among them.
pub(crate) fn thinned(shape: &BoxShape) -> BoxShape {
    let counts: Vec<usize> =
        shape.axes.iter().map(|axis| if let Axis::Levels(levels) = axis { levels.len() } else { 1 }).collect();
    let n_points = |most: usize| -> f64 { counts.iter().map(|&count| count.min(most) as f64).product() };
    if n_points(usize::MAX) <= WHOLE_GRID_POINTS {
        return shape.clone();
    }
    let longest = counts.iter().copied().max().unwrap_or(1);
    let (mut kept, mut too_many) = (2, longest);
    while too_many - kept > 1 {
        let middle = kept + (too_many - kept) / 2;
        if n_points(middle) <= GRID_POINTS { kept = middle } else { too_many = middle }
    }
    let axis = |(factor, axis): (usize, &Axis)| match axis {
        Axis::Levels(levels) if levels.len() > kept => {
            let last = levels.len() - 1;
            let mut indices: Vec<usize> = spread(kept, levels.len()).collect();
            for end in shape.forbidden.iter().flat_map(|forbidden| forbidden.range(factor)) {
                let above = levels.partition_point(|level| *level < end);
                indices.extend([above.saturating_sub(1), above.min(last)]);
            }
            indices.sort_unstable();
            indices.dedup();
            Axis::Levels(indices.into_iter().map(|index| levels[index]).collect())
        }
        axis => axis.clone(),
    };
    BoxShape { axes: shape.axes.iter().enumerate().map(axis).collect(), forbidden: shape.forbidden.clone() }
}

/// Points of a grid in place of a box with continuous axes, at most: as many as can be scanned quickly.
const GRID_POINTS: f64 = 4_194_304.0;
/// Levels of such a grid along a continuous axis, at most: a twentieth of half the axis apart.
const GRID_LEVELS: u32 = 41;

/// The box with levels along its continuous axes, an odd number so that ends and middle are among them.
pub(crate) fn gridded(shape: &BoxShape) -> Result<BoxShape, Error> {
    let given = |axis: &Axis| match axis {
        Axis::Continuous => None,
        Axis::Levels(levels) => Some(levels.len() as f64),
    };
    let n_continuous = shape.axes.iter().filter(|axis| given(axis).is_none()).count();
    let given: f64 = shape.axes.iter().filter_map(given).product();
    let most = (GRID_POINTS / given).powf(1.0 / n_continuous as f64);
    let levels = (3..=GRID_LEVELS).rev().step_by(2).find(|&levels| f64::from(levels) <= most).unwrap_or(3);
    let axis = |(factor, axis): (usize, &Axis)| match axis {
        Axis::Continuous => Ok(with_ends(Axis::equally_spaced(levels)?, shape, factor)),
        Axis::Levels(_) => Ok(axis.clone()),
    };
    let axes = shape.axes.iter().enumerate().map(axis).collect::<Result<Vec<_>, Error>>()?;
    let forbidden = shape.forbidden.iter().filter_map(|forbidden| opened(forbidden, shape));
    Ok(BoxShape { axes, forbidden: forbidden.collect() })
}

/// The levels of an axis with the ends of its forbidden ranges: the worst prediction is often there.
fn with_ends(axis: Axis, shape: &BoxShape, factor: usize) -> Axis {
    let Axis::Levels(mut levels) = axis else {
        return axis;
    };
    let ends = shape.forbidden.iter().flat_map(|forbidden| forbidden.range(factor));
    levels.extend(ends.filter(|end| end.abs() < 1.0));
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() <= SAME_RUN);
    Axis::Levels(levels)
}

/// A forbidden box whose ends along continuous axes are allowed though those axes now have levels; none if nothing is
/// left of it.
fn opened(forbidden: &Forbidden, shape: &BoxShape) -> Option<Forbidden> {
    const INWARD: f64 = 2.0 * SAME;
    let range = |(range, axis): (&Option<[f64; 2]>, &Axis)| match (range, axis) {
        (&Some([lower, upper]), Axis::Continuous) => {
            let lower = if lower <= -1.0 { lower } else { lower + INWARD };
            Some([lower, if upper >= 1.0 { upper } else { upper - INWARD }])
        }
        (range, _) => *range,
    };
    Forbidden::new(forbidden.ranges().iter().zip(&shape.axes).map(range).collect()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 50 levels of each of six factors: 12 of each are 3 million points, 13 would be 4.8 million.
    #[test]
    fn a_large_grid_is_thinned_to_as_many_levels_as_can_be_scanned() {
        let levels = Axis::equally_spaced(50).expect("levels");
        let corner = Forbidden::new(vec![Some([0.31, 1.0]), None, None, None, None, None]).expect("a box");
        let shape = BoxShape { axes: vec![levels.clone(); 6], forbidden: vec![corner] };
        let Axis::Levels(all) = &levels else { unreachable!("an axis with levels") };
        for (factor, axis) in thinned(&shape).axes.iter().enumerate() {
            let Axis::Levels(kept) = axis else { panic!("levels stay levels") };
            assert!((12..=15).contains(&kept.len()), "{} levels along factor {factor}", kept.len());
            assert!(kept.iter().all(|level| all.contains(level)));
            assert_eq!((kept[0], kept[kept.len() - 1]), (-1.0, 1.0));
            if factor == 0 {
                let next_to = |sign: f64| all.iter().copied().filter(move |level| sign * (level - 0.31) >= 0.0);
                let (below, above) = (next_to(-1.0).fold(-1.0, f64::max), next_to(1.0).fold(1.0, f64::min));
                assert!(kept.contains(&below) && kept.contains(&above), "{below} and {above} next to the end");
            } else {
                assert_eq!(kept.len(), 12);
            }
        }
        let small = BoxShape { axes: vec![levels; 4], forbidden: Vec::new() };
        assert_eq!(thinned(&small).axes, small.axes, "6 million points are searched as a whole");
    }

    /// Along continuous axes the ends of a forbidden range are allowed, but for those at the bounds.
    #[test]
    fn ends_of_forbidden_ranges_are_levels_and_allowed() {
        let corner = Forbidden::new(vec![Some([0.33, 1.0]), Some([-1.0, -0.42])]).expect("a box");
        let middle = Forbidden::new(vec![Some([-0.71, -0.13]), None]).expect("a box");
        let shape = BoxShape { axes: vec![Axis::Continuous; 2], forbidden: vec![corner, middle] };
        let grid = gridded(&shape).expect("a grid");
        let has = |factor: usize, level: f64| match &grid.axes[factor] {
            Axis::Levels(levels) => levels.iter().any(|other| (level - other).abs() < 1e-12),
            Axis::Continuous => false,
        };
        assert!([-0.71, -0.13, 0.33].into_iter().all(|end| has(0, end)) && has(1, -0.42));
        for (point, is_forbidden) in [
            ([0.33, -1.0], false),
            ([0.6, -0.42], false),
            ([1.0, -1.0], true),
            ([1.0, -0.42], false),
            ([1.0, -0.5], true),
            ([0.4, -1.0], true),
            ([-0.71, 0.0], false),
            ([-0.13, 1.0], false),
            ([-0.4, 1.0], true),
        ] {
            assert_eq!(grid.forbids(&point), is_forbidden, "{point:?}");
            assert_eq!(shape.forbids(&point), is_forbidden, "{point:?} of the box itself");
        }
    }
}
