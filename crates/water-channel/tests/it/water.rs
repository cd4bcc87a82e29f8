//! Water that moves: the statistics of the turbulence against their closed forms, the shedding, and flights through both.

use bat_dynamics::{Asymmetry, Flow, FlowHistory, FlowKnot, Transition};
use serde_json::Value;
use water_channel::{
    FlightRequest, FlightSettings, MovingWater, ProfileFile, Shedding, TestProfile, Turbine, Turbulence, WaterRow,
    WaterTable, Window, fly, fly_all, fly_seeded,
};

use crate::rigs::{assert_close, cost, first_row, fixture, flown, golden, kick, numbers, request_of, steps, text};

const SAMPLE_S: f64 = 0.025;
const GUSTS: Turbulence =
    Turbulence { intensity: 0.04, lateral_intensity: 0.03, vertical_intensity: 0.02, length_m: 0.1 };
const WAKE: Shedding = Shedding { strouhal: 0.2, width_m: 0.092, lift_coefficient: 0.15, plane_rad: 0.4 };

fn gusts(seed: u64) -> MovingWater {
    MovingWater { turbulence: Some(GUSTS), shedding: None, seed }
}

fn all(seed: u64) -> MovingWater {
    MovingWater { turbulence: Some(GUSTS), shedding: Some(WAKE), seed }
}

fn table(water: &MovingWater, flow: &FlowHistory, duration_s: f64) -> WaterTable {
    water.table(flow, duration_s, SAMPLE_S).unwrap()
}

fn components(row: &WaterRow) -> [f64; 3] {
    [row.along, row.lateral, row.upward]
}

/// Variance times correlation over a distance of `s` lengths.
fn closed_form(component: usize, s: f64) -> f64 {
    let intensity = [GUSTS.intensity, GUSTS.lateral_intensity, GUSTS.vertical_intensity][component];
    let correlation = if component == 0 { (-s).exp() } else { (1.0 - 0.5 * s) * (-s).exp() };
    intensity * intensity * correlation
}

#[test]
fn variance_and_autocorrelation_over_4000_seeds_are_those_of_dryden_also_across_a_step_of_the_speed() {
    const SEEDS: u64 = 4000;
    // 0.205 m/s for a second, then 0.285 m/s.
    let flow = steps(&[(0.0, 0.205, 0.0), (1.0, 0.285, 0.0)]);
    let gone = |k: usize| SAMPLE_S * (0.205 * k.min(40) as f64 + 0.285 * k.saturating_sub(40) as f64);
    let pairs = [(0, 0), (40, 40), (79, 79), (10, 11), (0, 12), (30, 50), (20, 60), (0, 79)];
    let mut sums = [[[0.0; 3]; 3]; 8];
    for seed in 0..SEEDS {
        let table = table(&gusts(seed), &flow, 2.0);
        for (sum, (a, b)) in sums.iter_mut().zip(pairs) {
            let (a, b) = (components(&table.rows()[a]), components(&table.rows()[b]));
            for i in 0..3 {
                for j in 0..3 {
                    sum[i][j] += a[i] * b[j];
                }
            }
        }
    }
    for (sum, (a, b)) in sums.iter().zip(pairs) {
        let s = (gone(b) - gone(a)) / GUSTS.length_m;
        for (i, row) in sum.iter().enumerate() {
            for (j, sum) in row.iter().enumerate() {
                let expected = if i == j { closed_form(i, s) } else { 0.0 };
                // The mean of n products of two Gaussian numbers: variance (R_ii R_jj + R_ij²)/n.
                let spread = ((closed_form(i, 0.0) * closed_form(j, 0.0) + expected * expected) / SEEDS as f64).sqrt();
                let found = sum / SEEDS as f64;
                assert_close(found, expected, 4.5 * spread, &format!("components {i}, {j} at samples {a}, {b}"));
            }
        }
    }
}

