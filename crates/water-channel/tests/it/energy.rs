//! Net energy: the power curve, what a flight gathers against its log, and a weight of zero.

use water_channel::{
    CostFile, Energy, FlightSettings, MovingWater, ProfileFile, TestProfile, Turbine, Turbulence, fly, fly_all,
    fly_logged,
};

use crate::rigs::{assert_close, first_row, flown, kick, short_test, steps, text};

const TURBINE: Turbine =
    Turbine { area_m2: 0.005, power_coefficient: 0.4, cut_in_m_s: 0.1, rated_power_w: 0.02, winch_efficiency: 0.8 };

#[test]
fn power_is_cubic_between_cut_in_and_rated_and_falls_with_the_cube_of_the_cosine() {
    let power = |speed: f64, cos: f64| TURBINE.power_w(1000.0, speed, cos);
    assert_close(power(0.2, 1.0), 0.5 * 1000.0 * 0.005 * 0.4 * 0.008, 1e-15, "cubic");
    assert_close(power(0.2, 0.5), power(0.1, 1.0), 1e-15, "misaligned");
    assert_close(power(0.1, 1.0), 0.5 * 1000.0 * 0.005 * 0.4 * 0.001, 1e-15, "at the cut-in speed");
    assert_close(power(0.3, 1.0), 0.02, 0.0, "rated");
    assert_close(power(0.099_999, 1.0), 0.0, 0.0, "below the cut-in speed");
    assert_close(power(0.3, -1.0), 0.0, 0.0, "from behind");
    // Reeling in against a tension takes power, paying out gives none back.
    assert_close(TURBINE.winch_power_w([2.0, 3.0, 1.0], [-0.01, 0.02, 0.0]), 0.025, 1e-17, "winches");
}

#[test]
fn flight_at_rest_gathers_the_power_of_its_trim() {
    let profile = TestProfile::new(10.0, steps(&[(0.0, 0.205, 0.0)]), Vec::new()).unwrap();
    let flight = flown(&first_row(), &profile.with_turbine(TURBINE).unwrap(), 2);
    let Energy { turbine_j, winches_j } = flight.energy.unwrap();
    let along = 0.205 * first_row().rig.set_points.pitch_rad.cos();
    assert_close(turbine_j, 10.0 * 0.5 * 1000.0 * 0.005 * 0.4 * along.powi(3), 1e-9, "turbine");
    assert!(winches_j.abs() < 1e-9, "nothing is reeled: {winches_j} J");
}

#[test]
fn energy_is_the_sum_over_the_log_and_changes_no_other_bit() {
    let water = MovingWater {
        turbulence: Some(Turbulence {
            intensity: 0.05,
            lateral_intensity: 0.03,
            vertical_intensity: 0.03,
            length_m: 0.1,
        }),
        shedding: None,
        seed: 4,
    };
    let test = TestProfile::new(12.0, steps(&[(0.0, 0.205, 0.0), (6.0, 0.245, 8.0)]), kick(1.0)).unwrap();
    for plain in [test.clone(), test.with_water(water).unwrap()] {
        let profile = plain.clone().with_turbine(TURBINE).unwrap();
        let (outcome, log) = fly_logged(&first_row(), &profile, &FlightSettings::default(), 1).unwrap();
        let flight = outcome.unwrap();
        let table = profile.water_table(0.025, None).unwrap();
        let (mut turbine, mut winches) = (0.0, 0.0);
        for (k, row) in log.rows.iter().enumerate() {
            let gust = table.as_ref().map_or(0.0, |table| table.rows()[k].along);
            // The shaft in the ground frame from the attitude, its share along the flow.
            let along = row.flow_speed_m_s * (1.0 + gust) * row.pitch_rad.cos() * row.heading_rad.cos();
            turbine += 0.025 * (0.5 * 1000.0 * 0.005 * 0.4 * along.powi(3)).min(0.02);
            for line in 0..3 {
                winches += 0.025 * (-row.tensions_n[line] * row.state[9 + line]).max(0.0) / 0.8;
            }
        }
        let energy = flight.energy.unwrap();
        assert_close(energy.turbine_j, turbine, 1e-12, "turbine");
        assert_close(energy.winches_j, winches, 1e-12, "winches");
        assert!(energy.winches_j > 1e-4, "the lines were pulled: {energy:?}");
        let without = flown(&first_row(), &plain, 2);
        assert!(without.energy.is_none(), "no turbine, no energy");
        assert_eq!(format!("{:?}", without.integrals), format!("{:?}", flight.integrals), "the same flight");
        let requests = vec![first_row(); 5];
        for beside in fly_all(&requests, &profile, &FlightSettings::default(), |_| {}) {
            assert_eq!(format!("{:?}", beside.unwrap()), format!("{flight:?}"), "in a lane");
        }
    }
}

