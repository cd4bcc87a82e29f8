//! What is refused of cameras and dots, in files and by hand: the field, what it is, and what is allowed.

use water_channel::{
    Dot, FileError, FlightError, FlightSettings, Provenance, Region, RigFile, Sensing, SensingFile, Viewer, fly,
};

use super::{cameras, with};
use crate::rigs::{first_row, fixture, short_test, text};

#[track_caller]
fn file(from: &str, to: &str, message: &str) {
    let text = text("bat/sensing.toml");
    assert!(text.contains(from), "`{from}` is not in the file");
    let error = SensingFile::parse(&text.replacen(from, to, 1)).unwrap_err();
    assert_eq!(error.to_string(), message, "{error:?}");
}

#[track_caller]
fn by_hand(change: impl FnOnce(&mut Sensing), message: &str) {
    let mut sensing = cameras();
    change(&mut sensing);
    let error = Viewer::new(&sensing, [0.0; 3]).unwrap_err();
    assert_eq!(error.to_string(), message, "{error:?}");
    let refused = fly(&with(first_row(), sensing), &short_test(0.5), &FlightSettings::default());
    assert_eq!(refused, Err(FlightError::Start(error)), "a flight with them does not start");
}

#[test]
fn fixture_is_a_section_that_a_rig_file_may_have() {
    let read = SensingFile::read(fixture("bat/sensing.toml")).unwrap();
    assert_eq!((read.sensing.cameras.len(), read.sensing.dots.len()), (3, 10));
    assert!(read.records.iter().all(|record| record.provenance != Provenance::Calibrated), "nothing is fitted");
    let given = read.records.iter().filter(|record| record.provenance == Provenance::Given).count();
    assert_eq!(given, 3, "the three directions of Section 2.2");

    let text = text("bat/sensing.toml");
    let section = &text[text.find("[sensing]").unwrap()..];
    let rig = crate::rigs::text("bat/rig.toml");
    let with_cameras = RigFile::parse(&format!("{rig}\n{section}")).unwrap();
    assert_eq!(with_cameras.rig.sensing, Some(read.sensing));
    assert_eq!(with_cameras.records.len(), RigFile::parse(&rig).unwrap().records.len() + read.records.len());
    assert_eq!(RigFile::parse(&rig).unwrap().rig.sensing, None, "the rig of the fixtures sees the state");
}

#[test]
fn mistakes_in_a_file_are_named_with_their_key() {
    let focal = |value: &str| format!("focal_length = {{ value = {value}, unit = \"px\"");
    file(&focal("800"), &focal("0"), "`sensing.camera[0].focal_length` is 0 px: it must be finite and more than zero");
    file(
        "delay = { value = 1,",
        "delay = { value = 1.5,",
        "`sensing.delay` is 1.5 samples: it must be a whole number, zero or more",
    );
    file(
        "delay = { value = 1,",
        "delay = { value = 20000,",
        "sensing.delay = 20000 samples: it must be a whole number from 0 to 10000",
    );
    file(
        "pixel_noise = { value = 0.1,",
        "pixel_noise = { value = -0.1,",
        "`sensing.pixel_noise` is -0.1 px: it must be finite and zero or more",
    );
    file("seed = 1", "seed = -1", "`sensing.seed` is -1: it must be a whole number, zero or more");
    file(
        "name = \"side\"\n",
        "name = \"side\"\nexposure = 1\n",
        "unknown key `sensing.camera[0].exposure`; known here: bottom, focal_length, heading, height, left, name, pitch, right, \
         roll, top, width, x, y, z",
    );
}

#[test]
fn missing_parts_of_a_file_are_named() {
    let text = text("bat/sensing.toml");
    let head = &text[..text.find("[[sensing.camera]]").unwrap()];
    let message = |text: &str| SensingFile::parse(text).unwrap_err().to_string();
    assert_eq!(message(head), "sensing.camera = none: it must be at least one camera");
    let without_dots = &text[..text.find("[[sensing.dot]]").unwrap()];
    assert_eq!(
        message(without_dots),
        "sensing.dot = 0 dots: it must be at least 4 dots, since fewer leave the pose open"
    );
    let without_noise = text.replacen("pixel_noise", "# pixel_noise", 1);
    assert_eq!(
        message(&without_noise),
        "missing key `sensing.pixel_noise`: a table { value, unit, provenance, source }"
    );
    let error = SensingFile::read(fixture("bat/no-such-file.toml")).unwrap_err();
    assert!(matches!(error, FileError::Read { .. }), "{error}");
}

#[test]
fn mistakes_by_hand_are_named_with_their_field() {
    by_hand(
        |s| s.cameras[1].focal_length_px = 0.0,
        "sensing.camera[1].focal_length of `downstream` = 0 px: it must be finite and more than zero",
    );
    by_hand(
        |s| s.cameras[1].focal_length_px = f64::NAN,
        "sensing.camera[1].focal_length of `downstream` = NaN px: it must be finite and more than zero",
    );
    by_hand(
        |s| s.cameras[0].pose.position_m[2] = f64::INFINITY,
        "sensing.camera[0].z of `side` = inf: it must be finite",
    );
    by_hand(
        |s| s.cameras[0].width_px = -1.0,
        "sensing.camera[0].width of `side` = -1 px: it must be finite and more than zero",
    );
    by_hand(
        |s| s.cameras[2].region = Region { left_px: 300.0, right_px: 300.0, ..Region::whole(640.0, 480.0) },
        "sensing.camera[2].left and right of `below` = 300 and 300 px: it must be a region of interest within the image, \
         the first less than the second",
    );
    by_hand(
        |s| s.cameras[2].region = Region { right_px: 700.0, ..Region::whole(640.0, 480.0) },
        "sensing.camera[2].left and right of `below` = 0 and 700 px: it must be a region of interest within the image, \
         the first less than the second",
    );
    by_hand(|s| s.cameras.clear(), "sensing.camera = none: it must be at least one camera");
    by_hand(|s| s.dots.clear(), "sensing.dot = 0 dots: it must be at least 4 dots, since fewer leave the pose open");
    by_hand(
        |s| s.dots[3].position_m = s.dots[1].position_m,
        "sensing.dot[3].position = that of dot[1]: it must be at least 1e-6 m from every other dot",
    );
    by_hand(
        |s| s.dots[2] = Dot { normal: [0.0; 3], ..s.dots[2] },
        "sensing.dot[2].normal = [0.0, 0.0, 0.0]: it must be finite and not zero in all three components",
    );
    by_hand(
        |s| s.dots[2].position_m[0] = f64::NAN,
        "sensing.dot[2].position = [NaN, 0.04169, -0.02106] m: it must be finite",
    );
    by_hand(|s| s.pixel_noise_px = -0.1, "sensing.pixel_noise = -0.1 px: it must be finite and zero or more");
    by_hand(|s| s.quantization_px = f64::NAN, "sensing.quantization = NaN px: it must be finite and zero or more");
    by_hand(|s| s.delay_samples = 10_001, "sensing.delay = 10001 samples: it must be a whole number from 0 to 10000");
}