#[test]
fn periodogram_over_600_seeds_is_the_dryden_spectrum() {
    const SEEDS: u64 = 600;
    const N: usize = 1024;
    let (speed, duration_s) = (0.245, N as f64 * SAMPLE_S);
    let flow = FlowHistory::constant(Flow::straight(speed)).unwrap();
    let bins = [3_usize, 8, 20, 50, 120];
    let mut power = [[0.0; 3]; 5];
    for seed in 0..SEEDS {
        let table = table(&gusts(seed + 10_000), &flow, duration_s);
        for (power, bin) in power.iter_mut().zip(bins) {
            let mut sums = [[0.0; 2]; 3];
            for (k, row) in table.rows()[..N].iter().enumerate() {
                let (s, c) = (core::f64::consts::TAU * (bin * k % N) as f64 / N as f64).sin_cos();
                for (sum, gust) in sums.iter_mut().zip(components(row)) {
                    *sum = [sum[0] + c * gust, sum[1] + s * gust];
                }
            }
            for (power, [c, s]) in power.iter_mut().zip(sums) {
                *power += (c * c + s * s) / (N as f64 * SEEDS as f64);
            }
        }
    }
    for (power, bin) in power.iter().zip(bins) {
        for (i, found) in power.iter().enumerate() {
            // What a finite record of this correlation shows, exactly: no window, no aliasing to correct for.
            let step = speed * SAMPLE_S / GUSTS.length_m;
            let lag = |m: usize| {
                let turn = core::f64::consts::TAU * (bin * m % N) as f64 / N as f64;
                (1.0 - m as f64 / N as f64) * closed_form(i, m as f64 * step) * turn.cos()
            };
            let expected = closed_form(i, 0.0) + 2.0 * (1..N).map(lag).sum::<f64>();
            // A periodogram is exponentially distributed.
            let spread = expected / (SEEDS as f64).sqrt();
            assert_close(*found, expected, 4.5 * spread, &format!("component {i}, bin {bin}"));
            // The printed spectrum over the wave number, one-sided.
            let intensity = closed_form(i, 0.0);
            let k = GUSTS.length_m * core::f64::consts::TAU * bin as f64 / (duration_s * speed);
            let shape = if i == 0 { 2.0 / (1.0 + k * k) } else { (1.0 + 3.0 * k * k) / (1.0 + k * k).powi(2) };
            let printed = intensity * shape * GUSTS.length_m / (speed * SAMPLE_S);
            if bin <= 20 {
                assert_close(*found, printed, (4.5 / (SEEDS as f64).sqrt() + 0.06) * printed, "the printed spectrum");
            }
        }
    }
}

#[test]
fn seed_fixes_the_water_and_no_part_of_it_changes_another() {
    let flow = steps(&[(0.0, 0.245, 0.0)]);
    let of = |water: MovingWater| table(&water, &flow, 3.0);
    assert_eq!(of(all(5)), of(all(5)), "one seed, one water");
    let (five, six) = (of(all(5)), of(all(6)));
    let differ =
        |f: fn(&WaterRow) -> f64| five.rows().iter().zip(six.rows()).all(|(a, b)| f(a).to_bits() != f(b).to_bits());
    assert!(differ(|row| row.along) && differ(|row| row.lateral), "another seed is other turbulence");
    assert!(differ(|row| row.wake_right), "and another start phase");
    let only = of(MovingWater {
        turbulence: Some(Turbulence { intensity: 0.0, vertical_intensity: 0.0, ..GUSTS }),
        shedding: None,
        seed: 5,
    });
    for (a, b) in five.rows().iter().zip(only.rows()) {
        assert_eq!(
            [0.0, a.lateral, 0.0].map(f64::to_bits),
            components(b).map(f64::to_bits),
            "the lateral gusts by themselves"
        );
    }
    let longer = all(5).table(&flow, 6.0, SAMPLE_S).unwrap();
    assert_eq!(longer.rows()[..120], five.rows()[..120], "a longer test begins with the same water");
}

