//! The test profile: where a flight starts, flow over time, and windows in which the winches are driven by hand.

use std::path::Path;
use std::sync::Arc;

use bat_dynamics::{Flow, FlowHistory, FlowKnot, Transition};
use serde::{Deserialize, Serialize};

use crate::course::Course;
use crate::energy::Turbine;
use crate::error::{Error, FileError};
use crate::file;
use crate::quantity::{
    Area, Departing, Direction, Efficiency, Extent, Instant, Intensity, NotNegative, Period, Power, Record,
    ReelFraction, Seed, Speed,
};
use crate::shedding::Shedding;
use crate::turbulence::Turbulence;
use crate::water::{MovingWater, WaterTable};

/// A time window in which given reel speeds replace the controller's command.
///
/// It holds at every sample from `from_s` to `to_s`, both included. The winch lag and the speed limit still act,
/// and the controller's filters keep running.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First instant, in s.
    pub from_s: f64,
    /// Last instant, in s.
    pub to_s: f64,
    /// Commands of the lines center, starboard, port, as fractions of the speed limit in [−1, 1].
    pub commands: [f64; 3],
}

/// How far from trim a flight starts, at rest: the free coordinates only, because the lines hold the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Departure {
    /// Added to the zenith angle Phi, in rad.
    pub zenith_rad: f64,
    /// Added to the azimuth Theta, in rad.
    pub azimuth_rad: f64,
    /// Added to the twist Psi, in rad.
    pub twist_rad: f64,
}

/// Who commands the winches outside the windows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// The controller.
    #[default]
    ClosedLoop,
    /// Nobody: the lines keep their lengths.
    OpenLoop,
}

/// What happens during one experiment.
///
/// In the source a line has one command in the windows T_1, another in T_2, and that of the controller otherwise.
///
/// Source: (22), (23), (24), (25), (26).
#[derive(Clone, Debug, PartialEq)]
pub struct TestProfile {
    duration_s: f64,
    flow: FlowHistory,
    windows: Vec<Window>,
    control: Control,
    start: Departure,
    water: Water,
    turbine: Option<Turbine>,
}

/// What the water does beside its mean flow.
#[derive(Clone, Debug, PartialEq)]
enum Water {
    /// Nothing.
    Still,
    /// Seeded turbulence and shedding.
    Seeded(MovingWater),
    /// A table that somebody made.
    Recorded(Arc<WaterTable>),
}

/// A test profile with the title and the provenance of every number of its file.
///
/// # The file
/// | key | unit (range) |
/// |---|---|
/// | `title`, `duration` | text, s (> 0) |
/// | `control` | `closed-loop` (when absent) or `open-loop`: outside the windows all commands are zero |
/// | `[start]`: `zenith`, `azimuth`, `twist` | rad, short of a half turn, zero when absent: departure from trim |
/// | `[[flow]]`, at least one: `from` | s, 0 in the first, then increasing, within the test |
/// | `speed`, `direction` | m/s (≥ 0), rad |
/// | `transition`, if given | `step` (the default) or `linear` to the next entry |
/// | `[[window]]`, any number: `from`, `to` | s, `from` within the test, `to` not before it |
/// | `center`, `starboard`, `port`, zero where absent | u_max, from −1 to 1: fraction of the winch's speed limit, positive pays out |
/// | `[water]`, if given: `seed` | a whole number, zero or more: the same seed is the same water |
/// | `[water.turbulence]`, if given: `length` | m (> 0): the longitudinal integral length scale |
/// | `intensity`, `lateral_intensity`, `vertical_intensity`, zero where absent | 1 (0 to 0.5): standard deviation over mean speed |
/// | `[water.shedding]`, if given: `strouhal`, `lift_coefficient`, `width` | 1 (≥ 0), 1 (≥ 0), m (> 0) |
/// | `plane`, zero where absent | rad: of the force, 0 to the side, a quarter turn up and down |
/// | `[turbine]`, if given: `area`, `rated_power` | m^2, W (> 0): flights then report their [`Energy`](crate::Energy) |
/// | `power_coefficient`, `cut_in`, `winch_efficiency` | 1 (≥ 0), m/s (≥ 0), 1 (> 0, at most 1) |
///
/// A window replaces the commands at every sample from `from` to `to`, both included; winches lag as always, and the filters go on.
/// Where two windows share a sample the earlier entry wins.
///
/// Numbers and units are those of [`RigFile`](crate::RigFile).
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileFile {
    /// The title of the file.
    pub title: String,
    /// The profile.
    pub profile: TestProfile,
    /// Every number as written, sorted by key.
    pub records: Vec<Record>,
}

