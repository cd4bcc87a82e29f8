//! When coordinates and runs are the same, which runs of many are, and how they come to be so to the last bit.

/// How far a coordinate may be from a level, a bound or a candidate and still be it.
pub(crate) const SAME: f64 = 1e-9;
/// Coordinates that differ by no more make two runs replicates.
pub(crate) const SAME_RUN: f64 = 1e-6;

/// Whether two runs are replicates of each other.
pub(crate) fn is_same_run(a: &[f64], b: &[f64]) -> bool {
    is_within(SAME_RUN, a, b)
}

/// Whether no coordinate of two runs differs by more than a tolerance.
pub(crate) fn is_within(tolerance: f64, a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= tolerance)
}

/// Two of these points that are the same run, by index and the earlier first; none if all are distinct.
pub(crate) fn same_pair(n_factors: usize, coordinates: &[f64]) -> Option<(usize, usize)> {
    let point = |index: usize| &coordinates[index * n_factors..][..n_factors];
    crowds(n_factors, coordinates).into_iter().find_map(|crowd| {
        crowd.iter().enumerate().find_map(|(place, &second)| {
            let first = crowd[..place].iter().find(|&&first| is_same_run(point(first), point(second)))?;
            Some((*first, second))
        })
    })
}

/// Gives each point after the first `n_fixed` the coordinates of the first point before it that is the same run, if there is
/// one. Two points are then equal or different runs, unless fixed ones are so close together.
pub(crate) fn unite(n_factors: usize, coordinates: &mut [f64], n_fixed: usize) {
    for crowd in crowds(n_factors, coordinates) {
        // Those that all others are held against: a point that has been given the coordinates of another is not needed.
        let mut own: Vec<usize> = Vec::new();
        for index in crowd {
            let at = index * n_factors..(index + 1) * n_factors;
            let twin =
                |&other: &usize| is_same_run(&coordinates[other * n_factors..][..n_factors], &coordinates[at.clone()]);
            match own.iter().copied().find(twin) {
                Some(first) if index >= n_fixed => {
                    coordinates.copy_within(first * n_factors..(first + 1) * n_factors, at.start);
                }
                _ => own.push(index),
            }
        }
    }
}

/// The first and the last point before each that are the same run; none where there is none.
pub(crate) fn twins(n_factors: usize, coordinates: &[f64]) -> Vec<Option<(usize, usize)>> {
    let point = |index: usize| &coordinates[index * n_factors..][..n_factors];
    let mut twins = vec![None; coordinates.len() / n_factors];
    for crowd in crowds(n_factors, coordinates) {
        // Points of the same coordinates once, with the first and the last of them so far.
        let mut own: Vec<(usize, usize)> = Vec::new();
        for index in crowd {
            let same = own.iter().filter(|&&(first, _)| is_same_run(point(first), point(index)));
            twins[index] = same.copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
            match own.iter_mut().find(|&&mut (first, _)| point(first) == point(index)) {
                Some((_, last)) => *last = index,
                None => own.push((index, index)),
            }
        }
    }
    twins
}

/// The points that are the same run as an earlier one, each with the first such that is not so itself: in groups, by index, each
/// rising, and by their first.
pub(crate) fn groups(n_factors: usize, coordinates: &[f64]) -> Vec<Vec<usize>> {
    let point = |index: usize| &coordinates[index * n_factors..][..n_factors];
    let mut all = Vec::new();
    for crowd in crowds(n_factors, coordinates) {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for index in crowd {
            match groups.iter_mut().find(|group| is_same_run(point(group[0]), point(index))) {
                Some(group) => group.push(index),
                None => groups.push(vec![index]),
            }
        }
        all.extend(groups.into_iter().filter(|group| group.len() > 1));
    }
    all.sort_unstable();
    all
}

