//! Designs that move mass: ballast that is shifted, and fins that weigh something, with the inertia that follows.

use crate::error::Error;
use crate::parameters::Parameters;

/// A ballast mass that is part of the body of the base parameters, small enough to be a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ballast {
    /// Its mass, in kg.
    pub mass_kg: f64,
    /// Where it lies in the base parameters, along the chord.
    pub x: f64,
    /// To starboard of the plane of symmetry, in m.
    pub y_m: f64,
    /// Above the joint, in m.
    pub height_m: f64,
}

/// A stabilizer as a plate of constant thickness, in two halves or in the plane of symmetry, part of the body of the base
/// parameters at the factor 1.
///
/// At the factor A on its area, its mass and volume are A times, its lengths from the root `sqrt(A)` times, and its moments of
/// inertia about its own center A² times those at 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fin {
    /// Mass at factor 1, both halves together, in kg.
    pub mass_kg: f64,
    /// Displaced volume at factor 1, both halves together, in m³.
    pub volume_m3: f64,
    /// Center of mass and volume aft of the root of the stabilizer at factor 1, in chords.
    pub offset_x: f64,
    /// Above the root at factor 1, in m.
    pub offset_height_m: f64,
    /// Of each half to its side of the plane of symmetry at factor 1, in m; zero for one fin in the plane.
    pub offset_lateral_m: f64,
    /// Moments of inertia about its own center of mass, both halves together, at factor 1, in kg m².
    pub inertia_kg_m2: [f64; 3],
    /// The integral of x z dm about its own center of mass, both halves together, at factor 1; not zero for a swept fin.
    pub inertia_xz_kg_m2: f64,
}

/// What a study varies of the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantDesign {
    /// Center of mass, along the chord.
    pub center_of_mass_x: f64,
    /// A^H.
    pub horizontal_area_factor: f64,
    /// A^V.
    pub vertical_area_factor: f64,
}

/// How mass, volume and inertia follow a design. Nothing of it by default: a design then moves the center of mass and the areas
/// alone, as if other ballast saw to the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MassModel {
    /// The ballast that is shifted along the chord to put the center of mass where the design wants it.
    pub ballast: Option<Ballast>,
    /// The horizontal stabilizer as a body.
    pub horizontal: Option<Fin>,
    /// The vertical stabilizer as a body.
    pub vertical: Option<Fin>,
}

/// A body that is added, or with a negative mass taken away.
struct Lump {
    mass_kg: f64,
    volume_m3: f64,
    x: f64,
    height_m: f64,
    y_m: f64,
    inertia_kg_m2: [f64; 3],
    inertia_xz_kg_m2: f64,
}

impl MassModel {
    /// The parameters of `design`, made of `base`, whose mass and inertia are those at factors of 1 and with the ballast in its
    /// place.
    ///
    /// The fins come first: they change mass, volume, center of buoyancy and, by the theorem of parallel axes, inertia and center
    /// of mass. Then the ballast moves along the chord until the center of mass has the x of the design. Without ballast that x
    /// is set by itself.
    ///
    /// # Errors
    /// [`Error::Argument`] for a mass model that is not finite or whose masses are not positive; [`Error::Parameter`] where the
    /// result, or the body without its ballast and fins, is not one that can be.
    pub fn parameters(&self, base: &Parameters, design: &PlantDesign) -> Result<Parameters, Error> {
        base.validate()?;
        self.validate()?;
        self.rest(base).validate()?;
        let mut p = *base;
        p.horizontal_stabilizer.area_factor = design.horizontal_area_factor;
        p.vertical_stabilizer.area_factor = design.vertical_area_factor;
        // The factors are roots of lengths below: they must be checked before.
        p.validate()?;
        let (h, v) = (base.horizontal_stabilizer, base.vertical_stabilizer);
        if let Some(fin) = &self.horizontal {
            fin.grow(&mut p, [h.root_x, h.root_height_m], design.horizontal_area_factor);
        }
        if let Some(fin) = &self.vertical {
            fin.grow(&mut p, [v.root_x, v.root_height_m], design.vertical_area_factor);
        }
        if let Some(ballast) = &self.ballast {
            let shift = (design.center_of_mass_x - p.body.center_of_mass_x) * p.body.mass_kg / ballast.mass_kg;
            combine(&mut p, &[ballast.lump(-ballast.mass_kg, 0.0), ballast.lump(ballast.mass_kg, shift)]);
        }
        p.body.center_of_mass_x = design.center_of_mass_x;
        p.validate()?;
        Ok(p)
    }

    /// What is left without ballast and fins, which must be a body too.
    fn rest(&self, base: &Parameters) -> Parameters {
        let mut p = *base;
        let (h, v) = (base.horizontal_stabilizer, base.vertical_stabilizer);
        if let Some(ballast) = &self.ballast {
            combine(&mut p, &[ballast.lump(-ballast.mass_kg, 0.0)]);
        }
        if let Some(fin) = &self.horizontal {
            combine(&mut p, &fin.halves([h.root_x, h.root_height_m], -1.0, 1.0));
        }
        if let Some(fin) = &self.vertical {
            combine(&mut p, &fin.halves([v.root_x, v.root_height_m], -1.0, 1.0));
        }
        p
    }