#[test]
fn wake_swings_at_the_strouhal_frequency_of_the_speed() {
    let water = MovingWater { turbulence: None, shedding: Some(WAKE), seed: 3 };
    let flow = steps(&[(0.0, 0.205, 0.0), (100.0, 0.285, 0.0)]);
    let table = table(&water, &flow, 200.0);
    let turns = |from: usize, to: usize| {
        let rows = &table.rows()[from..to];
        rows.windows(2).filter(|pair| pair[0].wake_right < 0.0 && pair[1].wake_right >= 0.0).count() as f64
    };
    for (from, to, speed) in [(0, 4000, 0.205), (4000, 8001, 0.285)] {
        let expected = WAKE.strouhal * speed / WAKE.width_m * 100.0;
        assert_close(turns(from, to), expected, 1.0, "turns in 100 s");
    }
    for row in table.rows() {
        assert_close(row.wake_up, row.wake_right * WAKE.plane_rad.tan(), 1e-15, "one plane");
        assert_eq!(components(row).map(f64::to_bits), [0; 3], "no gusts");
    }
    let largest = table.rows().iter().fold(0.0_f64, |most, row| most.max(row.wake_right.hypot(row.wake_up)));
    assert_close(largest, WAKE.lift_coefficient, 1e-4, "amplitude");
    // In gusts the phase follows the instantaneous speed: the integral of V (1 + u).
    let gusty = self::table(&all(3), &flow, 20.0);
    let mut phase = table.rows()[0].wake_right.atan2(0.0);
    let at = |row: &WaterRow| row.wake_right / (WAKE.lift_coefficient * WAKE.plane_rad.cos());
    let start = at(&gusty.rows()[0]).asin();
    let rising = at(&gusty.rows()[1]) > at(&gusty.rows()[0]);
    phase = if rising { start } else { core::f64::consts::PI - start } + 0.0 * phase;
    for pair in gusty.rows().windows(2) {
        let length = SAMPLE_S * 0.205 * (1.0 + 0.5 * (pair[0].along + pair[1].along));
        phase += core::f64::consts::TAU * WAKE.strouhal / WAKE.width_m * length;
        assert_close(at(&pair[1]), phase.sin(), 1e-9, "the phase is the integral of the speed");
    }
}

/// The phase is the integral of a speed that rises evenly: a quadratic in time.
#[test]
fn wake_follows_a_speed_that_changes_evenly() {
    let wake = Shedding { lift_coefficient: 1.0, plane_rad: 0.0, ..WAKE };
    let water = MovingWater { turbulence: None, shedding: Some(wake), seed: 5 };
    let knot = |from_s: f64, speed_m_s: f64| FlowKnot {
        from_s,
        flow: Flow::straight(speed_m_s),
        transition: Transition::Linear,
    };
    let flow = FlowHistory::new(vec![knot(0.0, 0.2), knot(20.0, 0.3)]).unwrap();
    let table = table(&water, &flow, 20.0);
    assert_close(table.sample_time_s(), SAMPLE_S, 0.0, "time between rows");
    let at = |row: &WaterRow| row.wake_right;
    let first = at(&table.rows()[0]).asin();
    let rising = at(&table.rows()[1]) > at(&table.rows()[0]);
    let first = if rising { first } else { core::f64::consts::PI - first };
    for (k, row) in table.rows().iter().enumerate() {
        let t = k as f64 * SAMPLE_S;
        let length = 0.2 * t + 0.5 * (0.1 / 20.0) * t * t;
        let phase = first + core::f64::consts::TAU * wake.strouhal / wake.width_m * length;
        assert_close(at(row), phase.sin(), 1e-9, "the phase is the integral of the speed");
    }
}

/// A table is flown with the sample time that it was made for, to a billionth of it.
#[test]
fn sample_time_of_a_table_is_that_of_the_controller() {
    let flow = steps(&[(0.0, 0.205, 0.0)]);
    let through = |sample_time_s: f64| {
        let rows = table(&gusts(1), &flow, 10.0).rows().to_vec();
        let profile = TestProfile::new(10.0, steps(&[(0.0, 0.205, 0.0)]), Vec::new()).unwrap();
        let water = WaterTable::new(sample_time_s, rows).unwrap();
        fly(&first_row(), &profile.with_water_table(water), &FlightSettings::with_steps(1))
    };
    assert!(through(SAMPLE_S * (1.0 + 1e-10)).is_ok());
    let error = through(SAMPLE_S * (1.0 + 1e-8)).unwrap_err().to_string();
    assert!(error.contains("sample time of the water") && error.contains("that of the controller"), "{error}");
}

