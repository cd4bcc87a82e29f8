//! The numbers and choices of the dissertation's loop.

use design_space::{Model, Region};
use doe::SplitMethod;
use serde::{Deserialize, Serialize};
use surface::{Confounded, Data, InverseDistance, Kind};

use crate::Error;
use crate::correction::{Gain, Law, Rule};

/// Beyond it a regression may refuse its data as dependent, after the experiments were made.
const LARGEST_WEIGHT_RATIO: f64 = 1e6;

/// How one of the three response surfaces is estimated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SurfaceKind {
    /// Weighted least squares on the regressor, (30) and (31).
    #[default]
    Regression,
    /// Inverse distance, (32) and (33).
    InverseDistance {
        /// The power of the distance, above 0 and at most 100; 2 in (33).
        #[serde(default = "default_power")]
        power: f64,
    },
    /// Squared exponential, (34).
    SquaredExponential {
        /// The scale c, 1e-100 to 1e100, per coded unit; chosen by leaving out one place at a time if there is none.
        #[serde(default)]
        scale: Option<f64>,
    },
}

fn default_power() -> f64 {
    InverseDistance::POWER
}

impl SurfaceKind {
    pub(crate) fn with_model(self, model: &Model) -> Kind {
        match self {
            Self::Regression => Kind::Regression { model: model.clone(), confounded: Confounded::Refuse },
            Self::InverseDistance { power } => Kind::InverseDistance { power },
            Self::SquaredExponential { scale } => Kind::SquaredExponential { scale },
        }
    }
}

/// The kinds of the three surfaces of Section 5.3. Default: regressions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table, like { combined = \"inverse_distance\" }")]
pub struct SurfaceKinds {
    /// Ĵexp, of the experiments alone.
    pub experiment: SurfaceKind,
    /// Ĵsim, of the simulations alone.
    pub simulation: SurfaceKind,
    /// Ĵ, of training experiments and corrected simulations.
    pub combined: SurfaceKind,
}

/// What a batch does when its validation experiments give no spread S: fewer than two of them
/// succeeded, or they were predicted without error, or so badly that S is not finite.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpreadFallback {
    /// It drops nothing.
    #[default]
    KeepAll,
    /// It uses this S, in the unit of the response, above 0.
    Given(f64),
    /// It drops nothing and ends the campaign.
    Stop,
}