/// Crowds of points, by index and rising, outside of which no point is the same run as one of them: along every axis in turn
/// points are parted where there is a gap. Points alone are left out.
fn crowds(n_factors: usize, coordinates: &[f64]) -> Vec<Vec<usize>> {
    let at = |index: usize, axis: usize| coordinates[index * n_factors + axis];
    let mut crowds = vec![(0..coordinates.len() / n_factors).collect::<Vec<usize>>()];
    for axis in 0..n_factors {
        let parted = |mut crowd: Vec<usize>| {
            crowd.sort_unstable_by(|&a, &b| at(a, axis).total_cmp(&at(b, axis)));
            let parts = crowd.chunk_by(|&a, &b| at(b, axis) - at(a, axis) <= SAME_RUN);
            parts.filter(|part| part.len() > 1).map(<[usize]>::to_vec).collect::<Vec<_>>()
        };
        crowds = crowds.into_iter().flat_map(parted).collect();
    }
    crowds.iter_mut().for_each(|crowd| crowd.sort_unstable());
    crowds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_takes_the_place_of_the_first_that_it_is_the_same_as() {
        // The third is the same as the second alone, which is the same as the first.
        let mut chain = [0.5, 0.5 + 0.9e-6, 0.5 + 1.8e-6, -1.0, -0.0, 0.0];
        unite(1, &mut chain, 0);
        let expected = [0.5_f64, 0.5, 0.5 + 1.8e-6, -1.0, -0.0, -0.0];
        assert_eq!(chain.map(f64::to_bits), expected.map(f64::to_bits), "{chain:?}");
    }

    #[test]
    fn fixed_runs_stay_where_they_are_and_others_come_to_them() {
        let given = [[0.1, 0.2], [0.1, 0.2 + 1e-9], [0.1 - 1e-9, 0.2 + 1e-9], [0.1, 0.3]].concat();
        let mut runs = given.clone();
        unite(2, &mut runs, 2);
        assert_eq!(runs[..4], given[..4], "fixed");
        assert_eq!((&runs[4..6], &runs[6..]), (&given[..2], &given[6..]));
    }

    /// By comparing all pairs.
    #[test]
    fn what_is_the_same_is_found_wherever_it_stands() {
        let number = |i: usize| ((i * i * 7919 + i * 31) % 7) as f64 - 3.0 + 4e-7 * ((i * 37 + i * i) % 5) as f64;
        for (n_factors, n_points) in [(1, 9), (2, 40), (3, 60), (3, 400)] {
            let points: Vec<f64> = (0..n_factors * n_points).map(number).collect();
            let all: Vec<&[f64]> = points.chunks_exact(n_factors).collect();
            let pairs = |all: &[&[f64]]| {
                let later = |i: usize| (i + 1..all.len()).map(move |j| (i, j));
                (0..all.len()).flat_map(later).filter(|&(i, j)| is_same_run(all[i], all[j])).collect::<Vec<_>>()
            };
            let expected = pairs(&all);
            match same_pair(n_factors, &points) {
                Some(pair) => assert!(expected.contains(&pair), "{pair:?} of {expected:?}"),
                None => assert_eq!(expected, [], "{n_factors} factors, {n_points} points"),
            }
            let mut united = points.clone();
            unite(n_factors, &mut united, 0);
            let after: Vec<&[f64]> = united.chunks_exact(n_factors).collect();
            assert!(pairs(&after).iter().all(|&(i, j)| after[i] == after[j]), "{n_factors} factors, {n_points} points");
            let before = |i: usize| {
                let same: Vec<usize> = (0..i).filter(|&j| is_same_run(all[j], all[i])).collect();
                same.first().copied().zip(same.last().copied())
            };
            let expected: Vec<_> = (0..all.len()).map(before).collect();
            assert_eq!(twins(n_factors, &points), expected, "{n_factors} factors, {n_points} points");
            let mut expected: Vec<Vec<usize>> = Vec::new();
            for run in 0..all.len() {
                match expected.iter_mut().find(|group| is_same_run(all[group[0]], all[run])) {
                    Some(group) => group.push(run),
                    None => expected.push(vec![run]),
                }
            }
            expected.retain(|group| group.len() > 1);
            assert_eq!(groups(n_factors, &points), expected, "{n_factors} factors, {n_points} points");
            assert!(united.iter().zip(&points).all(|(x, y)| (x - y).abs() <= SAME_RUN), "nothing moves farther");
        }
    }
}
