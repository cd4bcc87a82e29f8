//! What is kept: a row for each design that somebody chose, a fact for each number that belongs to a plant.

use anyhow::{Context as _, Result, ensure};

/// In what the experiments are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum World {
    /// The stand-in as it was calibrated: still water, a symmetric hull, a state that is known; noise is added to the cost.
    Still,
    /// Water that moves about a hull whose sides differ: one flight is an experiment, and no noise is added.
    Moving,
    /// The same seen by three cameras: some designs are flown again, and nobody chooses by it.
    Cameras,
}

impl World {
    pub(super) const ALL: [Self; 3] = [Self::Still, Self::Moving, Self::Cameras];
    /// Those in which campaigns are run.
    pub(super) const OF_CAMPAIGNS: [Self; 2] = [Self::Still, Self::Moving];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::Moving => "moving",
            Self::Cameras => "cameras",
        }
    }
}

/// What is optimized.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Study {
    /// The open loop: curves, and no campaign.
    Chapter3,
    Chapter4,
    /// Known truths: curves, and no campaign that is kept.
    Chapter6,
    /// Chapter 7, two parameters.
    Two,
    /// Chapter 7, four parameters.
    Four,
}

impl Study {
    pub(super) const ALL: [Self; 5] = [Self::Chapter3, Self::Chapter4, Self::Chapter6, Self::Two, Self::Four];
    /// Those in which campaigns are run here.
    pub(super) const OF_CAMPAIGNS: [Self; 3] = [Self::Chapter4, Self::Two, Self::Four];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Chapter3 => "chapter3",
            Self::Chapter6 => "chapter6",
            Self::Chapter4 => "chapter4",
            Self::Two => "chapter7-2",
            Self::Four => "chapter7-4",
        }
    }

    /// Of which chapter it is.
    pub(super) const fn chapter(self) -> &'static str {
        match self {
            Self::Chapter3 => "Chapter 3",
            Self::Chapter4 => "Chapter 4",
            Self::Chapter6 => "Chapter 6",
            Self::Two | Self::Four => "Chapter 7",
        }
    }

    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::Chapter3 => "Chapter 3",
            Self::Chapter6 => "Chapter 6, 2 parameters",
            Self::Chapter4 => "Chapter 4",
            Self::Two => "Chapter 7, 2 parameters",
            Self::Four => "Chapter 7, 4 parameters",
        }
    }
}

/// How a design was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Method {
    /// By the numerical model alone.
    Numerical,
    /// By the loop of the dissertation.
    Dissertation,
    /// By the loop of `infuse::pooled`.
    Pooled,
    /// From the experiments of the dissertation's loop, by a regression on them that knows no simulation.
    Alone,
    /// From Sobol points by a Gaussian process that knows no simulation.
    Process,
    /// The center of the box.
    Center,
    /// By nobody.
    Random,
    /// The best that was found in still water.
    Best,
}

impl Method {
    pub(super) const ALL: [Self; 8] = [
        Self::Numerical,
        Self::Dissertation,
        Self::Pooled,
        Self::Alone,
        Self::Process,
        Self::Center,
        Self::Random,
        Self::Best,
    ];

    /// Whether it is run once for each seed.
    pub(super) fn has_seeds(self) -> bool {
        matches!(self, Self::Dissertation | Self::Pooled | Self::Alone | Self::Process)
    }

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Numerical => "numerical",
            Self::Dissertation => "dissertation",
            Self::Pooled => "pooled",
            Self::Alone => "alone",
            Self::Process => "process",
            Self::Center => "center",
            Self::Random => "random",
            Self::Best => "best",
        }
    }
}

/// What a design shows in its flights: means over the test, and over the flights where there are several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    Cost,
    /// Standard deviation of the cost over flights.
    CostSd,
    /// Mean square of the heading, in deg².
    Heading,
    /// Of the pitch error, in deg².
    Pitch,
    /// Of the roll error, in deg².
    Roll,
    /// Magnitude of the mean roll error, in deg.
    RollOffset,
    /// Mean zenith angle, in deg.
    Zenith,
    /// Mean square of the altitude error, in cm².
    Altitude,
    /// Mean footprint, in cm².
    Footprint,
    /// Mean pitch error over the last ten seconds, magnitude, in deg.
    SteadyPitch,
    /// Share of the samples with a pose that was held.
    Held,
}

pub(super) const N_READINGS: usize = 11;

const READING_NAMES: [&str; N_READINGS] = [
    "cost_s",
    "cost_sd_s",
    "heading_deg2",
    "pitch_deg2",
    "roll_deg2",
    "roll_offset_deg",
    "zenith_deg",
    "altitude_cm2",
    "footprint_cm2",
    "steady_pitch_deg",
    "held",
];

/// Readings by [`Reading`]; not finite where the design cannot fly.
pub(super) type Readings = [f64; N_READINGS];

/// A unit of work: what is lost when a run is killed.
pub(super) type Unit = (String, u64);
/// The work of the unit that knows no plant: designs of experiments. Its number stands in the place of one.
pub(super) const DESIGNS: &str = "designs";

