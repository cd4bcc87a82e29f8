//! Net energy of a flight: what a turbine in the hull would give, less what the winches take. Source: Section 3.1, which names the
//! term and gives no curve.

use bat_dynamics::Real;
use serde::{Deserialize, Serialize};

use crate::error::Error;

/// A turbine in the hull, its shaft along the body's x axis, and the winches' efficiency.
///
/// With V the speed of the flow at the turbine, gusts along the mean flow included, and gamma the angle between shaft and mean flow,
///
/// ```text
/// U = V max(cos gamma, 0)        cos gamma = cos theta cos(psi − psi_flow)
/// P = min(½ rho A C_p U³, P_rated), and 0 for U below the cut-in speed
/// ```
///
/// A winch takes `max(−T u, 0)/efficiency`, T the tension of its line and u its speed, positive where it pays out; what a line
/// that pays out could give back is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbine {
    /// A, the swept area, in m²; more than zero.
    pub area_m2: f64,
    /// C_p, zero or more.
    pub power_coefficient: f64,
    /// Speed along the shaft below which there is no power, in m/s; zero or more.
    pub cut_in_m_s: f64,
    /// P_rated, in W; more than zero.
    pub rated_power_w: f64,
    /// Of the winches, more than zero and at most 1.
    pub winch_efficiency: f64,
}

/// Energies of one flight, in J: read at the samples, each power held until the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// From the turbine.
    pub turbine_j: f64,
    /// Into the winches.
    pub winches_j: f64,
}

impl Turbine {
    /// # Errors
    /// [`Error::Argument`] for a number out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let bad = |name, value, expected| Err(Error::Argument { name, value, expected });
        let positive = "finite and more than zero";
        if !(self.area_m2.is_finite() && self.area_m2 > 0.0) {
            return bad("area of the turbine in m^2", self.area_m2, positive);
        }
        if !(self.rated_power_w.is_finite() && self.rated_power_w > 0.0) {
            return bad("rated power of the turbine in W", self.rated_power_w, positive);
        }
        for (name, value) in [
            ("power coefficient of the turbine", self.power_coefficient),
            ("cut-in speed of the turbine in m/s", self.cut_in_m_s),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return bad(name, value, "finite and zero or more");
            }
        }
        if !(self.winch_efficiency > 0.0 && self.winch_efficiency <= 1.0) {
            return bad("efficiency of the winches", self.winch_efficiency, "more than zero and at most 1");
        }
        Ok(())
    }

    /// Power in W at the speed `speed_m_s` of the flow, `cos_misalignment` the cosine between shaft and flow.
    #[must_use]
    pub fn power_w(&self, density_kg_m3: f64, speed_m_s: f64, cos_misalignment: f64) -> f64 {
        let along = speed_m_s * cos_misalignment.max(0.0);
        if along < self.cut_in_m_s {
            return 0.0;
        }
        (0.5 * density_kg_m3 * self.area_m2 * self.power_coefficient * along * along * along).min(self.rated_power_w)
    }

    /// Power in W that the winches take at these tensions and reel speeds.
    #[must_use]
    pub fn winch_power_w(&self, tensions_n: [f64; 3], reel_m_s: [f64; 3]) -> f64 {
        let taken = tensions_n.iter().zip(reel_m_s).map(|(tension, reel)| (-tension * reel).max(0.0));
        taken.sum::<f64>() / self.winch_efficiency
    }
}

impl Energy {
    /// Turbine less winches, in J.
    #[must_use]
    pub fn net_j(&self) -> f64 {
        self.turbine_j - self.winches_j
    }

    /// What the net energy adds to a cost in s, with a weight in 1/W: less, the more there is.
    #[must_use]
    pub fn cost_s(&self, weight_per_w: f64) -> f64 {
        -(weight_per_w * self.net_j())
    }
}

/// What a meter notes at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    pub(crate) speed_m_s: f64,
    pub(crate) pitch_rad: f64,
    pub(crate) heading_rad: f64,
    pub(crate) tensions_n: [f64; 3],
    pub(crate) reel_m_s: [f64; 3],
    pub(crate) until_next_s: f64,
}

/// A turbine in its fluid, and what it has given so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meter {
    pub(crate) turbine: Turbine,
    pub(crate) density_kg_m3: f64,
    pub(crate) energy: Energy,
}

impl Meter {
    /// Adds what flows until the next sample.
    pub(crate) fn add(&mut self, reading: &Reading) {
        let Self { turbine, density_kg_m3, energy } = self;
        // The plant's own functions: the same bits on every machine.
        let (cos_pitch, cos_heading) = (Real::sin_cos(reading.pitch_rad).1, Real::sin_cos(reading.heading_rad).1);
        let given = turbine.power_w(*density_kg_m3, reading.speed_m_s, cos_pitch * cos_heading);
        energy.turbine_j += given * reading.until_next_s;
        energy.winches_j += turbine.winch_power_w(reading.tensions_n, reading.reel_m_s) * reading.until_next_s;
    }
}
