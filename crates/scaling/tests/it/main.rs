//! What the crate promises, one module per behavior.

#![expect(clippy::unwrap_used, clippy::missing_assert_message, reason = "the helpers of tests fail like tests")]

mod conversion;
#[cfg(feature = "toml")]
mod document;
mod errors;
mod factor;
mod groups;
mod law;
mod null_spaces;
mod properties;
mod serde;
mod similarity;
mod units;

use num_rational::BigRational;
use scaling::{System, Units};

/// Table 1 of the dissertation: 14 variables of a lifting body on a tether.
const TABLE_1: [(&str, &str); 14] = [
    ("L_t", "m"),
    ("L_c", "m"),
    ("d_t", "m"),
    ("M_a", "kg"),
    ("rho", "kg*m^-3"),
    ("V", "m/s"),
    ("g", "m/s^2"),
    ("Theta_dot", "1/s"),
    ("Theta_ddot", "1/s^2"),
    ("Phi_dot", "1/s"),
    ("Phi_ddot", "1/s^2"),
    ("Psi_dot", "1/s"),
    ("Psi_ddot", "1/s^2"),
    ("lambda", "kg/m"),
];

/// The controller's variables before (19), without the dimensionless `k_d^z`.
const CONTROLLER: [(&str, &str); 10] = [
    ("L_t", "m"),
    ("V", "m/s"),
    ("k_p^z", "1/s"),
    ("k_p^theta", "m/(s*rad)"),
    ("k_p^phi", "m/(s*rad)"),
    ("k_d^theta", "m/rad"),
    ("k_d^phi", "m/rad"),
    ("tau_z", "s"),
    ("tau_theta", "s"),
    ("tau_phi", "s"),
];

fn system(variables: &[(&str, &str)]) -> System {
    System::parse(&Units::si(), variables).unwrap()
}

fn ratio(text: &str) -> BigRational {
    text.parse().unwrap()
}
