//! One start: fitted, looked at over the whole box, and fitted anew where its costs are lower elsewhere.

use anyhow::Result;

use super::candidate::Candidate;
use super::evidence::{Aims, Evidence, Rival};
use super::file::Calibration;
use super::fit::{Fit, worst};
use super::landscape::Landscape;
use super::outcome::{Member, Refusal, Start};

/// How often a plant is fitted anew because its costs are lower elsewhere.
const ROUNDS: usize = 5;
/// A plant of which more of the box cannot fly is refused.
const MOST_FAILED: f64 = 0.02;

impl Calibration {
    /// From a start to a plant that meets the evidence over the whole box, or why there is none.
    pub(super) fn try_start(&self, number: u64) -> Result<(Start, Option<Member>)> {
        let mut aims = Aims::new(&self.evidence, self.tolerance);
        let mut coordinates = self.start(number);
        let refused = |refusal, worst| Ok((Start { number, refusal: Some(refusal), worst }, None));
        for _ in 0..ROUNDS {
            let fitted = match Fit::new(self, &aims).run(&coordinates) {
                Ok(fitted) => fitted,
                Err((refusal, worst)) => return refused(refusal, worst),
            };
            let landscape = Landscape::fly(self, &fitted.candidate);
            if landscape.failed() > MOST_FAILED {
                return refused(Refusal::FailsInBox, Some(worst(&fitted.residuals)));
            }
            let rivals = self.rivals(&landscape, &fitted.candidate)?;
            if rivals.is_empty() {
                let member = Member { start: number, values: self.values(&fitted.coordinates) };
                let worst = Some(worst(&fitted.residuals));
                return Ok((Start { number, refusal: None, worst }, Some(member)));
            }
            rivals.into_iter().for_each(|rival| aims.add(rival));
            coordinates = fitted.coordinates;
        }
        refused(Refusal::OtherOptimum, None)
    }

    /// Where in the box costs are lowest, if not where the evidence has it.
    fn rivals(&self, landscape: &Landscape, candidate: &Candidate) -> Result<Vec<Rival>> {
        let mut rivals = Vec::new();
        for (index, evidence) in self.evidence.iter().enumerate().filter(|(_, evidence)| evidence.is_optimum) {
            let (design, _) = landscape.lowest(self, index, candidate)?;
            if !self.is_near(evidence, design) {
                rivals.push(Rival { evidence: index, design });
            }
        }
        Ok(rivals)
    }

    fn is_near(&self, evidence: &Evidence, design: [f64; 2]) -> bool {
        let apart = design.iter().zip(evidence.design).zip(self.tolerance.of_design());
        apart.into_iter().all(|((found, wanted), tolerance)| (found - wanted).abs() <= tolerance)
    }
}
