//! Water that moves beside its mean flow: turbulence and shedding as a table that is made before the flight.

use bat_dynamics::{FlowHistory, LANES, Lanes, Real};
use multiversion::multiversion;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::course::{Course, Stretch, samples};
use crate::error::Error;
use crate::shedding::Shedding;
use crate::turbulence::{Gust, Turbulence};

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
        Ok(self.table_of(&self.course(flow, duration_s, sample_time_s)?))
    }

    /// What tables of this water share, whatever their seed.
    pub(crate) fn course(&self, flow: &FlowHistory, duration_s: f64, sample_time_s: f64) -> Result<Course, Error> {
        self.validate()?;
        Course::new(flow, duration_s, sample_time_s, self.turbulence.map_or(1.0, |turbulence| turbulence.length_m))
    }

    /// The table of this water along a course that was made for it.
    pub(crate) fn table_of(&self, course: &Course) -> WaterTable {
        let mut rows = vec![WaterRow::default(); course.samples() + 1];
        if let Some(turbulence) = self.turbulence {
            let Turbulence { intensity, lateral_intensity, vertical_intensity, .. } = turbulence;
            self.add_gust::<false>(ALONG, intensity, course, &mut rows, |row| &mut row.along);
            self.add_gust::<true>(LATERAL, lateral_intensity, course, &mut rows, |row| &mut row.lateral);
            self.add_gust::<true>(UPWARD, vertical_intensity, course, &mut rows, |row| &mut row.upward);
        }
        if let Some(shedding) = self.shedding.filter(|shedding| !shedding.is_still()) {
            self.add_phase(&shedding, course, &mut rows);
            swing(&mut rows, &shedding);
        }
        WaterTable { sample_time_s: course.sample_time_s(), rows }
    }

    #[inline(always)]
    fn add_gust<const ACROSS: bool>(
        &self,
        stream: u64,
        intensity: f64,
        course: &Course,
        rows: &mut [WaterRow],
        place: impl Fn(&mut WaterRow) -> &mut f64,
    ) {
        if intensity <= 0.0 {
            return;
        }
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        generator.set_stream(stream);
        let mut gust = Gust::<ACROSS>::new(&mut generator);
        *place(&mut rows[0]) = intensity * gust.now();
        let mut rest = rows[1..].iter_mut();
        for Stretch { samples, passage, .. } in course.stretches() {
            for row in rest.by_ref().take(*samples) {
                gust.pass(*passage, &mut generator);
                *place(row) = intensity * gust.now();
            }
        }
    }

    /// Puts the phase of the shedding where [`swing`] makes a force of it.
    fn add_phase(&self, shedding: &Shedding, course: &Course, rows: &mut [WaterRow]) {
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        generator.set_stream(PHASE);
        let turn = core::f64::consts::TAU;
        let mut phase = turn * generator.random::<f64>();
        let per_length = turn * shedding.strouhal / shedding.width_m;
        let mut along = rows[0].along;
        rows[0].wake_right = phase;
        let mut rest = rows[1..].iter_mut();
        for stretch in course.stretches() {
            let [from, to] = stretch.speeds_m_s;
            for row in rest.by_ref().take(stretch.samples) {
                let length = 0.5 * course.sample_time_s() * (from * (1.0 + along) + to * (1.0 + row.along));
                phase += per_length * length;
                (row.wake_right, along) = (phase, row.along);
            }
        }
    }
}

/// From the phase of each row to the force of the wake, four rows side by side.
#[multiversion(targets("x86_64+avx+avx2"))]
fn swing(rows: &mut [WaterRow], shedding: &Shedding) {
    let (up, right) = shedding.plane_rad.sin_cos();
    for four in rows.chunks_mut(LANES) {
        let phase = |k: usize| four[if k < four.len() { k } else { 0 }].wake_right;
        // The plant's own sine: the same bits on every machine.
        let (sines, _) = Lanes([phase(0), phase(1), phase(2), phase(3)]).sin_cos();
        for (row, sine) in four.iter_mut().zip(sines.0) {
            let coefficient = shedding.lift_coefficient * sine;
            (row.wake_right, row.wake_up) = (coefficient * right, coefficient * up);
        }
    }
}

impl WaterTable {
    /// A table from its rows, the first at the start of the test, `sample_time_s` apart: water that was recorded, or made elsewhere.
    ///
    /// A flight needs a row per sample and one at its end, and a table with the sample time of its controller.
    ///
    /// # Errors
    /// [`Error::Argument`] for a sample time that is not positive, less than two rows or a number that is not finite.
    pub fn new(sample_time_s: f64, rows: Vec<WaterRow>) -> Result<Self, Error> {
        let bad = |name, value, expected| Err(Error::Argument { name, value, expected });
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
                expected: "that of the controller",
            });
        }
        if self.rows.len() < samples(duration_s, sample_time_s)? + 1 {
            return Err(Error::Argument {
                name: "rows of the water",
                value: self.rows.len() as f64,
                expected: "one per sample of the test and one at its end",
            });
        }
        Ok(())
    }
}
