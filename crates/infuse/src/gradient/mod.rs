//! The loop of Chapter 3 and its Figure 3, in continuous parameters: optimize the corrected model, experiment around its
//! optimum, correct the slopes by (27), repeat.
//!
//! `turn` is one turn of the figure; [`Loop`] asks for its experiments and takes their outcomes.
//!
//! # A turn
//!
//! 1. Minimize J_mod = J + J_cor over the whole region; call the optimum p*. At first J_cor = 0.
//! 2. Run 2n + 1 experiments in n parameters: at p*, and one step δ_j to each side in each parameter. Five in two parameters.
//! 3. Take the slopes of the experiment by central differences, and those of J_mod at p* by finer ones of the simulation.
//! 4. Correct, per parameter with its own trust factor R_j:
//!
//!    ```text
//!    J_cor(p) ← J_cor(p) + Σ_j R_j (∂J_exp/∂p_j − ∂J_mod/∂p_j)(p*) (p_j − p*_j)        (27), repaired
//!    ```
//!
//! 5. Stop when p* has come to rest.
//!
//! The sum stays linear in p, so the correction is kept as a slope and an offset. Its fixed points are stationary for the
//! differences of the experiment, whatever the model believes; the model decides only how fast the loop gets there. On
//! quadratics with curvatures H_mod and H_exp in one parameter, the distance to the experiment's optimum is multiplied by
//! 1 − R H_exp/H_mod per iteration: the loop contracts for 0 < R < 2 H_mod/H_exp.
//!
//! ```rust
//! use design_space::{Parameter, Region};
//! use infuse::{CodesignProblem, Outcome, Role, gradient};
//!
//! let region = Region::new(vec![
//!     Parameter::continuous("center of mass", "% chord", 45.0, 52.0)?,
//!     Parameter::continuous("pitch", "deg", 10.0, 22.0)?,
//! ])?;
//! let problem = CodesignProblem::new(region, vec![Role::Plant, Role::Controller])?;
//!
//! // R_p = R_c = 0.6; experiment steps of 1 % chord and 1 degree.
//! let settings = gradient::Settings::new(problem.per_role(0.6, 0.6), vec![1.0, 1.0]);
//! let mut campaign = gradient::Loop::new(problem, settings)?;
//!
//! // The model believes in (46.1, 17.3), the water in (49.3, 19.4).
//! let mut simulation = |p: &[f64]| Ok(4.35 + 0.08 * (p[0] - 46.1).powi(2) + 0.06 * (p[1] - 17.3).powi(2));
//! let experiment = |p: &[f64]| 5.81 + 0.07 * (p[0] - 49.3).powi(2) + 0.07 * (p[1] - 19.4).powi(2);
//!
//! while let gradient::Ask::Trials(trials) = campaign.ask(&mut simulation)? {
//!     assert_eq!(trials.len(), 5);
//!     for trial in trials.iter().rev() {
//!         campaign.tell(trial.id, Outcome::Value(experiment(&trial.point)))?;
//!     }
//!     // Here the campaign could be written to a file, and read again tomorrow.
//! }
//! assert!(campaign.is_converged());
//! let best = &campaign.reports().last().expect("at least one iteration").numerical.point;
//! assert!((best[0] - 49.3).abs() < 0.1 && (best[1] - 19.4).abs() < 0.1);
//! assert_eq!(campaign.reports().len(), 6);
//! # Ok::<(), infuse::Error>(())
//! ```
//!
//! # What can go wrong, and what then happens
//!
//! * A simulation fails: the search meets a barrier, strictly above every finite cost it has seen, and goes around. The
//!   barrier is never a result; point and reason are in the report. Only when every simulation fails is there an error, and
//!   the state is as before.
//! * A trial fails: with one side the difference is taken from the center, with neither, or without the center where it is
//!   needed, the slope is unknown; the correction of that parameter stays as it was, and the report says so. When nothing
//!   was learned the campaign stops with [`StopReason::NoInformation`]. So report a failure only when the trial shall not be
//!   repeated.
//! * A side lies outside the region: by default it is not asked, and the difference is one-sided, which is off by half the
//!   curvature times the step. [`BoundPolicy::StepOutside`] asks it anyway.
//! * A setting could not be made exactly: [`Loop::tell_at`] takes the one that was made, and the difference uses it.
//! * The optimum rests on a bound: the campaign counts as converged only if the experiments, too, got worse away from that
//!   bound.
//! * R is small: so are the moves. Tolerances are on the move of p*, so choose them with R in mind.
//!
//! # Where it departs from the printed (27)
//!
//! As printed, the correction is J_cor,prev + R_p ∂J/∂p_p (p*_p − p_p) + R_c ∂J/∂p_c (p*_c − p_c). Its slope is *against* the
//! slope of the experiment, so the corrected model likes what the experiment disliked.
//!
//! * `printed_27_walks_away_from_the_optimum_of_the_experiment`: on two parabolas the distance to the experiment's optimum
//!   grows by 1 + R H_exp/H_mod per iteration.
//! * `repaired_27_approaches_the_optimum_of_the_experiment_geometrically`,
//!   `repaired_27_contracts_below_twice_the_ratio_of_curvatures_and_not_above`: with the sign repaired it follows the closed
//!   form above.
//! * `an_active_bound_does_not_wind_the_correction_up`: at an optimum on a bound J_mod has a slope of its own. It is
//!   subtracted, as modifier adaptation does (Marchetti, Chachuat and Bonvin 2009); otherwise the correction would grow
//!   against the bound for as long as the optimum rests there.
//! * `the_fixed_point_is_stationary_for_the_experiment`: random biased pairs, with coupling and with optima outside the box.
//!
//! [`Form::AsPrinted`](crate::correction::Form::AsPrinted) is (27) to the letter, for those who want to see it fail.
//!
//! # Unknown numbers of the plant
//!
//! With the feature `identification`, `IdentifyingLoop` is the same loop on a model with unknowns, which every turn finds anew from
//! all that was measured, alone or together with (27).
//!
//! # A saved campaign
//!
//! When it is read, every closed iteration must follow from its optimum and the outcomes of its trials, number for number:
//! that takes no more than sums, products and differences, so it holds on every machine. Where the next optimum is found
//! may differ elsewhere in the last digits, as the simulation itself may. The same goes for `IdentifyingLoop`; of it what the model
//! with unknowns has said, fits and slopes, is taken as it stands.

mod ask_tell;
mod campaign;
#[cfg(feature = "identification")]
mod identifying;
#[cfg(feature = "identification")]
mod identifying_state;
mod numerical;
mod report;
mod settings;
mod slope;
mod state;
mod trial;
mod turn;

pub use ask_tell::Ask;
pub use campaign::Loop;
#[cfg(feature = "identification")]
pub use identifying::{IdentifyingLoop, Mechanism, Reading, Turn, UncertainModel};
pub use numerical::NumericalOptimum;
pub use report::{Report, StopReason};
pub use settings::{BoundPolicy, Settings};
pub use trial::{Trial, TrialRecord, TrialRole};
