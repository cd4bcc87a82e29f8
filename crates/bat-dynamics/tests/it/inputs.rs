//! Parameters and states: what is refused, and how it is told.

use bat_dynamics::{
    Allowed, Error, FIELDS, Fidelity, Field, Flow, OPTIONAL_FIELDS, Parameters, Plant, SINGULAR_SIN_ZENITH,
    STATE_NAMES, STATE_UNITS, TetherLayout, accelerations, check_state, evaluate,
};

use crate::plants::{everything, rig};

const STATE: [f64; 12] = [0.3, 0.1, -0.05, 0.1, -0.2, 0.15, 0.62, 0.6, 0.61, 0.004, -0.003, 0.002];

/// The error of `parameters`, which names `section` and `name`.
#[track_caller]
fn refused(parameters: &Parameters, section: &str, name: &str) -> String {
    match Plant::new(parameters, Fidelity::NUMERICAL) {
        Err(error @ Error::Parameter { .. }) => {
            assert!(error.to_string().starts_with(&format!("{section}.{name} = ")), "{section}.{name}: {error}");
            error.to_string()
        }
        other => panic!("{section}.{name} was not refused: {other:?}"),
    }
}

#[test]
fn every_parameter_is_checked_against_its_range() {
    for field in Parameters::fields() {
        let outside: &[f64] = match field.allowed {
            Allowed::Finite => &[],
            Allowed::NonNegative => &[-1e-9, -1.0],
            Allowed::Positive => &[0.0, -1.0],
            Allowed::AcuteAngle => &[0.0, -0.1, 1.6],
            Allowed::ShortOfHalfTurn => &[core::f64::consts::PI, -3.2, 20.0],
        };
        for value in outside.iter().chain(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]) {
            let mut p = rig();
            (field.set)(&mut p, *value);
            let message = refused(&p, field.section, field.name);
            assert!(message.ends_with(field.allowed.words()), "{message}");
        }
    }
    // Zero is a surface that is not there, and a product of inertia has either sign.
    assert!(FIELDS.iter().filter(|f| f.name == "area").all(|f| f.allowed.admits(0.0)), "areas");
    assert!(Field::find("body", "inertia_xz").unwrap().allowed.admits(-1e-5), "inertia_xz");
}

/// Degrees by mistake: with an incidence of 20 rad the linear model would stall.
#[test]
fn an_incidence_of_half_a_turn_and_more_is_refused() {
    for incidence in [20.0, -20.0, core::f64::consts::PI] {
        let mut p = rig();
        p.horizontal_stabilizer.incidence_rad = incidence;
        let message = refused(&p, "horizontal_stabilizer", "incidence");
        assert!(message.ends_with("short of a half turn to either side"), "{message}");
    }
    let mut p = rig();
    p.horizontal_stabilizer.incidence_rad = -3.1;
    p.asymmetry.incidence_difference_rad = 3.1;
    Plant::new(&p, Fidelity::NUMERICAL).unwrap();
}

#[test]
fn inertia_that_no_body_can_have_is_refused() {
    for (name, [xx, yy, zz]) in
        [("inertia_xx", [3.1, 1.0, 2.0]), ("inertia_yy", [1.0, 3.1, 2.0]), ("inertia_zz", [2.0, 1.0, 3.1])]
    {
        let mut p = rig();
        (p.body.inertia_xx_kg_m2, p.body.inertia_yy_kg_m2, p.body.inertia_zz_kg_m2) = (xx, yy, zz);
        p.body.inertia_xz_kg_m2 = 0.0;
        assert!(refused(&p, "body", name).contains("sum of the other two"), "{name}");
    }
    // Second moments of mass along x and z are 1.25 and 0.75 with moments of inertia 1.5, 2 and 2: of these the product
    // is at most the geometric mean, as for the moments of any distribution.
    let mut p = rig();
    (p.body.inertia_xx_kg_m2, p.body.inertia_yy_kg_m2, p.body.inertia_zz_kg_m2) = (1.5, 2.0, 2.0);
    let most = (1.25_f64 * 0.75).sqrt();
    for product in [most, -most] {
        p.body.inertia_xz_kg_m2 = 0.999 * product;
        Plant::new(&p, Fidelity::NUMERICAL).unwrap();
        p.body.inertia_xz_kg_m2 = 1.001 * product;
        refused(&p, "body", "inertia_xz");
    }
}

#[test]
fn fields_reach_every_number_by_section_and_name() {
    let mut rig = rig();
    rig.asymmetry.center_of_mass_y_m = 0.002;
    rig.asymmetry.line_port_m = -0.003;
    let copy = Parameters::from_fields(rig.layout, |field| Ok::<f64, ()>((field.get)(&rig))).unwrap();
    assert_eq!(copy, rig, "what sets its sides apart included");
    // No two fields share a place: setting one changes what it reads and nothing else.
    for field in Parameters::fields() {
        let mut p = rig;
        (field.set)(&mut p, 123.0);
        let changed: Vec<_> =
            Parameters::fields().filter(|f| (f.get)(&p) != (f.get)(&rig)).map(|f| (f.section, f.name)).collect();
        assert_eq!(changed, [(field.section, field.name)]);
        let found = Field::find(field.section, field.name).unwrap();
        assert_eq!((found.section, found.name, found.unit), (field.section, field.name, field.unit));
    }
    let is_optional = |field: &&Field| field.optional;
    assert_eq!(Parameters::fields().filter(is_optional).count(), OPTIONAL_FIELDS.len(), "those of the second list");
    assert!(FIELDS.iter().all(|field| !field.optional), "and none of the first");
    assert!(Field::find("body", "wingspan").is_none(), "an unknown name");
    let stopped = Parameters::from_fields(TetherLayout::OneForwardTwoAft, |field| {
        if field.name == "volume" { Err(field.section) } else { Ok(1.0) }
    });
    assert_eq!(stopped.unwrap_err(), "body");
}

