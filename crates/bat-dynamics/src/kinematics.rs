//! From generalized coordinates to positions, attitudes and velocities: equations (5)–(9).
//!
//! The work is done in the tether frame T, `R_gt = Rz(Theta) Ry(Phi)`: there the joint lies at (0, 0, −L_t)
//! and the equations of motion are short. Azimuths are taken relative to the flow, `Theta − psi_flow`.

use crate::coordinates::Coordinates;
use crate::flow::Flow;
use crate::plant::Plant;
use crate::real::Real;
use crate::vector::{Vector, add, combine, cross_place, dot, scale};

/// Sines and cosines of a configuration, and the axes of T in B.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose<T> {
    pub(crate) length: T,
    pub(crate) sin_zenith: T,
    pub(crate) cos_zenith: T,
    /// Of Theta − psi_flow.
    pub(crate) sin_azimuth: T,
    pub(crate) cos_azimuth: T,
    pub(crate) cos_pitch: T,
    pub(crate) sin_roll: T,
    pub(crate) cos_roll: T,
    /// Rows of R_tb = Rz(Psi) Ry(theta') Rx(phi'): the axes of T in components along B.
    pub(crate) axes: [Vector<T>; 3],
}

/// Rates of the six coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates<T> {
    pub(crate) zenith: T,
    pub(crate) azimuth: T,
    pub(crate) twist: T,
    pub(crate) length: T,
    pub(crate) pitch: T,
    pub(crate) roll: T,
}

/// Accelerations of the driven coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driven<T> {
    pub(crate) length: T,
    pub(crate) pitch: T,
    pub(crate) roll: T,
}

impl<T: Real> Pose<T> {
    #[inline(always)]
    pub(crate) fn new(length: T, zenith: (T, T), azimuth: (T, T), twist: (T, T), pitch: (T, T), roll: (T, T)) -> Self {
        let ((sin_zenith, cos_zenith), (sin_azimuth, cos_azimuth)) = (zenith, azimuth);
        let ((st, ct), (sp, cp), (sr, cr)) = (twist, pitch, roll);
        let axes = [
            [ct * cp, ct * sp * sr - st * cr, ct * sp * cr + st * sr],
            [st * cp, st * sp * sr + ct * cr, st * sp * cr - ct * sr],
            [-sp, cp * sr, cp * cr],
        ];
        Self {
            length,
            sin_zenith,
            cos_zenith,
            sin_azimuth,
            cos_azimuth,
            cos_pitch: cp,
            sin_roll: sr,
            cos_roll: cr,
            axes,
        }
    }

    /// The pose of `q` seen from the flow's direction.
    #[inline(always)]
    pub(crate) fn of_coordinates(q: &Coordinates<T>, flow: &Flow<T>) -> Self {
        Self::new(
            q[3],
            q[0].sin_cos(),
            (q[1] - flow.direction_rad).sin_cos(),
            q[2].sin_cos(),
            q[4].sin_cos(),
            q[5].sin_cos(),
        )
    }

    /// Axis of theta' in B.
    #[inline(always)]
    pub(crate) fn pitch_axis(&self) -> Vector<T> {
        [T::constant(0.0), self.cos_roll, -self.sin_roll]
    }

    /// Velocity of the joint and angular velocity of T, both along T.
    #[inline(always)]
    pub(crate) fn joint_velocity(&self, rates: &Rates<T>) -> Vector<T> {
        [-(self.length * rates.zenith), -(self.length * rates.azimuth * self.sin_zenith), -rates.length]
    }

    /// Angular velocity of the body along B, and of the body relative to T along B.
    #[inline(always)]
    pub(crate) fn angular_velocity(&self, rates: &Rates<T>) -> (Vector<T>, Vector<T>) {
        let frame =
            combine(&self.axes, [-(rates.azimuth * self.sin_zenith), rates.zenith, rates.azimuth * self.cos_zenith]);
        let twist = scale(rates.twist, self.axes[2]);
        let bridle = [rates.roll, rates.pitch * self.cos_roll, -(rates.pitch * self.sin_roll)];
        let relative = add(twist, bridle);
        (add(frame, relative), relative)
    }

    /// The flow's velocity along T.
    #[inline(always)]
    pub(crate) fn flow_velocity(&self, speed: T) -> Vector<T> {
        let upwind = -(speed * self.cos_azimuth);
        [upwind * self.cos_zenith, speed * self.sin_azimuth, upwind * self.sin_zenith]
    }

    /// Along T, of a vector along the axes of G turned to the flow: against it, right, down.
    #[inline(always)]
    pub(crate) fn along_tether(&self, [ahead, right, down]: Vector<T>) -> Vector<T> {
        let level = self.cos_azimuth * ahead + self.sin_azimuth * right;
        [
            level * self.cos_zenith - down * self.sin_zenith,
            self.cos_azimuth * right - self.sin_azimuth * ahead,
            level * self.sin_zenith + down * self.cos_zenith,
        ]
    }