fn short(duration_s: f64) -> TestProfile {
    let flow = steps(&[(0.0, 0.205, 0.0), (0.4 * duration_s, 0.245, 5.0)]);
    TestProfile::new(duration_s, flow, kick(1.0)).unwrap()
}

fn words<T: std::fmt::Debug>(value: &T) -> String {
    format!("{value:?}")
}

#[test]
fn water_without_strength_is_still_water_bit_for_bit() {
    let none = Turbulence { intensity: 0.0, lateral_intensity: 0.0, vertical_intensity: 0.0, length_m: 0.1 };
    let nothing =
        MovingWater { turbulence: Some(none), shedding: Some(Shedding { lift_coefficient: 0.0, ..WAKE }), seed: 9 };
    let still = short(6.0);
    let same = short(6.0).with_water(nothing).unwrap();
    assert!(same.water().is_none() && same == still, "the profile says nothing moves");
    assert_eq!(words(&flown(&first_row(), &still, 2)), words(&flown(&first_row(), &same, 2)));
    // The code for moving water, with zeros: the same to rounding.
    let zeros = WaterTable::new(SAMPLE_S, vec![WaterRow::default(); 241]).unwrap();
    let [a, b] = [still.clone(), still.with_water_table(zeros)].map(|profile| cost(&flown(&first_row(), &profile, 2)));
    assert_close(a, b, 1e-12 * a, "cost in water of zeros");
}

#[test]
fn moving_water_moves_pitch_and_roll_away_from_the_pulls() {
    let quiet = TestProfile::new(20.0, steps(&[(0.0, 0.245, 0.0)]), Vec::<Window>::new()).unwrap();
    let still = flown(&first_row(), &quiet, 2).integrals.gram;
    let moved = flown(&first_row(), &quiet.with_water(all(1)).unwrap(), 2).integrals.gram;
    for (term, name) in [(1, "pitch"), (2, "roll"), (0, "heading")] {
        assert!(
            still[term][term] < 1e-20 && moved[term][term] > 1e-10,
            "{name}: {} and {}",
            still[term][term],
            moved[term][term]
        );
    }
}

#[test]
fn error_of_the_cost_falls_with_the_fourth_power_of_the_step_in_moving_water() {
    let profile = short(12.0).with_water(all(2)).unwrap();
    let truth = cost(&flown(&first_row(), &profile, 32));
    let errors = [1, 2, 4].map(|steps| (cost(&flown(&first_row(), &profile, steps)) - truth).abs());
    for pair in errors.windows(2) {
        let slope = (pair[0] / pair[1]).log2();
        assert!((3.5..5.0).contains(&slope), "slope {slope} of the errors {errors:?}");
    }
    assert!(errors[1] < 1e-6 * truth, "two steps: {errors:?} of {truth}");
}

#[test]
fn flights_in_moving_water_match_an_independent_integration_at_tight_tolerance() {
    let file = golden("water-channel/moving_water.json");
    let rows = file["header"]["table"].as_array().unwrap().iter().map(|row| {
        let row = numbers(row);
        WaterRow { along: row[0], lateral: row[1], upward: row[2], wake_right: row[3], wake_up: row[4] }
    });
    let water = WaterTable::new(SAMPLE_S, rows.collect()).unwrap();
    let flow = steps(&[(0.0, 0.245, 0.0), (10.0, 0.285, 0.15_f64.to_degrees())]);
    let pull = vec![Window { from_s: 4.0, to_s: 5.0, commands: [0.0, 0.0, -1.0] }];
    let turbine =
        Turbine { area_m2: 0.005, power_coefficient: 0.4, cut_in_m_s: 0.1, rated_power_w: 0.02, winch_efficiency: 0.8 };
    let profile = TestProfile::new(20.0, flow, pull).unwrap().with_water_table(water).with_turbine(turbine).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let request = moving_case(case);
        let flight = flown(&request, &profile, 8);
        let start = numbers(&case["start"]);
        for (k, (found, expected)) in flight.trim.state.iter().zip(start).enumerate() {
            assert_close(*found, expected, 1e-9, &format!("state {k} at the start of {}", case["name"]));
        }
        for (found, expected) in flight.final_state.iter().zip(numbers(&case["final_state"])) {
            assert_close(*found, expected, 2e-7, &format!("final state of {}", case["name"]));
        }
        for (row, expected) in flight.integrals.gram.iter().zip(case["gram"].as_array().unwrap()) {
            for (found, expected) in row.iter().zip(numbers(expected)) {
                assert_close(*found, expected, 1e-6 * expected.abs(), &format!("Gram matrix of {}", case["name"]));
            }
        }
        let heading = case["integral_psi_error_squared"].as_f64().unwrap();
        assert_close(flight.integrals.heading_squared, heading, 1e-6 * heading, "heading");
        let energy = flight.energy.unwrap();
        for (what, found) in [("turbine", energy.turbine_j), ("winches", energy.winches_j)] {
            let expected = case[what].as_f64().unwrap();
            assert_close(found, expected, 1e-6 * expected, &format!("energy of the {what} of {}", case["name"]));
        }
    }
}