/// A design that was chosen after a step of a method.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) study: Study,
    pub(super) world: World,
    pub(super) method: Method,
    /// Of the noise or the water; number of the point where nobody chose.
    pub(super) seed: u64,
    /// Iteration or batch, from 1; 0 where there was no experiment.
    pub(super) step: usize,
    pub(super) point: Vec<f64>,
    /// Share of the space that is left.
    pub(super) share: f64,
    /// S of (39).
    pub(super) spread: f64,
    /// 1 where the best design known is still in what is left, 0 where it was dropped.
    pub(super) keeps_best: f64,
    pub(super) readings: Readings,
}

impl Row {
    pub(super) fn of(&self, reading: Reading) -> f64 {
        self.readings[reading as usize]
    }

    pub(super) fn cost(&self) -> f64 {
        self.of(Reading::Cost)
    }
}

/// A number that belongs to a plant in a study and a world.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fact {
    pub(super) study: Study,
    pub(super) world: World,
    pub(super) name: String,
    pub(super) value: f64,
}

/// The coordinates of a point that a table has room for.
const N_COORDINATES: usize = 4;
const N_OWN: usize = 8;

pub(super) fn row_head() -> Vec<String> {
    let own = ["study", "world", "method", "seed", "step", "share_left", "spread_s", "keeps_best"];
    let coordinates = ["center_of_mass_pct", "pitch_set_point_deg", "horizontal_area", "vertical_area"];
    own.into_iter().chain(coordinates).chain(READING_NAMES).map(str::to_owned).collect()
}

pub(super) fn fact_head() -> Vec<String> {
    ["study", "world", "name", "value"].map(str::to_owned).to_vec()
}

/// Six digits: more say nothing, and fill the file.
fn digits(value: f64) -> String {
    if value.is_finite() {
        format!("{value:.5e}").parse::<f64>().map_or(String::new(), |rounded| rounded.to_string())
    } else {
        String::new()
    }
}

fn number(text: &str) -> Result<f64> {
    if text.is_empty() { Ok(f64::NAN) } else { text.parse().with_context(|| format!("`{text}` is no number")) }
}

fn named<T: Copy>(all: &[T], name: fn(T) -> &'static str, text: &str) -> Result<T> {
    all.iter().copied().find(|one| name(*one) == text).with_context(|| format!("`{text}` is not known here"))
}

impl Row {
    pub(super) fn cells(&self) -> Vec<String> {
        let mut cells = [self.study.name(), self.world.name(), self.method.name()].map(str::to_owned).to_vec();
        cells.extend([self.seed.to_string(), self.step.to_string()]);
        cells.extend([self.share, self.spread, self.keeps_best].map(digits));
        cells.extend((0..N_COORDINATES).map(|k| self.point.get(k).map_or(String::new(), |x| digits(*x))));
        cells.extend(self.readings.map(digits));
        cells
    }

    pub(super) fn read(cells: &[String]) -> Result<Self> {
        let head = row_head();
        ensure!(cells.len() == head.len(), "{} cells, {} are needed", cells.len(), head.len());
        let column = |k: usize| format!("column `{}`", head[k]);
        let at = |k: usize| number(&cells[k]).with_context(|| column(k));
        let whole = |k: usize| -> Result<u64> {
            cells[k].parse().ok().with_context(|| format!("{}: `{}` is no whole number", column(k), cells[k]))
        };
        let mut readings = [f64::NAN; N_READINGS];
        for (k, reading) in readings.iter_mut().enumerate() {
            *reading = at(N_OWN + N_COORDINATES + k)?;
        }
        Ok(Self {
            study: named(&Study::ALL, Study::name, &cells[0]).with_context(|| column(0))?,
            world: named(&World::ALL, World::name, &cells[1]).with_context(|| column(1))?,
            method: named(&Method::ALL, Method::name, &cells[2]).with_context(|| column(2))?,
            seed: whole(3)?,
            step: whole(4)? as usize,
            share: at(5)?,
            spread: at(6)?,
            keeps_best: at(7)?,
            point: (N_OWN..N_OWN + N_COORDINATES).filter(|k| !cells[*k].is_empty()).map(at).collect::<Result<_>>()?,
            readings,
        })
    }
}

impl Fact {
    pub(super) fn cells(&self) -> Vec<String> {
        vec![self.study.name().to_owned(), self.world.name().to_owned(), self.name.clone(), digits(self.value)]
    }

    pub(super) fn read(cells: &[String]) -> Result<Self> {
        let head = fact_head();
        ensure!(cells.len() == head.len(), "{} cells, {} are needed", cells.len(), head.len());
        let column = |k: usize| format!("column `{}`", head[k]);
        Ok(Self {
            study: named(&Study::ALL, Study::name, &cells[0]).with_context(|| column(0))?,
            world: named(&World::ALL, World::name, &cells[1]).with_context(|| column(1))?,
            name: cells[2].clone(),
            value: number(&cells[3]).with_context(|| column(3))?,
        })
    }
}