/// Instants closer than this share of a sample time count as the same.
const SAME_INSTANT: f64 = 1e-6;

impl TestProfile {
    /// A closed-loop profile that starts from trim. Where two windows share a sample, the earlier entry wins.
    ///
    /// # Errors
    /// [`Error::Argument`] for a duration that is not positive, a window that ends before it begins or lies
    /// outside the test, or a command outside [−1, 1].
    pub fn new(duration_s: f64, flow: FlowHistory, windows: Vec<Window>) -> Result<Self, Error> {
        let bad = |name, value, expected| Err(Error::Argument { name, value, expected });
        if !(duration_s.is_finite() && duration_s > 0.0) {
            return bad("duration in s", duration_s, "finite and more than zero");
        }
        for window in &windows {
            if !(window.from_s.is_finite() && (0.0..=duration_s).contains(&window.from_s)) {
                return bad("start of a window in s", window.from_s, "within the test");
            }
            if !(window.to_s.is_finite() && window.to_s >= window.from_s) {
                return bad("end of a window in s", window.to_s, "finite and not before its start");
            }
            if let Some(value) = window.commands.iter().find(|c| !(c.is_finite() && c.abs() <= 1.0)) {
                return bad("command of a window", *value, "a fraction of the speed limit within -1 and 1");
            }
        }
        if let Some(knot) = flow.knots().iter().find(|knot| knot.from_s > duration_s) {
            return bad("time of a flow knot in s", knot.from_s, "within the test");
        }
        Ok(Self {
            duration_s,
            flow,
            windows,
            control: Control::ClosedLoop,
            start: Departure::default(),
            water: Water::Still,
            turbine: None,
        })
    }

    /// The same test with or without the controller.
    #[must_use]
    pub fn with_control(self, control: Control) -> Self {
        Self { control, ..self }
    }

    /// The same test from another start.
    ///
    /// # Errors
    /// [`Error::Argument`] for an angle that is not finite or reaches a half turn.
    pub fn with_start(self, start: Departure) -> Result<Self, Error> {
        let angles = [
            ("start: departure of the zenith angle in rad", start.zenith_rad),
            ("start: departure of the azimuth in rad", start.azimuth_rad),
            ("start: departure of the twist in rad", start.twist_rad),
        ];
        match angles.into_iter().find(|(_, angle)| angle.is_nan() || angle.abs() >= core::f64::consts::PI) {
            Some((name, value)) => {
                Err(Error::Argument { name, value, expected: "short of a half turn to either side" })
            }
            None => Ok(Self { start, ..self }),
        }
    }

    /// The same test in water that moves beside its mean flow; where nothing of it moves, in still water.
    ///
    /// # Errors
    /// [`Error::Argument`] for a number out of range.
    pub fn with_water(self, water: MovingWater) -> Result<Self, Error> {
        water.validate()?;
        Ok(Self { water: if water.is_still() { Water::Still } else { Water::Seeded(water) }, ..self })
    }

    /// The same test in water that was recorded, or made elsewhere; a flight must have the sample time of the table.
    #[must_use]
    pub fn with_water_table(self, table: WaterTable) -> Self {
        Self { water: Water::Recorded(Arc::new(table)), ..self }
    }

    /// The same test with a turbine, whose energy every flight then reports.
    ///
    /// # Errors
    /// [`Error::Argument`] for a number out of range.
    pub fn with_turbine(self, turbine: Turbine) -> Result<Self, Error> {
        turbine.validate()?;
        Ok(Self { turbine: Some(turbine), ..self })
    }

    /// The turbine of the test, if it has one.
    #[must_use]
    pub fn turbine(&self) -> Option<&Turbine> {
        self.turbine.as_ref()
    }

    /// The turbulence and shedding of the test, if it has any that is seeded.
    #[must_use]
    pub fn water(&self) -> Option<&MovingWater> {
        match &self.water {
            Water::Seeded(water) => Some(water),
            Water::Still | Water::Recorded(_) => None,
        }
    }

