//! Designs that nobody chose, spread over a box: in how many of them something comes out is what chance gives.

use anyhow::Result;
use design_space::Region;

/// So many are flown for what chance gives.
const N_FLOWN: usize = 64;

/// Points all over a region: multiples of square roots of primes, each without its whole part.
pub(crate) fn points(region: &Region, n: usize) -> Vec<Vec<f64>> {
    let share = |point: usize, factor: usize| (0.5 + point as f64 * f64::from([2, 3, 5, 7][factor % 4]).sqrt()).fract();
    let point = |point: usize| {
        let parameters = region.parameters().iter().enumerate();
        parameters.map(|(factor, p)| p.lower() + share(point, factor) * (p.upper() - p.lower())).collect()
    };
    (0..n).map(point).collect()
}

/// What such designs show; none where one cannot fly.
#[derive(Clone, Debug)]
pub(crate) struct Blind<T>(Vec<Option<T>>);

impl<T> Blind<T> {
    /// By what is read of all of them together, in their order.
    pub(crate) fn read(region: &Region, read: impl FnOnce(&[Vec<f64>]) -> Vec<Result<T>>) -> Self {
        Self(read(&points(region, N_FLOWN)).into_iter().map(Result::ok).collect())
    }
}

impl<T> Blind<T> {
    /// The share that meets something; what cannot fly meets nothing.
    pub(crate) fn share(&self, meets: impl Fn(&T) -> bool) -> f64 {
        self.0.iter().flatten().filter(|one| meets(one)).count() as f64 / self.0.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use design_space::Parameter;

    use super::*;

    fn region() -> Region {
        let parameter = |name, lower, upper| Parameter::continuous(name, "1", lower, upper).expect("a parameter");
        Region::new(vec![parameter("a", 0.0, 1.0), parameter("b", -2.0, 2.0)]).expect("a region")
    }

    #[test]
    fn every_part_of_the_box_has_its_share() {
        let all = points(&region(), N_FLOWN);
        for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let inside = |point: &&Vec<f64>| (point[0] >= 0.5) == (a == 1) && (point[1] >= 0.0) == (b == 1);
            let n = all.iter().filter(inside).count();
            assert!((12..=20).contains(&n), "{n} of 64 in a quarter");
        }
    }

    #[test]
    fn what_cannot_fly_meets_nothing() {
        let read = |point: &Vec<f64>| if point[0] < 0.5 { Ok(point[0]) } else { anyhow::bail!("slack") };
        let blind = Blind::read(&region(), |points| points.iter().map(read).collect());
        let share = blind.share(|_| true);
        assert!((0.4..0.6).contains(&share), "{share}");
        assert!(blind.share(|x| *x < 0.25) < share);
    }
}
