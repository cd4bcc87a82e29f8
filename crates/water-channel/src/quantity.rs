//! Numbers in files: a value with its unit and where it comes from.

use core::fmt;

use serde::de::{Error as Fault, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::units::{converted, understood};

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Provenance {
    /// Printed in the source; the note names the place.
    Given,
    /// Computed from given numbers; the note is the formula.
    Derived,
    /// From geometry, handbooks or habit; the note says how.
    Estimated,
    /// Fitted; the note says to what. It never counts as a reproduction of that.
    Calibrated,
}

/// A number as it stands in a file, with its key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Record {
    /// The key with its sections, `plant.body.mass` for example.
    pub key: String,
    /// The value as written.
    pub value: f64,
    /// The unit as written.
    pub unit: String,
    /// Where it comes from.
    pub provenance: Provenance,
    /// The place, the formula, the reason or what it was fitted to.
    pub source: String,
}

/// A number as it stands in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table { value, unit, provenance, source }")]
pub(crate) struct Written {
    #[serde(deserialize_with = "number")]
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(crate) provenance: Provenance,
    pub(crate) source: String,
}

impl Written {
    /// The number in `unit`, if `admits` finds it in the range that `words` describe.
    pub(crate) fn within<E: Fault>(&self, unit: &str, admits: impl Fn(f64) -> bool, words: &str) -> Result<f64, E> {
        self.within_any(unit, &admits, words)
    }

    /// As one function for all ranges: it was compiled for each of some sixty.
    fn within_any<E: Fault>(&self, unit: &str, admits: &dyn Fn(f64) -> bool, words: &str) -> Result<f64, E> {
        let Some(value) = converted(self.value, &self.unit, unit) else {
            let (found, expected) = (format!("in the unit `{}`", self.unit), format!("in {}", understood(unit)));
            return Err(E::invalid_value(Unexpected::Other(&found), &expected.as_str()));
        };
        if admits(value) {
            return Ok(value);
        }
        Err(E::invalid_value(Unexpected::Other(&format!("{} {}", self.value, self.unit)), &words))
    }
}

fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    struct Number;
    impl Visitor<'_> for Number {
        type Value = f64;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number")
        }
        fn visit_f64<E>(self, value: f64) -> Result<f64, E> {
            Ok(value)
        }
        fn visit_i64<E>(self, value: i64) -> Result<f64, E> {
            Ok(value as f64)
        }
    }
    deserializer.deserialize_f64(Number)
}

/// What fixes a sequence of random numbers: a plain whole number, without a unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seed(pub(crate) u64);

impl<'de> Deserialize<'de> for Seed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Whole;
        impl Visitor<'_> for Whole {
            type Value = Seed;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number, zero or more")
            }
            fn visit_i64<E: Fault>(self, value: i64) -> Result<Seed, E> {
                u64::try_from(value).map(Seed).map_err(|_| E::invalid_value(Unexpected::Signed(value), &self))
            }
        }
        deserializer.deserialize_i64(Whole)
    }
}

/// A range of numbers.
#[derive(Clone, Copy, Debug)]
enum Range {
    Finite,
    NonNegative,
    Positive,
    UnitInterval,
    UpToHalf,
    /// Above 0, at most 1.
    Share,
    /// Short of a quarter turn, in rad.
    WithinQuarterTurn,
    /// Short of a half turn, in rad.
    WithinHalfTurn,
    /// Not more than a double holds exactly.
    Whole,
}

impl Range {
    fn admits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::NonNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::UnitInterval => value.abs() <= 1.0,
                Self::Share => value > 0.0 && value <= 1.0,
                Self::UpToHalf => (0.0..=0.5).contains(&value),
                Self::WithinQuarterTurn => value.abs() < core::f64::consts::FRAC_PI_2,
                Self::WithinHalfTurn => value.abs() < core::f64::consts::PI,
                Self::Whole => (0.0..=9_007_199_254_740_992.0).contains(&value) && value.fract() <= 0.0,
            }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Finite => "finite",
            Self::NonNegative => "finite and zero or more",
            Self::Positive => "finite and more than zero",
            Self::UnitInterval => "within -1 and 1",
            Self::UpToHalf => "from 0 to 0.5",
            Self::Share => "more than zero and at most 1",
            Self::WithinQuarterTurn => "finite and short of a quarter turn to either side",
            Self::WithinHalfTurn => "finite and short of a half turn to either side",
            Self::Whole => "a whole number, zero or more",
        }
    }
}

macro_rules! quantities {
    ($( $name:ident: $unit:literal, $range:ident; )*) => {$(
        #[doc = concat!("A number of a file in ", $unit, ", checked; zero where a file may leave it out.")]
        #[derive(Clone, Copy, Debug, Default)]
        pub(crate) struct $name(pub(crate) f64);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let range = Range::$range;
                let written = Written::deserialize(deserializer)?;
                written.within($unit, |value| range.admits(value), range.words()).map(Self)
            }
        }
    )*};
}

quantities! {
    Period: "s", Positive;
    Instant: "s", NonNegative;
    Altitude: "m", Positive;
    Extent: "m", Positive;
    Area: "m^2", Positive;
    Power: "W", Positive;
    Efficiency: "1", Share;
    PerPower: "1/W", NonNegative;
    Intensity: "1", UpToHalf;
    NotNegative: "1", NonNegative;
    Speed: "m/s", NonNegative;
    Direction: "rad", Finite;
    Departing: "rad", WithinHalfTurn;
    Attitude: "rad", WithinQuarterTurn;
    ReelFraction: "u_max", UnitInterval;
    PerSecond: "1/s", Finite;
    Plain: "1", Finite;
    SpeedPerAngle: "m/(s*rad)", Finite;
    LengthPerAngle: "m/rad", Finite;
    PerAngle: "1/rad", NonNegative;
    PerAngleSquared: "1/rad^2", NonNegative;
    PerLengthSquared: "1/m^2", NonNegative;
    PerSpeedSquared: "s^2/m^2", NonNegative;
    PerBallastSquared: "1/(% chord)^2", NonNegative;
    Place: "m", Finite;
    PixelSize: "px", Positive;
    PixelEdge: "px", NonNegative;
    PixelError: "px", NonNegative;
    Samples: "samples", Whole;
    Chords: "chord", Finite;
    Mass: "kg", Positive;
    Volume: "m^3", NonNegative;
    Inertia: "kg*m^2", NonNegative;
    Product: "kg*m^2", Finite;
}
