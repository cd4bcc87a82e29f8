//! The costs (20), (21) and (60) from integrals that do not depend on their weights.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::energy::Energy;
use crate::error::{Error, FileError};
use crate::file;
use crate::quantity::{
    PerAngle, PerAngleSquared, PerBallastSquared, PerLengthSquared, PerPower, PerSpeedSquared, Record,
};

/// Number of terms inside the square of (21).
pub const N_TERMS: usize = 6;

/// Names of the terms of (21), the last one outside the square.
pub const TERM_NAMES: [&str; N_TERMS + 1] = ["heading", "pitch", "roll", "altitude", "reel speed", "zenith", "ballast"];

/// What a flight leaves for any cost: the integrals over time of all products of the six terms
/// `[(psi − psi_flow)², theta_e², phi_e², z_e², uᵀu, Phi]` of (21), in SI units and radians, and those of (20).
///
/// One flight serves every set of weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Integrals {
    /// `gram[i][j] = ∫ f_i f_j dt`, symmetric.
    pub gram: [[f64; N_TERMS]; N_TERMS],
    /// `∫ (psi − psi_flow)² dt` in rad² s.
    pub heading_squared: f64,
    /// `∫ y² dt` in m² s, y the lateral position of the center of mass in the ground frame.
    pub lateral_squared: f64,
    /// T_f − T_i in s.
    pub duration_s: f64,
}

/// Weights of (21): with k7 = 0, of (60).
///
/// Angles in rad, lengths in m, speeds in m/s, ballast in per cent of chord: J is then in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostWeights {
    /// k1 to k6, in the order of [`TERM_NAMES`].
    pub terms: [f64; N_TERMS],
    /// k7, per (per cent of chord)².
    pub ballast: f64,
}

/// A cost with the share of each term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CostBreakdown {
    /// J in s.
    pub total: f64,
    /// What each term contributes to J, in s, in the order of [`TERM_NAMES`]: `∫ k_i f_i Σ_j k_j f_j dt` for the
    /// terms inside the square, and the ballast term. They sum to the total.
    pub terms: [f64; N_TERMS + 1],
}

impl CostWeights {
    /// The cost `∫ (k1 (psi − psi_flow)² + … + k6 Phi)² dt + k7 (x_cm − x_cb)² (T_f − T_i)`, term by term.
    ///
    /// `ballast_pct_chord` is x_cm − x_cb in per cent of chord.
    ///
    /// Source: (21), (60).
    /// Differs from the source: the bracket of (21) closes behind the square there; this is the form of (60).
    #[must_use]
    pub fn cost(&self, integrals: &Integrals, ballast_pct_chord: f64) -> CostBreakdown {
        let mut terms = [0.0; N_TERMS + 1];
        for (term, (weight, row)) in terms.iter_mut().zip(self.terms.iter().zip(&integrals.gram)) {
            let sum: f64 = self.terms.iter().zip(row).map(|(k, entry)| k * entry).sum();
            *term = weight * sum;
        }
        terms[N_TERMS] = self.ballast * ballast_pct_chord * ballast_pct_chord * integrals.duration_s;
        CostBreakdown { total: terms.iter().sum(), terms }
    }
}

/// The open-loop cost `∫ (K1 psi² + K2 y²) dt` as its two terms.
///
/// `heading` is K1 per rad², `lateral` K2 per m²; psi is taken relative to the flow.
///
/// Source: (20).
#[must_use]
pub fn open_loop_cost(integrals: &Integrals, heading: f64, lateral: f64) -> [f64; 2] {
    [heading * integrals.heading_squared, lateral * integrals.lateral_squared]
}

/// Weights with the title and the provenance of every number of their file.
///
/// # The file
/// `title` and `k1_heading`, `k2_pitch`, `k3_roll` 1/rad^2, `k4_altitude` 1/m^2, `k5_reel_speed` s^2/m^2, `k6_zenith` 1/rad,
/// `k7_ballast` 1/(% chord)^2, all zero or more; and `k8_net_energy` 1/W, zero or more, and zero where it is left out. Numbers and units are those of [`RigFile`](crate::RigFile).
#[derive(Clone, Debug, PartialEq)]
pub struct CostFile {
    /// The title of the file.
    pub title: String,
    /// The weights.
    pub weights: CostWeights,
    /// The weight of the net energy, in 1/W: ours, zero unless the file has it.
    pub net_energy_per_w: f64,
    /// Every number as written, sorted by key.
    pub records: Vec<Record>,
}

impl CostFile {
    /// Reads weights from a TOML file.
    ///
    /// # Errors
    /// [`FileError`], with the file, the key, what was found and what is allowed. Unknown keys are errors.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        file::read(path.as_ref(), Self::parse)
    }

    /// Reads weights from the text of a TOML file; see [`CostFile::read`].
    ///
    /// # Errors
    /// [`FileError`], without the name of a file.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let (table, records) = file::parse::<CostTable>(text)?;
        let weights = CostWeights {
            terms: [
                table.k1_heading.0,
                table.k2_pitch.0,
                table.k3_roll.0,
                table.k4_altitude.0,
                table.k5_reel_speed.0,
                table.k6_zenith.0,
            ],
            ballast: table.k7_ballast.0,
        };
        Ok(Self { title: table.title, weights, net_energy_per_w: table.k8_net_energy.0, records })
    }
}

impl CostFile {
    /// J in s less the weight times the net energy: `J − k8 (E_turbine − E_winches)`. With k8 = 0, the bits of J.
    ///
    /// # Errors
    /// [`Error::Argument`] where net energy has a weight and the flight, for want of a turbine in its test, has no energy.
    pub fn total(&self, cost: &CostBreakdown, energy: Option<&Energy>) -> Result<f64, Error> {
        let weight = self.net_energy_per_w;
        match energy {
            _ if weight <= 0.0 => Ok(cost.total),
            Some(energy) => Ok(cost.total + energy.cost_s(weight)),
            None => Err(Error::Argument {
                name: "weight of the net energy per W",
                value: weight,
                expected: "zero where the test has no turbine",
            }),
        }
    }
}

/// Weights as they stand in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct CostTable {
    title: String,
    k1_heading: PerAngleSquared,
    k2_pitch: PerAngleSquared,
    k3_roll: PerAngleSquared,
    k4_altitude: PerLengthSquared,
    k5_reel_speed: PerSpeedSquared,
    k6_zenith: PerAngle,
    k7_ballast: PerBallastSquared,
    #[serde(default)]
    k8_net_energy: PerPower,
}