fn moving_case(case: &Value) -> FlightRequest {
    let number = |name: &str| case[name].as_f64().unwrap();
    let mut full = case.clone();
    full["layout"] = "one-forward-two-aft".into();
    full["center_of_mass_x_pct_chord"] = 48.0.into();
    full["pitch_set_point_deg"] = 12.0.into();
    let mut request = request_of(&full);
    request.rig.plant.asymmetry = Asymmetry {
        center_of_mass_y_m: number("center_of_mass_y"),
        offset_lateral_m: number("offset_lateral"),
        incidence_difference_rad: number("incidence_difference"),
        line_port_m: number("line_port"),
        ..Asymmetry::default()
    };
    request
}

#[test]
fn flights_side_by_side_in_waters_of_their_own_have_the_bits_of_flights_alone() {
    let (profile, settings) = (short(5.0).with_water(all(0)).unwrap(), FlightSettings::default());
    let mut requests = vec![first_row(); 7];
    for (k, request) in requests.iter_mut().enumerate() {
        request.rig.set_points.pitch_rad += 0.01 * k as f64;
        request.rig.plant.asymmetry.center_of_mass_y_m = if k == 4 { 1e-3 } else { 0.0 };
    }
    let together = fly_all(&requests, &profile, &settings, |_| {});
    let alone: Vec<_> = requests.iter().map(|request| fly(request, &profile, &settings)).collect();
    assert_eq!(words(&together), words(&alone), "one water");
    let seeds = [4, 4, 8, 2, 2, 1, 0];
    let together = fly_seeded(&requests, &seeds, &profile, &settings, |_| {});
    let alone = requests
        .iter()
        .zip(seeds)
        .map(|(request, seed)| fly(request, &short(5.0).with_water(all(seed)).unwrap(), &settings));
    assert_eq!(words(&together), words(&alone.collect::<Vec<_>>()), "a water for each");
    for outcome in fly_seeded(&requests, &seeds[1..], &profile, &settings, |_| {}) {
        let error = outcome.unwrap_err().to_string();
        assert_eq!(error, "cannot start: number of seeds = 6: it must be one per request");
    }
}

