//! The log: units in its header, numbers that read back bit for bit, the same flight with and without it.

use std::hash::{DefaultHasher, Hash, Hasher};

use water_channel::{FlightLog, FlightSettings, LogRow, fly, fly_logged, footprint_m2};

use crate::rigs::{assert_close, first_row, logged, short_test};

fn csv(log: &FlightLog) -> Vec<u8> {
    let mut bytes = Vec::new();
    log.write_csv(&mut bytes).unwrap();
    bytes
}

fn numbers(row: &LogRow) -> Vec<f64> {
    let mut all = vec![
        row.time_s,
        row.flow_speed_m_s,
        row.flow_direction_rad,
        row.altitude_m,
        row.lateral_m,
        row.roll_rad,
        row.pitch_rad,
        row.heading_rad,
        row.pitch_error_rad,
        row.roll_error_rad,
        row.altitude_error_m,
    ];
    all.extend(row.state);
    all.extend(row.commands_m_s);
    all.extend(row.tensions_n);
    all
}

#[test]
fn header_names_every_column_with_its_unit() {
    let header = FlightLog::header();
    assert_eq!(header.len(), 29, "columns");
    assert_eq!(FlightLog::columns()[28], ("tension_port".to_owned(), "N"));
    assert_eq!(header[0], "time [s]");
    assert_eq!(header[7], "heading_from_flow [rad]");
    assert_eq!(header[11], "zenith [rad]");
    assert_eq!(header[25], "command_port [m/s]");
    assert_eq!(header[28], "tension_port [N]");
    for name in &header {
        let (column, unit) = name.split_once(" [").unwrap();
        assert!(!column.is_empty() && unit.ends_with(']'), "{name}");
        assert!(["s]", "m]", "m/s]", "rad]", "rad/s]", "N]"].contains(&unit), "unit of {name}");
    }
    let mut names = header.clone();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), header.len(), "no name twice");
}

#[test]
fn csv_reads_back_bit_for_bit() {
    let log = logged(&first_row(), &short_test(5.0));
    let bytes = csv(&log);
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(header, FlightLog::header());
    let mut n_rows = 0;
    for (record, row) in reader.records().zip(&log.rows) {
        let read: Vec<u64> = record.unwrap().iter().map(|field| field.parse::<f64>().unwrap().to_bits()).collect();
        let written: Vec<u64> = numbers(row).iter().map(|number| number.to_bits()).collect();
        assert_eq!(row.numbers().map(f64::to_bits).collect::<Vec<_>>(), written, "t = {}", row.time_s);
        assert_eq!(read, written, "t = {}", row.time_s);
        n_rows += 1;
    }
    assert_eq!(n_rows, 200, "a row per sample");
}

/// Check 39: the same build gives the same log, whatever ran before.
#[test]
fn log_has_the_same_hash_in_every_run() {
    let hash = || {
        let mut hasher = DefaultHasher::new();
        csv(&logged(&first_row(), &short_test(20.0))).hash(&mut hasher);
        hasher.finish()
    };
    let first = hash();
    for _ in 0..3 {
        assert_eq!(hash(), first, "hash of the log");
    }
}

#[test]
fn logging_does_not_change_the_flight() {
    let (request, profile) = (first_row(), short_test(8.0));
    for steps in [1, 2, 3] {
        let settings = FlightSettings::with_steps(steps);
        let plain = fly(&request, &profile, &settings).unwrap();
        for every in [1, 7] {
            let (outcome, _) = fly_logged(&request, &profile, &settings, every).unwrap();
            assert_eq!(format!("{:?}", outcome.unwrap()), format!("{plain:?}"), "every {every}-th sample");
        }
    }
}

#[test]
fn thinned_log_keeps_every_nth_sample_from_the_first() {
    let (request, profile) = (first_row(), short_test(5.0));
    let all = logged(&request, &profile);
    let (_, thin) = fly_logged(&request, &profile, &FlightSettings::default(), 7).unwrap();
    let expected: Vec<LogRow> = all.rows.iter().step_by(7).copied().collect();
    assert_eq!(thin.rows, expected);
}

#[test]
fn log_starts_at_trim_and_its_errors_are_those_of_its_angles() {
    let request = first_row();
    let log = logged(&request, &short_test(5.0));
    let set = request.rig.set_points;
    assert_close(log.rows[0].altitude_m, set.altitude_m, 1e-12, "altitude at trim");
    for (k, row) in log.rows.iter().enumerate() {
        assert_close(row.time_s, 0.025 * k as f64, 1e-12, "time");
        assert_close(row.pitch_error_rad, row.pitch_rad - set.pitch_rad, 0.0, "pitch error");
        assert_close(row.roll_error_rad, row.roll_rad - set.roll_rad, 0.0, "roll error");
        assert_close(row.altitude_error_m, set.altitude_m - row.altitude_m, 0.0, "altitude error");
        assert!(row.commands_m_s.iter().all(|speed| speed.abs() <= 0.01030184), "beyond the limit: {row:?}");
    }
}

#[test]
fn extremes_are_those_of_the_log() {
    let (outcome, log) = fly_logged(&first_row(), &short_test(20.0), &FlightSettings::default(), 1).unwrap();
    let extremes = outcome.unwrap().extremes;
    let over = |f: &dyn Fn(&LogRow) -> f64| log.rows.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
    assert_close(extremes.peak_heading_rad, over(&|row| row.heading_rad.abs()), 0.0, "peak heading");
    assert_close(extremes.largest_zenith_rad, over(&LogRow::zenith_rad), 0.0, "largest zenith angle");
    assert_close(extremes.smallest_zenith_rad, -over(&|row| -row.zenith_rad()), 0.0, "smallest zenith angle");
    let smallest = -over(&|row| -row.tensions_n.iter().copied().fold(f64::INFINITY, f64::min));
    assert_close(extremes.smallest_tension_n, smallest, 0.0, "smallest tension");
}

#[test]
fn footprint_is_the_circle_under_the_tether() {
    // 61 m of tether at 30 degrees sweep a circle of 30.5 m.
    assert_close(footprint_m2(61.0, 30f64.to_radians()), 2922.467, 1e-3, "footprint in m2");
    let trim = crate::rigs::flown(&first_row(), &short_test(0.5), 1);
    let (length, zenith) = (trim.trim.coordinates[3], trim.trim.coordinates[0]);
    assert_close(trim.trim_footprint_m2(), footprint_m2(length, zenith), 0.0, "footprint at trim");
    let at_trim = logged(&first_row(), &short_test(0.5)).rows[0].footprint_m2();
    assert_close(at_trim, footprint_m2(length, zenith), 1e-3 * at_trim, "of the three lines, the first row of the log");
}