    fn validate(&self) -> Result<(), Error> {
        let positive = |name, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(Error::Argument { name, value, expected: "finite and more than zero" }),
        };
        let finite = |name, values: &[f64]| match values.iter().find(|value| !value.is_finite()) {
            None => Ok(()),
            Some(&value) => Err(Error::Argument { name, value, expected: "finite" }),
        };
        let not_negative =
            |name, values: &[f64]| match values.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
                None => Ok(()),
                Some(&value) => Err(Error::Argument { name, value, expected: "finite and zero or more" }),
            };
        if let Some(ballast) = &self.ballast {
            positive("mass of the ballast in kg", ballast.mass_kg)?;
            finite("place of the ballast", &[ballast.x, ballast.y_m, ballast.height_m])?;
        }
        for fin in [&self.horizontal, &self.vertical].into_iter().flatten() {
            positive("mass of a fin in kg", fin.mass_kg)?;
            not_negative("volume of a fin in m^3", &[fin.volume_m3])?;
            finite("place of a fin", &[fin.offset_x, fin.offset_height_m, fin.offset_lateral_m])?;
            finite("product of inertia of a fin in kg*m^2", &[fin.inertia_xz_kg_m2])?;
            not_negative("moment of inertia of a fin in kg*m^2", &fin.inertia_kg_m2)?;
        }
        Ok(())
    }
}

impl Ballast {
    /// With `mass_kg`, aft of its place by `shift` chords.
    fn lump(&self, mass_kg: f64, shift: f64) -> Lump {
        let Self { x, y_m, height_m, .. } = *self;
        Lump { mass_kg, volume_m3: 0.0, x: x + shift, height_m, y_m, inertia_kg_m2: [0.0; 3], inertia_xz_kg_m2: 0.0 }
    }
}

impl Fin {
    /// Takes the fin at factor 1 off and puts that at `factor` on.
    fn grow(&self, p: &mut Parameters, root: [f64; 2], factor: f64) {
        let ([a, b], [c, d]) = (self.halves(root, -1.0, 1.0), self.halves(root, 1.0, factor));
        combine(p, &[a, b, c, d]);
    }

    /// Starboard and port half at `factor`, with masses of this `sign`.
    fn halves(&self, root: [f64; 2], sign: f64, factor: f64) -> [Lump; 2] {
        let length = factor.sqrt();
        [1.0, -1.0].map(|side| Lump {
            mass_kg: 0.5 * sign * factor * self.mass_kg,
            volume_m3: 0.5 * sign * factor * self.volume_m3,
            x: root[0] + length * self.offset_x,
            height_m: root[1] + length * self.offset_height_m,
            y_m: side * length * self.offset_lateral_m,
            inertia_kg_m2: self.inertia_kg_m2.map(|inertia| 0.5 * sign * factor * factor * inertia),
            inertia_xz_kg_m2: 0.5 * sign * factor * factor * self.inertia_xz_kg_m2,
        })
    }
}

/// Adds the lumps to the body: masses and first moments sum, second moments move by the theorem of parallel axes.
fn combine(p: &mut Parameters, lumps: &[Lump]) {
    let chord_m = p.body.chord_m;
    let mut volume_m3 = p.body.volume_m3;
    // First moments of volume about the old center of buoyancy.
    let mut buoyancy = [0.0; 2];
    let mut mass_kg = p.body.mass_kg;
    // First and second moments of mass about the old center of mass, along B.
    let (mut first, mut second) = ([0.0; 3], [[0.0; 3]; 3]);
    let (mut own, mut own_xz) = ([0.0; 3], 0.0);
    for lump in lumps {
        let r = [
            -(lump.x - p.body.center_of_mass_x) * chord_m,
            lump.y_m - p.asymmetry.center_of_mass_y_m,
            -(lump.height_m - p.body.center_of_mass_height_m),
        ];
        mass_kg += lump.mass_kg;
        volume_m3 += lump.volume_m3;
        buoyancy[0] += lump.volume_m3 * (lump.x - p.body.center_of_buoyancy_x);
        buoyancy[1] += lump.volume_m3 * (lump.height_m - p.body.center_of_buoyancy_height_m);
        own_xz += lump.inertia_xz_kg_m2;
        for i in 0..3 {
            first[i] += lump.mass_kg * r[i];
            own[i] += lump.inertia_kg_m2[i];
            for k in 0..3 {
                second[i][k] += lump.mass_kg * r[i] * r[k];
            }
        }
    }
    let shift = first.map(|moment| moment / mass_kg);
    let moved = |i: usize, k: usize| second[i][k] - mass_kg * shift[i] * shift[k];
    p.body.mass_kg = mass_kg;
    p.body.center_of_mass_x -= shift[0] / chord_m;
    p.asymmetry.center_of_mass_y_m += shift[1];
    p.body.center_of_mass_height_m -= shift[2];
    p.body.inertia_xx_kg_m2 += own[0] + moved(1, 1) + moved(2, 2);
    p.body.inertia_yy_kg_m2 += own[1] + moved(0, 0) + moved(2, 2);
    p.body.inertia_zz_kg_m2 += own[2] + moved(0, 0) + moved(1, 1);
    p.body.inertia_xz_kg_m2 += own_xz + moved(0, 2);
    p.asymmetry.inertia_xy_kg_m2 += moved(0, 1);
    p.asymmetry.inertia_yz_kg_m2 += moved(1, 2);
    p.body.volume_m3 = volume_m3;
    p.body.center_of_buoyancy_x += buoyancy[0] / volume_m3;
    p.body.center_of_buoyancy_height_m += buoyancy[1] / volume_m3;
}