    /// The table that a flight with this sample time meets, the seed replaced by `seed` where one is given; `None` for water
    /// that moves with its mean flow alone.
    ///
    /// # Errors
    /// [`Error::Argument`] where a recorded table does not fit the sample time or the duration.
    pub fn water_table(&self, sample_time_s: f64, seed: Option<u64>) -> Result<Option<Arc<WaterTable>>, Error> {
        self.water_on(self.course(sample_time_s)?.as_ref(), sample_time_s, seed)
    }

    /// What the tables of all seeds share; none where the water has no seed.
    pub(crate) fn course(&self, sample_time_s: f64) -> Result<Option<Course>, Error> {
        self.water().map(|water| water.course(&self.flow, self.duration_s, sample_time_s)).transpose()
    }

    /// [`TestProfile::water_table`] on the course of the same sample time.
    pub(crate) fn water_on(
        &self,
        course: Option<&Course>,
        sample_time_s: f64,
        seed: Option<u64>,
    ) -> Result<Option<Arc<WaterTable>>, Error> {
        match (&self.water, course) {
            (Water::Seeded(water), Some(course)) => {
                let water = MovingWater { seed: seed.unwrap_or(water.seed), ..*water };
                Ok(Some(Arc::new(water.table_of(course))))
            }
            (Water::Recorded(table), _) => {
                table.check(self.duration_s, sample_time_s)?;
                Ok(Some(Arc::clone(table)))
            }
            (Water::Still | Water::Seeded(_), _) => Ok(None),
        }
    }

    /// Who commands the winches outside the windows.
    #[must_use]
    pub fn control(&self) -> Control {
        self.control
    }

    /// How far from trim a flight starts.
    #[must_use]
    pub fn start(&self) -> Departure {
        self.start
    }

    /// Length of the test in s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// The flow over time.
    #[must_use]
    pub fn flow(&self) -> &FlowHistory {
        &self.flow
    }

    /// The windows.
    #[must_use]
    pub fn windows(&self) -> &[Window] {
        &self.windows
    }

    /// The fractions of the speed limit that replace the command at `time_s`: those of the window that holds, else
    /// zeros in open loop, else `None`.
    #[must_use]
    #[inline]
    pub fn override_at(&self, time_s: f64, sample_time_s: f64) -> Option<[f64; 3]> {
        let slack = SAME_INSTANT * sample_time_s;
        self.windows
            .iter()
            .find(|window| time_s >= window.from_s - slack && time_s <= window.to_s + slack)
            .map(|window| window.commands)
            .or((self.control == Control::OpenLoop).then_some([0.0; 3]))
    }

    /// The first knot of the flow inside (`from_s`, `to_s`), or `to_s`.
    #[inline]
    pub(crate) fn next_cut(&self, from_s: f64, to_s: f64) -> f64 {
        let slack = SAME_INSTANT * (to_s - from_s);
        let inside = |t: &f64| *t > from_s + slack && *t < to_s - slack;
        self.flow.knots().iter().map(|knot| knot.from_s).find(inside).unwrap_or(to_s)
    }

    /// The piece of the flow that holds just after `time_s`.
    #[inline]
    pub(crate) fn piece_after(&self, time_s: f64, sample_time_s: f64) -> usize {
        self.flow.piece(time_s + SAME_INSTANT * sample_time_s)
    }
}

impl ProfileFile {
    /// Reads a profile from a TOML file.
    ///
    /// # Errors
    /// [`FileError`], with the file, the key, what was found and what is allowed. Unknown keys are errors.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        file::read(path.as_ref(), Self::parse)
    }

    /// Reads a profile from the text of a TOML file; see [`ProfileFile::read`].
    ///
    /// # Errors
    /// [`FileError`], without the name of a file.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let (table, records) = file::parse::<ProfileTable>(text)?;
        table.check()?;
        let title = table.title.clone();
        let profile = table.profile().map_err(FileError::Inconsistent)?;
        Ok(Self { title, profile, records })
    }
}

/// A profile as it stands in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct ProfileTable {
    title: String,
    duration: Period,
    #[serde(default)]
    control: Control,
    #[serde(default)]
    start: StartTable,
    #[serde(default)]
    flow: Vec<KnotTable>,
    #[serde(default)]
    window: Vec<WindowTable>,
    water: Option<WaterFile>,
    turbine: Option<TurbineTable>,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
