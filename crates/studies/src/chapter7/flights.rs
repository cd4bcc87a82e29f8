//! How a design flies in the stand-in.

use anyhow::Result;

use super::file::Case;
use crate::bat::STAND_IN;
use crate::blind::Blind;
use crate::logged::{Logged, Reading};

/// What Figures 24 and 26 to 28 show, with a name and a unit.
pub(crate) struct Quantity {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    /// Whether it is an error, whose square is looked at too.
    pub(crate) is_error: bool,
    /// Whether its mean says something: the error of what is controlled to zero has none worth a word.
    pub(crate) has_mean: bool,
    pub(crate) of: Reading,
}

pub(crate) const HEADING: Quantity =
    Quantity { name: "heading", unit: "deg", is_error: true, has_mean: false, of: |row| row.heading_rad.to_degrees() };
pub(crate) const PITCH: Quantity = Quantity {
    name: "pitch error",
    unit: "deg",
    is_error: true,
    has_mean: false,
    of: |row| row.pitch_error_rad.to_degrees(),
};
pub(crate) const ROLL: Quantity = Quantity {
    name: "roll error",
    unit: "deg",
    is_error: true,
    has_mean: true,
    of: |row| row.roll_error_rad.to_degrees(),
};
pub(crate) const ZENITH: Quantity = Quantity {
    name: "zenith angle",
    unit: "deg",
    is_error: false,
    has_mean: true,
    of: |row| row.zenith_rad().to_degrees(),
};
pub(crate) const ALTITUDE: Quantity = Quantity {
    name: "altitude error",
    unit: "cm",
    is_error: true,
    has_mean: false,
    of: |row| 100.0 * row.altitude_error_m,
};

/// A design flown, sample by sample.
#[derive(Debug)]
pub(crate) struct Flown {
    pub(crate) point: Vec<f64>,
    pub(crate) cost: f64,
    logged: Logged,
}

impl Flown {
    pub(crate) fn fly(case: &Case, point: &[f64]) -> Result<Self> {
        Ok(Self::of(point, case.bat.logged(point, STAND_IN)?))
    }

    pub(crate) fn of(point: &[f64], logged: Logged) -> Self {
        Self { point: point.to_vec(), cost: logged.cost.total, logged }
    }

    pub(crate) fn times(&self) -> Vec<f64> {
        self.logged.times()
    }

    pub(crate) fn values(&self, quantity: &Quantity) -> Vec<f64> {
        self.logged.values(quantity.of)
    }

    pub(crate) fn mean(&self, quantity: &Quantity) -> f64 {
        self.logged.mean(quantity.of)
    }

    pub(crate) fn mean_square(&self, quantity: &Quantity) -> f64 {
        self.logged.mean(|row| (quantity.of)(row).powi(2))
    }

    pub(crate) fn means(&self) -> Means {
        Means {
            cost: self.cost,
            heading2: self.mean_square(&HEADING),
            pitch2: self.mean_square(&PITCH),
            roll2: self.mean_square(&ROLL),
            roll_offset: self.mean(&ROLL).abs(),
            zenith: self.mean(&ZENITH),
            altitude2: self.mean_square(&ALTITUDE),
        }
    }
}

/// Means over the test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Means {
    pub(crate) cost: f64,
    pub(crate) heading2: f64,
    pub(crate) pitch2: f64,
    pub(crate) roll2: f64,
    pub(crate) roll_offset: f64,
    pub(crate) zenith: f64,
    pub(crate) altitude2: f64,
}

/// A mean by name, unit and value.
pub(crate) type NamedMean = (&'static str, &'static str, fn(&Means) -> f64);

pub(crate) const READINGS: [NamedMean; 7] = [
    ("cost", "s", |m| m.cost),
    ("mean square of the heading", "deg²", |m| m.heading2),
    ("mean square of the pitch error", "deg²", |m| m.pitch2),
    ("mean square of the roll error", "deg²", |m| m.roll2),
    ("roll offset, magnitude of the mean", "deg", |m| m.roll_offset),
    ("mean zenith angle", "deg", |m| m.zenith),
    ("mean square of the altitude error", "cm²", |m| m.altitude2),
];

/// The designs before and after infusion, without noise and for every seed.
#[derive(Debug)]
pub(crate) struct BeforeAfter {
    /// The optimum of the numerical model.
    pub(crate) before: Flown,
    /// The last optimum of the loop without noise.
    pub(crate) after: Flown,
    /// The same with noise, seed by seed.
    pub(crate) after_seeds: Vec<Means>,
    /// Designs that nobody chose.
    pub(crate) blind: Blind<(Vec<f64>, Means)>,
}
