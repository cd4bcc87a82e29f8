//! A number that calibration may choose: where it stands, and its range.

use anyhow::{Context as _, Result, bail, ensure};
use bat_dynamics::{FIELDS, Field};
use serde::Deserialize;
use tether_control::FilteredPd;

use super::candidate::{Candidate, STUDIES};

/// Names of the weights of (21), as in files of weights.
const WEIGHTS: [&str; 7] =
    ["k1_heading", "k2_pitch", "k3_roll", "k4_altitude", "k5_reel_speed", "k6_zenith", "k7_ballast"];
const WEIGHT_UNITS: [&str; 7] = ["1/rad^2", "1/rad^2", "1/rad^2", "1/m^2", "s^2/m^2", "1/rad", "1/(% chord)^2"];

/// A `[[free]]` entry.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FreeEntry {
    key: String,
    unit: String,
    lower: f64,
    upper: f64,
    start: Option<f64>,
    scale: Scale,
    reason: String,
    #[serde(default)]
    also: Vec<String>,
}

/// How a range is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Scale {
    Linear,
    Log,
}

#[derive(Debug, Clone, Copy)]
enum Pd {
    Altitude,
    Pitch,
    Roll,
}

#[derive(Debug, Clone, Copy)]
enum Gain {
    Proportional,
    Derivative,
    TimeConstant,
}

/// Where a number stands.
#[derive(Debug, Clone, Copy)]
enum Place {
    Plant(&'static Field),
    Controller(Pd, Gain),
    /// Of a study; the seventh stands outside the square.
    Weight(usize, usize),
}

/// A number within its range.
#[derive(Debug, Clone)]
pub(crate) struct Free {
    pub(crate) key: String,
    pub(crate) unit: String,
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// Of the plant where starts begin, if the file says so.
    pub(crate) start: Option<f64>,
    pub(crate) reason: String,
    /// Those that take the same value.
    also: Vec<String>,
    scale: Scale,
    places: Vec<Place>,
}

impl FreeEntry {
    pub(crate) fn check(self) -> Result<Free> {
        let Self { key, unit, lower, upper, start, scale, reason, also } = self;
        let range = || format!("`{key}` goes from {lower} to {upper}");
        ensure!(lower.is_finite() && upper.is_finite() && lower < upper, "{}: lower must be below upper", range());
        ensure!(scale == Scale::Linear || lower > 0.0, "{}: on a log scale both must be positive", range());
        let outside = start.filter(|value| !(lower..=upper).contains(value));
        if let Some(start) = outside {
            bail!("`{key}` has start = {start}: it must be within its range, {lower} to {upper}");
        }
        ensure!(!reason.trim().is_empty(), "`{key}` has no reason: every range must have one");
        let keys = std::iter::once(&key).chain(&also);
        let places = keys.map(|key| Place::of(key, &unit, [lower, upper])).collect::<Result<_>>()?;
        Ok(Free { key, unit, lower, upper, start, reason, also, scale, places })
    }
}

impl Place {
    /// The place of a key, its unit checked, and the range where the place has one.
    fn of(key: &str, unit: &str, range: [f64; 2]) -> Result<Self> {
        let (place, expected) = Self::named(key)?;
        ensure!(unit == expected, "`{key}` has the unit `{unit}`: it must be `{expected}`");
        if let Self::Plant(field) = place {
            let outside = range.into_iter().find(|value| !field.allowed.admits(*value));
            if let Some(value) = outside {
                bail!("`{key}` may become {value}: it must be {}", field.allowed.words());
            }
        }
        Ok(place)
    }

    /// The place of a key, and the unit there.
    fn named(key: &str) -> Result<(Self, &'static str)> {
        let parts: Vec<&str> = key.split('.').collect();
        let found = match parts[..] {
            ["plant", section, name] => FIELDS
                .iter()
                .find(|field| field.section == section && field.name == name)
                .map(|field| (Self::Plant(field), field.unit)),
            ["controller", pd, gain] => Self::gain(pd, gain),
            [study, weight] => STUDIES
                .iter()
                .position(|known| *known == study)
                .zip(WEIGHTS.iter().position(|known| *known == weight))
                .map(|(study, weight)| (Self::Weight(study, weight), WEIGHT_UNITS[weight])),
            _ => None,
        };
        found.with_context(|| {
            format!("no number `{key}`: it must be plant.SECTION.NAME or controller.LOOP.GAIN of a rig file, or STUDY.WEIGHT")
        })
    }