struct StartTable {
    zenith: Departing,
    azimuth: Departing,
    twist: Departing,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct KnotTable {
    from: Instant,
    speed: Speed,
    direction: Direction,
    #[serde(default)]
    transition: Transition,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct WindowTable {
    from: Instant,
    to: Instant,
    #[serde(default)]
    center: ReelFraction,
    #[serde(default)]
    starboard: ReelFraction,
    #[serde(default)]
    port: ReelFraction,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct WaterFile {
    seed: Seed,
    turbulence: Option<TurbulenceTable>,
    shedding: Option<SheddingTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct TurbulenceTable {
    #[serde(default)]
    intensity: Intensity,
    #[serde(default)]
    lateral_intensity: Intensity,
    #[serde(default)]
    vertical_intensity: Intensity,
    length: Extent,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct SheddingTable {
    strouhal: NotNegative,
    width: Extent,
    lift_coefficient: NotNegative,
    #[serde(default)]
    plane: Direction,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct TurbineTable {
    area: Area,
    power_coefficient: NotNegative,
    cut_in: Speed,
    rated_power: Power,
    winch_efficiency: Efficiency,
}

impl TurbineTable {
    fn turbine(&self) -> Turbine {
        Turbine {
            area_m2: self.area.0,
            power_coefficient: self.power_coefficient.0,
            cut_in_m_s: self.cut_in.0,
            rated_power_w: self.rated_power.0,
            winch_efficiency: self.winch_efficiency.0,
        }
    }
}

impl WaterFile {
    fn water(&self) -> MovingWater {
        let turbulence = self.turbulence.as_ref().map(|table| Turbulence {
            intensity: table.intensity.0,
            lateral_intensity: table.lateral_intensity.0,
            vertical_intensity: table.vertical_intensity.0,
            length_m: table.length.0,
        });
        let shedding = self.shedding.as_ref().map(|table| Shedding {
            strouhal: table.strouhal.0,
            width_m: table.width.0,
            lift_coefficient: table.lift_coefficient.0,
            plane_rad: table.plane.0,
        });
        MovingWater { turbulence, shedding, seed: self.seed.0 }
    }
}

impl ProfileTable {
    /// Checks what depends on more than one number, naming the key.
    fn check(&self) -> Result<(), FileError> {
        let refuse = |key: String, time_s: f64, expected: &str| {
            Err(FileError::Value { key, found: format!("{time_s} s"), expected: expected.to_owned() })
        };
        if self.flow.is_empty() {
            let expected = "at least one table [[flow]] with `from`, `speed` and `direction`".to_owned();
            return Err(FileError::MissingKey { key: "flow".to_owned(), expected });
        }
        let mut before_s = None;
        for (index, from_s) in self.flow.iter().map(|knot| knot.from.0).enumerate() {
            let key = format!("flow[{index}].from");
            match before_s.replace(from_s) {
                None if from_s > 0.0 => return refuse(key, from_s, "0 in the first entry"),
                Some(before_s) if from_s <= before_s => return refuse(key, from_s, "later than in the entry before"),
                _ if from_s > self.duration.0 => return refuse(key, from_s, "within `duration`"),
                _ => {}
            }
        }
        for (index, WindowTable { from, to, .. }) in self.window.iter().enumerate() {
            if from.0 > self.duration.0 {
                return refuse(format!("window[{index}].from"), from.0, "within `duration`");
            }
            if to.0 < from.0 {
                return refuse(format!("window[{index}].to"), to.0, "not before `from`");
            }
        }
        Ok(())
    }

    fn profile(&self) -> Result<TestProfile, Error> {
        let knot = |KnotTable { from, speed, direction, transition }: &KnotTable| FlowKnot {
            from_s: from.0,
            flow: Flow { speed_m_s: speed.0, direction_rad: direction.0 },
            transition: *transition,
        };
        let window = |WindowTable { from, to, center, starboard, port }: &WindowTable| Window {
            from_s: from.0,
            to_s: to.0,
            commands: [center.0, starboard.0, port.0],
        };
        let flow = FlowHistory::new(self.flow.iter().map(knot).collect())?;
        let start = Departure {
            zenith_rad: self.start.zenith.0,
            azimuth_rad: self.start.azimuth.0,
            twist_rad: self.start.twist.0,
        };
        let mut profile = TestProfile::new(self.duration.0, flow, self.window.iter().map(window).collect())?
            .with_control(self.control)
            .with_start(start)?;
        if let Some(file) = &self.water {
            profile = profile.with_water(file.water())?;
        }
        if let Some(table) = &self.turbine {
            profile = profile.with_turbine(table.turbine())?;
        }
        Ok(profile)
    }
}
