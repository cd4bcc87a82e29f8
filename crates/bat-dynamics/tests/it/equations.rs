//! The wrench form of the equations of motion against the Lagrangian form.

use bat_dynamics::*;
use nalgebra::Vector6;

use crate::plants::rig;

#[test]
fn wrench_form_satisfies_the_lagrangian_form() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let plant = Plant::new(&rig(), fidelity).unwrap();
        let q = [0.3, -0.4, 0.7, 0.6, 0.2, -0.15];
        let rate = [0.5, -0.8, 0.9, 0.03, -0.4, 0.6];
        let driven = [0.1, 0.7, -0.9];
        let flow = Flow { speed_m_s: 0.25, direction_rad: 0.35 };
        let at = accelerations(&plant, &q, &rate, driven, &flow).unwrap();
        let [a, b, c] = at.free_rad_s2;
        let acceleration = Vector6::new(a, b, c, driven[0], driven[1], driven[2]);
        let left = mass_matrix(&plant, &q) * acceleration
            + christoffel_matrix(&plant, &q, &rate) * Vector6::from(rate)
            + gravity_vector(&plant, &q)
            - generalized_forces(&plant, &q, &rate, &flow);
        println!("{left} {at:?}");
        for k in 0..3 {
            assert!(left[k].abs() < 1e-12, "row {k}: {}", left[k]);
            assert!((left[k + 3] - at.supplied[k]).abs() < 1e-12, "row {}: {}", k + 3, left[k + 3]);
        }
        let trim = trim(&plant, &TrimRequest { flow: Flow::straight(0.245), pitch_rad: 8f64.to_radians(), height: TrimHeight::Altitude(0.61) }).unwrap();
        println!("{trim:?}");
        let lin = linearize(&plant, &trim.state, [0.0; 3], &Flow::straight(0.245)).unwrap();
        println!("{:?}", modes(&nalgebra::DMatrix::from_iterator(6, 6, lin.passive().iter().cloned())).unwrap());
    }
}
