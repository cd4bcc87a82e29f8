//! The proposition of Section 6.1, repaired: the corrected model stays inside its finite bound, and
//! some errors bring it there.

use infuse::{
    convergence::{Bound, Norm, NormOrder, NormScaling},
    correction::{Gain, Law, ModelStage, Rule},
};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use super::{LAWS, STAGES, any_gain, any_stage, by_recursion, converging_law, rule};

/// Relative to the sum of the magnitudes that meet: sums of some dozen terms.
const ROUNDING: f64 = 1e-13;

/// One cell with a true gap, and errors within their bounds.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    /// J_sim: a law that treats both surfaces alike cannot see it.
    pub(crate) offset: f64,
    pub(crate) gap: f64,
    /// E1 of n + 1 batches.
    pub(crate) simulation: Vec<f64>,
    /// E2 of n batches.
    pub(crate) experiment: Vec<f64>,
    /// Fractions of gap, E1 and E2 in −1..1: some errors within the bounds.
    pub(crate) fractions: Vec<f64>,
}

impl Case {
    /// Experiments and simulations when gap and errors are these fractions of their bounds.
    fn surfaces(&self, fractions: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
        let truth = self.offset + fractions[0] * self.gap;
        let n_sim = self.simulation.len();
        let simulation = self.simulation.iter().zip(&fractions[1..]).map(|(bound, at)| self.offset + at * bound);
        let experiment = self.experiment.iter().zip(&fractions[1 + n_sim..]).map(|(bound, at)| truth + at * bound);
        (truth, experiment.collect(), simulation.collect())
    }

    fn error(&self, law: &impl Fn(&[f64], &[f64]) -> f64, fractions: &[f64]) -> f64 {
        let (truth, experiment, simulation) = self.surfaces(fractions);
        law(&experiment, &simulation) - truth
    }

    /// The fractions, each 1 or −1, that take a law furthest from the truth. The error is linear in
    /// them up to a constant, so the slope in each tells its sign.
    fn worst(&self, law: &impl Fn(&[f64], &[f64]) -> f64) -> Vec<f64> {
        let zero = vec![0.0; self.fractions.len()];
        let constant = self.error(law, &zero);
        let slopes = (0..zero.len()).map(|index| {
            let mut one = zero.clone();
            one[index] = 1.0;
            self.error(law, &one) - constant
        });
        let side = if constant < 0.0 { -1.0 } else { 1.0 };
        slopes.map(|slope| if slope < 0.0 { -side } else { side }).collect()
    }
}

pub(crate) fn cases(n: std::ops::Range<usize>) -> impl Strategy<Value = Case> {
    let bound = || prop_oneof![1 => Just(0.0), 6 => 0.01..3.0];
    n.prop_flat_map(move |n| {
        let bounds = (prop::collection::vec(bound(), n + 1), prop::collection::vec(bound(), n));
        (-5.0..5.0, bound(), bounds, prop::collection::vec(-1.0..=1.0, 2 * n + 2)).prop_map(
            |(offset, gap, (simulation, experiment), fractions)| Case {
                offset,
                gap,
                simulation,
                experiment,
                fractions,
            },
        )
    })
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Holds,
    LeavesTheBound,
    FallsShortOfIt,
}

/// Whether a law, given as the model it makes of n experiments and n + 1 simulations, stays inside the
/// bound at the case's errors and at the worst ones, and attains it there.
pub(crate) fn verdict(bound: &Bound, law: &impl Fn(&[f64], &[f64]) -> f64, case: &Case) -> Verdict {
    let n = case.experiment.len();
    let n_sim = if bound.stage == ModelStage::Onset { n + 1 } else { n.max(1) };
    let finite = bound.finite(case.gap, &case.simulation[..n_sim], &case.experiment).unwrap();
    let model = bound.rule.model(bound.stage, n);
    let factors: f64 = model.experiment.iter().chain(&model.simulation).map(|factor| factor.abs()).sum();
    let rounding = ROUNDING * (finite + (1.0 + factors) * (case.offset.abs() + case.gap));
    let some = case.error(law, &case.fractions).abs();
    let worst = case.error(law, &case.worst(law)).abs();
    if some.max(worst) > finite + rounding {
        Verdict::LeavesTheBound
    } else if worst < finite - rounding {
        Verdict::FallsShortOfIt
    } else {
        Verdict::Holds
    }
}

