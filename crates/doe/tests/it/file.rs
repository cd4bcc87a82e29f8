//! Designs in CSV files: what is read, what is refused, and that nothing is lost on the way.

use doe::{Criterion, Design, DesignFile, Error, FileFault, Model, Parameter, Region, RunOrder, Space};
use proptest::prelude::*;

fn region() -> Region {
    Region::new(vec![
        Parameter::continuous("pitch", "deg", 10.0, 22.0).unwrap().with_levels(25).unwrap(),
        Parameter::continuous("mass", "kg", 1.0, 3.0).unwrap(),
        Parameter::continuous("gain", "", -0.5, 0.5).unwrap(),
    ])
    .unwrap()
}

fn read(text: &str) -> Result<Design, Error> {
    Design::read_csv(&region(), text.as_bytes()).map(|file| file.design)
}

#[track_caller]
fn check_refused(text: &str, messages: &[&str]) {
    let Err(Error::File { faults }) = read(text) else { panic!("{text} was read") };
    assert_eq!(faults.iter().map(ToString::to_string).collect::<Vec<_>>(), messages, "{text}");
}

#[test]
fn columns_may_be_in_any_order_with_units_and_company() {
    let expected = [-1.0, 0.0, 1.0, 1.0, -1.0, 0.0];
    for text in [
        "pitch,mass,gain\n10,2,0.5\n22,1,0\n",
        "gain, mass [kg],pitch [deg]\n0.5,2,10\n0,1,22\n",
        "# a comment\nnote,pitch [ deg ],mass,gain\nfirst,10,2,0.5\n\nsecond,22,1,0",
        "\u{feff}pitch,mass,gain []\r\n1e1,2.,.5\r\n22,1,-0\r\n",
    ] {
        assert_eq!(read(text).unwrap().coordinates(), expected, "{text}");
    }
    let file = Design::read_csv(&region(), "note,pitch,mass,gain,J\na,10,2,0.5,3\n".as_bytes()).unwrap();
    assert_eq!(file.ignored, ["note", "J"]);
}

#[test]
fn faults_of_the_header_name_the_column() {
    check_refused(
        "pitch,mas\n",
        &["no column `mass`, the columns are: pitch, mas", "no column `gain`, the columns are: pitch, mas"],
    );
    check_refused("pitch,mass,gain,mass [kg]\n", &["two columns `mass`, expected one"]);
    check_refused(
        "pitch [rad],mass [g],gain [s]\n",
        &[
            "column `pitch` is in rad, expected deg",
            "column `mass` is in g, expected kg",
            "column `gain` is in s, expected no unit",
        ],
    );
    for empty in ["", "\n\n", "# only a comment\n", " \n"] {
        check_refused(empty, &["the file is empty, expected a header with the names of the parameters"]);
    }
    let message = "the columns are separated by semicolons, expected commas, and decimal points in numbers";
    check_refused("pitch;mass;gain\n10,5;2,0;0,5\n", &[message]);
    check_refused("note;pitch [deg];mass [kg];gain\n;10;2;0\n", &[message]);
    check_refused("pitch\tmass\tgain\n10\t2\t0\n", &[&message.replace("semicolons", "tabs")]);
}

#[test]
fn faults_of_fields_name_line_and_column_all_at_once() {
    check_refused(
        "pitch,mass,gain\n10,2,0\n9.9,,0\n# half way\n\n10,\"2,5\",nan\n10,2,inf\n",
        &[
            "line 3, column `pitch`: 9.9, expected 10.0 to 22.0 deg",
            "line 3, column `mass`: nothing, expected a number",
            "line 6, column `mass`: \"2,5\", expected a finite number with a decimal point, not a comma",
            "line 6, column `gain`: \"nan\", expected a finite number",
            "line 7, column `gain`: \"inf\", expected a finite number",
        ],
    );
    check_refused("pitch,mass,gain\n10,2,0.6\n", &["line 2, column `gain`: 0.6, expected -0.5 to 0.5"]);
    check_refused("pitch,mass,gain\n", &["no runs after the header, expected at least one"]);
    check_refused(
        "pitch,mass,gain\n10,2\n# decimal commas\n10,5,2,0,0,5\n9,2,0\n",
        &[
            "line 2: 2 fields, expected 3 as in the header",
            "line 4: 6 fields, expected 3 as in the header (numbers with decimal commas?)",
            "line 5, column `pitch`: 9.0, expected 10.0 to 22.0 deg",
        ],
    );
    let Err(Error::File { faults }) = Design::read_csv(&region(), &[0xff, 0xfe, 0x00][..]) else { panic!("no text") };
    assert!(matches!(&faults[..], [FileFault::Unreadable { .. }]), "{faults:?}");
    let many = format!("pitch,mass,gain\n{}", "10,2,9\n".repeat(30));
    assert!(read(&many).unwrap_err().to_string().ends_with("; and 10 more"));
}

