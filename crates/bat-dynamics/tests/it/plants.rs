//! The plants and the random states of the tests.

use std::sync::LazyLock;

use bat_dynamics::{Parameters, TetherLayout};

/// The parameters of `fixtures/bat/rig.toml`.
pub(crate) fn rig() -> Parameters {
    static RIG: LazyLock<Parameters> = LazyLock::new(read_rig);
    *RIG
}

fn read_rig() -> Parameters {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/bat/rig.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let table: toml::Table = text.parse().unwrap();
    Parameters::from_fields(TetherLayout::OneForwardTwoAft, |field| {
        let Some(entry) = table["plant"].get(field.section).and_then(|section| section.get(field.name)) else {
            assert!(field.optional, "the file has no {}.{}", field.section, field.name);
            return Ok(0.0);
        };
        let value = entry["value"].as_float().unwrap();
        match (entry["unit"].as_str().unwrap(), field.unit) {
            ("% chord", "chord") => Ok::<f64, ()>(value / 100.0),
            ("deg", "rad") => Ok(value.to_radians()),
            (found, expected) => {
                assert_eq!(found, expected, "unit of {}.{}", field.section, field.name);
                Ok(value)
            }
        }
    })
    .unwrap()
}

/// The rig with every number that the file has at zero, one or on an axis moved away from there.
pub(crate) fn everything() -> Parameters {
    let mut p = rig();
    p.body.inertia_xz_kg_m2 = 4.1e-5;
    p.body.center_of_mass_x = 0.53;
    p.hull.pitch_moment_zero = 0.031;
    p.hull.pitch_moment_slope_per_rad = -0.047;
    p.horizontal_stabilizer.lift_zero = 0.11;
    p.horizontal_stabilizer.incidence_rad = 0.032;
    p.horizontal_stabilizer.offset_height_m = 0.012;
    p.horizontal_stabilizer.area_factor = 1.31;
    p.vertical_stabilizer.area_factor = 0.87;
    p.added_mass.z_kg = 0.17;
    p.added_mass.inertia_z_kg_m2 = 7.3e-5;
    p
}

/// Excess buoyancy of [`point_body`] in N: its buoyancy less its weight.
pub(crate) const POINT_LIFT_N: f64 = 1000.0 * 9.81 * 2.4e-4 - 0.18 * 9.81;
/// Mass of [`point_body`] in kg.
pub(crate) const POINT_MASS_KG: f64 = 0.18;

/// A buoyant point at the joint: no extent, no surface, hardly any inertia, lines without mass, width or drag.
pub(crate) fn point_body() -> Parameters {
    Parameters::from_fields(TetherLayout::OneForwardTwoAft, |field| {
        Ok::<f64, ()>(match (field.section, field.name) {
            ("fluid", "density") => 1000.0,
            ("fluid", "gravity") => 9.81,
            ("body", "chord") => 1.0,
            ("body", "mass") => POINT_MASS_KG,
            ("body", "volume") => 2.4e-4,
            ("body", "inertia_xx" | "inertia_yy" | "inertia_zz") => 1e-13,
            ("tether", "separation_longitudinal") => 0.07,
            ("tether", "separation_lateral") => 0.1,
            ("winch", "time_constant") => 0.05,
            ("winch", "speed_limit") => 0.02,
            ("stall", _) => 0.3,
            (_, "area_factor") => 1.0,
            _ => 0.0,
        })
    })
    .unwrap()
}

/// The rig without any surface or width in the flow: nothing that dissipates, nothing that lifts.
pub(crate) fn without_surfaces(mut p: Parameters) -> Parameters {
    p.hull.area_m2 = 0.0;
    p.horizontal_stabilizer.area_m2 = 0.0;
    p.vertical_stabilizer.area_m2 = 0.0;
    p.tether.drag_coefficient = 0.0;
    p
}

/// Uniform random numbers from a seed (splitmix64).
pub(crate) struct Sample(pub(crate) u64);

impl Sample {
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn array<const N: usize>(&mut self, low: f64, high: f64) -> [f64; N] {
        core::array::from_fn(|_| self.within(low, high))
    }

    /// Coordinates anywhere the tether is neither vertical nor near the ground.
    pub(crate) fn coordinates(&mut self) -> [f64; 6] {
        [
            self.within(0.05, 1.4),
            self.within(-3.0, 3.0),
            self.within(-2.0, 2.0),
            self.within(0.2, 1.5),
            self.within(-0.8, 0.8),
            self.within(-0.8, 0.8),
        ]
    }

    /// Rates of [`Sample::coordinates`].
    pub(crate) fn rates(&mut self) -> [f64; 6] {
        let [a, b, c, d, e, f] = self.array(-1.5, 1.5);
        [a, b, c, 0.1 * d, e, f]
    }

    /// A flight state like those of a flight of the rig, somewhat wilder.
    pub(crate) fn state(&mut self) -> [f64; 12] {
        let length = self.within(0.3, 1.0);
        [
            self.within(0.05, 1.0),
            self.within(-1.5, 1.5),
            self.within(-1.0, 1.0),
            self.within(-1.0, 1.0),
            self.within(-1.0, 1.0),
            self.within(-1.0, 1.0),
            length + self.within(-0.03, 0.03),
            length + self.within(-0.03, 0.03),
            length + self.within(-0.03, 0.03),
            self.within(-0.02, 0.02),
            self.within(-0.02, 0.02),
            self.within(-0.02, 0.02),
        ]
    }
}