#[test]
fn named_plant_is_the_one_of_the_file() {
    let (named, file) = (Parameters::water_channel_bat(), rig());
    for field in FIELDS {
        // The file has per cent of chord: a division by 100 rounds.
        let (found, expected) = ((field.get)(&named), (field.get)(&file));
        let rounding = f64::EPSILON * expected.abs();
        assert!((found - expected).abs() <= rounding, "{}.{} is {expected} in the file", field.section, field.name);
    }
    assert_eq!(named.layout, file.layout);
}

#[track_caller]
fn check_refused(state: [f64; 12], name: &str, words: &str) {
    let error = check_state(&state, 12.5).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, Error::State { time_s, .. } if time_s == 12.5), "{error:?}");
    assert!(text.starts_with(name) && text.contains("t = 12.5 s") && text.contains(words), "{text}");
}

#[test]
fn states_outside_the_model_are_named_with_value_and_time() {
    check_state(&STATE, 0.0).unwrap();
    for k in 0..12 {
        for value in [f64::NAN, f64::INFINITY] {
            let mut state = STATE;
            state[k] = value;
            check_refused(state, STATE_NAMES[k], STATE_UNITS[k]);
        }
    }
    for zenith in [0.0, 1e-9, -1e-9, core::f64::consts::PI] {
        let mut state = STATE;
        state[0] = zenith;
        check_refused(state, "zenith angle Phi", "azimuth and twist coincide");
    }
    let mut state = STATE;
    state[0] = 2.0 * SINGULAR_SIN_ZENITH;
    check_state(&state, 0.0).unwrap();
    state[0] = -state[0];
    check_state(&state, 0.0).unwrap();
    for lines in [[0.0; 3], [-0.5, 0.2, 0.2]] {
        let mut state = STATE;
        state[6..9].copy_from_slice(&lines);
        check_refused(state, "tether length L_t", "more than zero");
    }
}

#[test]
fn accelerations_refuse_what_they_are_not_defined_for() {
    let plant = Plant::new(&rig(), Fidelity::NUMERICAL).unwrap();
    let (q, rate, flow) = ([0.3, 0.1, 0.2, 0.6, 0.1, 0.0], [0.1; 6], Flow::straight(0.2));
    accelerations(&plant, &q, &rate, [0.0; 3], &flow).unwrap();
    let names = ["zenith", "azimuth", "twist", "tether length", "induced pitch", "induced roll"];
    for k in 0..6 {
        let (mut bad_q, mut bad_rate) = (q, rate);
        (bad_q[k], bad_rate[k]) = (f64::NAN, f64::INFINITY);
        for (q, rate) in [(bad_q, rate), (q, bad_rate)] {
            let error = accelerations(&plant, &q, &rate, [0.0; 3], &flow).unwrap_err();
            assert!(error.to_string().starts_with(names[k]), "{error}");
        }
    }
    let mut bad = q;
    bad[0] = 0.0;
    let error = accelerations(&plant, &bad, &rate, [0.0; 3], &flow).unwrap_err();
    assert!(error.to_string().contains("coincide"), "{error}");
    bad[0] = 0.3;
    for length in [0.0, -0.1] {
        bad[3] = length;
        let error = accelerations(&plant, &bad, &rate, [0.0; 3], &flow).unwrap_err();
        assert!(error.to_string().contains("more than zero"), "{error}");
    }
    let error = accelerations(&plant, &q, &rate, [0.0, f64::NAN, 0.0], &flow).unwrap_err();
    assert!(matches!(error, Error::Argument { .. }), "{error}");
    let error = accelerations(&plant, &q, &rate, [0.0; 3], &Flow::straight(-1.0)).unwrap_err();
    assert!(error.to_string().contains("flow speed"), "{error}");
}

#[test]
fn numbers_that_are_not_finite_do_not_vanish_on_the_way() {
    // The kernel checks nothing, so whatever it is given must show in what it returns.
    let plant = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    for k in 0..17 {
        let (mut state, mut command, mut flow) = (STATE, [0.0; 3], Flow::straight(0.2));
        match k {
            0..12 => state[k] = f64::NAN,
            12..15 => command[k - 12] = f64::NAN,
            15 => flow.speed_m_s = f64::NAN,
            _ => flow.direction_rad = f64::NAN,
        }
        let at = evaluate(&plant, &state, command, &flow);
        assert!(at.derivative.iter().any(|rate| !rate.is_finite()), "input {k} leaves {:?}", at.derivative);
    }
}

#[test]
fn still_fluid_is_a_state_like_any_other() {
    let plant = Plant::new(&everything(), Fidelity::STALLED_WITH_ADDED_MASS).unwrap();
    let mut rest = STATE;
    rest[3..6].fill(0.0);
    rest[9..].fill(0.0);
    let at = evaluate(&plant, &rest, [0.0; 3], &Flow::straight(0.0));
    assert!(at.derivative.iter().all(|rate| rate.is_finite()), "{:?}", at.derivative);
    assert!(at.tensions.named().iter().all(|line| line.1.is_finite()), "{:?}", at.tensions);
}