#[test]
fn meaningless_water_is_refused_by_name() {
    let with = |turbulence: Turbulence| MovingWater { turbulence: Some(turbulence), shedding: None, seed: 0 };
    let sheds = |shedding: Shedding| MovingWater { turbulence: None, shedding: Some(shedding), seed: 0 };
    let cases = [
        (with(Turbulence { intensity: -0.01, ..GUSTS }), "intensity of the turbulence = -0.01"),
        (with(Turbulence { lateral_intensity: f64::NAN, ..GUSTS }), "lateral intensity"),
        (with(Turbulence { vertical_intensity: 0.6, ..GUSTS }), "vertical intensity"),
        (with(Turbulence { length_m: 0.0, ..GUSTS }), "length scale of the turbulence in m = 0"),
        (with(Turbulence { length_m: f64::INFINITY, ..GUSTS }), "length scale"),
        (sheds(Shedding { strouhal: -0.2, ..WAKE }), "Strouhal number"),
        (sheds(Shedding { width_m: 0.0, ..WAKE }), "width that sheds"),
        (sheds(Shedding { lift_coefficient: f64::NAN, ..WAKE }), "lift coefficient of the shedding"),
        (sheds(Shedding { plane_rad: f64::INFINITY, ..WAKE }), "plane of the shedding"),
    ];
    for (water, words) in cases {
        let error = short(5.0).with_water(water).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let rows = |count: usize| vec![WaterRow::default(); count];
    for (table, words) in [
        (WaterTable::new(0.0, rows(3)), "sample time of the water"),
        (WaterTable::new(SAMPLE_S, rows(1)), "rows of the water"),
        (WaterTable::new(SAMPLE_S, vec![WaterRow { along: f64::NAN, ..WaterRow::default() }; 2]), "number in a row"),
    ] {
        assert!(table.clone().unwrap_err().to_string().contains(words), "{table:?}");
    }
    for (table, words) in [
        (WaterTable::new(0.05, rows(101)).unwrap(), "that of the controller"),
        (WaterTable::new(SAMPLE_S, rows(200)).unwrap(), "one per sample of the test"),
    ] {
        let outcome = fly(&first_row(), &short(5.0).with_water_table(table), &FlightSettings::default());
        assert!(outcome.clone().unwrap_err().to_string().contains(words), "{outcome:?}");
    }
}

#[test]
fn water_of_a_profile_file_is_read_and_checked() {
    let number = |value: &str, unit: &str| {
        format!("{{ value = {value}, unit = \"{unit}\", provenance = \"estimated\", source = \"a guess\" }}")
    };
    let file = |intensity: &str, length: &str, width: &str| {
        format!(
            "{}\n[water]\nseed = 12\n[water.turbulence]\nintensity = {intensity}\nlateral_intensity = {}\nlength = {length}\n\
             [water.shedding]\nstrouhal = {}\nwidth = {width}\nlift_coefficient = {}\nplane = {}\n",
            text("bat/test-profile.toml"),
            number("0.02", "1"),
            number("0.2", "1"),
            number("0.1", "1"),
            number("90", "deg"),
        )
    };
    let good = [number("3", "%"), number("10", "cm"), number("92", "mm")];
    let read = ProfileFile::parse(&file(&good[0], &good[1], &good[2])).unwrap();
    let expected = MovingWater {
        turbulence: Some(Turbulence {
            intensity: 0.03,
            lateral_intensity: 0.02,
            vertical_intensity: 0.0,
            length_m: 0.1,
        }),
        shedding: Some(Shedding {
            strouhal: 0.2,
            width_m: 0.092,
            lift_coefficient: 0.1,
            plane_rad: core::f64::consts::FRAC_PI_2,
        }),
        seed: 12,
    };
    assert_eq!(read.profile.water(), Some(&expected));
    assert!(read.records.iter().any(|record| record.key == "water.turbulence.length"), "its numbers are records");
    for (texts, message) in [
        ([&number("-1", "%"), &good[1], &good[2]], "`water.turbulence.intensity` is -1 %: it must be from 0 to 0.5"),
        (
            [&good[0], &number("0", "m"), &good[2]],
            "`water.turbulence.length` is 0 m: it must be finite and more than zero",
        ),
        (
            [&good[0], &good[1], &number("0", "m")],
            "`water.shedding.width` is 0 m: it must be finite and more than zero",
        ),
    ] {
        let error = ProfileFile::parse(&file(texts[0], texts[1], texts[2])).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    let text = text("bat/test-profile.toml");
    let none = ProfileFile::parse(&format!("{text}\n[water]\nseed = 1\n")).unwrap().profile;
    assert_eq!(
        none,
        ProfileFile::read(fixture("bat/test-profile.toml")).unwrap().profile,
        "water in which nothing moves"
    );
    for (more, message) in [
        ("[water]\n", "missing key `water.seed`: a whole number, zero or more"),
        ("[water]\nseed = -3\n", "`water.seed` is -3: it must be a whole number, zero or more"),
        ("[water]\nseed = 0.5\n", "`water.seed` is 0.5: it must be a whole number, zero or more"),
        ("[water]\nseed = 1\nwaves = 2\n", "unknown key `water.waves`"),
    ] {
        let error = ProfileFile::parse(&format!("{text}\n{more}")).unwrap_err().to_string();
        assert!(error.starts_with(message), "{error}");
    }
}
