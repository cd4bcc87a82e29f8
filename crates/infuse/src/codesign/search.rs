//! One bounded search in coded coordinates, from several starts.

use bobyqa::{Bobyqa, Config, Status};

use crate::Error;
use crate::codesign::optimizer::CodesignStop;
use crate::codesign::starts::{Evaluated, lattice, worth_a_descent};

/// What a search is allowed and how fine it goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchSettings {
    pub(crate) n_starts: usize,
    pub(crate) initial_radius: f64,
    pub(crate) final_radius: f64,
    pub(crate) max_steps: usize,
}

/// The best point of a search; nothing if every evaluation failed.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) best: Option<(Vec<f64>, f64)>,
    pub(crate) stop: CodesignStop,
}

/// What a search makes small, by reference: the search is compiled once, not for each cost.
type Cost<'a> = dyn FnMut(&[f64]) -> Result<Option<f64>, Error> + 'a;

/// Minimizes `cost` over the box from −1 to 1 in `warm_start.len()` coordinates, by BOBYQA (Powell
/// 2009) from every start worth a descent.
///
/// `cost` gives nothing where the simulation failed. The descent then sees a barrier, strictly above
/// everything finite this search has seen; the barrier is never a result.
pub(crate) fn search(warm_start: &[f64], settings: &SearchSettings, cost: &mut Cost<'_>) -> Result<Found, Error> {
    let n_axes = warm_start.len();
    let mut history = History::new(cost);
    let mut candidates = vec![warm_start.to_vec()];
    candidates.extend(lattice(n_axes, settings.n_starts));
    let mut starts = Vec::with_capacity(candidates.len());
    for coded in candidates {
        let value = history.evaluate(&coded);
        starts.push(Evaluated { coded, value });
    }

    let mut solver = Bobyqa::new(n_axes, configuration(n_axes, settings))
        .map_err(|_| Error::OptimizerRefused { n_parameters: n_axes })?;
    let mut stop = CodesignStop::Converged;
    for index in worth_a_descent(&starts) {
        let mut coded = starts[index].coded.clone();
        let cost = |point: &[f64]| history.with_barrier(point);
        let (lower, upper) = (vec![-1.0; n_axes], vec![1.0; n_axes]);
        let outcome = solver.minimize(cost, &mut coded, &lower, &upper);
        stop = stop.and(match outcome.status {
            Status::MaxFunReached => CodesignStop::SearchLimit,
            Status::ModelDegenerate => CodesignStop::ModelDegenerate,
            Status::InvalidArgs | Status::AllocationFailed => {
                return Err(Error::OptimizerRefused { n_parameters: n_axes });
            }
            Status::Converged | Status::TargetReached | Status::FtolReached => CodesignStop::Converged,
        });
    }
    let best = history.best();
    history.fault.map_or(Ok(Found { best, stop }), Err)
}

fn configuration(n_axes: usize, settings: &SearchSettings) -> Config {
    let mut config = Config::new(n_axes);
    config.rho_begin = settings.initial_radius;
    config.rho_end = settings.final_radius;
    config.max_fun = settings.max_steps.max(config.npt + 1);
    // With one coordinate the model is always fully determined, and the faithful port then spends
    // evaluations on rescues that rounding alone decides.
    config.prima_parity = false;
    config
}

/// Everything one search has evaluated, so that no point is simulated twice.
struct History<C> {
    cost: C,
    seen: Vec<Evaluated>,
    fault: Option<Error>,
}

impl<C: FnMut(&[f64]) -> Result<Option<f64>, Error>> History<C> {
    fn new(cost: C) -> Self {
        Self { cost, seen: Vec::new(), fault: None }
    }

    fn evaluate(&mut self, coded: &[f64]) -> Option<f64> {
        if let Some(known) = self.seen.iter().find(|known| same(&known.coded, coded)) {
            return known.value;
        }
        if self.fault.is_some() {
            return None;
        }
        match (self.cost)(coded) {
            Ok(value) => {
                self.seen.push(Evaluated { coded: coded.to_vec(), value });
                value
            }
            Err(fault) => {
                self.fault = Some(fault);
                None
            }
        }
    }

    fn with_barrier(&mut self, coded: &[f64]) -> f64 {
        self.evaluate(coded).unwrap_or_else(|| self.barrier())
    }

    /// Above the worst cost seen by the spread of the costs seen, and by a thousandth of its size
    /// at least.
    fn barrier(&self) -> f64 {
        let costs = || self.seen.iter().filter_map(|known| known.value);
        let worst = costs().fold(f64::NEG_INFINITY, f64::max);
        let best = costs().fold(f64::INFINITY, f64::min);
        if !worst.is_finite() {
            return 0.0;
        }
        worst + (worst - best).max(1e-3 * worst.abs()).max(f64::MIN_POSITIVE)
    }

    /// The first of the best points.
    fn best(&self) -> Option<(Vec<f64>, f64)> {
        let mut best: Option<(&Evaluated, f64)> = None;
        for known in &self.seen {
            if let Some(value) = known.value
                && best.is_none_or(|(_, least)| value < least)
            {
                best = Some((known, value));
            }
        }
        best.map(|(known, value)| (known.coded.clone(), value))
    }
}

fn same(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|value| value.to_bits()).eq(b.iter().map(|value| value.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails at positive coordinates, costs `scale` times the coordinate elsewhere.
    fn history(scale: f64) -> History<impl FnMut(&[f64]) -> Result<Option<f64>, Error>> {
        History::new(move |coded: &[f64]| Ok((coded[0] <= 0.0).then_some(scale * coded[0])))
    }

    #[test]
    fn the_barrier_is_above_everything_finite_and_is_no_result() {
        for scale in [0.0, 1.0, -1.0, 1e-300, 1e20, -1e20] {
            let mut history = history(scale);
            let costs = [-1.0, -0.5, 0.0].map(|coded| history.with_barrier(&[coded]));
            let barrier = history.with_barrier(&[0.5]);
            assert!(costs.iter().all(|cost| *cost < barrier), "{costs:?}, {barrier}");
            let best = history.best().map(|(_, value)| value);
            assert!(best.is_some_and(|best| best < barrier), "{best:?}, {barrier}");
        }
    }

    #[test]
    fn of_equal_costs_the_first_is_the_best() {
        let mut history = history(0.0);
        for coded in [0.5, -0.5, -1.0] {
            history.evaluate(&[coded]);
        }
        assert_eq!(history.best(), Some((vec![-0.5], 0.0)));
    }

    #[test]
    fn no_point_is_evaluated_twice() {
        let mut count = 0;
        let mut history = History::new(|_: &[f64]| {
            count += 1;
            Ok(Some(1.0))
        });
        for coded in [0.1, 0.2, 0.1] {
            history.evaluate(&[coded]);
        }
        drop(history);
        assert_eq!(count, 2);
    }
}
