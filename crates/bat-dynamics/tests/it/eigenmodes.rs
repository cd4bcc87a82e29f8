//! Eigenmodes of matrices whose modes are known.

use bat_dynamics::{Error, modes};
use nalgebra::{Complex, DMatrix, DVector};

#[test]
fn damped_oscillator_has_its_frequency_and_damping() {
    let (omega, zeta) = (3.0, 0.2);
    let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -2.0 * zeta * omega]);
    let found = modes(&a).unwrap();
    assert_eq!(found.modes.len(), 1, "a conjugate pair counts once");
    let mode = &found.modes[0];
    assert!((mode.natural_frequency_rad_s() - omega).abs() < 1e-14, "frequency");
    assert!((mode.damping_ratio() - zeta).abs() < 1e-14, "damping");
    assert!((mode.eigenvalue.im - omega * (1.0 - zeta * zeta).sqrt()).abs() < 1e-14, "{}", mode.eigenvalue);
    assert!(!mode.is_unstable() && found.is_stable(), "stable");
    // Position and speed take part alike in one oscillator.
    for share in mode.participation.as_ref().unwrap() {
        assert!((share - 0.5).abs() < 1e-12, "{:?}", mode.participation);
    }
    assert!((mode.share_of(&[0, 1]).unwrap() - 1.0).abs() < 1e-12, "shares add to one");
}

#[test]
fn uncoupled_states_take_part_in_their_own_modes_only() {
    // A planted answer: an unstable divergence, a decay and a pair, each on its own states.
    let mut a = DMatrix::zeros(4, 4);
    a[(2, 2)] = 0.5;
    a[(0, 0)] = -2.0;
    (a[(1, 3)], a[(3, 1)]) = (4.0, -1.0);
    let found = modes(&a).unwrap();
    let planted = [(0.5, 0.0, 2), (0.0, 2.0, 1), (-2.0, 0.0, 0)];
    assert_eq!(found.modes.len(), planted.len());
    for (mode, (re, im, state)) in found.modes.iter().zip(planted) {
        assert!((mode.eigenvalue - Complex::new(re, im)).norm() < 1e-13, "{mode:?}");
        let shares = mode.participation.as_ref().unwrap();
        let expected = if im > 0.0 { 0.5 } else { 1.0 };
        assert!((shares[state] - expected).abs() < 1e-9, "{mode:?}");
    }
    assert!(!found.is_stable() && found.modes[0].is_unstable(), "the slowest decay comes first: a growth");
    assert_eq!(found.modes[0].damping_ratio(), -1.0, "growth without oscillation");
    assert_eq!(found.modes[2].damping_ratio(), 1.0, "decay without oscillation");
}

#[test]
fn participation_does_not_depend_on_units() {
    // x = S y changes the eigenvectors but not the shares.
    let a = DMatrix::from_row_slice(3, 3, &[-1.0, 0.4, 0.1, -0.3, -2.0, 0.7, 0.2, 0.5, -0.3]);
    let scale = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 50.0, 0.02]));
    let scaled = scale.clone().try_inverse().unwrap() * &a * &scale;
    let (one, other) = (modes(&a).unwrap().modes, modes(&scaled).unwrap().modes);
    for (mode, scaled) in one.iter().zip(&other) {
        for (a, b) in mode.participation.as_ref().unwrap().iter().zip(scaled.participation.as_ref().unwrap()) {
            assert!((a - b).abs() < 1e-9, "{mode:?} and {scaled:?}");
        }
    }
}

#[test]
fn repeated_eigenvalues_with_a_full_set_of_eigenvectors_have_shares() {
    for a in [DMatrix::identity(3, 3) * -2.0, DMatrix::zeros(3, 3)] {
        let found = modes(&a).unwrap().modes;
        assert_eq!(found.len(), 3);
        for mode in found {
            assert_eq!(mode.eigenvalue, Complex::new(a[(0, 0)], 0.0));
            let total: f64 = mode.participation.as_ref().unwrap().iter().sum();
            assert!((total - 1.0).abs() < 1e-12, "shares add to {total}");
        }
    }
    // Two equal decays that one invertible change of states couples.
    let change = DMatrix::from_row_slice(3, 3, &[1.0, 0.3, -0.2, 0.1, 1.0, 0.4, 0.5, -0.1, 1.0]);
    let diagonal = DMatrix::from_diagonal(&DVector::from_vec(vec![-1.0, -1.0, -3.0]));
    let a = &change * diagonal * change.clone().try_inverse().unwrap();
    for mode in modes(&a).unwrap().modes {
        let expected = if mode.eigenvalue.re < -2.0 { -3.0 } else { -1.0 };
        assert!((mode.eigenvalue.re - expected).abs() < 1e-9 && mode.participation.is_some(), "{mode:?}");
    }
}

#[test]
fn defective_matrix_has_eigenvalues_but_no_shares() {
    let defective = [
        DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]),
        DMatrix::from_row_slice(2, 2, &[-1.0, 1.0, 0.0, -1.0]),
        DMatrix::from_row_slice(3, 3, &[-2.0, 1.0, 0.0, 0.0, -2.0, 1.0, 0.0, 0.0, -2.0]),
        DMatrix::from_row_slice(3, 3, &[-5.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, -1.0]),
    ];
    for a in defective {
        for mode in modes(&a).unwrap().modes {
            assert_eq!(mode.participation, None, "{mode:?} of {a}");
            assert_eq!(mode.share_of(&[0]), None, "{mode:?} of {a}");
        }
    }
    let zero = modes(&DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0])).unwrap();
    assert_eq!(zero.modes[0].damping_ratio(), 0.0, "at zero there is no damping to speak of");
    assert!(!zero.is_stable(), "an integrator does not decay");
}

#[test]
fn matrices_without_eigenvalues_are_errors() {
    for a in [
        DMatrix::zeros(0, 0),
        DMatrix::zeros(2, 3),
        DMatrix::from_element(2, 2, f64::NAN),
        DMatrix::from_element(3, 3, f64::INFINITY),
    ] {
        let error = modes(&a).unwrap_err();
        assert_eq!(error, Error::Eigenvalues { size: a.nrows() });
        assert!(error.to_string().contains("eigenvalues"), "{error}");
    }
}
