//! What the experiments so far come to: the recommended design, how far it may be from the best, and what speaks against it.

use design_space::Cell;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::pooled::bands::Bands;
use crate::pooled::certificate::{Certificate, Evidence, Forecast};
use crate::pooled::designs::Designs;
use crate::pooled::drift::{Drift, Members, Shift};
use crate::pooled::held::{Expected, MAY_RESPOND, UNKNOWN};
use crate::pooled::knowledge::Knowledge;
use crate::pooled::measurements::Reading;
use crate::pooled::outliers::{Doubted, Outlier, Readings};
use crate::pooled::registration::Registration;
use crate::pooled::settings::{Settings, StopBy};

/// What is known of one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Its cell.
    pub cell: Cell,
    /// Settings, natural.
    pub point: Vec<f64>,
    /// The response that is expected there.
    pub mean: f64,
    /// Standard deviation of that expectation, without the noise of a reading: up to four times as large as the surface has it while there
    /// are few readings, and as it is when they are many times the terms of a quadratic.
    pub deviation: f64,
    /// Number of readings there.
    pub n_readings: usize,
    /// Mean of those readings.
    pub measured: Option<f64>,
    /// Probability that an experiment there gives a response.
    pub feasible: f64,
    /// Probability that it is better than the recommended design and keeps to every constraint; 0 for that one.
    pub probability_better: f64,
    /// Whether it may still be the best: it is better than the recommended one with a probability of at least 1 − the
    /// certificate's, and an experiment there gives a response with a probability of at least 0.75.
    pub may_be_best: bool,
    /// Each constrained response there, in the order of the constraints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<Constrained>,
    /// Whether it keeps to every constraint with the probability that is asked for, and gives a response with 0.75.
    pub suffices: bool,
}

impl Standing {
    /// The same with a wider band.
    pub(crate) fn widened(self, bands: Bands) -> Self {
        Self { deviation: bands.widen(self.deviation), ..self }
    }
}

/// What is known of a constrained response at one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Constrained {
    /// What is expected, and the standard deviation of that without the noise of a reading; none before its first reading.
    pub expected: Option<(f64, f64)>,
    /// Probability that the design keeps to the bounds.
    pub within: f64,
    /// Mean of its readings there.
    pub measured: Option<f64>,
}

/// What is expected at one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    /// The response.
    pub mean: f64,
    /// Standard deviation of that, as of a [`Standing`].
    pub deviation: f64,
    /// Probability that an experiment there gives a response.
    pub feasible: f64,
    /// Each constrained response there, in the order of the constraints; `measured` is not looked up.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<Constrained>,
}

/// The lowest mean of readings at one design, where it contradicts the recommendation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contradiction {
    /// The design that measured so low, or the recommended one itself.
    pub standing: Standing,
    /// Its readings lie as many of their standard errors away from what the surface says: below it, or above it for the
    /// recommended design.
    pub deviations: f64,
}

/// What the simulation is worth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SimulationWorth {
    /// Squared correlation of simulation and readings: the share of their variance that the simulation explains. Where it is displaced, of
    /// the readings of which it tells within the bounds.
    pub explained: f64,
    /// Whether that correlation is negative: what the simulation calls better is worse.
    #[serde(default)]
    pub is_inverted: bool,
    /// Probability that the response is better learnt without it.
    pub ignored: f64,
    /// Mean of its factor ρ, where it is used.
    pub factor: f64,
    /// Standard deviation of that.
    pub factor_deviation: f64,
}

/// What a certificate waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Needed {
    /// So many readings, three more than a plane has terms: of fewer none knows how much of what they differ by is noise.
    Readings(usize),
    /// Readings of so many different designs, one more than a plane has terms: repeats do not tell what others are like.
    Designs(usize),
    /// A design that is run again: where there are no more designs than a quadratic has terms, it fits whatever they read, and nothing else
    /// tells the noise.
    Repeat,
    /// A reading that differs: where all are equal, to the last bit, they tell neither what designs differ by nor the noise.
    Difference,
    /// Readings that tell of the parameters: these may be noise alone, which foretells each of them from the others nearly as well as the
    /// surface does. What they differ by is then no measure of what wells may be deep. Not once so many designs were run that nothing is
    /// [held in reserve](Forecast::reserves_until) for one.
    Signal,
}

