//! Where a body is and how it is turned, in the ground frame.

use core::f64::consts::PI;

use bat_dynamics::{Lanes, Real};

use super::triple::Triple;

/// Position of a point of the body and the body's attitude, in the ground frame G.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// x upstream, y to the right of x, z down, in m; of the center of mass wherever a flight is meant.
    pub position_m: [f64; 3],
    /// phi, starboard down.
    pub roll_rad: f64,
    /// theta, nose up.
    pub pitch_rad: f64,
    /// psi, nose right.
    pub heading_rad: f64,
}

impl Pose {
    /// Rows of `R_gb = Rz(psi) Ry(theta) Rx(phi)`, which turns components along the body into components along G.
    #[inline(always)]
    #[must_use]
    pub fn rows_gb(&self) -> [[f64; 3]; 3] {
        self.attitude().rows_gb()
    }

    #[inline(always)]
    pub(crate) fn attitude(&self) -> Attitude {
        // The plant's own functions: the same bits on every machine.
        let (Lanes([sr, sp, sh, _]), Lanes([cr, cp, ch, _])) =
            Lanes([self.roll_rad, self.pitch_rad, self.heading_rad, 0.0]).sin_cos();
        Attitude { sines: [sr, sp, sh], cosines: [cr, cp, ch] }
    }

    /// Height of the point above the origin of G, in m.
    #[must_use]
    pub fn altitude_m(&self) -> f64 {
        -self.position_m[2]
    }

    /// The six numbers: x, y, z in m, roll, pitch, heading in rad.
    #[must_use]
    pub fn numbers(&self) -> [f64; 6] {
        let [x, y, z] = self.position_m;
        [x, y, z, self.roll_rad, self.pitch_rad, self.heading_rad]
    }

    /// The same attitude with roll and heading in (−pi, pi] and pitch within a quarter turn, as the model reads them.
    pub(crate) fn usual(self) -> Self {
        let within = Self { pitch_rad: wrapped(self.pitch_rad), ..self };
        let upside = within.pitch_rad.abs() > PI / 2.0;
        let turned = if upside {
            let (roll_rad, heading_rad) = (self.roll_rad + PI, self.heading_rad + PI);
            Self { roll_rad, pitch_rad: PI - within.pitch_rad, heading_rad, ..self }
        } else {
            within
        };
        Self {
            roll_rad: wrapped(turned.roll_rad),
            pitch_rad: wrapped(turned.pitch_rad),
            heading_rad: wrapped(turned.heading_rad),
            ..turned
        }
    }
}

/// Sines and cosines of roll, pitch and heading, for all that is asked of a pose at once, or of several side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attitude<T = f64> {
    pub(crate) sines: Triple<T>,
    pub(crate) cosines: Triple<T>,
}

/// A cosine of the pitch below this is one of a nose straight up or down, where roll and heading are the same turn.
const UPRIGHT: f64 = 1e-9;

impl<T: Real> Attitude<T> {
    /// Of roll, pitch and heading.
    #[inline(always)]
    pub(crate) fn of_angles([roll, pitch, heading]: Triple<T>) -> Self {
        let ((sr, cr), (sp, cp), (sh, ch)) = (roll.sin_cos(), pitch.sin_cos(), heading.sin_cos());
        Self { sines: [sr, sp, sh], cosines: [cr, cp, ch] }
    }

    /// Rows of `R_gb`.
    #[inline(always)]
    pub(crate) fn rows_gb(&self) -> [Triple<T>; 3] {
        let ([sr, sp, sh], [cr, cp, ch]) = (self.sines, self.cosines);
        [
            [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
            [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
            [-sp, cp * sr, cp * cr],
        ]
    }

    /// 1, and 0 with the nose straight up or down, where [`Attitude::angles_of_turn`] means nothing.
    #[inline(always)]
    pub(crate) fn has_angles(&self) -> T {
        let (none, one) = (T::constant(0.0), T::constant(1.0));
        T::constant(UPRIGHT).select_below(self.cosines[1].abs(), one, none)
    }

    /// From a small turn in rad, along G, to the changes of roll, pitch and heading that make it.
    ///
    /// ```text
    /// omega = a_phi phi̇ + a_theta thetȧ + a_psi psi̇     a_phi   = [cos theta cos psi, cos theta sin psi, −sin theta]
    ///                                                    a_theta = [−sin psi, cos psi, 0],  a_psi = [0, 0, 1]
    /// ```
    ///
    /// Nothing with the nose straight up or down, where roll and heading are the same turn.
    #[inline(always)]
    pub(crate) fn angles_of_turn(&self) -> [Triple<T>; 3] {
        let ([_, sp, sh], [_, cp, ch]) = (self.sines, self.cosines);
        let (zero, one) = (T::constant(0.0), T::constant(1.0));
        let roll = [ch / cp, sh / cp, zero];
        [roll, [-sh, ch, zero], [sp * roll[0], sp * roll[1], one]]
    }
}

/// The angle in (−pi, pi]; one that lies there keeps its bits.
fn wrapped(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI { angle_rad } else { PI - (PI - angle_rad).rem_euclid(2.0 * PI) }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    fn matrix(rows: [Triple; 3]) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| rows[i][j])
    }

    #[test]
    fn small_turn_is_the_turn_of_its_angles() {
        let pose = Pose { position_m: [0.0; 3], roll_rad: 0.3, pitch_rad: -0.4, heading_rad: 2.0 };
        let turn = Vector3::new(3e-7, -2e-7, 5e-7);
        let angles = matrix(pose.attitude().angles_of_turn()) * turn;
        let after = Pose {
            roll_rad: pose.roll_rad + angles[0],
            pitch_rad: pose.pitch_rad + angles[1],
            heading_rad: pose.heading_rad + angles[2],
            ..pose
        };
        let after = matrix(after.rows_gb());
        let expected = (Matrix3::identity() + turn.cross_matrix()) * matrix(pose.rows_gb());
        assert!((after - expected).amax() < 1e-12, "{}", after - expected);
        let upright = Pose { pitch_rad: PI / 2.0, ..pose };
        assert!(upright.attitude().has_angles() < 1.0, "roll and heading are one turn");
        assert!(pose.attitude().has_angles() > 0.0, "here they are not");
    }

    #[test]
    fn usual_angles_are_the_same_attitude() {
        for (roll_rad, pitch_rad, heading_rad) in
            [(0.1, 2.0, 0.2), (4.0, 0.3, -3.5), (0.0, -3.0, 7.0), (1.0, 5.0, 0.1), (0.2, -6.0, -9.0)]
        {
            let pose = Pose { position_m: [1.0, 2.0, 3.0], roll_rad, pitch_rad, heading_rad };
            let usual = pose.usual();
            assert!((matrix(usual.rows_gb()) - matrix(pose.rows_gb())).amax() < 1e-14, "{usual:?}");
            assert!(usual.pitch_rad.abs() <= PI / 2.0 && usual.heading_rad.abs() <= PI, "{usual:?}");
        }
        let plain = Pose { position_m: [0.0; 3], roll_rad: -0.1, pitch_rad: 0.2, heading_rad: PI };
        assert_eq!(plain.usual(), plain, "bits of a usual attitude are kept");
    }
}
