//! Water that moves beside its mean flow: turbulence and shedding as a table that is made before the flight.

use bat_dynamics::{FlowHistory, Real};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::Error;
use crate::shedding::Shedding;
use crate::turbulence::{Direction, Turbulence, unit_gusts};

/// What moves in the water of a test, and the seed that fixes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingWater {
    /// Turbulence, if there is any.
    pub turbulence: Option<Turbulence>,
    /// Vortex shedding, if there is any.
    pub shedding: Option<Shedding>,
    /// The seed: the same seed is the same water.
    pub seed: u64,
}

/// The water at one sample, relative to the mean flow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaterRow {
    /// Gust along the flow over the mean speed: positive where the water is faster.
    pub along: f64,
    /// Gust to the right of someone who looks upstream, over the mean speed.
    pub lateral: f64,
    /// Upward gust over the mean speed.
    pub upward: f64,
    /// Coefficient of the wake's force to the right: the force over `½ rho A_ref V²`, V the speed along the flow with its gust.
    pub wake_right: f64,
    /// Coefficient of the wake's force upwards.
    pub wake_up: f64,
}

impl WaterRow {
    /// In the order of the fields.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f64; 5] {
        [self.along, self.lateral, self.upward, self.wake_right, self.wake_up]
    }
}

/// Disturbances of the water at equal times from the start of a test on, linear in between.
///
/// Everything that flies through a table meets the same water, whatever integrates it.
#[derive(Clone, Debug, PartialEq)]
pub struct WaterTable {
    sample_time_s: f64,
    rows: Vec<WaterRow>,
}

/// Streams of the generator, one for each thing that is drawn: none changes when another is switched off.
const ALONG: u64 = 0;
const LATERAL: u64 = 1;
const UPWARD: u64 = 2;
const PHASE: u64 = 3;

impl MovingWater {
    /// # Errors
    /// [`Error::Argument`], see [`Turbulence::validate`] and [`Shedding::validate`].
    pub fn validate(&self) -> Result<(), Error> {
        self.turbulence.as_ref().map_or(Ok(()), Turbulence::validate)?;
        self.shedding.as_ref().map_or(Ok(()), Shedding::validate)
    }

    /// Whether nothing moves: every intensity and the coefficient of the shedding are zero or absent.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.turbulence.as_ref().is_none_or(Turbulence::is_still)
            && self.shedding.as_ref().is_none_or(Shedding::is_still)
    }

    /// The table of this water for a test of `duration_s` in `flow`, at samples `sample_time_s` apart.
    ///
    /// # Errors
    /// [`Error::Argument`] for numbers out of range, or for a sample time that gives no sample.
    pub fn table(&self, flow: &FlowHistory, duration_s: f64, sample_time_s: f64) -> Result<WaterTable, Error> {
        self.validate()?;
        let count = samples(duration_s, sample_time_s)?;
        let ends = speeds(flow, count, sample_time_s);
        let mut rows = vec![WaterRow::default(); count + 1];
        if let Some(turbulence) = self.turbulence.filter(|turbulence| !turbulence.is_still()) {
            self.add_gusts(&turbulence, &ends, sample_time_s, &mut rows);
        }
        if let Some(shedding) = self.shedding.filter(|shedding| !shedding.is_still()) {
            self.add_wake(&shedding, &ends, sample_time_s, &mut rows);
        }
        Ok(WaterTable { sample_time_s, rows })
    }

    fn add_gusts(&self, turbulence: &Turbulence, ends: &[[f64; 2]], sample_time_s: f64, rows: &mut [WaterRow]) {
        // By how many lengths the mean flow moves on between two samples.
        let per_length = 0.5 * sample_time_s / turbulence.length_m;
        let steps: Vec<f64> = ends.iter().map(|[from, to]| per_length * (from + to)).collect();
        let mut add = |intensity: f64, direction, stream, place: fn(&mut WaterRow) -> &mut f64| {
            if intensity > 0.0 {
                for (row, gust) in rows.iter_mut().zip(unit_gusts(direction, self.seed, stream, &steps)) {
                    *place(row) = intensity * gust;
                }
            }
        };
        add(turbulence.intensity, Direction::Along, ALONG, |row| &mut row.along);
        add(turbulence.lateral_intensity, Direction::Across, LATERAL, |row| &mut row.lateral);
        add(turbulence.vertical_intensity, Direction::Across, UPWARD, |row| &mut row.upward);
    }

    fn add_wake(&self, shedding: &Shedding, ends: &[[f64; 2]], sample_time_s: f64, rows: &mut [WaterRow]) {
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        generator.set_stream(PHASE);
        let turn = core::f64::consts::TAU;
        let mut phase = turn * generator.random::<f64>();
        let per_length = turn * shedding.strouhal / shedding.width_m;
        let (up, right) = shedding.plane_rad.sin_cos();
        for k in 0..rows.len() {
            // The plant's own sine: the same bits on every machine.
            let coefficient = shedding.lift_coefficient * Real::sin_cos(phase).0;
            (rows[k].wake_right, rows[k].wake_up) = (coefficient * right, coefficient * up);
            if let Some([from, to]) = ends.get(k) {
                let length = 0.5 * sample_time_s * (from * (1.0 + rows[k].along) + to * (1.0 + rows[k + 1].along));
                phase += per_length * length;
            }
        }
    }
}