    fn gain(pd: &str, gain: &str) -> Option<(Self, &'static str)> {
        let pd = match pd {
            "altitude" => Pd::Altitude,
            "pitch" => Pd::Pitch,
            "roll" => Pd::Roll,
            _ => return None,
        };
        let gain = match gain {
            "proportional" => Gain::Proportional,
            "derivative" => Gain::Derivative,
            "time_constant" => Gain::TimeConstant,
            _ => return None,
        };
        let unit = match (gain, pd) {
            (Gain::Proportional, Pd::Altitude) => "1/s",
            (Gain::Proportional, _) => "m/(s*rad)",
            (Gain::Derivative, Pd::Altitude) => "1",
            (Gain::Derivative, _) => "m/rad",
            (Gain::TimeConstant, _) => "s",
        };
        Some((Self::Controller(pd, gain), unit))
    }

    fn get(self, candidate: &Candidate) -> f64 {
        match self {
            Self::Plant(field) => (field.get)(&candidate.rig.plant),
            Self::Controller(pd, gain) => {
                let pd = match pd {
                    Pd::Altitude => &candidate.rig.altitude,
                    Pd::Pitch => &candidate.rig.pitch,
                    Pd::Roll => &candidate.rig.roll,
                };
                [pd.proportional(), pd.derivative(), pd.time_constant_s()][gain as usize]
            }
            Self::Weight(study, weight) => {
                let weights = &candidate.weights[study];
                weights.terms.get(weight).copied().unwrap_or(weights.ballast)
            }
        }
    }

    fn set(self, candidate: &mut Candidate, value: f64) -> Result<()> {
        match self {
            Self::Plant(field) => (field.set)(&mut candidate.rig.plant, value),
            Self::Controller(pd, gain) => {
                let rig = &mut candidate.rig;
                let pd = match pd {
                    Pd::Altitude => &mut rig.altitude,
                    Pd::Pitch => &mut rig.pitch,
                    Pd::Roll => &mut rig.roll,
                };
                let mut gains = [pd.proportional(), pd.derivative(), pd.time_constant_s()];
                gains[gain as usize] = value;
                *pd = FilteredPd::new(gains[0], gains[1], gains[2])?;
            }
            Self::Weight(study, weight) => {
                let weights = &mut candidate.weights[study];
                match weights.terms.get_mut(weight) {
                    Some(term) => *term = value,
                    None => weights.ballast = value,
                }
            }
        }
        Ok(())
    }
}

impl Free {
    /// The value at a share of the range, from 0 to 1.
    pub(super) fn at(&self, share: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.lower + share * (self.upper - self.lower),
            Scale::Log => self.lower * (self.upper / self.lower).powf(share),
        }
    }

    /// The share of the range at which a value stands.
    pub(super) fn share(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.lower) / (self.upper - self.lower),
            Scale::Log => (value / self.lower).ln() / (self.upper / self.lower).ln(),
        }
    }

    /// Its key and those that take the same value.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.key).chain(&self.also).map(String::as_str)
    }

    pub(crate) fn value(&self, candidate: &Candidate) -> f64 {
        self.places.first().map_or(f64::NAN, |place| place.get(candidate))
    }

    pub(crate) fn set(&self, candidate: &mut Candidate, value: f64) -> Result<()> {
        self.places.iter().try_for_each(|place| place.set(candidate, value))
    }

    /// Whether its range is divided evenly.
    #[cfg(feature = "identification")]
    pub(crate) fn is_linear(&self) -> bool {
        self.scale == Scale::Linear
    }

    /// Whether flights do not depend on it.
    pub(crate) fn is_weight(&self) -> bool {
        matches!(self.places[..], [Place::Weight(..)])
    }
}
