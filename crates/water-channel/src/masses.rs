//! What moves along with a design of a rig: the ballast that is shifted, and fins that weigh something.

use bat_dynamics::{Ballast, Fin, MassModel, Parameters, PlantDesign};
use serde::Deserialize;

use crate::error::Error;
use crate::quantity::{Chords, Inertia, Mass, Place, Product, Volume};

/// Ballast and fins of a rig, and the center of mass for which its other numbers hold.
///
/// Mass, volume, centers and moments of inertia in [`Rig::plant`](crate::Rig::plant) are then those of the body with its center of
/// mass here and with area factors of 1; the center of mass and the area factors that stand there are the design, and
/// [`Rig::parameters`](crate::Rig::parameters) makes one of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masses {
    /// Ballast and fins.
    pub model: MassModel,
    /// Center of mass of the body as its numbers say, along the chord.
    pub center_of_mass_x: f64,
}

impl Masses {
    /// The parameters of the design that stands in `plant`.
    ///
    /// # Errors
    /// [`Error::Plant`] for masses or a design out of range.
    pub(crate) fn parameters(&self, plant: &Parameters) -> Result<Parameters, Error> {
        let design = PlantDesign {
            center_of_mass_x: plant.body.center_of_mass_x,
            horizontal_area_factor: plant.horizontal_stabilizer.area_factor,
            vertical_area_factor: plant.vertical_stabilizer.area_factor,
        };
        let mut base = *plant;
        base.body.center_of_mass_x = self.center_of_mass_x;
        (base.horizontal_stabilizer.area_factor, base.vertical_stabilizer.area_factor) = (1.0, 1.0);
        Ok(self.model.parameters(&base, &design)?)
    }
}

/// The section `[masses]` of a rig file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct MassesTable {
    ballast: Option<BallastTable>,
    horizontal_stabilizer: Option<FinTable>,
    vertical_stabilizer: Option<FinTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct BallastTable {
    mass: Mass,
    x: Chords,
    #[serde(default)]
    y: Place,
    height: Place,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct FinTable {
    mass: Mass,
    volume: Volume,
    offset_x: Chords,
    offset_height: Place,
    #[serde(default)]
    offset_lateral: Place,
    inertia_xx: Inertia,
    inertia_yy: Inertia,
    inertia_zz: Inertia,
    #[serde(default)]
    inertia_xz: Product,
}

impl MassesTable {
    /// With the center of mass of the file that it stands in.
    pub(crate) fn at(self, center_of_mass_x: f64) -> Masses {
        let ballast = self.ballast.map(|ballast| Ballast {
            mass_kg: ballast.mass.0,
            x: ballast.x.0,
            y_m: ballast.y.0,
            height_m: ballast.height.0,
        });
        let [horizontal, vertical] =
            [self.horizontal_stabilizer, self.vertical_stabilizer].map(|fin| fin.map(Fin::from));
        Masses { model: MassModel { ballast, horizontal, vertical }, center_of_mass_x }
    }
}

impl From<FinTable> for Fin {
    fn from(table: FinTable) -> Self {
        Self {
            mass_kg: table.mass.0,
            volume_m3: table.volume.0,
            offset_x: table.offset_x.0,
            offset_height_m: table.offset_height.0,
            offset_lateral_m: table.offset_lateral.0,
            inertia_kg_m2: [table.inertia_xx.0, table.inertia_yy.0, table.inertia_zz.0],
            inertia_xz_kg_m2: table.inertia_xz.0,
        }
    }
}