    /// Rows of the rotation from B to G turned by −psi_flow: forward, right and down seen from the flow.
    #[inline(always)]
    fn rows_from_flow(&self) -> [Vector<T>; 3] {
        let level = add(scale(self.cos_zenith, self.axes[0]), scale(self.sin_zenith, self.axes[2]));
        let down = add(scale(-self.sin_zenith, self.axes[0]), scale(self.cos_zenith, self.axes[2]));
        [
            add(scale(self.cos_azimuth, level), scale(-self.sin_azimuth, self.axes[1])),
            add(scale(self.sin_azimuth, level), scale(self.cos_azimuth, self.axes[1])),
            down,
        ]
    }

    /// What cameras would see; the center of mass lies in the plane of symmetry unless `LOPSIDED`.
    #[inline(always)]
    pub(crate) fn sight<const LOPSIDED: bool>(&self, plant: &Plant<T>) -> Sight<T> {
        let rows = self.rows_from_flow();
        let joint = [
            -(self.length * self.sin_zenith * self.cos_azimuth),
            -(self.length * self.sin_zenith * self.sin_azimuth),
            -(self.length * self.cos_zenith),
        ];
        let along = |row: Vector<T>| {
            let in_plane = row[0] * plant.cm_x + row[2] * plant.cm_z;
            if LOPSIDED { in_plane + row[1] * plant.cm_y } else { in_plane }
        };
        // From both legs rather than by an arc sine: rounding cannot push it past a quarter turn.
        let level = (rows[0][0] * rows[0][0] + rows[1][0] * rows[1][0]).sqrt();
        let legs = [(rows[2][1], rows[2][2]), (-rows[2][0], level), (rows[1][0], rows[0][0])];
        let mut angles = [level; 3];
        // A loop that stays one: a smaller block of code around it, which the compiler packs into vectors as a whole.
        for (angle, (y, x)) in angles.iter_mut().zip(legs) {
            *angle = y.atan2(x);
        }
        let [roll_rad, pitch_rad, heading_rad] = angles;
        Sight {
            forward_m: joint[0] + along(rows[0]),
            right_m: joint[1] + along(rows[1]),
            altitude_m: -(joint[2] + along(rows[2])),
            roll_rad,
            pitch_rad,
            heading_rad,
        }
    }
}

/// Position of the center of mass and attitude, seen from the flow's direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight<T = f64> {
    /// Position of the center of mass against the flow.
    pub forward_m: T,
    /// Position of the center of mass to the right of the flow's axis.
    pub right_m: T,
    /// Altitude of the center of mass above the winches.
    pub altitude_m: T,
    /// Roll angle phi, starboard down.
    pub roll_rad: T,
    /// Pitch angle theta, nose up.
    pub pitch_rad: T,
    /// Heading relative to the flow, psi − psi_flow in (−pi, pi], nose right.
    pub heading_rad: T,
}

impl<T: Copy> Rates<T> {
    #[inline(always)]
    pub(crate) fn of_array(rates: &Coordinates<T>) -> Self {
        let &[zenith, azimuth, twist, length, pitch, roll] = rates;
        Self { zenith, azimuth, twist, length, pitch, roll }
    }
}

/// Position and velocity of the center of mass, `X = [x, y, z, u, v, w]`: x, y, z in G in m, u, v, w along B in m/s.
///
/// `q_rate` holds the rates of `q`.
///
/// Source: (5), (8).
#[must_use]
pub fn translation<T: Real>(plant: &Plant<T>, q: &Coordinates<T>, q_rate: &Coordinates<T>) -> [T; 6] {
    let still = Flow { speed_m_s: T::constant(0.0), direction_rad: T::constant(0.0) };
    let (pose, rates) = (Pose::of_coordinates(q, &still), Rates::of_array(q_rate));
    let (omega, _) = pose.angular_velocity(&rates);
    let (sight, swing) = if plant.lopsided {
        (pose.sight::<true>(plant), cross_place::<_, true>(omega, plant.cm()))
    } else {
        (pose.sight::<false>(plant), cross_place::<_, false>(omega, plant.cm()))
    };
    let velocity = add(combine(&pose.axes, pose.joint_velocity(&rates)), swing);
    [sight.forward_m, sight.right_m, -sight.altitude_m, velocity[0], velocity[1], velocity[2]]
}

/// Attitude and body rates, `Omega = [phi, theta, psi, p, q, r]` in rad and rad/s: roll starboard down, pitch nose up, yaw
/// nose right.
///
/// `q_rate` holds the rates of `q`.
///
/// Source: (6), (9).
#[must_use]
pub fn rotation<T: Real>(plant: &Plant<T>, q: &Coordinates<T>, q_rate: &Coordinates<T>) -> [T; 6] {
    let still = Flow { speed_m_s: T::constant(0.0), direction_rad: T::constant(0.0) };
    let (pose, rates) = (Pose::of_coordinates(q, &still), Rates::of_array(q_rate));
    let sight = pose.sight::<false>(plant);
    let (omega, _) = pose.angular_velocity(&rates);
    [sight.roll_rad, sight.pitch_rad, sight.heading_rad, omega[0], omega[1], omega[2]]
}

/// Rows of the rotation from B to G at `q`.
#[must_use]
pub fn body_to_ground(q: &Coordinates) -> [[f64; 3]; 3] {
    Pose::of_coordinates(q, &Flow::straight(0.0)).rows_from_flow()
}

/// Height of a point of the body above the joint.
#[inline(always)]
pub(crate) fn height<T: Real>(row_down: Vector<T>, point: Vector<T>) -> T {
    -dot(row_down, point)
}