impl Needed {
    /// The first of them.
    pub(crate) fn of(
        evidence: &Evidence,
        designs: &Designs,
        settings: &Settings,
        repeats: (usize, bool),
    ) -> Option<Self> {
        let (n_repeats, are_equal) = repeats;
        let n_designs = usize::try_from(evidence.n_designs).unwrap_or(usize::MAX);
        let (readings, different) = (designs.n_to_promise(), designs.n_to_tell().min(n_designs));
        let is_noise_unknown = settings.noise.is_none() && n_repeats == 0;
        match evidence {
            few if few.n_readings < readings => Some(Self::Readings(readings)),
            few if few.n_tried < different => Some(Self::Designs(different)),
            _ if is_noise_unknown && designs.are_few() => Some(Self::Repeat),
            _ if are_equal && n_designs > 1 => Some(Self::Difference),
            _ => None,
        }
    }
}

/// The state of knowledge after some experiments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assessment {
    /// The feasible design with the lowest mean.
    pub recommended: Standing,
    /// How much better another may be.
    pub certificate: Certificate,
    /// What the certificate waits for before it says anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needed: Option<Needed>,
    /// How that is expected to fall.
    pub forecast: Forecast,
    /// Standard deviation of one reading, as given or as learnt.
    pub noise: f64,
    /// Standard deviation of the error that all runs of an assembly share, where plants are told apart, or of a block, where that is taken in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assembly: Option<f64>,
    /// As much of that may be the plants' own, a part of the response: what plants that were put together again do not differ by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<f64>,
    /// Assemblies beyond the first of their plant, which alone tell one from the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_again: Option<usize>,
    /// Degrees of freedom of the repeats, which alone measure the noise: readings beyond one per setting.
    pub n_repeats: usize,
    /// Whether readings are taken to have no noise, because that was said or because repeats do not differ at all.
    #[serde(default)]
    pub is_exact: bool,
    /// Share of all designs that may still be the best.
    pub left: f64,
    /// Their number, where all designs were looked at: of many, `left` is told from a sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_left: Option<u64>,
    /// Share of all designs that a well may take and have been met by no run: as many evenly spread runs as leave no more of the box
    /// unseen would have met a larger one with the certificate's probability. None where every design was run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen: Option<f64>,
    /// What the simulation is worth; none without one, or before three readings.
    pub simulation: Option<SimulationWorth>,
    /// How far the simulation is displaced, in the unit of each parameter: an experiment gives what it says of a design so much farther on.
    /// None where it is not, as far as readings tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Vec<f64>>,
    /// What the readings tell of that, sure or not; none without a simulation, before there are enough of them, and where the campaign takes the
    /// simulation as it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<Registration>,
    /// What the readings say of runs of a batch that read otherwise than those of others, sure or not; none where they are too few, where
    /// such an error is [taken in](Settings::blocks) whatever they say, and where runs of a plant share one anyway.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
    /// The same of each constrained response; empty where nothing is constrained, or nobody asks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained_drifts: Vec<Option<Drift>>,
    /// By how much the runs of each block read above what is expected of them, where they [share an error](Self::assembly) that is taken in.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shifts: Vec<Shift>,
    /// Standard deviation of the error that readings of each constrained response share, where that is taken in; empty where it is for none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained_shared: Vec<Option<f64>>,
    /// Readings that contradict the recommendation.
    pub contradiction: Option<Contradiction>,
    /// Settings of the best design that was measured to be far better than runs elsewhere say, and was not looked around on all sides
    /// yet; natural.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub find: Option<Vec<f64>>,
    /// Readings more than four standard deviations off, and those that are set aside.
    pub outliers: Vec<Outlier>,
    /// Whether the response is [said](Settings::smooth) to have no narrow well, and is not believed to: runs of one design, more than one, are
    /// far better than all others say.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub smooth_refuted: bool,
    /// The one of them on which the recommended design stands, if its settings were run but once: what is expected there holds unless that
    /// reading is a slip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubted: Option<Doubted>,
    /// [Further batches](Forecast::further_batches) until what the campaign [stops by](Settings::stop_by) is expected to be as small as its `worth`,
    /// open ones among them: 0 if it is. None without `worth`, and where there is no forecast.
    pub further_batches: Option<u64>,
}

impl Assessment {
    /// By how much another design may be better, as the certificate has it; none while something is [needed](Self::needed) to say so, and
    /// where no design is known to keep to its bounds.
    #[must_use]
    pub fn bound(&self) -> Option<f64> {
        let is_kept = self.recommended.suffices || self.recommended.constrained.is_empty();
        (self.needed.is_none() && is_kept).then_some(self.certificate.bound)
    }

