//! A checked plant: the constants that the equations of motion use, for one flight or one per lane.

use crate::error::Error;
use crate::lanes::{LANES, Lanes};
use crate::parameters::{Asymmetry, Parameters};
use crate::real::Real;
use crate::vector::Vector;

/// Lift beyond the stall angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lift {
    /// Linear in the angle of attack at every angle: the numerical model.
    Attached,
    /// (58), (59): falls again beyond the stall angle.
    Stalled,
}

/// Fluid that the body carries along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FluidInertia {
    /// Left out: the numerical model.
    Neglected,
    /// Added mass and added inertia at the center of buoyancy.
    Included,
}

/// Which physics a plant has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fidelity {
    /// Lift beyond stall.
    pub lift: Lift,
    /// Added mass.
    pub fluid_inertia: FluidInertia,
}

impl Fidelity {
    /// The numerical model of the dissertation: no stall, no added mass.
    pub const NUMERICAL: Self = Self { lift: Lift::Attached, fluid_inertia: FluidInertia::Neglected };
    /// The numerical model with stall, the truth of Section 6.2.
    pub const STALLED: Self = Self { lift: Lift::Stalled, fluid_inertia: FluidInertia::Neglected };
    /// The numerical model with added mass and without stall.
    pub const ADDED_MASS: Self = Self { lift: Lift::Attached, fluid_inertia: FluidInertia::Included };
    /// Stall and added mass: our stand-in for the water channel.
    pub const STALLED_WITH_ADDED_MASS: Self = Self { lift: Lift::Stalled, fluid_inertia: FluidInertia::Included };
}

/// Number of lines.
pub(crate) const N_LINES: f64 = 3.0;
/// An angle of attack never reaches it, so that there is no stall: that of the flow is within a half turn, and so are the incidence of
/// a stabilizer and the difference of its halves, of which each has half.
const NO_STALL_RAD: f64 = 16.0;

