//! The loop of Chapters 5 and 6 and its Figures 4 and 19, over every combination of the levels of a region: design a
//! batch, experiment and simulate, fit surfaces, correct, test every cell, drop what is worse beyond doubt, repeat.
//!
//! `turn` is one turn of the figure; [`Loop`] asks for its experiments and takes their outcomes.
//!
//! # A turn
//!
//! M_i is what is left of the grid at the onset of batch i; coordinates are coded to the original box throughout.
//!
//! 1. Design N_E experiments and N_S simulations over M_i, each G-optimal for the regressor (the repaired (29)), and divide
//!    the experiments into training and validation (5.1). Terms that M_i cannot tell apart are left out for the batch and
//!    named; with fewer cells than runs, cells are run again.
//! 2. Run the simulations; hand out the experiments.
//! 3. Fit Ĵexp to all experiments and Ĵsim to the simulations, each by regression (30), (31), inverse distance (33) or
//!    squared exponential (34).
//! 4. Fit the combined Ĵ to the training experiments and to J(p_sim) + Ĵcor,i−1(p_sim), the simulations corrected by the
//!    batch *before*.
//! 5. Update the correction by a [`Rule`](crate::correction::Rule): (35), (36) or their repair.
//! 6. p̂* is the cell of M_i with the smallest Ĵ, of equals the first. With S from the validation experiments (40), drop
//!    every cell with
//!
//!    ```text
//!    z(p) = (Ĵ(p) − Ĵ(p̂*)) / (S √2) ≥ z_0        (39), z_0 = 1.2816 at 90 %, one-sided
//!    ```
//!
//! A dropped cell stays dropped. [`Loop::why_dropped`] says when and by which numbers, computed again from the surfaces of
//! that batch; [`Loop::retained_at`] gives any M_i.
//!
//! # What else it can do
//!
//! * **In two halves:** [`Loop::plan`] gives the designs of the next batch, [`Loop::open`] begins it with them. So
//!   simulations run side by side, or were run before, and a campaign is followed again from its notes without searching.
//! * **Dropping later:** the combined surface of batch 1 rests on simulations that nothing has corrected.
//!   [`Settings::first_screening`] = 2 lets that batch correct, and drop nothing.
//! * **Repeats:** [`Settings::replicates`] of the experiments repeat others where the design wants it;
//!   [`Loop::pure_error`] pools the scatter of equal settings.
//! * **Earlier experiments** ([`Loop::add_earlier`]) train both surfaces from then on, as long as their cell is left, and
//!   never validate.
//! * **Whether to go on:** [`Loop::outlook`] draws surfaces that may as well be true and says what it would be worth to
//!   know which; [`Loop::observed_certificate`] is the certificate with errors as they were at runs left out of the fits.
//! * **Validation cannot leak.** [`Observations`] and [`TracedSurface`] know every trial they rest on, directly or through
//!   a correction. [`quality_of_fit`], the only place where S is computed, refuses validation experiments that the
//!   surface rests on. Applying the correction in its own batch, the other reading of 5.4, is such a leak: Ĵexp has seen
//!   the validation experiments.
//! * **Minding what was run:** with [`Settings::careful`] cells whose experiment failed are dropped, S comes from
//!   validation experiments at new cells alone, no batch repeats an earlier one, and nothing is concluded from a misfit that
//!   no degree of freedom shows.
//! * **S undefined**, by fewer than two validation responses or a fit without error: [`Settings::fallback`] says whether
//!   nothing is dropped, a given S is used, or the campaign ends.
//! * **Little left:** a model without a constant can lose all its terms to a small M_i; a constant is then estimated, and
//!   the report says so. Should the search find no design, one is built run by run, each where the determinant or the
//!   prediction variance is largest.
//! * **Failures:** with too few experiments for Ĵexp the correction stays as it was and the report says why; the batch is
//!   then no step of the recursion. With too few simulations [`Loop::ask`] is an error, and the next call simulates other
//!   cells.
//! * **Memory** is one bit per cell, 24 MB at 24⁶, and nothing per cell in a file: what is left is found again when the
//!   campaign is read. While a batch is worked out there is more: a second set of bits, the candidates with their
//!   regressors, the search; the peak at 24⁶ was 233 MB, with 30 experiments, 60 simulations and 28 terms. Designs are
//!   searched among all cells of M_i up to [`Settings::candidate_limit`]; beyond, among a random part of them with the
//!   corners, edges and farthest cells, and the report says so.
//!
//! The z-test is the dissertation's, with its limits: S is a mean over validation points, so a narrow misfit at the optimum
//! goes unseen, and its 90 % is not the chance of keeping the optimum. A
//! [`RegretCertificate`](crate::convergence::RegretCertificate) says what can be promised.
//!
//! # A saved campaign, here and on another machine
//!
//! A [`Loop`] is one serializable value. When it is read it is replayed: all but the outcomes and the choice of cells is
//! computed again and must agree.
//!
//! * **On the same machine with the same build** it goes on with the same bits, on any number of threads.
//! * **Elsewhere** factorizations (`faer` takes the instructions it finds) and the platform's exp, ln and sin may round
//!   differently. So what was chosen and reported must agree exactly: cells, trials, outcomes, dropped terms, numbers of
//!   cells. What was computed (S, Ĵ(p̂*), changes) must agree as [`agrees`] says, to 1e-9 of the largest response, and
//!   efficiencies to 1e-6. The error names the field, what the file says and what was found.
//! * So elsewhere the next designs may be others, and a cell whose z is z_0 to rounding, or a tie for the optimum, may be
//!   decided otherwise: then the file is refused there.
//!
//! `max_batches` and `seed` may be changed in a file; a seed counts from the next batch on.
//! The tests `saving_and_loading_at_every_point_changes_no_bit`, `the_number_of_threads_changes_no_bit` and
//! `numbers_that_follow_may_differ_by_rounding_and_not_by_more` hold what is promised here.

mod agreement;
mod ask_tell;
mod batch;
mod campaign;
mod candidates;
mod cells;
mod changes;
mod earlier;
mod experience;
mod farthest;
mod fits;
mod greedy;
mod left;
mod open_batch;
mod outlook;
mod plan;
mod promises;
mod pure_error;
mod report;
mod retained;
mod screening;
mod settings;
mod spread;
mod state;
mod surfaces;
pub(crate) mod trial;
mod turn;

pub use crate::pure_error::PureError;
pub use agreement::agrees;
pub use ask_tell::Ask;
pub use campaign::Loop;
pub use earlier::EarlierExperiment;
pub use outlook::Outlook;
pub use plan::Plan;
pub use promises::ObservedErrors;
pub use report::{Report, StopReason};
pub use retained::RetainedSet;
pub use settings::{Settings, SpreadFallback, SurfaceKind, SurfaceKinds};
pub use spread::quality_of_fit;
pub use surfaces::BatchSurfaces;
pub use trial::{Trial, TrialRecord, TrialUse};

pub use crate::traced::{Observations, TracedSurface};

/// What a [`Report`] consists of, and what is said of a dropped cell.
pub mod reported {
    pub use super::batch::{Batch, DroppedTerm};
    pub use super::changes::SurfaceChanges;
    pub use super::report::SimulationRecord;
    pub use super::screening::{Dropped, Screening};
    pub use super::spread::{Spread, SpreadFault};
}