/// Samples that begin within a test.
fn samples(duration_s: f64, sample_time_s: f64) -> Result<usize, Error> {
    let count = (duration_s / sample_time_s - 1e-6).ceil();
    if sample_time_s > 0.0 && (1.0..=1e8).contains(&count) {
        return Ok(count as usize);
    }
    Err(Error::Argument {
        name: "sample time of the water in s",
        value: sample_time_s,
        allowed: "more than zero, and from 1 to 1e8 samples in the test",
    })
}

/// Mean speeds just after each sample and just before the next; a knot between two samples counts from the next sample on.
fn speeds(flow: &FlowHistory, count: usize, sample_time_s: f64) -> Vec<[f64; 2]> {
    let (knots, mut piece) = (flow.knots(), 0);
    let of_sample = |k: usize| {
        let from_s = k as f64 * sample_time_s;
        while knots.get(piece + 1).is_some_and(|knot| knot.from_s <= from_s + 1e-6 * sample_time_s) {
            piece += 1;
        }
        [from_s, from_s + sample_time_s].map(|time_s| flow.within(piece, time_s).speed_m_s)
    };
    (0..count).map(of_sample).collect()
}

impl WaterTable {
    /// A table from its rows, the first at the start of the test, `sample_time_s` apart: water that was recorded, or made elsewhere.
    ///
    /// A flight needs a row per sample and one at its end, and a table with the sample time of its controller.
    ///
    /// # Errors
    /// [`Error::Argument`] for a sample time that is not positive, less than two rows or a number that is not finite.
    pub fn new(sample_time_s: f64, rows: Vec<WaterRow>) -> Result<Self, Error> {
        let bad = |name, value, allowed| Err(Error::Argument { name, value, allowed });
        if !(sample_time_s.is_finite() && sample_time_s > 0.0) {
            return bad("sample time of the water in s", sample_time_s, "finite and more than zero");
        }
        if rows.len() < 2 {
            return bad("rows of the water", rows.len() as f64, "at least two");
        }
        if let Some(value) = rows.iter().flat_map(WaterRow::numbers).find(|number| !number.is_finite()) {
            return bad("number in a row of the water", value, "finite");
        }
        Ok(Self { sample_time_s, rows })
    }

    /// The rows, one per sample and one at the end.
    #[must_use]
    pub fn rows(&self) -> &[WaterRow] {
        &self.rows
    }

    /// Time between two rows, in s.
    #[must_use]
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// The numbers of the row of sample `index` and of the next.
    #[inline(always)]
    pub(crate) fn around(&self, index: usize) -> [[f64; 5]; 2] {
        [self.rows[index].numbers(), self.rows[index + 1].numbers()]
    }

    /// Whether a flight of `duration_s` with samples `sample_time_s` apart can fly through it.
    pub(crate) fn check(&self, duration_s: f64, sample_time_s: f64) -> Result<(), Error> {
        if (self.sample_time_s - sample_time_s).abs() > 1e-9 * sample_time_s {
            return Err(Error::Argument {
                name: "sample time of the water in s",
                value: self.sample_time_s,
                allowed: "that of the controller",
            });
        }
        if self.rows.len() < samples(duration_s, sample_time_s)? + 1 {
            return Err(Error::Argument {
                name: "rows of the water",
                value: self.rows.len() as f64,
                allowed: "one per sample of the test and one at its end",
            });
        }
        Ok(())
    }
}
