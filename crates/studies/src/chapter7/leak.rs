//! The correction leak: validation experiments in the correction of their own iteration.
//!
//! `infuse` knows from which trials a surface is made and refuses to compare it with one of them, so the leak cannot be
//! said in its settings. Here the correction is smuggled in through the simulation: the loop's own correction is all but
//! switched off, and the simulations that it asks for come corrected by experiments of the same batch.

use anyhow::Result;
use design_space::Cell;
use infuse::{
    Outcome,
    correction::{Gain, Rule},
    global::{self, Observations, TracedSurface},
};
use surface::{Confounded, Kind};

use crate::gridded::{Designs, StandInRig};

/// Which correction the simulations of iteration n carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Timing {
    /// That of iteration n, with the experiments that S is estimated from: the leak.
    SameIteration,
    /// That of iteration n − 1, as the loop itself has it: to check what this does.
    #[cfg_attr(not(test), expect(dead_code, reason = "the check is a test"))]
    NextIteration,
}

/// The gain of the loop's own correction: nothing that shows, for 0 is no gain.
const NO_GAIN: f64 = 1e-13;

/// Runs a campaign whose correction acts when `timing` says.
pub(crate) fn run(
    rig: &StandInRig<'_>,
    settings: &global::Settings,
    designs: &Designs,
    timing: Timing,
) -> Result<global::Loop> {
    let rule = settings.correction;
    let region = rig.space.region();
    let k = region.n_parameters();
    let kind = Kind::Regression { model: settings.model.clone(), confounded: Confounded::Drop };
    let mut settings = settings.clone();
    settings.correction = Rule::new(rule.law, Gain::constant(NO_GAIN)?);
    let mut campaign = global::Loop::new(region, settings)?;
    let (mut experiments, mut simulations) = (Vec::new(), Vec::new());
    let mut correction = TracedSurface::combination(k, [])?;
    while let Some(plan) = designs.next(&campaign)? {
        // What the loop is about to run, by a copy of it: designs do not depend on costs.
        let mut simulated = Observations::none(k);
        let mut fault = None;
        let trials = campaign.clone().open(&plan, &mut |cell: Cell, point: &[f64]| {
            let cost = rig.simulate(cell)?;
            let added = region.coded(point).map_err(infuse::Error::from);
            let added = added.and_then(|coded| simulated.add_simulation(&coded, cost));
            fault = fault.take().or(added.err());
            Ok(cost)
        })?;
        if let Some(fault) = fault {
            return Err(fault.into());
        }
        let outcomes = rig.measure(&trials)?;
        let mut measured = Observations::none(k);
        for (trial, outcome) in trials.iter().zip(&outcomes) {
            if let Outcome::Value(cost) = outcome {
                measured.add_experiment(trial.id, &region.coded(&trial.point)?, *cost)?;
            }
        }
        let before = correction;
        experiments.push(TracedSurface::fit(&kind, &measured)?);
        simulations.push(TracedSurface::fit(&kind, &simulated)?);
        let factors = rule.correction(experiments.len());
        let factors = factors.experiment.into_iter().chain(factors.simulation);
        correction = TracedSurface::combination(k, factors.zip(experiments.iter().chain(&simulations)))?;
        let acting = match timing {
            Timing::SameIteration => &correction,
            Timing::NextIteration => &before,
        };

        campaign.open(&plan, &mut |cell: Cell, point: &[f64]| {
            let coded = region.coded(point).map_err(|error| error.to_string())?;
            Ok(rig.simulate(cell)? + acting.surface().predict(&coded))
        })?;
        for (trial, outcome) in trials.iter().zip(outcomes) {
            campaign.tell(trial.id, outcome)?;
        }
    }
    Ok(campaign)
}

#[cfg(test)]
mod tests {
    use doe::Model;
    use infuse::{TrialId, global::quality_of_fit};

    use super::*;
    use crate::costs::Cost;
    use crate::gridded::{CellCosts, Space};

    /// A bowl over seven levels of two parameters, with a ripple that no quadratic follows.
    #[derive(Debug)]
    struct Bowl {
        space: Space,
        lowest: [f64; 2],
    }

    impl CellCosts for Bowl {
        fn cost(&self, cell: Cell) -> Cost {
            let point = self.space.point(cell).map_err(|error| error.to_string())?;
            let (x, y) = (point[0] - self.lowest[0], point[1] - self.lowest[1]);
            Ok(1.0 + x * x + 0.1 * y * y + 0.3 * (3.0 * x).sin() * y.cos())
        }

        fn range(&self) -> f64 {
            10.0
        }
    }

    fn bowls() -> [Bowl; 2] {
        [[47.0, 3.0], [50.0, 8.0]].map(|lowest| Bowl { space: Space::of_two([46.0, 52.0], [0.0, 12.0], 13), lowest })
    }

    fn settings() -> global::Settings {
        let mut settings = global::Settings::new(Model::additive_quadratic(2).expect("a model"), 12, 24);
        settings.max_batches = 3;
        settings
    }

    fn found(campaign: &global::Loop) -> Vec<(u64, u64)> {
        campaign
            .reports()
            .iter()
            .map(|report| (report.screening.optimum_cell.index(), report.screening.n_after))
            .collect()
    }

    #[test]
    fn a_correction_smuggled_in_one_iteration_later_is_the_loop_itself() {
        let [model, truth] = bowls();
        let rig = StandInRig { space: &model.space, model: &model, truth: &truth, noise: 0.01, seed: 3 };
        let folder = tempfile::tempdir().expect("a writable directory");
        let designs = Designs::keep_in(folder.path(), None).expect("no designs yet");
        let smuggled = run(&rig, &settings(), &designs, Timing::NextIteration).expect("a campaign");
        let mut itself = global::Loop::new(model.space.region(), settings()).expect("a campaign");
        while let global::Ask::Trials(trials) = itself.ask(&mut |cell, _| rig.simulate(cell)).expect("a batch") {
            for (trial, outcome) in trials.iter().zip(rig.measure(&trials).expect("costs")) {
                itself.tell(trial.id, outcome).expect("an outcome");
            }
        }
        assert_eq!(found(&smuggled), found(&itself), "optimum and cells left, iteration by iteration");
        assert!(found(&itself).len() > 1, "the correction has acted: {:?}", found(&itself));
        let leaking = run(&rig, &settings(), &designs, Timing::SameIteration).expect("a campaign");
        let spread = |campaign: &global::Loop| campaign.reports()[0].screening.spread.s().expect("S");
        assert!(spread(&leaking) < spread(&itself), "the first S knows its own experiments");
    }

    #[test]
    fn the_library_refuses_the_leak() {
        let kind =
            Kind::Regression { model: Model::additive_quadratic(1).expect("a model"), confounded: Confounded::Refuse };
        let (mut validation, mut simulated) = (Observations::none(1), Observations::none(1));
        for (number, x) in [-1.0, -0.5, 0.5, 1.0].into_iter().enumerate() {
            validation.add_experiment(TrialId::new(number as u64 + 1), &[x], x * x).expect("one coordinate");
            simulated.add_simulation(&[x], x).expect("one coordinate");
        }
        let correction = TracedSurface::fit(&kind, &validation).expect("a surface");
        let corrected = simulated.corrected_by(&correction).expect("one coordinate");
        let combined = TracedSurface::fit(&kind, &corrected).expect("a surface");
        let error = quality_of_fit(&combined, &validation).expect_err("the surface knows the experiments");
        assert!(matches!(error, infuse::Error::ValidationLeak { .. }), "{error}");
    }
}