fn written(design: &Design, order: RunOrder) -> String {
    let mut bytes = Vec::new();
    design.write_csv(&region(), order, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn a_file_says_units_points_and_replicates() {
    let design = read("pitch,mass,gain\n10,2,0.5\n22,1.5,0\n10,2,0.5\n10,2,0.5\n").unwrap();
    let expected = "run,standard,point,replicate,pitch [deg],mass [kg],gain\n\
                    1,1,1,1,10,2,0.5\n2,2,2,1,22,1.5,0\n3,3,1,2,10,2,0.5\n4,4,1,3,10,2,0.5\n";
    assert_eq!(written(&design, RunOrder::Standard), expected);
}

#[test]
fn a_file_tells_runs_that_were_settled_from_new_ones() {
    let design = read("pitch,mass,gain\n10,2,0.5\n22,1.5,0\n12,2,0.5\n22,1.5,0\n").unwrap();
    let mut bytes = Vec::new();
    design.write_csv_with_kinds(&region(), RunOrder::Standard, 1, &mut bytes).unwrap();
    let expected = "run,standard,point,replicate,kind,pitch [deg],mass [kg],gain\n1,1,1,1,fixed,10,2,0.5\n\
                    2,2,2,1,new,22,1.5,0\n3,3,3,1,new,12,2,0.5\n4,4,2,2,replicate of 2,22,1.5,0\n";
    assert_eq!(String::from_utf8(bytes.clone()).unwrap(), expected);
    let back = Design::read_csv(&region(), &bytes[..]).unwrap();
    assert_eq!((back.design, back.ignored), (design, Vec::<String>::new()));
}

#[test]
fn a_rounded_design_reads_back_to_the_same_efficiency() {
    let (model, space) = (Model::quadratic(3).unwrap(), Space::of_region(&region()).unwrap());
    let angle = |i: u32| (f64::from(i * i) * 0.7).sin();
    let runs: Vec<[f64; 3]> = (0..14).map(|i| [f64::from(i % 5) / 2.0 - 1.0, angle(3 * i), angle(3 * i + 1)]).collect();
    let design = Design::from_runs(&runs).unwrap();
    let rounded = design.rounded(&region(), &space, 2).unwrap();
    assert_eq!(rounded.coordinates()[..6], design.coordinates()[..6], "settled runs stay as they are");
    let text = written(&rounded, RunOrder::Standard);
    for line in text.lines().skip(3) {
        for field in line.split(',').skip(4) {
            let digits = field.trim_start_matches(['-', '0', '.']).chars().filter(char::is_ascii_digit).count();
            assert!(digits <= 9, "{line}");
        }
    }
    let g = |design: &Design| Criterion::G.efficiency(&model, &space, design).unwrap().percent;
    assert!((g(&read(&text).unwrap()) - g(&rounded)).abs() < 1e-9);
    assert!((g(&design) - g(&rounded)).abs() < 1e-5, "nobody notices");
}

#[test]
fn settings_are_written_as_short_as_a_rig_can_be_set() {
    let pitch = |coded: f64| {
        let text = written(&Design::new(3, vec![1.0, coded, 0.0]).unwrap(), RunOrder::Standard);
        text.lines().nth(1).unwrap().split(',').nth(5).unwrap().to_owned()
    };
    assert_eq!(pitch(-1.0 + 1e-13), "1");
    assert_eq!(pitch(1.0 - 1e-13), "3");
    assert_eq!(pitch(0.123_456_789_012_345), "2.123456789");
    // Rounded, this bound would be passed: it is written in full.
    let region = Region::new(vec![Parameter::continuous("x", "", 0.0, 2.0 / 3.0).unwrap()]).unwrap();
    let mut bytes = Vec::new();
    Design::new(1, vec![1.0]).unwrap().write_csv(&region, RunOrder::Standard, &mut bytes).unwrap();
    assert_eq!(Design::read_csv(&region, &bytes[..]).unwrap().design.coordinates(), [1.0]);
}

#[test]
fn a_random_order_is_a_permutation_that_the_seed_decides() {
    let runs: Vec<[f64; 3]> = (0..20).map(|i| [f64::from(i) / 19.0, 0.0, 0.0]).collect();
    let design = Design::from_runs(&runs).unwrap();
    let shuffled = |seed| written(&design, RunOrder::Random { seed });
    assert_eq!(shuffled(4), shuffled(4));
    assert_ne!(shuffled(4), shuffled(5));
    let mut standard: Vec<usize> =
        shuffled(4).lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert_ne!(standard, (1..=20).collect::<Vec<_>>());
    standard.sort_unstable();
    assert_eq!(standard, (1..=20).collect::<Vec<_>>());
}

#[test]
fn every_order_comes_first_equally_often() {
    // 24 orders of 4 runs, 2,400 seeds: 100 each, give or take 10; 5 sigma are 50.
    let design = Design::from_runs(&[[-1.0; 3], [0.0; 3], [0.5; 3], [1.0; 3]]).unwrap();
    let mut counts = std::collections::BTreeMap::new();
    for seed in 0..2400 {
        *counts.entry(written(&design, RunOrder::Random { seed })).or_insert(0) += 1;
    }
    assert_eq!(counts.len(), 24);
    assert!(counts.values().all(|count| (50..=150).contains(count)), "{:?}", counts.values());
}

#[test]
fn reserved_and_foreign_names_are_refused() {
    let region = Region::new(vec![Parameter::continuous("run", "", 0.0, 1.0).unwrap()]).unwrap();
    let error = Design::new(1, vec![0.0]).unwrap().write_csv(&region, RunOrder::Standard, Vec::new()).unwrap_err();
    assert!(error.to_string().starts_with("a parameter is called `run`"), "{error}");
    let error =
        Design::new(1, vec![0.0]).unwrap().write_csv(&self::region(), RunOrder::Standard, Vec::new()).unwrap_err();
    assert!(
        matches!(error, Error::DesignSpace(doe::DesignSpaceError::WrongDimension { expected: 3, found: 1, .. })),
        "{error}"
    );
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(flat in prop::collection::vec(-1.0..=1.0, 3..30), seed: u64) {
        let flat = &flat[..flat.len() / 3 * 3];
        let design = Design::new(3, flat.to_vec()).unwrap();
        let back = read(&written(&design, RunOrder::Standard)).unwrap();
        for (x, y) in back.coordinates().iter().zip(design.coordinates()) {
            // A continuous value is rounded to 1e-10 of its range, a value this near a level is the level.
            prop_assert!((x - y).abs() <= 2e-9);
        }
        for (x, y) in back.natural(&region()).unwrap().iter().flatten().zip(design.natural(&region()).unwrap().iter().flatten()) {
            prop_assert!((x - y).abs() <= 1e-9);
        }
        prop_assert_eq!(read(&written(&design, RunOrder::Random { seed })).unwrap().n_runs(), design.n_runs());
    }
}

proptest! {
    /// One rule rounds both, so the file holds the design that was rounded and evaluated.
    #[test]
    fn a_rounded_design_is_written_as_it_is(
        flat in prop::collection::vec(-1.0..=1.0_f64, 12),
        (widths_away, log_width) in (-1e3..1e3_f64, -3.0..6.0_f64),
    ) {
        let lower = widths_away * 10.0_f64.powf(log_width);
        let upper = lower + 10.0_f64.powf(log_width);
        let parameters = vec![
            Parameter::continuous("x", "", lower, upper).unwrap(),
            Parameter::continuous("y", "m", 0.0, 2.0 / 3.0).unwrap(),
            Parameter::continuous("z", "m", -1.0, 1.0).unwrap().with_levels(7).unwrap(),
        ];
        let region = Region::new(parameters).unwrap();
        let space = doe::Space::of_region(&region).unwrap();
        let runs: Vec<f64> = flat
            .chunks_exact(3)
            .flat_map(|run| [run[0], run[1], (3.0 * run[2]).round() / 3.0])
            .collect();
        let rounded = Design::new(3, runs.clone()).unwrap().rounded(&region, &space, 0).unwrap();
        let mut bytes = Vec::new();
        rounded.write_csv(&region, RunOrder::Standard, &mut bytes).unwrap();
        let back = Design::read_csv(&region, &bytes[..]).unwrap().design;
        for (x, y) in back.coordinates().iter().zip(rounded.coordinates()) {
            prop_assert_eq!(x.to_bits(), y.to_bits(), "{} and {}", x, y);
        }
        for (x, y) in rounded.coordinates().iter().zip(&runs) {
            prop_assert!((x - y).abs() <= 2.1e-8, "{} for {}", x, y);
        }
    }
}

/// A reader does not see spaces around a name, and takes brackets for a unit.
#[test]
fn what_is_written_can_be_read_back_or_is_refused() {
    let region = |names: [(&str, &str); 2]| {
        let parameters = names.map(|(name, unit)| Parameter::continuous(name, unit, 0.0, 1.0).unwrap());
        Region::new(parameters.to_vec())
    };
    let written = |region: &Region| {
        let mut text = Vec::new();
        let design = Design::new(2, vec![-1.0, 0.5]).unwrap();
        design.write_csv(region, RunOrder::Standard, &mut text).map(|()| text)
    };
    for names in [[("a", ""), ("b ", "")], [(" a", "m"), ("ab", "m")], [("a", "m"), ("a b", "")]] {
        let region = region(names).unwrap();
        let text = written(&region).unwrap();
        let read = Design::read_csv(&region, &text[..]).unwrap().design;
        assert_eq!(read.coordinates(), [-1.0, 0.5], "{names:?}");
    }
    for names in [[("a", ""), ("a ", "")], [("a", "m"), ("a [m]", "")], [("a", ""), (" a", "m")]] {
        let Ok(region) = region(names) else { continue };
        let error = written(&region).unwrap_err().to_string();
        assert!(error.contains("cannot be told from another in the header of a file"), "{names:?}: {error}");
    }
}

/// What a search leaves of a bound or of the middle is not a setting that anyone can make.
#[test]
fn last_bits_of_a_search_are_written_as_what_they_are_beside_the_width() {
    for (lower, upper, coded, expected) in [
        (0.0, 10.0, -1.0 + 1.5e-12, "0"),
        (-10.0, 10.0, -2.6e-12, "0"),
        (0.0, 10.0, 2.0 / 3.0, "8.333333333"),
        (1e6, 1e6 + 1e-3, -0.2, "1000000.0004"),
        (0.0, 3e-7, 1.0 / 3.0 + 1e-12, "0.0000002"),
        (0.0, 10.0, 1.0 - 1e-13, "10"),
    ] {
        let region = Region::new(vec![Parameter::continuous("a", "mm", lower, upper).unwrap()]).unwrap();
        let design = Design::new(1, vec![coded]).unwrap();
        let mut text = Vec::new();
        design.write_csv(&region, RunOrder::Standard, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let written = text.lines().last().and_then(|line| line.rsplit(',').next());
        assert_eq!(written, Some(expected), "{coded} of {lower} to {upper}");
        let rounded = design.rounded(&region, &doe::Space::of_region(&region).unwrap(), 0).unwrap();
        let natural = rounded.natural(&region).unwrap()[0][0];
        let error = (natural - expected.parse::<f64>().unwrap()).abs();
        assert!(error <= 1e-8 * (upper - lower) + 4.0 * f64::EPSILON * upper.abs(), "{natural}");
        assert!(expected != "0" || error <= 0.0, "{natural}");
    }
}

/// A region may hold a choice, whose column holds places.
#[test]
fn a_place_between_two_choices_is_named_with_its_line() {
    let hull = Parameter::categorical("hull", ["foam", "film", "wood"]).unwrap();
    let region = Region::new(vec![hull]).unwrap();
    let read = |text: &str| Design::read_csv(&region, text.as_bytes());
    assert_eq!(read("hull\n1\n2\n").unwrap().design.coordinates(), [0.0, 1.0], "places");
    let Err(Error::File { faults }) = read("hull\n1.4\n2\n3\n") else { panic!("1.4 was read") };
    assert_eq!(
        faults.iter().map(ToString::to_string).collect::<Vec<_>>(),
        [
            "line 2, column `hull`: 1.4, expected the place of a choice: 0 (foam), 1 (film) or 2 (wood)",
            "line 4, column `hull`: 3.0, expected 0.0 to 2.0",
        ]
    );
}

#[test]
fn what_a_file_gave_returns_from_json() {
    let file = Design::read_csv(&region(), "note,pitch,mass,gain,J\na,10,2,0.5,3\n".as_bytes()).unwrap();
    let text = serde_json::to_string(&file).unwrap();
    assert_eq!(serde_json::from_str::<DesignFile>(&text).unwrap(), file, "{text}");
}
