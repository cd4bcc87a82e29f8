//! One start: fitted, looked at over the whole box, and fitted anew where its costs are lower elsewhere.

use anyhow::Result;

use super::candidate::Candidate;
use super::evidence::{Aims, Evidence, Found, Rival};
use super::file::Calibration;
use super::fit::{Fit, Fitted, Unmet, worst};
use super::landscape::Landscape;
use super::outcome::{Member, Refusal, Start};

/// How often a plant is fitted anew because its costs are lower elsewhere.
const ROUNDS: usize = 5;
/// A plant of which more of the box cannot fly is refused.
const MOST_FAILED: f64 = 0.02;

/// What came of a start, and where its last fit ended.
#[derive(Debug)]
pub(super) struct Attempt {
    pub(super) start: Start,
    pub(super) member: Option<Member>,
    /// All that the evidence asks for, row by row; nothing where it cannot fly.
    pub(super) rows: Vec<Found>,
}

impl Calibration {
    /// From a start to a plant that meets the evidence over the whole box, or why there is none.
    pub(super) fn try_start(&self, number: u64, reach: [f64; 2]) -> Result<Attempt> {
        let mut aims = Aims::new(&self.evidence, self.tolerance);
        let mut coordinates = self.start(number, reach);
        let refused = |refusal, worst, rows| {
            Ok(Attempt { start: Start { number, refusal: Some(refusal), worst }, member: None, rows })
        };
        let mut elsewhere = Vec::new();
        for _ in 0..ROUNDS {
            let rows = |fitted: &Fitted| aims.rows(&fitted.candidate, &fitted.flown);
            let fitted = match Fit::new(self, &aims).run(&coordinates) {
                Ok(fitted) => fitted,
                Err(Unmet { refusal, at }) => {
                    let worst = at.as_ref().map(|fitted| worst(&fitted.residuals));
                    return refused(refusal, worst, at.map_or_else(Vec::new, |fitted| rows(&fitted)));
                }
            };
            let rows = rows(&fitted);
            let landscape = Landscape::fly(self, &fitted.candidate);
            if landscape.failed() > MOST_FAILED {
                return refused(Refusal::FailsInBox, Some(worst(&fitted.residuals)), rows);
            }
            let rivals = self.rivals(&landscape, &fitted.candidate)?;
            if rivals.is_empty() {
                let member = Member { start: number, values: self.values(&fitted.coordinates) };
                let worst = Some(worst(&fitted.residuals));
                return Ok(Attempt { start: Start { number, refusal: None, worst }, member: Some(member), rows });
            }
            elsewhere = rows;
            for rival in rivals {
                let evidence = &self.evidence[rival.evidence];
                for place in evidence.places(rival.design, &self.tolerance) {
                    let own = elsewhere.iter_mut().find(|row| (&row.label, row.what) == (&place.label, place.what));
                    own.into_iter().for_each(|row| *row = place.clone());
                }
                aims.add(rival);
            }
            coordinates = fitted.coordinates;
        }
        refused(Refusal::OtherOptimum, None, elsewhere)
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
        evidence.places(design, &self.tolerance).iter().all(|row| (row.found - row.printed).abs() <= row.allowed)
    }
}