/// The settings of the dissertation's loop.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The regressor r(p) of (28), in coordinates coded to the original box: of the designs, and of
    /// every surface that is a regression.
    pub model: Model,
    /// N_E, experiments per batch: at least 4, and at least the number of terms.
    pub n_experiments: usize,
    /// How many of the experiments repeat others of the same batch, at most half of them: where, the design decides.
    /// Repeats measure the noise, and against it the lack of fit. Default 0.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub replicates: usize,
    /// N_S, simulations per batch: at least the number of terms.
    pub n_simulations: usize,
    /// How the surfaces are estimated.
    #[serde(default)]
    pub surfaces: SurfaceKinds,
    /// w of (31) of each training experiment, 1e-6 to 1e6 times that of a simulation. Default 0.7, as in Section 7.2.
    ///
    /// Weights are per point: with 9 training experiments and 36 simulations, 0.7 and 0.3 give the
    /// simulations 63 % of the total.
    #[serde(default = "default_experiment_weight")]
    pub experiment_weight: f64,
    /// w of (31) of each simulation, above 0. Default 0.3.
    #[serde(default = "default_simulation_weight")]
    pub simulation_weight: f64,
    /// Level of the one-sided z-test, between 0.5 and 1. Default 0.9, as in Section 5.5.
    #[serde(default = "default_confidence")]
    pub confidence: f64,
    /// The first batch that drops cells. Default 1, as in Section 5.5. But the combined surface of batch 1 is fitted to
    /// simulations that nothing has corrected yet, so where they are far off, 2 is safer.
    #[serde(default = "default_first_screening", skip_serializing_if = "is_one")]
    pub first_screening: usize,
    /// How the experiments correct the simulation. Default: the recursion of the proof with gain 0.5;
    /// the dissertation does not tell its gain.
    #[serde(default = "default_correction")]
    pub correction: Rule,
    /// What to do without a spread.
    #[serde(default)]
    pub fallback: SpreadFallback,
    /// How experiments are divided into training and validation. Default: the alternation of Section 5.1.
    /// The balanced split needs a training half with as many runs as the model has terms.
    #[serde(default = "default_split")]
    pub split: SplitMethod,
    /// Whether a campaign minds what it has run. Default `false`: as in the dissertation, each batch stands alone. With
    /// `true`
    ///
    /// - a cell whose experiment failed, and where none gave a response, is dropped with the batch: it is not run again and
    ///   is no optimum;
    /// - S (40) comes from validation experiments at cells that taught the surface nothing: neither a training experiment of
    ///   the batch, nor any experiment of an earlier batch, nor one from outside of the campaign was made there. With fewer
    ///   than two such it is undefined, and the [`fallback`](Self::fallback) says what happens;
    /// - experiments at new cells validate first, and a batch with too few of them for that is designed anew from cells that
    ///   were not run, if enough are left; so none repeats an earlier one;
    /// - a batch whose experiments were made at no more settings than the regressor has terms drops nothing by the test, and
    ///   [`outlook`](crate::global::Loop::outlook) says nothing of the misfit after it.
    #[serde(default, skip_serializing_if = "is_false")]
    pub careful: bool,
    /// Limit on the batches. Default 10.
    #[serde(default = "default_max_batches", alias = "max_iterations")]
    pub max_batches: usize,
    /// Everything random follows from this. Default 1.
    ///
    /// It may be changed in the file of a saved campaign, and then counts from the next batch on: designs that
    /// were made are not searched for again. Only with more cells than the
    /// [`candidate_limit`](Self::candidate_limit) it also decides what past designs are compared with, and is refused.
    #[serde(default = "default_seed")]
    pub seed: u64,
    /// Starts of each search for a design. Default 2; the time of a batch is nearly all theirs.
    #[serde(default = "default_design_starts")]
    pub design_starts: u64,
    /// Designs are searched among at most about this many cells, at least 1000: a larger set is
    /// represented by a part of it. Default 400,000; for more than 15 terms so many that they have
    /// 4,500,000 regressors, which keeps a search within some 150 MB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidate_limit: Option<u64>,
}

fn default_experiment_weight() -> f64 {
    0.7
}

fn default_simulation_weight() -> f64 {
    0.3
}

fn default_confidence() -> f64 {
    0.9
}