    /// Whether readings of the response are sure of a [drift](Self::drift).
    #[must_use]
    pub fn is_drifting(&self) -> bool {
        self.drift.as_ref().is_some_and(Drift::is_sure)
    }

    /// With what nobody needs to choose a batch.
    pub(crate) fn with_shifts(
        self,
        knowledge: &mut Knowledge<'_, '_>,
        readings: &Readings,
        settings: &Settings,
    ) -> Result<Self, Error> {
        if settings.plants.is_some() || !readings.are_shared() {
            return Ok(self);
        }
        let cells: Vec<Cell> = readings.kept.iter().map(|reading| reading.cell).collect();
        let places = knowledge.places(&cells)?;
        let beyond = readings.kept.iter().zip(knowledge.process.marginals(&places)?.means);
        let beyond: Vec<f64> = beyond.map(|(reading, expected)| reading.response - expected).collect();
        let shifts = Shift::of_each(&Members::of(&readings.kept, &readings.blocks), &beyond);
        Ok(Self { shifts, ..self })
    }

    /// The same, as a campaign has it that [stops](Settings::stop_by) so.
    #[must_use]
    pub fn bound_to_stop_by(&self, stop_by: StopBy) -> Option<f64> {
        self.bound().map(|bound| match stop_by {
            StopBy::Bound => bound,
            StopBy::Surface => self.forecast.by_the_surface(),
        })
    }
}

/// What the surface has of a design, beside the recommended one.
pub(crate) fn standing(
    knowledge: &mut Knowledge<'_, '_>,
    readings: &[Reading],
    constrained: &[Vec<Reading>],
    cell: Cell,
    recommended: Cell,
    confidence: f64,
) -> Result<Standing, Error> {
    let cells = [recommended, cell];
    let places = knowledge.places(&cells)?;
    let marginals = knowledge.marginals(&places)?;
    let chances = knowledge.chances(&cells, &places)?;
    let feasible = chances.responding[1];
    let probability_better = match cell == recommended {
        true => 0.0,
        false => better(knowledge, &places)?[1] * chances.within[1],
    };
    let here: Vec<f64> =
        readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response).collect();
    let n_readings = here.len();
    let may_be_best = cell == recommended || (feasible >= MAY_RESPOND && probability_better >= 1.0 - confidence);
    let mut of_constraints = constrained_at(knowledge, &[cell])?.remove(0);
    for (one, readings) in of_constraints.iter_mut().zip(constrained) {
        let here = readings.iter().filter(|reading| reading.cell == cell).map(|reading| reading.response);
        let n = here.clone().count() as f64;
        one.measured = (n > 0.0).then(|| here.sum::<f64>() / n);
    }
    Ok(Standing {
        cell,
        point: knowledge.designs.grid().point(cell)?,
        mean: marginals.means[1],
        deviation: marginals.variances[1].sqrt(),
        n_readings,
        measured: (n_readings > 0).then(|| here.iter().map(|response| response / n_readings as f64).sum()),
        feasible,
        probability_better,
        may_be_best,
        constrained: of_constraints,
        suffices: chances.suffices[1],
    })
}

/// What is known of each constrained response at each of the cells.
pub(crate) fn constrained_at(knowledge: &Knowledge<'_, '_>, cells: &[Cell]) -> Result<Vec<Vec<Constrained>>, Error> {
    let of_each = knowledge.expected_of_each(cells)?;
    let at = |place: usize| {
        let one = |expected: &Option<Expected>| Constrained {
            expected: expected.as_ref().map(|expected| (expected.means[place], expected.deviations[place])),
            within: expected.as_ref().map_or(UNKNOWN, |expected| expected.within[place]),
            measured: None,
        };
        of_each.iter().map(one).collect()
    };
    Ok((0..cells.len()).map(at).collect())
}

/// Probability of each place to be better than the first, over all particles.
pub(crate) fn better(knowledge: &Knowledge<'_, '_>, places: &surface::process::Places) -> Result<Vec<f64>, Error> {
    let of_each = knowledge.contrasts(places)?;
    let n = of_each.len() as f64;
    let below = |place: usize| of_each.iter().map(|each| each.probability_below(place) / n).sum();
    Ok((0..places.n_places()).map(below).collect())
}
