//! How far a corrected model can be from the truth, and what that says about a design: Section 5.4 and Chapter 6,
//! repaired and extended.
//!
//! The dissertation's loop corrects the model everywhere, by the difference of two fitted surfaces, Ĵexp of the experiments and
//! Ĵsim of the simulations. A [`Rule`](crate::correction::Rule) says how, [`Bound`] how far the corrected model can then be
//! from the truth, [`RegretCertificate`] what that means for a design.
//!
//! With a gap d_0 = ‖J_true − J_sim‖, errors of the surfaces of at most E1 (simulation) and E2 (experiment), and a gain 0 < k ≤ 1:
//!
//! | law | compares the experiment with | error of the corrected model after n ≥ 2 batches, at most | limit |
//! |---|---|---|---|
//! | `ProofRecursion`, (45)–(47) | the corrected model of the batch before | 2 E1 + E2 + (1 − k)ⁿ (d_0 − E1 − E2) | 2 E1 + E2, (55) |
//! | `CurrentSimulation` | the corrected simulation of this batch | 2 (1 − k) E1 + E2 + (1 − k)ⁿ (d_0 − E1 − E2) | 2 (1 − k) E1 + E2 |
//! | `AsPrinted36` | the simulation, and adds up what is a sum already | grows as 2ⁿ | none |
//!
//! * Each bound is attained by some errors, so none can be improved without knowing more. It holds in every norm ([`Norm`]: q = 1, 2, any q ≥ 1, ∞).
//! * [`Bound::finite`] takes errors that differ from batch to batch, and needs no assumption that they fall. [`AssumptionReport`] says whether they did.
//! * [`Bound::batches_to`] answers how many batches: 44, 13, 7 and 3 bring the gap's share to a hundredth with k = 0.1, 0.3, 0.5 and 0.8.
//! * The harmonic gain 1/n forgets the gap after one batch and averages the noise of the rest; its limit is 2 E1 + E2 under both laws.
//! * For 1 < k < 2 the laws still converge, to limits that grow as k nears 2; [`Bound`] documents them.
//! * The table is for Ĵnum,n. The next batch starts from Ĵsim,n+1 plus the same correction ([`ModelStage::Onset`](crate::correction::ModelStage::Onset)): 2 E1 + E2 in the limit under both laws.
//! * In the sup norm a bound eps certifies a design: its true response is above the best by at most its excess in the model plus 2 eps.
//!   About designs dropped earlier that says nothing unless each was dropped by more than 2 eps; [`possible_optima`] drops no others.
//!
//! The dissertation's loop takes all this over its own cells, one after the other and without a list of them: `norm_over` is (42) over
//! any M_i of any surface, `certificate` says what an eps promises of p̂*, `possible_optima` which cells are left that may be
//! better.
//!
//! ```
//! # #[cfg(feature = "global")] {
//! use design_space::{Model, Parameter, Region};
//! use infuse::convergence::{AssumptionReport, Bound, Norm};
//! use infuse::{correction::ModelStage, global};
//! use surface::Surface;
//!
//! fn truth(p: &[f64]) -> f64 {
//!     1.0 + (p[0] - 0.4).powi(2) + (p[1] + 0.2).powi(2)
//! }
//!
//! fn simulation(p: &[f64]) -> f64 {
//!     truth(p) + 0.5 + 0.3 * p[0] + 0.02 * (3.0 * p[1]).sin()
//! }
//!
//! /// Ĵsim − J_sim, in coordinates coded to the original box. The simulation is cheap, so this can be looked at.
//! #[derive(Debug)]
//! struct SimulationError<'a>(&'a dyn Surface, &'a Region);
//!
//! impl Surface for SimulationError<'_> {
//!     fn n_factors(&self) -> usize {
//!         self.0.n_factors()
//!     }
//!
//!     fn predict(&self, point: &[f64]) -> f64 {
//!         self.1.natural(point).map_or(f64::NAN, |p| self.0.predict(point) - simulation(&p))
//!     }
//! }
//!
//! let axis = |name| Parameter::continuous(name, "m", -1.0, 1.0)?.with_levels(24);
//! let region = Region::new(vec![axis("x")?, axis("y")?])?;
//! let mut settings = global::Settings::new(Model::quadratic(2)?, 12, 18);
//! settings.max_batches = 5;
//! let mut campaign = global::Loop::new(&region, settings)?;
//! let reading = |p: &[f64], number: u64| truth(p) + 0.01 * (12.9898 * number as f64).sin();
//! campaign.run(&mut |_, p| Ok(simulation(p)), &mut |trial| Ok(reading(&trial.point, trial.id.number())))?;
//!
//! // E1 of each batch is measured. E2 is what the rig is trusted to: half again its error of 0.01.
//! let error = |i: usize| SimulationError(campaign.surfaces()[i - 1].simulation.surface(), &region);
//! let e1 = (1..=5).map(|i| campaign.norm_over(i, &error(i), Norm::SUP)).collect::<Result<Vec<_>, _>>()?;
//! let e2 = [0.015; 5];
//! assert!(e1[0] > 0.02 && e1[4] < 0.001, "the wave is in no term of the model, but what is left gets small");
//! assert!(AssumptionReport::new(&e1, &e2, 0.1)?.holds());
//!
//! // d_0 is at most what was seen between the first surfaces, and their errors.
//! let gap = campaign.reports()[0].changes.gap.expect("experiments") + e1[0] + e2[0];
//! let bound = Bound::new(campaign.settings().correction, ModelStage::Corrected);
//! let eps = bound.finite(gap, &e1, &e2)?;
//! let certificate = campaign.certificate(eps)?.expect("five batches");
//! let possible = campaign.possible_optima(eps)?.expect("five batches");
//! assert!(eps < 0.05 && certificate.is_within(0.1), "of all that is left none is better by more");
//! assert_eq!(possible.n_retained(), campaign.retained().n_retained(), "the z-test has dropped more than eps could");
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod assumption;
mod bound;
mod certificate;
mod norm;

pub use assumption::{AssumptionReport, Growth};
pub use bound::{Amplification, Bound, ErrorLevels};
pub use certificate::{RegretCertificate, possible_optima};
pub use norm::{Norm, NormOrder, NormScaling, coded_cell_measure};
