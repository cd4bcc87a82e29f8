//! One turn of Figure 3.

use crate::Error;
use crate::codesign::evaluator::Simulation;
use crate::correction::Slopes;
use crate::gradient::campaign::{Loop, OpenIteration};
use crate::gradient::numerical::numerical_optimum;
use crate::gradient::report::Report;
use crate::gradient::trial::{Measured, Trials, experiments_around};

impl Loop {
    /// The upper half of the figure, up to the experiments: they wait for whoever has the rig.
    pub(super) fn begin(&self, simulation: &mut Simulation<'_>) -> Result<OpenIteration, Error> {
        // Optimize the corrected model J + J_cor,
        let last = self.reports().last().map(|report| report.numerical.point.as_slice());
        let numerical = numerical_optimum(self.problem(), self.settings(), last, &self.correction(), simulation)?;
        // and experiment at its optimum and beside it.
        let trials = self.experiments_around(&numerical.point);
        Ok(OpenIteration { numerical, trials })
    }

    /// The lower half, with the outcomes of all experiments.
    pub(super) fn finish(&self, open: OpenIteration) -> Report {
        let OpenIteration { numerical, trials } = open;
        let (trials, settings) = (trials.into_records(), self.settings());
        // The slopes of the experiments at the optimum, beside those of the model there,
        let Measured { cost, gradient } = Measured::around(&numerical.point, &trials);
        let slopes = Slopes { optimum: &numerical.point, experiment: &gradient, model: &numerical.model_gradient };
        // and by them the correction (27), with which the next turn begins.
        let (correction, is_corrected) = self.correction().updated(settings.correction_form, &settings.trust, slopes);
        Report {
            iteration: self.iteration(),
            numerical,
            trials,
            experiment_cost: cost,
            experiment_gradient: gradient,
            is_corrected,
            correction,
        }
    }

    /// The trials of the next iteration, if its optimum is here.
    pub(super) fn experiments_around(&self, optimum: &[f64]) -> Trials {
        let region = self.problem().region();
        experiments_around(optimum, region, self.settings(), self.iteration(), self.n_asked())
    }
}
