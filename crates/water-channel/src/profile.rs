//! The test profile: flow over time, and windows in which the winches are driven by hand: (22)–(26).

use std::path::Path;

use bat_dynamics::{Flow, FlowHistory, FlowKnot, Transition};

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

/// What happens during one experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct TestProfile {
    duration_s: f64,
    flow: FlowHistory,
    windows: Vec<Window>,
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
    /// A profile from its parts. Where two windows share a sample, the earlier entry wins.
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
        Ok(Self { duration_s, flow, windows })
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

    /// The fractions of the speed limit that replace the command at `time_s`, if a window holds.
    #[must_use]
    #[inline]
    pub fn override_at(&self, time_s: f64, sample_time_s: f64) -> Option<[f64; 3]> {
        let slack = SAME_INSTANT * sample_time_s;
        self.windows
            .iter()
            .find(|window| time_s >= window.from_s - slack && time_s <= window.to_s + slack)
            .map(|window| window.commands)
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
                .and_then(|flow| TestProfile::new(duration_s, flow, windows))
                .map_err(FileError::Inconsistent)?;
            Ok((title, profile))
        })?;
        Ok(Self { title, profile, records })
    }
}