fn default_first_screening() -> usize {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
pub(crate) fn is_zero(count: &usize) -> bool {
    *count == 0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_false(flag: &bool) -> bool {
    !*flag
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_one(count: &usize) -> bool {
    *count == 1
}

fn default_correction() -> Rule {
    // One half is a gain, so the other branch is never taken.
    let gain = Gain::constant(0.5).unwrap_or_else(|_| Gain::harmonic());
    Rule::new(Law::ProofRecursion, gain)
}

fn default_split() -> SplitMethod {
    SplitMethod::Alternating
}

fn default_max_batches() -> usize {
    10
}

fn default_seed() -> u64 {
    1
}

fn default_design_starts() -> u64 {
    2
}

/// Designs are searched among at least so many cells.
const LEAST_CANDIDATES: u64 = 1000;

const MOST_CANDIDATES: u64 = 400_000;
/// Up to so many terms the default number of candidates needs little memory.
const FEW_TERMS: usize = 15;
/// With more terms, as many candidates as have so many regressors together: 36 MB, of which a search holds a few copies.
const MOST_REGRESSORS: usize = 4_500_000;

impl Settings {
    /// The largest number of experiments or simulations of a batch.
    pub const MOST_RUNS: usize = 10_000;

    /// Settings with this regressor and these numbers of experiments and simulations per batch;
    /// the rest as documented per field.
    #[must_use]
    pub fn new(model: Model, n_experiments: usize, n_simulations: usize) -> Self {
        Self {
            model,
            n_experiments,
            replicates: 0,
            n_simulations,
            surfaces: SurfaceKinds::default(),
            experiment_weight: default_experiment_weight(),
            simulation_weight: default_simulation_weight(),
            confidence: default_confidence(),
            first_screening: default_first_screening(),
            correction: default_correction(),
            fallback: SpreadFallback::default(),
            split: default_split(),
            careful: false,
            max_batches: default_max_batches(),
            seed: default_seed(),
            design_starts: default_design_starts(),
            candidate_limit: None,
        }
    }

    /// The limit in force.
    #[must_use]
    pub fn candidate_limit(&self) -> u64 {
        let n_terms = self.model.n_terms();
        let by_memory = if n_terms > FEW_TERMS { MOST_REGRESSORS / n_terms } else { usize::MAX };
        self.candidate_limit.unwrap_or_else(|| MOST_CANDIDATES.min(by_memory as u64).max(LEAST_CANDIDATES))
    }

    /// Whether every setting is usable for this region.
    ///
    /// # Errors
    ///
    /// [`Error::DesignSpace`] for a regressor of another number of factors, [`Error::Setting`], [`Error::SettingCount`];
    /// [`Error::Surface`] for the power or scale of a surface.
    pub fn validate(&self, region: &Region) -> Result<(), Error> {
        let (expected, found) = (region.n_parameters(), self.model.n_factors());
        if expected != found {
            return Err(doe::Error::FactorMismatch { what: "the setting `model`", expected, found }.into());
        }
        let n_terms = self.model.n_terms();
        let runs = "at least the number of terms of the model, at most 10000";
        count(
            "n_experiments",
            self.n_experiments,
            self.n_experiments >= 4,
            "at least 4: two to train, two to validate",
        )?;
        for (name, value) in [("n_experiments", self.n_experiments), ("n_simulations", self.n_simulations)] {
            count(name, value, (n_terms..=Self::MOST_RUNS).contains(&value), runs)?;
        }
        let distinct = self.n_experiments.saturating_sub(self.replicates);
        let repeats = 2 * self.replicates <= self.n_experiments && distinct >= n_terms;
        let expected = "at most half of the experiments, the others at least as many as the model has terms";
        count("replicates", self.replicates, repeats, expected)?;
        let trains = self.split != SplitMethod::Balanced || self.n_experiments.div_ceil(2) >= n_terms;
        let expected = "twice the number of terms less one for the balanced split, or the alternating split";
        count("n_experiments", self.n_experiments, trains, expected)?;
        for kind in [self.surfaces.experiment, self.surfaces.simulation, self.surfaces.combined] {
            kind.with_model(&self.model).check()?;
        }
        self.validate_weights()?;
        if !(self.confidence > 0.5 && self.confidence < 1.0) {
            return Err(Error::Setting {
                name: "confidence",
                value: self.confidence,
                expected: "0.5 < confidence < 1",
            });
        }
        if let SpreadFallback::Given(spread) = self.fallback {
            positive("fallback", spread)?;
        }
        count("first_screening", self.first_screening, self.first_screening > 0, "at least 1")?;
        count("max_batches", self.max_batches, self.max_batches > 0, "at least 1")?;
        let positive_count = |name, value: u64, least: u64, expected| {
            let value_shown = usize::try_from(value).unwrap_or(usize::MAX);
            count(name, value_shown, value >= least, expected)
        };
        positive_count("design_starts", self.design_starts, 1, "at least 1")?;
        positive_count("candidate_limit", self.candidate_limit(), LEAST_CANDIDATES, "at least 1000")
    }

    fn validate_weights(&self) -> Result<(), Error> {
        let (name, experiment, simulation) = ("experiment_weight", self.experiment_weight, self.simulation_weight);
        for (name, value) in [(name, experiment), ("simulation_weight", simulation)] {
            if !(Data::SMALLEST_WEIGHT..=Data::LARGEST).contains(&value) {
                return Err(Error::Setting { name, value, expected: "a number from 1e-100 to 1e100" });
            }
        }
        let ratio = experiment / simulation;
        if (1.0 / LARGEST_WEIGHT_RATIO..=LARGEST_WEIGHT_RATIO).contains(&ratio) {
            return Ok(());
        }
        let expected = "1e-6 to 1e6 times `simulation_weight`, or one kind of data would be lost by rounding";
        Err(Error::Setting { name, value: experiment, expected })
    }
}

fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Setting { name, value, expected: "a positive number" })
}

fn count(name: &'static str, value: usize, is_usable: bool, expected: &'static str) -> Result<(), Error> {
    if is_usable { Ok(()) } else { Err(Error::SettingCount { name, value, expected }) }
}