pub(crate) fn law_of_the_crate(rule: Rule, stage: ModelStage) -> impl Fn(&[f64], &[f64]) -> f64 {
    move |experiment, simulation| {
        let rows = |values: &[f64]| values.iter().map(|value| vec![*value]).collect::<Vec<_>>();
        by_recursion(rule, stage, &rows(experiment), &rows(simulation))[0]
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// The ratio of the worst error to the bound is 1 to rounding, from no rounds at all on.
    #[test]
    fn every_law_stays_inside_its_bound_and_attains_it(
        case in cases(0..13), law in prop::sample::select(&LAWS[..]), gain in any_gain(), stage in any_stage(),
    ) {
        let rule = Rule::new(law, gain);
        let verdict = verdict(&Bound::new(rule, stage), &law_of_the_crate(rule, stage), &case);
        prop_assert_eq!(verdict, Verdict::Holds);
    }

    /// The closed forms with constant bounds are attained too.
    #[test]
    fn constant_bounds_are_attained(
        mut case in cases(1..20), law in converging_law(), gain in any_gain(), stage in any_stage(),
    ) {
        let n = case.experiment.len();
        let (e1, e2) = (case.simulation[0], case.experiment[0]);
        case.simulation.fill(e1);
        case.experiment.fill(e2);
        let rule = Rule::new(law, gain);
        let model = law_of_the_crate(rule, stage);
        let levels = infuse::convergence::ErrorLevels::new(case.gap, e1, e2).unwrap();
        let expected = Bound::new(rule, stage).after(n).error(&levels);
        let worst = case.error(&model, &case.worst(&model)).abs();
        let scale = expected + 80.0 * (case.offset.abs() + case.gap);
        prop_assert!((worst - expected).abs() <= ROUNDING * scale, "{} attained, {} allowed", worst, expected);
    }
}

/// Fields over the cells of a region that shrinks: `kept_until[c]` is the last batch that has the cell.
#[derive(Debug, Clone)]
struct Campaign {
    measures: Vec<f64>,
    kept_until: Vec<usize>,
    gap: Vec<f64>,
    simulation: Vec<Vec<f64>>,
    experiment: Vec<Vec<f64>>,
}

fn campaigns() -> impl Strategy<Value = Campaign> {
    (1_usize..10, 1_usize..9).prop_flat_map(|(n, n_cells)| {
        let row = |size: f64| prop::collection::vec(-size..size, n_cells);
        let measures = prop::collection::vec(0.1..2.0, n_cells);
        let kept_until = prop::collection::vec(1..=n + 1, n_cells);
        let errors = (prop::collection::vec(row(1.0), n + 1), prop::collection::vec(row(1.5), n));
        (measures, kept_until, row(4.0), errors).prop_map(move |(measures, mut kept_until, gap, errors)| {
            kept_until[0] = n + 1; // the region never runs empty
            Campaign { measures, kept_until, gap, simulation: errors.0, experiment: errors.1 }
        })
    })
}

impl Campaign {
    fn n(&self) -> usize {
        self.experiment.len()
    }

    /// Values at the cells that batch j has.
    fn over(&self, j: usize, values: &[f64]) -> Vec<f64> {
        let kept = values.iter().zip(&self.kept_until);
        kept.filter(|(_, until)| **until >= j).map(|(value, _)| *value).collect()
    }

    fn norm(&self, norm: &Norm, j: usize, values: &[f64]) -> f64 {
        norm.over(&self.over(j, values), &self.over(j, &self.measures)).unwrap()
    }

    /// Norm of the model's error over the last region, J_sim being a saddle over the cells.
    fn error(&self, rule: Rule, stage: ModelStage, norm: &Norm) -> f64 {
        let cells = 0..self.gap.len();
        let simulated: Vec<f64> = cells.map(|cell| cell as f64 - 2.0).collect();
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let truth = sum(&simulated, &self.gap);
        let experiment: Vec<_> = self.experiment.iter().map(|error| sum(&truth, error)).collect();
        let simulation: Vec<_> = self.simulation.iter().map(|error| sum(&simulated, error)).collect();
        let model = by_recursion(rule, stage, &experiment, &simulation);
        let error: Vec<f64> = model.iter().zip(&truth).map(|(model, truth)| model - truth).collect();
        self.norm(norm, self.last(stage), &error)
    }

    fn last(&self, stage: ModelStage) -> usize {
        if stage == ModelStage::Onset { self.n() + 1 } else { self.n() }
    }

    /// The finite bound from norms of each batch's errors over the region of batch `region(j)`.
    fn bound(&self, bound: &Bound, norm: &Norm, region: impl Fn(usize) -> usize) -> f64 {
        let last = self.last(bound.stage);
        let norms = |rows: &[Vec<f64>]| -> Vec<f64> {
            rows.iter().enumerate().map(|(index, row)| self.norm(norm, region(index + 1), row)).collect()
        };
        let gap = self.norm(norm, region(last), &self.gap);
        bound.finite(gap, &norms(&self.simulation[..last]), &norms(&self.experiment)).unwrap()
    }
}

fn any_norm() -> impl Strategy<Value = Norm> {
    let order = prop_oneof![
        Just(NormOrder::INFINITY),
        prop::sample::select(&[1.0, 2.0, 3.0, 17.0][..]).prop_map(|q| NormOrder::finite(q).unwrap()),
        (1.0..6.0).prop_map(|q| NormOrder::finite(q).unwrap()),
    ];
    (order, prop::sample::select(&[NormScaling::Integral, NormScaling::Mean][..]))
        .prop_map(|(order, scaling)| Norm { order, scaling })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn random_fields_stay_inside_in_every_norm_while_the_region_shrinks(
        campaign in campaigns(), law in prop::sample::select(&LAWS[..]), gain in any_gain(), stage in any_stage(),
        norm in any_norm(),
    ) {
        let rule = Rule::new(law, gain);
        let bound = Bound::new(rule, stage);
        let error = campaign.error(rule, stage, &norm);
        let last = campaign.last(stage);
        let over_last = campaign.bound(&bound, &norm, |_| last);
        prop_assert!(error <= over_last * (1.0 + 1e-10) + 1e-10, "{} over the last region, {}", error, over_last);
        // Norms over the regions as they were serve too, unless they are means.
        if norm.scaling == NormScaling::Integral || norm.order == NormOrder::INFINITY {
            let as_they_were = campaign.bound(&bound, &norm, |j| j);
            prop_assert!(over_last <= as_they_were * (1.0 + 1e-12), "{} as they were, {}", over_last, as_they_were);
        }
    }

    #[test]
    fn errors_along_one_function_attain_the_bound_in_every_norm(
        mut campaign in campaigns(), law in prop::sample::select(&LAWS[..]), gain in any_gain(), stage in any_stage(),
        norm in any_norm(), sizes in prop::collection::vec(0.01..3.0, 20),
    ) {
        let rule = Rule::new(law, gain);
        let n = campaign.n();
        let model = rule.model(stage, n);
        let shape = campaign.gap.clone();
        prop_assume!(campaign.norm(&norm, n + 1, &shape) > 0.1);
        let along = |factor: f64| shape.iter().map(|value| factor * value).collect::<Vec<f64>>();
        // The error is −(1 − Σ w) gap plus factor times error: all terms to one side.
        let weights: f64 = model.experiment.iter().sum();
        campaign.gap = along(sizes[0] * (weights - 1.0).signum());
        for (index, factor) in model.experiment.iter().enumerate() {
            campaign.experiment[index] = along(sizes[index] * factor.signum());
        }
        for (index, factor) in model.simulation.iter().enumerate() {
            campaign.simulation[index] = along(sizes[19 - index] * factor.signum());
        }
        let last = campaign.last(stage);
        let (error, bound) = (campaign.error(rule, stage, &norm), campaign.bound(&Bound::new(rule, stage), &norm, |_| last));
        prop_assert!((error / bound - 1.0).abs() <= 1e-9, "{} attained, {} allowed", error, bound);
    }

    /// Whatever the surfaces' errors, if they do not hide the gap.
    #[test]
    fn printed_36_leaves_every_bound(
        mut case in cases(48..49), k in 0.01..1.99, law in converging_law(), stage in any_stage(),
    ) {
        // Together under nine tenths of the gap.
        case.gap += 0.1;
        for error in case.simulation.iter_mut().chain(&mut case.experiment) {
            *error *= 0.15 * case.gap;
        }
        case.fractions[0] = case.fractions[0].signum();
        let printed = law_of_the_crate(rule(Law::AsPrinted36, k), stage);
        let bound = Bound::new(rule(law, k), stage);
        // From 25 rounds on 0.1 k 2^(n−2) exceeds the largest amplification there is, 2/(2 − k) = 200.
        for n in 25..=48 {
            let part = Case {
                simulation: case.simulation[..=n].to_vec(),
                experiment: case.experiment[..n].to_vec(),
                fractions: case.fractions[..2 * n + 2].to_vec(),
                ..case
            };
            let error = part.error(&printed, &part.fractions).abs();
            let n_sim = if stage == ModelStage::Onset { n + 1 } else { n };
            let finite = bound.finite(part.gap, &part.simulation[..n_sim], &part.experiment).unwrap();
            if error <= finite {
                return Err(TestCaseError::fail(format!("n = {n}: {error} is within {finite}")));
            }
        }
    }
}

#[test]
fn printed_36_leaves_the_bounds_of_both_laws_however_small_the_gap() {
    for (law, k, gap) in [(LAWS[0], 0.1, 1e-9), (LAWS[1], 0.5, 1e-6), (LAWS[0], 1.0, 1.0), (LAWS[1], 1.9, 1e-3)] {
        for stage in STAGES {
            let levels = infuse::convergence::ErrorLevels::new(gap, 1.0, 1.0).unwrap();
            let bound = Bound::new(rule(law, k), stage);
            let printed = law_of_the_crate(rule(Law::AsPrinted36, k), stage);
            let is_outside = |n: usize| {
                let error = printed(&vec![gap; n], &vec![0.0; n + 1]) - gap;
                error.abs() > bound.after(n).error(&levels)
            };
            let outside: Vec<bool> = (0..80).map(is_outside).collect();
            let first = outside.iter().rposition(|out| !out).map_or(0, |last_inside| last_inside + 1);
            assert!(first < 50, "{law:?}, k = {k}, gap {gap}: outside for good from {first} on");
        }
    }
}

#[test]
fn falling_errors_bring_the_finite_bound_to_the_limit_of_their_limits() {
    let falling = |n: usize, limit: f64| (1..=n).map(|j| limit + 3.0 / j as f64).collect::<Vec<f64>>();
    for law in &LAWS[..2] {
        for gain in [Gain::constant(0.3).unwrap(), Gain::constant(1.0).unwrap(), Gain::constant(1.4).unwrap()] {
            let bound = Bound::new(Rule::new(*law, gain), ModelStage::Corrected);
            let limit = bound.limit().unwrap().error(&infuse::convergence::ErrorLevels::new(5.0, 0.2, 0.1).unwrap());
            let finite = [100, 1000, 10_000].map(|n| bound.finite(5.0, &falling(n, 0.2), &falling(n, 0.1)).unwrap());
            assert!(finite.is_sorted_by(|a, b| a > b), "{law:?}, {gain:?}: {finite:?}");
            assert!((finite[2] - limit).abs() < 1e-2, "{law:?}, {gain:?}: {finite:?}, limit {limit}");
        }
    }
}
