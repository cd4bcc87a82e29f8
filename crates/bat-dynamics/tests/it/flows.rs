//! Flow as a function of time.

use bat_dynamics::{Error, Flow, FlowHistory, FlowKnot, Transition};

fn knot(from_s: f64, speed_m_s: f64, direction_rad: f64, transition: Transition) -> FlowKnot {
    FlowKnot { from_s, flow: Flow { speed_m_s, direction_rad }, transition }
}

fn history() -> FlowHistory {
    FlowHistory::new(vec![
        knot(0.0, 0.2, 0.0, Transition::Step),
        knot(100.0, 0.3, 0.1, Transition::Linear),
        knot(110.0, 0.5, -0.1, Transition::Step),
        knot(120.0, 0.1, 0.2, Transition::Linear),
    ])
    .unwrap()
}

#[test]
fn flow_steps_at_its_knots_and_goes_linearly_where_asked() {
    let history = history();
    for (time_s, speed, direction) in [
        (-5.0, 0.2, 0.0),
        (0.0, 0.2, 0.0),
        (100.0_f64.next_down(), 0.2, 0.0),
        (100.0, 0.3, 0.1),
        (102.5, 0.35, 0.05),
        (105.0, 0.4, 0.0),
        (110.0, 0.5, -0.1),
        (119.0, 0.5, -0.1),
        // The last knot has no successor to go to: it holds.
        (120.0, 0.1, 0.2),
        (1e9, 0.1, 0.2),
    ] {
        let Flow { speed_m_s, direction_rad } = history.at(time_s);
        assert!((speed_m_s - speed).abs() < 1e-15, "speed {speed_m_s} at {time_s} s");
        assert!((direction_rad - direction).abs() < 1e-15, "direction {direction_rad} at {time_s} s");
    }
    assert_eq!(history.knots().len(), 4);
}

#[test]
fn piece_gives_the_flow_before_and_after_a_step() {
    let history = history();
    assert_eq!([0.0, 99.9, 100.0, 110.0, 500.0].map(|t| history.piece(t)), [0, 0, 1, 2, 3]);
    // At its end a piece still has its own formula: an integrator's last stage sees the flow before the step.
    assert_eq!(history.within(0, 100.0).speed_m_s, 0.2);
    assert_eq!(history.within(1, 110.0).speed_m_s, 0.5);
    assert_eq!(history.within(2, 120.0).speed_m_s, 0.5);
    assert_eq!(history.within(9, 130.0), history.at(130.0), "beyond the last piece");
}

#[test]
fn constant_flow_is_constant() {
    let flow = Flow { speed_m_s: 0.25, direction_rad: -0.3 };
    let history = FlowHistory::constant(flow).unwrap();
    assert_eq!([history.at(0.0), history.at(1e6)], [flow; 2]);
}

#[test]
fn histories_that_mean_nothing_are_refused_by_name() {
    use Transition::Step;
    let cases = [
        (vec![], "number of flow knots"),
        (vec![knot(1.0, 0.2, 0.0, Step)], "first flow knot"),
        (vec![knot(f64::NAN, 0.2, 0.0, Step)], "first flow knot"),
        (vec![knot(0.0, -0.2, 0.0, Step)], "flow speed"),
        (vec![knot(0.0, 0.2, f64::NAN, Step)], "flow direction"),
        (vec![knot(0.0, 0.2, 0.0, Step), knot(0.0, 0.3, 0.0, Step)], "time of a flow knot"),
        (vec![knot(0.0, 0.2, 0.0, Step), knot(f64::INFINITY, 0.3, 0.0, Step)], "time of a flow knot"),
        (vec![knot(0.0, 0.2, 0.0, Step), knot(5.0, f64::NAN, 0.0, Step)], "flow speed"),
    ];
    for (knots, name) in cases {
        let error = FlowHistory::new(knots).unwrap_err();
        assert!(matches!(error, Error::Argument { .. }) && error.to_string().contains(name), "{name}: {error}");
    }
    assert!(FlowHistory::constant(Flow::straight(f64::INFINITY)).is_err(), "infinite speed");
}