macro_rules! plant {
    ($( $(#[$doc:meta])* $name:ident ),* $(,)?) => {
        /// The constants of one plant, derived from checked [`Parameters`] and a [`Fidelity`].
        ///
        /// `Plant<f64>` is one plant; `Plant<Lanes>` holds several of them side by side.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Plant<T = f64> {
            $( $(#[$doc])* pub(crate) $name: T, )*
            /// Whether any of [`Asymmetry`](crate::Asymmetry) is not zero.
            pub(crate) lopsided: bool,
        }

        impl<T: Real> Plant<T> {
            /// The same plant in another scalar, constants with zero derivative.
            #[must_use]
            pub(crate) fn map<U>(&self, f: impl Fn(T) -> U) -> Plant<U> {
                Plant { $( $name: f(self.$name), )* lopsided: self.lopsided }
            }
        }

        impl Plant<Lanes> {
            /// Plant `i` in lane `i`.
            #[must_use]
            pub fn gather(plants: [&Plant; LANES]) -> Self {
                Plant {
                    $( $name: Lanes(plants.map(|plant| plant.$name)), )*
                    lopsided: plants.iter().any(|plant| plant.lopsided),
                }
            }
        }
    };
}

plant! {
    /// g, m/s².
    gravity,
    /// m, kg.
    mass,
    /// rho Vol, kg.
    displaced_mass,
    /// Center of mass from the joint along x_B, m.
    cm_x,
    /// Center of mass from the joint along z_B, m.
    cm_z,
    /// Center of buoyancy from the joint along x_B, m.
    cb_x,
    /// Center of buoyancy from the joint along z_B, m.
    cb_z,
    /// I_xx + I_ax.
    inertia_x,
    /// I_yy + I_ay.
    inertia_y,
    /// I_zz + I_az.
    inertia_z,
    /// Product of inertia, the integral of x z dm.
    inertia_xz,
    /// Added mass along x.
    added_x,
    /// Added mass along y.
    added_y,
    /// Added mass along z.
    added_z,
    /// m + M_ax.
    total_x,
    /// m + M_ay.
    total_y,
    /// m + M_az.
    total_z,
    /// First moment about the joint, along z, of the mass that moves along x: m z_cm + M_ax z_cb.
    first_xz,
    /// First moment about the joint, along x, of the mass that moves along y.
    first_yx,
    /// First moment about the joint, along z, of the mass that moves along y.
    first_yz,
    /// First moment about the joint, along x, of the mass that moves along z.
    first_zx,
    /// Moment of inertia about the joint in roll, added mass included.
    joint_x,
    /// Moment of inertia about the joint in pitch, added mass included.
    joint_y,
    /// Moment of inertia about the joint in yaw, added mass included.
    joint_z,
    /// Product of inertia about the joint, added mass included.
    joint_xz,
    /// Center of mass from the joint along y_B, m.
    cm_y,
    /// Product of inertia, the integral of x y dm.
    inertia_xy,
    /// Product of inertia, the integral of y z dm.
    inertia_yz,
    /// First moment about the joint along y: m y_cm.
    first_y,
    /// m y_cm².
    joint_y_squared,
    /// Product of inertia about the joint, the integral of x y dm.
    joint_xy,
    /// Product of inertia about the joint, the integral of y z dm.
    joint_yz,
    /// Aerodynamic centers of the halves of the horizontal stabilizer from the plane of symmetry, m.
    fin_h_y,
    /// Half of what the starboard half has more of incidence than the port half.
    fin_h_half_incidence,
    /// Half of what the starboard half has more of lift slope than the port half.
    fin_h_half_cla,
    /// How much longer the center line is than its winch says, m.
    line_center,
    /// How much longer the starboard line is than its winch says, m.
    line_starboard,
    /// How much longer the port line is than its winch says, m.
    line_port,
    /// ½ rho A of the hull.
    hull_q,
    /// ½ rho A L_c of the hull.
    hull_q_chord,
    hull_x, hull_z, hull_cd0, hull_k, hull_cl0, hull_cla, hull_csb, hull_clb, hull_cm0, hull_cma, hull_cnb,
    /// Stall angle of the hull; out of reach where there is no stall.
    hull_stall,
    /// ½ rho A^H of the horizontal stabilizer.
    fin_h_q,
    fin_h_x, fin_h_z, fin_h_incidence, fin_h_cd0, fin_h_k, fin_h_cl0, fin_h_cla,
    /// Stall angle of the horizontal stabilizer; out of reach where there is no stall.
    fin_h_stall,
    /// ½ rho A^V of the vertical stabilizer.
    fin_v_q,
    fin_v_x, fin_v_z, fin_v_cd0, fin_v_k, fin_v_csb,
    /// lambda, kg/m.
    tether_density,
    /// lambda less the displaced fluid, kg/m.
    tether_net_density,
    /// ½ rho n d_t C_Dt, kg/m².
    tether_drag,
    /// 1/l_long, with the sign of the layout.
    per_long,
    /// 1/l_lat.
    per_lat,
    /// 1/tau_winch.
    per_winch,
    /// u_max.
    reel_limit,
}

impl Plant {
    /// Checks the parameters and derives the constants.
    ///
    /// The area of a stabilizer is its factor times its area; its aerodynamic center moves from the root by
    /// the square root of the factor, since its shape does not change (Section 7.2.3).
    ///
    /// # Errors
    /// [`Error::Parameter`], see [`Parameters::validate`].
    pub fn new(parameters: &Parameters, fidelity: Fidelity) -> Result<Self, Error> {
        parameters.validate()?;
        let Parameters { fluid, body, hull, horizontal_stabilizer: h, vertical_stabilizer: v, tether, winch, .. } =
            parameters;
        let along = |x: f64| -(x - body.joint_x) * body.chord_m;
        let half_density = 0.5 * fluid.density_kg_m3;
        let stall = |angle_rad| match fidelity.lift {
            Lift::Attached => NO_STALL_RAD,
            Lift::Stalled => angle_rad,
        };
        let added = match fidelity.fluid_inertia {
            FluidInertia::Neglected => 0.0,
            FluidInertia::Included => 1.0,
        };
        let added_mass = &parameters.added_mass;
        let (h_growth, v_growth) = (h.area_factor.sqrt(), v.area_factor.sqrt());
        let [added_x, added_y, added_z] = [added_mass.x_kg, added_mass.y_kg, added_mass.z_kg].map(|mass| added * mass);
        let inertia_x = body.inertia_xx_kg_m2 + added * added_mass.inertia_x_kg_m2;
        let inertia_y = body.inertia_yy_kg_m2 + added * added_mass.inertia_y_kg_m2;
        let inertia_z = body.inertia_zz_kg_m2 + added * added_mass.inertia_z_kg_m2;
        let m = body.mass_kg;
        let (cm_x, cm_z) = (along(body.center_of_mass_x), -body.center_of_mass_height_m);
        let (cb_x, cb_z) = (along(body.center_of_buoyancy_x), -body.center_of_buoyancy_height_m);
        let asymmetry = &parameters.asymmetry;
        let cm_y = asymmetry.center_of_mass_y_m;
        let line_area_m2 = core::f64::consts::FRAC_PI_4 * tether.line_diameter_m * tether.line_diameter_m;
        Ok(Self {
            gravity: fluid.gravity_m_s2,
            mass: m,
            displaced_mass: fluid.density_kg_m3 * body.volume_m3,
            cm_x,
            cm_z,
            cb_x,
            cb_z,
            inertia_x,
            inertia_y,
            inertia_z,
            inertia_xz: body.inertia_xz_kg_m2,
            added_x,
            added_y,
            added_z,
            total_x: m + added_x,
            total_y: m + added_y,
            total_z: m + added_z,
            first_xz: m * cm_z + added_x * cb_z,
            first_yx: m * cm_x + added_y * cb_x,
            first_yz: m * cm_z + added_y * cb_z,
            first_zx: m * cm_x + added_z * cb_x,
            joint_x: inertia_x + m * cm_z * cm_z + added_y * cb_z * cb_z,
            joint_y: inertia_y + m * (cm_x * cm_x + cm_z * cm_z) + added_x * cb_z * cb_z + added_z * cb_x * cb_x,
            joint_z: inertia_z + m * cm_x * cm_x + added_y * cb_x * cb_x,
            joint_xz: body.inertia_xz_kg_m2 + m * cm_x * cm_z + added_y * cb_x * cb_z,
            cm_y,
            inertia_xy: asymmetry.inertia_xy_kg_m2,
            inertia_yz: asymmetry.inertia_yz_kg_m2,
            first_y: m * cm_y,
            joint_y_squared: m * cm_y * cm_y,
            joint_xy: asymmetry.inertia_xy_kg_m2 + m * cm_x * cm_y,
            joint_yz: asymmetry.inertia_yz_kg_m2 + m * cm_y * cm_z,
            fin_h_y: h_growth * asymmetry.offset_lateral_m,
            fin_h_half_incidence: 0.5 * asymmetry.incidence_difference_rad,
            fin_h_half_cla: 0.5 * asymmetry.lift_slope_difference_per_rad,
            line_center: asymmetry.line_center_m,
            line_starboard: asymmetry.line_starboard_m,
            line_port: asymmetry.line_port_m,
            lopsided: *asymmetry != Asymmetry::default(),
            hull_q: half_density * hull.area_m2,
            hull_q_chord: half_density * hull.area_m2 * body.chord_m,
            hull_x: along(hull.center_x),
            hull_z: -hull.center_height_m,
            hull_cd0: hull.drag_zero_lift,
            hull_k: hull.drag_due_to_lift,
            hull_cl0: hull.lift_zero,
            hull_cla: hull.lift_slope_per_rad,
            hull_csb: hull.side_force_slope_per_rad,
            hull_clb: hull.roll_moment_slope_per_rad,
            hull_cm0: hull.pitch_moment_zero,
            hull_cma: hull.pitch_moment_slope_per_rad,
            hull_cnb: hull.yaw_moment_slope_per_rad,
            hull_stall: stall(parameters.stall.hull_rad),
            fin_h_q: half_density * h.area_m2 * h.area_factor,
            fin_h_x: along(h.root_x + h_growth * h.offset_x),
            fin_h_z: -(h.root_height_m + h_growth * h.offset_height_m),
            fin_h_incidence: h.incidence_rad,
            fin_h_cd0: h.drag_zero_lift,
            fin_h_k: h.drag_due_to_lift,
            fin_h_cl0: h.lift_zero,
            fin_h_cla: h.lift_slope_per_rad,
            fin_h_stall: stall(parameters.stall.horizontal_stabilizer_rad),
            fin_v_q: half_density * v.area_m2 * v.area_factor,
            fin_v_x: along(v.root_x + v_growth * v.offset_x),
            fin_v_z: -(v.root_height_m + v_growth * v.offset_height_m),
            fin_v_cd0: v.drag_zero_lift,
            fin_v_k: v.drag_due_to_side_force,
            fin_v_csb: v.side_force_slope_per_rad,
            tether_density: tether.linear_density_kg_m,
            tether_net_density: tether.linear_density_kg_m - N_LINES * fluid.density_kg_m3 * line_area_m2,
            tether_drag: half_density * N_LINES * tether.line_diameter_m * tether.drag_coefficient,
            per_long: parameters.layout.pitch_sign() / tether.separation_longitudinal_m,
            per_lat: 1.0 / tether.separation_lateral_m,
            per_winch: 1.0 / winch.time_constant_s,
            reel_limit: winch.speed_limit_m_s,
        })
    }

    /// The largest reel speed u_max in m/s.
    #[must_use]
    pub fn speed_limit_m_s(&self) -> f64 {
        self.reel_limit
    }

    /// Whether starboard and port differ: something of [`Asymmetry`] is not zero.
    #[must_use]
    pub fn is_lopsided(&self) -> bool {
        self.lopsided
    }

    /// The plant with this share of what a resting body feels of its asymmetry; with none of it, symmetric.
    ///
    /// Not a plant to fly: the inertia keeps its asymmetry.
    #[must_use]
    pub(crate) fn with_asymmetry(&self, share: f64) -> Self {
        Self {
            cm_y: share * self.cm_y,
            fin_h_half_incidence: share * self.fin_h_half_incidence,
            fin_h_half_cla: share * self.fin_h_half_cla,
            line_center: share * self.line_center,
            line_starboard: share * self.line_starboard,
            line_port: share * self.line_port,
            lopsided: share.abs() > 0.0,
            ..*self
        }
    }

    /// The plant with every constant as another scalar (dual numbers, identical lanes).
    #[must_use]
    pub fn cast<T: Real>(&self) -> Plant<T> {
        self.map(T::constant)
    }
}

impl<T: Real> Plant<T> {
    /// `M_a v` for a velocity along B: the momentum of the added mass.
    #[inline(always)]
    pub(crate) fn added_mass_times(&self, v: Vector<T>) -> Vector<T> {
        [self.added_x * v[0], self.added_y * v[1], self.added_z * v[2]]
    }

    /// Center of mass from the joint, along B.
    #[inline(always)]
    pub(crate) fn cm(&self) -> Vector<T> {
        [self.cm_x, self.cm_y, self.cm_z]
    }

    /// `(I + I_a) omega` for an angular velocity along B: the angular momentum about the center of mass, and that of the
    /// added inertia; the products out of the plane of symmetry only where `LOPSIDED`.
    #[inline(always)]
    pub(crate) fn inertia_times<const LOPSIDED: bool>(&self, omega: Vector<T>) -> Vector<T> {
        let [x, y, z] = [
            self.inertia_x * omega[0] - self.inertia_xz * omega[2],
            self.inertia_y * omega[1],
            self.inertia_z * omega[2] - self.inertia_xz * omega[0],
        ];
        if LOPSIDED {
            let across = self.inertia_xy * omega[0] + self.inertia_yz * omega[2];
            return [x - self.inertia_xy * omega[1], y - across, z - self.inertia_yz * omega[1]];
        }
        [x, y, z]
    }
}