#[test]
fn weight_of_zero_is_the_cost_of_before_and_others_count_net_energy_down() {
    let file = CostFile::parse(&text("bat/cost-chapter4.toml")).unwrap();
    assert_close(file.net_energy_per_w, 0.0, 0.0, "left out");
    let profile = short_test(5.0).with_turbine(TURBINE).unwrap();
    let flight = fly(&first_row(), &profile, &FlightSettings::default()).unwrap();
    let cost = file.weights.cost(&flight.integrals, 0.7);
    let energy = flight.energy.unwrap();
    assert_eq!(file.total(&cost, None).unwrap().to_bits(), cost.total.to_bits(), "no energy, no weight");
    assert_eq!(file.total(&cost, Some(&energy)).unwrap().to_bits(), cost.total.to_bits(), "no weight");
    let more = "\nk8_net_energy = { value = 2.5, unit = \"1/W\", provenance = \"estimated\", source = \"a guess\" }\n";
    let weighed = CostFile::parse(&(text("bat/cost-chapter4.toml") + more)).unwrap();
    let total = weighed.total(&cost, Some(&energy)).unwrap();
    assert_close(total, cost.total - 2.5 * (energy.turbine_j - energy.winches_j), 1e-12, "J less 2.5 E");
    let error = weighed.total(&cost, None).unwrap_err().to_string();
    assert_eq!(error, "weight of the net energy per W = 2.5: it must be zero where the test has no turbine");
}

#[test]
fn turbine_of_a_profile_file_is_read_and_checked() {
    let number = |value: &str, unit: &str| {
        format!("{{ value = {value}, unit = \"{unit}\", provenance = \"estimated\", source = \"a guess\" }}")
    };
    let file = |area: &str, efficiency: &str| {
        format!(
            "{}\n[turbine]\narea = {}\npower_coefficient = {}\ncut_in = {}\nrated_power = {}\nwinch_efficiency = {}\n",
            text("bat/test-profile.toml"),
            number(area, "cm^2"),
            number("0.4", "1"),
            number("0.1", "m/s"),
            number("0.02", "W"),
            number(efficiency, "1"),
        )
    };
    let profile = ProfileFile::parse(&file("50", "0.8")).unwrap().profile;
    assert_eq!(profile.turbine(), Some(&TURBINE));
    for (text, message) in [
        (file("0", "0.8"), "`turbine.area` is 0 cm^2: it must be finite and more than zero"),
        (file("50", "1.2"), "`turbine.winch_efficiency` is 1.2 1: it must be more than zero and at most 1"),
        (file("50", "0"), "`turbine.winch_efficiency` is 0 1: it must be more than zero and at most 1"),
    ] {
        assert_eq!(ProfileFile::parse(&text).unwrap_err().to_string(), message);
    }
    for (turbine, words) in [
        (Turbine { area_m2: f64::NAN, ..TURBINE }, "area of the turbine"),
        (Turbine { power_coefficient: -0.1, ..TURBINE }, "power coefficient of the turbine = -0.1"),
        (Turbine { cut_in_m_s: -1.0, ..TURBINE }, "cut-in speed"),
        (Turbine { rated_power_w: 0.0, ..TURBINE }, "rated power"),
        (Turbine { winch_efficiency: 0.0, ..TURBINE }, "efficiency of the winches"),
    ] {
        let error = short_test(5.0).with_turbine(turbine).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
