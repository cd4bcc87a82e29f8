//! The physical parameters of the plant, each with its key, unit and allowed range.
//!
//! The tables [`FIELDS`] and [`OPTIONAL_FIELDS`] are the one list of all numbers, [`Parameters::fields`]: a file reader, a writer
//! and a scale converter walk it.

use crate::allowed::Allowed;
use crate::error::Error;
use crate::layout::TetherLayout;

/// One number of [`Parameters`]: where it stands in a file and how to reach it.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Section, `body` for example.
    pub section: &'static str,
    /// Name inside the section, `mass` for example.
    pub name: &'static str,
    /// Unit of the value in [`Parameters`]; `chord` is a fraction of the chord.
    pub unit: &'static str,
    /// Allowed values.
    pub allowed: Allowed,
    /// Whether a plant may leave it out, and then has it at zero.
    pub optional: bool,
    /// Reads the number.
    pub get: fn(&Parameters) -> f64,
    /// Writes the number.
    pub set: fn(&mut Parameters, f64),
}

macro_rules! parameters {
    ($(
        $(#[$section_doc:meta])*
        $section:ident: $Section:ident {
            $( $(#[$doc:meta])* $field:ident = $name:literal, $unit:literal, $allowed:ident; )*
        }
    )*
    @optional
    $(
        $(#[$optional_doc:meta])*
        $optional:ident: $Optional:ident {
            $( $(#[$key_doc:meta])* $key:ident = $key_name:literal, $key_unit:literal, $key_allowed:ident; )*
        }
    )*) => {
        $(
            $(#[$section_doc])*
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub struct $Section {
                $( $(#[$doc])* pub $field: f64, )*
            }
        )*
        $(
            $(#[$optional_doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq)]
            pub struct $Optional {
                $( $(#[$key_doc])* pub $key: f64, )*
            }
        )*

        /// Every physical parameter of the plant, in SI units and radians; positions along the chord are
        /// fractions of the chord aft of the leading edge, heights are above the bridle joint.
        ///
        /// Values are public: [`Plant::new`](crate::Plant::new) checks them all.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Parameters {
            $( $(#[$section_doc])* pub $section: $Section, )*
            $( $(#[$optional_doc])* pub $optional: $Optional, )*
            /// Arrangement of the three lines.
            pub layout: TetherLayout,
        }

        /// Every number of [`Parameters`] that a plant must have, section by section.
        pub const FIELDS: &[Field] = &[
            $($( Field {
                section: stringify!($section),
                name: $name,
                unit: $unit,
                allowed: Allowed::$allowed,
                optional: false,
                get: |p| p.$section.$field,
                set: |p, value| p.$section.$field = value,
            }, )*)*
        ];

        /// Every number of [`Parameters`] that a plant may leave out, and then has at zero.
        pub const OPTIONAL_FIELDS: &[Field] = &[
            $($( Field {
                section: stringify!($optional),
                name: $key_name,
                unit: $key_unit,
                allowed: Allowed::$key_allowed,
                optional: true,
                get: |p| p.$optional.$key,
                set: |p, value| p.$optional.$key = value,
            }, )*)*
        ];

        impl Parameters {
            /// Every number: [`FIELDS`], and after them [`OPTIONAL_FIELDS`].
            pub fn fields() -> impl Iterator<Item = &'static Field> {
                FIELDS.iter().chain(OPTIONAL_FIELDS)
            }

            /// Builds the parameters by asking `lookup` for every one of [`fields`](Self::fields), in that order. For one that is
            /// [`optional`](Field::optional) and not there it gives 0: a plant without any of them is symmetric.
            ///
            /// # Errors
            /// The first error that `lookup` returns.
            pub fn from_fields<E>(
                layout: TetherLayout,
                mut lookup: impl FnMut(&'static Field) -> Result<f64, E>,
            ) -> Result<Self, E> {
                let mut fields = Self::fields();
                let mut next = || fields.next().map_or(Ok(f64::NAN), &mut lookup);
                Ok(Self {
                    $( $section: $Section { $( $field: next()?, )* }, )*
                    $( $optional: $Optional { $( $key: next()?, )* }, )*
                    layout,
                })
            }
        }
    };
}

parameters! {
    /// The fluid around the body.
    fluid: Fluid {
        /// Density.
        density_kg_m3 = "density", "kg/m^3", Positive;
        /// Gravitational acceleration, downwards.
        gravity_m_s2 = "gravity", "m/s^2", Positive;
    }
    /// Mass, inertia and the points of the hull; ballast keeps them apart from the stabilizers' factors.
    body: Body {
        /// Chord of the hull, the unit of the positions along it.
        chord_m = "chord", "m", Positive;
        /// Mass.
        mass_kg = "mass", "kg", Positive;
        /// Displaced volume.
        volume_m3 = "volume", "m^3", Positive;
        /// Moment of inertia in roll, about the center of mass.
        inertia_xx_kg_m2 = "inertia_xx", "kg*m^2", Positive;
        /// Moment of inertia in pitch, about the center of mass.
        inertia_yy_kg_m2 = "inertia_yy", "kg*m^2", Positive;
        /// Moment of inertia in yaw, about the center of mass.
        inertia_zz_kg_m2 = "inertia_zz", "kg*m^2", Positive;
        /// Product of inertia, the integral of x z dm about the center of mass: positive for mass ahead below and aft
        /// above. The entry of the inertia tensor is minus it.
        inertia_xz_kg_m2 = "inertia_xz", "kg*m^2", Finite;
        /// Bridle joint.
        joint_x = "joint_x", "chord", Finite;
        /// Center of mass, along the chord.
        center_of_mass_x = "center_of_mass_x", "chord", Finite;
        /// Center of mass, above the joint.
        center_of_mass_height_m = "center_of_mass_height", "m", Finite;
        /// Center of buoyancy, along the chord.
        center_of_buoyancy_x = "center_of_buoyancy_x", "chord", Finite;
        /// Center of buoyancy, above the joint.
        center_of_buoyancy_height_m = "center_of_buoyancy_height", "m", Finite;
    }
    /// The annular hull (component F of the build-up).
    hull: Hull {
        /// Reference area.
        area_m2 = "area", "m^2", NonNegative;
        /// Aerodynamic center, along the chord.
        center_x = "center_x", "chord", Finite;
        /// Aerodynamic center, above the joint.
        center_height_m = "center_height", "m", Finite;
        /// `C_D0`.
        drag_zero_lift = "drag_zero_lift", "1", NonNegative;
        /// `K` of `C_D = C_D0 + K (C_L² + C_S²)`.
        drag_due_to_lift = "drag_due_to_lift", "1", NonNegative;
        /// `C_L0`.
        lift_zero = "lift_zero", "1", Finite;
        /// `C_Lα`.
        lift_slope_per_rad = "lift_slope", "1/rad", Finite;
        /// `C_Sβ`; negative where a side slip from starboard pushes to port.
        side_force_slope_per_rad = "side_force_slope", "1/rad", Finite;
        /// `C_lβ`.
        roll_moment_slope_per_rad = "roll_moment_slope", "1/rad", Finite;
        /// `C_m0`; positive lifts the nose.
        pitch_moment_zero = "pitch_moment_zero", "1", Finite;
        /// `C_mα`.
        pitch_moment_slope_per_rad = "pitch_moment_slope", "1/rad", Finite;
        /// `C_nβ`; positive turns the nose into the flow.
        yaw_moment_slope_per_rad = "yaw_moment_slope", "1/rad", Finite;
    }
    /// The horizontal stabilizer (component H): lift and drag, no side force.
    horizontal_stabilizer: HorizontalStabilizer {
        /// Area at factor 1.
        area_m2 = "area", "m^2", NonNegative;
        /// `A^H`, the factor on the area.
        area_factor = "area_factor", "1", NonNegative;
        /// Root on the hull, along the chord.
        root_x = "root_x", "chord", Finite;
        /// Root on the hull, above the joint.
        root_height_m = "root_height", "m", Finite;
        /// Aerodynamic center aft of the root, at factor 1; grows with the square root of the factor.
        offset_x = "offset_x", "chord", Finite;
        /// Aerodynamic center above the root, at factor 1; grows with the square root of the factor.
        offset_height_m = "offset_height", "m", Finite;
        /// Incidence, positive leading edge up.
        incidence_rad = "incidence", "rad", ShortOfHalfTurn;
        /// `C_D0`.
        drag_zero_lift = "drag_zero_lift", "1", NonNegative;
        /// `K` of `C_D = C_D0 + K C_L²`.
        drag_due_to_lift = "drag_due_to_lift", "1", NonNegative;
        /// `C_L0`.
        lift_zero = "lift_zero", "1", Finite;
        /// `C_Lα`.
        lift_slope_per_rad = "lift_slope", "1/rad", Finite;
    }
    /// The vertical stabilizer (component V): side force and drag, no lift.
    vertical_stabilizer: VerticalStabilizer {
        /// Area at factor 1.
        area_m2 = "area", "m^2", NonNegative;
        /// `A^V`, the factor on the area.
        area_factor = "area_factor", "1", NonNegative;
        /// Root on the hull, along the chord.
        root_x = "root_x", "chord", Finite;
        /// Root on the hull, above the joint.
        root_height_m = "root_height", "m", Finite;
        /// Aerodynamic center aft of the root, at factor 1; grows with the square root of the factor.
        offset_x = "offset_x", "chord", Finite;
        /// Aerodynamic center above the root, at factor 1; grows with the square root of the factor.
        offset_height_m = "offset_height", "m", Finite;
        /// `C_D0`.
        drag_zero_lift = "drag_zero_lift", "1", NonNegative;
        /// `K` of `C_D = C_D0 + K C_S²`.
        drag_due_to_side_force = "drag_due_to_side_force", "1", NonNegative;
        /// `C_Sβ`; negative.
        side_force_slope_per_rad = "side_force_slope", "1/rad", Finite;
    }
    /// The three lines, taken together as one straight tether.
    tether: Tether {
        /// Diameter of one line.
        line_diameter_m = "line_diameter", "m", NonNegative;
        /// Mass per length of all lines together.
        linear_density_kg_m = "linear_density", "kg/m", NonNegative;
        /// Drag coefficient of a line across the flow.
        drag_coefficient = "drag_coefficient", "1", NonNegative;
        /// Separation of the attachments along the body, (2).
        separation_longitudinal_m = "separation_longitudinal", "m", Positive;
        /// Separation of the attachments across the body, (1).
        separation_lateral_m = "separation_lateral", "m", Positive;
    }
    /// The winches.
    winch: Winch {
        /// Time constant of the reel speed.
        time_constant_s = "time_constant", "s", Positive;
        /// Largest reel speed.
        speed_limit_m_s = "speed_limit", "m/s", Positive;
    }
    /// Stall angles, (58) and (59); used by the stalled fidelity.
    stall: Stall {
        /// Of the hull.
        hull_rad = "hull", "rad", AcuteAngle;
        /// Of the horizontal stabilizer.
        horizontal_stabilizer_rad = "horizontal_stabilizer", "rad", AcuteAngle;
    }
    /// Added mass at the center of buoyancy, along the body axes; used by the fidelity that asks for it.
    added_mass: AddedMass {
        /// Along x.
        x_kg = "x", "kg", NonNegative;
        /// Along y.
        y_kg = "y", "kg", NonNegative;
        /// Along z.
        z_kg = "z", "kg", NonNegative;
        /// Added inertia in roll.
        inertia_x_kg_m2 = "inertia_x", "kg*m^2", NonNegative;
        /// Added inertia in pitch.
        inertia_y_kg_m2 = "inertia_y", "kg*m^2", NonNegative;
        /// Added inertia in yaw.
        inertia_z_kg_m2 = "inertia_z", "kg*m^2", NonNegative;
    }
    @optional
    /// What sets the starboard side of body and lines apart from the port side; all zero for a symmetric plant.
    ///
    /// With `offset_lateral` or a difference of the stabilizers the horizontal stabilizer is two halves of half its area, each
    /// in its own local flow.
    asymmetry: Asymmetry {
        /// Center of mass to starboard of the plane of symmetry.
        center_of_mass_y_m = "center_of_mass_y", "m", Finite;
        /// Product of inertia, the integral of x y dm about the center of mass.
        inertia_xy_kg_m2 = "inertia_xy", "kg*m^2", Finite;
        /// Product of inertia, the integral of y z dm about the center of mass.
        inertia_yz_kg_m2 = "inertia_yz", "kg*m^2", Finite;
        /// Aerodynamic centers of the halves of the horizontal stabilizer to either side of the plane of symmetry, at factor 1;
        /// grows with the square root of the factor.
        offset_lateral_m = "offset_lateral", "m", NonNegative;
        /// Incidence of the starboard half less that of the port half. The mean is `incidence`.
        incidence_difference_rad = "incidence_difference", "rad", ShortOfHalfTurn;
        /// `C_Lα` of the starboard half less that of the port half. The mean is `lift_slope`.
        lift_slope_difference_per_rad = "lift_slope_difference", "1/rad", Finite;
        /// How much longer the center line is than its winch says.
        line_center_m = "line_center", "m", Finite;
        /// How much longer the starboard line is than its winch says.
        line_starboard_m = "line_starboard", "m", Finite;
        /// How much longer the port line is than its winch says.
        line_port_m = "line_port", "m", Finite;
    }
}

impl Parameters {
    /// Checks every number against its allowed range, and that the inertia is one a body can have.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first number that is out of range.
    pub fn validate(&self) -> Result<(), Error> {
        for field in Self::fields() {
            let value = (field.get)(self);
            if !field.allowed.admits(value) {
                return Err(field.error(value, field.allowed.words()));
            }
        }
        self.check_inertia()?;
        self.check_products()
    }

    /// The moments of inertia and the product in the plane of symmetry.
    fn check_inertia(&self) -> Result<(), Error> {
        let [xx, yy, zz] = [self.body.inertia_xx_kg_m2, self.body.inertia_yy_kg_m2, self.body.inertia_zz_kg_m2];
        let impossible = |name, value| Error::Parameter {
            section: "body",
            name,
            value,
            unit: "kg*m^2",
            expected: "at most the sum of the other two moments of inertia",
        };
        if xx > yy + zz {
            return Err(impossible("inertia_xx", xx));
        }
        if yy > zz + xx {
            return Err(impossible("inertia_yy", yy));
        }
        if zz > xx + yy {
            return Err(impossible("inertia_zz", zz));
        }
        // The product is at most the geometric mean of the second moments of mass along x and z, and less than that of
        // the moments of inertia about them.
        let xz = self.body.inertia_xz_kg_m2;
        if 4.0 * xz * xz > (yy + zz - xx) * (xx + yy - zz) || xz * xz >= xx * zz {
            return Err(Error::Parameter {
                section: "body",
                name: "inertia_xz",
                value: xz,
                unit: "kg*m^2",
                expected: "at most sqrt((I_yy + I_zz - I_xx) (I_xx + I_yy - I_zz))/2 in magnitude",
            });
        }
        Ok(())
    }

    /// The products out of the plane of symmetry: the second moments of mass, twice over, form a matrix without a negative
    /// principal minor.
    fn check_products(&self) -> Result<(), Error> {
        let [xx, yy, zz] = [self.body.inertia_xx_kg_m2, self.body.inertia_yy_kg_m2, self.body.inertia_zz_kg_m2];
        let (xy, yz) = (self.asymmetry.inertia_xy_kg_m2, self.asymmetry.inertia_yz_kg_m2);
        let refused = |name, value, expected| {
            Err(Error::Parameter { section: "asymmetry", name, value, unit: "kg*m^2", expected })
        };
        let (x, y, z) = (yy + zz - xx, xx + zz - yy, xx + yy - zz);
        if 4.0 * xy * xy > x * y {
            let expected = "at most sqrt((I_yy + I_zz - I_xx) (I_xx + I_zz - I_yy))/2 in magnitude";
            return refused("inertia_xy", xy, expected);
        }
        if 4.0 * yz * yz > y * z {
            let expected = "at most sqrt((I_xx + I_zz - I_yy) (I_xx + I_yy - I_zz))/2 in magnitude";
            return refused("inertia_yz", yz, expected);
        }
        let (xy, yz, xz) = (2.0 * xy, 2.0 * yz, 2.0 * self.body.inertia_xz_kg_m2);
        let determinant = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz);
        // With both products zero this repeats what was checked above, and rounding must not refuse it.
        if (xy.abs() > 0.0 || yz.abs() > 0.0) && determinant < 0.0 {
            let (name, value) = if xy.abs() > 0.0 { ("inertia_xy", xy / 2.0) } else { ("inertia_yz", yz / 2.0) };
            return refused(name, value, "smaller in magnitude beside the other products: no mass has this inertia");
        }
        Ok(())
    }
}

impl Field {
    /// The error that says that `value` is not `expected` here.
    #[must_use]
    pub fn error(&self, value: f64, expected: &'static str) -> Error {
        Error::Parameter { section: self.section, name: self.name, value, unit: self.unit, expected }
    }

    /// The field `section.name`, optional or not, if there is one.
    #[must_use]
    pub fn find(section: &str, name: &str) -> Option<&'static Self> {
        Parameters::fields().find(|field| field.section == section && field.name == name)
    }
}
