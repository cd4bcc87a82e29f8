//! The test profile: where a flight starts, flow over time, and windows in which the winches are driven by hand:
//! (22)–(26).

use std::path::Path;

use bat_dynamics::{Flow, FlowHistory, FlowKnot, Transition};
use serde::{Deserialize, Serialize};

use crate::error::{Error, FileError};
use crate::quantity::{Range, Reader, Record, read_file};

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
#[derive(Clone, Debug, PartialEq)]
pub struct TestProfile {
    duration_s: f64,
    flow: FlowHistory,
    windows: Vec<Window>,
    control: Control,
    start: Departure,
}

/// A test profile with the title and the provenance of every number of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileFile {
    /// The title of the file.
    pub title: String,
    /// The profile.
    pub profile: TestProfile,
    /// Every number as written.
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
        let bad = |name, value, allowed| Err(Error::Argument { name, value, allowed });
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
        Ok(Self { duration_s, flow, windows, control: Control::ClosedLoop, start: Departure::default() })
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
            Some((name, value)) => Err(Error::Argument { name, value, allowed: "short of a half turn to either side" }),
            None => Ok(Self { start, ..self }),
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
        read_file(path.as_ref(), Self::parse)
    }

    /// Reads a profile from the text of a TOML file; see [`ProfileFile::read`].
    ///
    /// # Errors
    /// [`FileError`], without the name of a file.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let ((title, profile), records) = Reader::parse(text, |top| {
            let title = top.text("title")?;
            let duration_s = top.quantity("duration", "s", Range::Positive)?;
            let control = top.choice("control", "closed-loop or open-loop", Some(Control::ClosedLoop))?;
            let start = top.optional_section("start", |start| {
                let angle = |name| start.quantity_or(name, "rad", Range::WithinHalfTurn, 0.0);
                Ok(Departure {
                    zenith_rad: angle("zenith")?,
                    azimuth_rad: angle("azimuth")?,
                    twist_rad: angle("twist")?,
                })
            })?;
            let start = start.unwrap_or_default();
            let mut before_s = None;
            let knots = top.list("flow", |knot| {
                let from_s = knot.quantity("from", "s", Range::NonNegative)?;
                match before_s.replace(from_s) {
                    None if from_s > 0.0 => return Err(knot.refuse("from", from_s, "s", "0 in the first entry")),
                    Some(before_s) if from_s <= before_s => {
                        return Err(knot.refuse("from", from_s, "s", "later than in the entry before"));
                    }
                    _ if from_s > duration_s => return Err(knot.refuse("from", from_s, "s", "within `duration`")),
                    _ => {}
                }
                Ok(FlowKnot {
                    from_s,
                    flow: Flow {
                        speed_m_s: knot.quantity("speed", "m/s", Range::NonNegative)?,
                        direction_rad: knot.quantity("direction", "rad", Range::Finite)?,
                    },
                    transition: knot.choice("transition", "step or linear", Some(Transition::Step))?,
                })
            })?;
            if knots.is_empty() {
                return Err(top.missing("flow", "at least one table [[flow]] with `from`, `speed` and `direction`"));
            }
            let windows = top.list("window", |window| {
                let from_s = window.quantity("from", "s", Range::NonNegative)?;
                if from_s > duration_s {
                    return Err(window.refuse("from", from_s, "s", "within `duration`"));
                }
                let to_s = window.quantity("to", "s", Range::NonNegative)?;
                if to_s < from_s {
                    return Err(window.refuse("to", to_s, "s", "not before `from`"));
                }
                let command = |line| window.quantity_or(line, "u_max", Range::UnitInterval, 0.0);
                let commands = [command("center")?, command("starboard")?, command("port")?];
                Ok(Window { from_s, to_s, commands })
            })?;
            let profile = FlowHistory::new(knots)
                .map_err(Error::Plant)
                .and_then(|flow| TestProfile::new(duration_s, flow, windows)?.with_control(control).with_start(start))
                .map_err(FileError::Inconsistent)?;
            Ok((title, profile))
        })?;
        Ok(Self { title, profile, records })
    }
}
