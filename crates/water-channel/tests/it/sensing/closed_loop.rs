//! Flights with cameras: the controller reads estimates, late, noisy and sometimes held.

use bat_dynamics::{Fidelity, Plant, driven_of_lines, rotation, translation};
use rayon::ThreadPoolBuilder;
use water_channel::{
    Control, Error, FlightError, FlightLog, FlightRequest, FlightSettings, Hold, PixelNoise, Pose, Sensing,
    TestProfile, Tracker, fly, fly_all, fly_logged,
};

use super::{MIDDLE, cameras, distance, perfect, viewer, with};
use crate::rigs::{assert_close, cost, first_row, flown, kick, logged, request, short_test, steps};

/// Fifteen seconds with a turning flow, so that heading and position are relative to nothing simple.
fn turning_test() -> TestProfile {
    TestProfile::new(15.0, steps(&[(0.0, 0.245, 0.0), (6.0, 0.265, 12.0)]), kick(1.0)).unwrap()
}

fn csv(log: &FlightLog) -> String {
    let mut bytes = Vec::new();
    log.write_csv(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn perfect_cameras_fly_as_the_state_does() {
    for fidelity in [Fidelity::NUMERICAL, Fidelity::STALLED_WITH_ADDED_MASS] {
        let request = request(fidelity, 46.1, 17.3);
        let (state, seen) = (flown(&request, &turning_test(), 2), flown(&with(request, perfect()), &turning_test(), 2));
        assert_close(cost(&seen), cost(&state), 1e-8 * cost(&state), "J");
    }
}

/// Position and attitude of the center of mass in the ground frame, by the maps (5) and (6) of the coordinates.
fn pose_of(plant: &Plant, q: &[f64; 6]) -> Pose {
    let [x, y, z, ..] = translation(plant, q, &[0.0; 6]);
    let [roll_rad, pitch_rad, heading_rad, ..] = rotation(plant, q, &[0.0; 6]);
    Pose { position_m: [x, y, z], roll_rad, pitch_rad, heading_rad }
}

#[test]
fn estimates_are_the_state_in_the_ground_frame() {
    let request = with(first_row(), perfect());
    let plant = request.rig.plant(request.fidelity).unwrap();
    let columns = FlightLog::camera_columns();
    let place = |name: &str| columns.iter().position(|(column, _)| column == name).unwrap();
    for row in &logged(&request, &turning_test()).rows {
        let [zenith, azimuth, twist, .., l1, l2, l3, _, _, _] = row.state;
        let [length, pitch, roll] = driven_of_lines(&plant, [l1, l2, l3]);
        let truth = pose_of(&plant, &[zenith, azimuth, twist, length, pitch, roll]);
        let reported = row.estimate.unwrap().pose;
        assert!(distance(&reported, &truth) < 1e-9, "t = {}: {reported:?} and {truth:?}", row.time_s);

        let written: Vec<f64> = row.camera_numbers().collect();
        for (name, number) in [
            ("estimated_x", reported.position_m[0]),
            ("estimated_y", reported.position_m[1]),
            ("estimated_altitude", -reported.position_m[2]),
            ("estimated_roll", reported.roll_rad),
            ("estimated_pitch", reported.pitch_rad),
            ("estimated_heading", reported.heading_rad),
        ] {
            assert_close(written[place(name)], number, 0.0, name);
        }
    }
}

/// The dots of a rig sit where the bridle joint says, though its poses are those of the center of mass.
#[test]
fn dots_of_a_rig_hang_on_its_bridle_joint() {
    let request = with(request(Fidelity::NUMERICAL, 49.0, 12.0), perfect());
    let plant = request.rig.plant(request.fidelity).unwrap();
    let q = [0.25, -0.1, 0.2, 0.6, 0.05, -0.15];
    let center = pose_of(&plant, &q);
    let ((sin_zenith, cos_zenith), (sin_azimuth, cos_azimuth)) = (q[0].sin_cos(), q[1].sin_cos());
    let joint_m = [sin_zenith * cos_azimuth, sin_zenith * sin_azimuth, cos_zenith].map(|x| -q[3] * x);
    let joint = Pose { position_m: joint_m, ..center };

    let of_rig = request.rig.viewer().unwrap().unwrap().look(&center, &mut PixelNoise::new(1));
    let of_joint = viewer(&perfect()).look(&joint, &mut PixelNoise::new(1));
    assert_eq!(of_rig.sightings().len(), of_joint.sightings().len(), "dots seen");
    for (a, b) in of_rig.sightings().iter().zip(of_joint.sightings()) {
        assert_close(a.pixel[0], b.pixel[0], 1e-9, "u");
        assert_close(a.pixel[1], b.pixel[1], 1e-9, "v");
    }
}

#[test]
fn without_cameras_there_are_no_columns_of_theirs() {
    let plain = csv(&logged(&first_row(), &short_test(1.0)));
    let header = plain.lines().next().unwrap();
    assert_eq!(header.split(',').count(), 29, "{header}");
    let seen = csv(&logged(&with(first_row(), cameras()), &short_test(1.0)));
    let more = seen.lines().next().unwrap();
    assert_eq!(
        more.strip_prefix(header).unwrap(),
        ",estimated_x [m],estimated_y [m],estimated_altitude [m],estimated_roll [rad],estimated_pitch [rad],\
         estimated_heading [rad],dots_seen [1],cameras_seeing [1],hold [1]"
    );
    assert!(seen.lines().all(|line| line.split(',').count() == 38), "nine more in every row");
    assert!(seen.lines().nth(1).unwrap().ends_with(",0,0,4"), "no image has come at the first sample");
    assert!(seen.lines().nth(2).unwrap().ends_with(",10,3,0"), "all dots are seen");
}

#[test]
fn delay_is_exactly_a_shift() {
    // In open loop the body does not notice what is reported of it.
    let profile = short_test(6.0).with_control(Control::OpenLoop);
    let reported = |delay_samples: usize| {
        let sensing = Sensing { delay_samples, ..cameras() };
        let log = logged(&with(first_row(), sensing), &profile);
        log.rows.iter().map(|row| row.estimate.unwrap()).collect::<Vec<_>>()
    };
    let at_once = reported(0);
    for delay in [1, 7] {
        let late = reported(delay);
        assert_eq!(late[delay..], at_once[..at_once.len() - delay], "{delay} samples late");
        for early in &late[..delay] {
            assert_eq!((early.hold, early.dots_seen), (Some(Hold::NoImageYet), 0));
            assert!(distance(&early.pose, &late[0].pose) <= 0.0, "the start");
        }
    }
}

#[test]
fn delay_of_a_tracker_is_exactly_a_shift() {
    let pose = |k: usize| Pose { heading_rad: 0.01 * k as f64, ..MIDDLE };
    let (at_once, late) = [0, 3].map(|delay_samples| viewer(&Sensing { delay_samples, ..cameras() })).into();
    let (mut at_once, mut late) = (Tracker::new(&at_once), Tracker::new(&late));
    let reported: Vec<_> = (0..20).map(|k| (at_once.observe(&pose(k)), late.observe(&pose(k)))).collect();
    for k in 3..20 {
        assert_eq!(reported[k].1, reported[k - 3].0, "sample {k}");
    }
}

#[test]
fn controller_reads_the_estimate() {
    // Of a body that rests at trim a controller with the wrong idea of its roll asks for something else.
    let request = first_row();
    let mut sensing = perfect();
    for camera in &mut sensing.cameras {
        camera.focal_length_px *= 1.0 + 1e-12;
    }
    let resting = logged(&with(request.clone(), sensing), &short_test(0.5));
    assert!(resting.rows.iter().flat_map(|row| row.commands_m_s).all(|speed| speed.abs() < 1e-6), "at rest");
    let noisy = logged(&with(request, Sensing { pixel_noise_px: 1.0, ..perfect() }), &short_test(0.5));
    assert!(noisy.rows.iter().flat_map(|row| row.commands_m_s).any(|speed| speed.abs() > 1e-3), "it shakes");
}

/// The flow turns the body out of a narrow view and brings it back.
#[test]
fn flight_goes_on_with_the_last_pose_while_dots_are_out_of_view() {
    let mut sensing = perfect();
    sensing.cameras = sensing.cameras.split_off(2);
    (sensing.cameras[0].region.top_px, sensing.cameras[0].region.bottom_px) = (205.0, 275.0);
    let flow = steps(&[(0.0, 0.245, 0.0), (2.0, 0.245, 25.0), (8.0, 0.245, 0.0)]);
    let profile = TestProfile::new(30.0, flow, Vec::new()).unwrap();
    let log = logged(&with(first_row(), sensing), &profile);
    let reported: Vec<_> = log.rows.iter().map(|row| row.estimate.unwrap()).collect();
    let held = reported.iter().filter(|reported| reported.hold == Some(Hold::TooFewDots)).count();
    assert!((10..1000).contains(&held), "{held} of {} samples are held", reported.len());
    for (before, now) in reported.iter().zip(&reported[1..]) {
        assert!(now.hold.is_none() || now.pose == before.pose, "held: {before:?} and {now:?}");
    }
    assert_eq!(reported.last().unwrap().hold, None, "the dots are back");
    let (row, reported) = (log.rows.last().unwrap(), reported.last().unwrap());
    assert_close(reported.pose.altitude_m(), row.altitude_m, 1e-9, "regained");
}

/// The share that a flight says is that of its log, alone and side by side; a delay counts for nothing.
#[test]
fn flight_says_on_how_many_images_a_pose_was_held() {
    let mut narrow = perfect();
    narrow.cameras = narrow.cameras.split_off(2);
    (narrow.cameras[0].region.top_px, narrow.cameras[0].region.bottom_px) = (205.0, 275.0);
    let flow = steps(&[(0.0, 0.245, 0.0), (2.0, 0.245, 25.0), (8.0, 0.245, 0.0)]);
    let profile = TestProfile::new(30.0, flow, Vec::new()).unwrap();
    let requests =
        [with(first_row(), narrow), with(first_row(), Sensing { delay_samples: 3, ..perfect() }), first_row()];
    let shares: Vec<Option<f64>> = fly_all(&requests, &profile, &FlightSettings::default(), |_| {})
        .into_iter()
        .map(|flight| flight.unwrap().held_share)
        .collect();
    let log = logged(&requests[0], &profile);
    let held = log.rows.iter().filter(|row| row.estimate.unwrap().hold.is_some()).count();
    assert!(held > 0);
    assert_eq!(shares, [Some(held as f64 / log.rows.len() as f64), Some(0.0), None]);
}

/// One of three cameras is turned to the floor: the others do, and the flight says which saw nothing; lane by lane, and alone.
#[test]
fn flight_says_which_cameras_saw_no_dot_at_all() {
    let mut turned = cameras();
    turned.cameras[2].pose.pitch_rad = -turned.cameras[2].pose.pitch_rad;
    let requests = [with(first_row(), cameras()), with(first_row(), turned), first_row()];
    let blind: Vec<Vec<usize>> = fly_all(&requests, &short_test(2.0), &FlightSettings::default(), |_| {})
        .into_iter()
        .map(|flight| flight.unwrap().blind_cameras)
        .collect();
    assert_eq!(blind, [vec![], vec![2], vec![]]);
    assert_eq!(fly(&requests[1], &short_test(2.0), &FlightSettings::default()).unwrap().blind_cameras, [2]);
}

/// Cameras that look away.
#[test]
fn flight_whose_cameras_give_no_pose_at_the_start_does_not_start() {
    let mut away = cameras();
    for camera in &mut away.cameras {
        camera.pose.heading_rad += std::f64::consts::PI;
        camera.pose.pitch_rad = -camera.pose.pitch_rad;
    }
    let request = with(first_row(), away);
    let words = "cannot start: sensing: no pose can be had where the flight begins: three dots or fewer are seen (0 of 10 dots; of them \
                 0 by camera `side`, 0 by camera `downstream`, 0 by camera `below`); cameras or dots must stand otherwise";
    let alone = fly(&request, &short_test(1.0), &FlightSettings::default()).unwrap_err();
    assert_eq!(alone.to_string(), words);
    let together = fly_all(&[first_row(), request], &short_test(1.0), &FlightSettings::default(), |_| {});
    assert!(together[0].is_ok());
    assert_eq!(together[1], Err(alone));
}

/// Two dots in the image of one camera and none in those of the others.
#[test]
fn error_names_every_camera_with_the_dots_that_it_sees() {
    let start = logged(&with(first_row(), perfect()), &short_test(1.0)).rows[0].estimate.unwrap().pose;
    let mut sensing = perfect();
    for camera in &mut sensing.cameras[1..] {
        camera.pose.heading_rad += std::f64::consts::PI;
        camera.pose.pitch_rad = -camera.pose.pitch_rad;
    }
    let names: Vec<String> = sensing.cameras.iter().map(|camera| camera.name.clone()).collect();
    let rig = with(first_row(), sensing.clone()).rig;
    let view = rig.viewer().unwrap().unwrap().look(&start, &mut PixelNoise::new(0));
    let mut columns: Vec<f64> = view.sightings().iter().map(|sighting| sighting.pixel[0]).collect();
    columns.sort_by(f64::total_cmp);
    assert!(columns.len() > 2, "{columns:?}");
    // All that lies to the right of the second dot is cut off.
    sensing.cameras[0].region.right_px = 0.5 * (columns[1] + columns[2]);
    let error = fly(&with(first_row(), sensing), &short_test(1.0), &FlightSettings::default()).unwrap_err();
    let FlightError::Start(Error::NoFirstPose { dots_seen, seen_by, .. }) = &error else { panic!("{error}") };
    let expected: Vec<(String, usize)> = names.iter().cloned().zip([2, 0, 0]).collect();
    assert_eq!((*dots_seen, seen_by), (2, &expected));
    let words = format!("2 by camera `{}`, 0 by camera `{}`, 0 by camera `{}`", names[0], names[1], names[2]);
    assert!(error.to_string().contains(&words), "{error}");
}

/// Nine flights: some with cameras, with seeds and delays of their own, some without, one that cannot start.
fn company() -> Vec<FlightRequest> {
    (0..9)
        .map(|k| {
            let mut request = request(Fidelity::STALLED_WITH_ADDED_MASS, 46.1, 12.0 + 0.5 * k as f64);
            if k % 3 != 0 {
                let sensing = Sensing { seed: k, delay_samples: k as usize % 2, ..cameras() };
                request.rig.sensing = Some(sensing);
            }
            if k == 5 {
                request.rig.sensing.as_mut().unwrap().cameras.clear();
            }
            request
        })
        .collect()
}

#[test]
fn flight_with_cameras_has_the_same_bits_in_any_company_and_on_any_number_of_threads() {
    let (requests, profile, settings) = (company(), turning_test(), FlightSettings::default());
    let alone: Vec<_> = requests.iter().map(|request| format!("{:?}", fly(request, &profile, &settings))).collect();
    for n_threads in [1, 2, 3] {
        let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        let together = pool.install(|| fly_all(&requests, &profile, &settings, |_| {}));
        let together: Vec<_> = together.iter().map(|result| format!("{result:?}")).collect();
        assert_eq!(together, alone, "{n_threads} threads");
    }
    assert!(alone[5].contains("camera"), "{}", alone[5]);
}

#[test]
fn seed_decides_the_flight() {
    let (request, profile) = (first_row(), short_test(5.0));
    let bits = |seed| {
        let sensing = Sensing { seed, ..cameras() };
        cost(&flown(&with(request.clone(), sensing), &profile, 2)).to_bits()
    };
    assert_eq!(bits(3), bits(3));
    assert_ne!(bits(3), bits(4));
}

#[test]
fn flight_that_leaves_the_model_says_so_with_cameras_too() {
    // Noise of fifty pixels shakes the body until something gives, or does not: in no case does it panic.
    let mut shaken = with(first_row(), Sensing { pixel_noise_px: 50.0, ..cameras() });
    shaken.rig.plant.winch.speed_limit_m_s = 2.0;
    let (outcome, log) = fly_logged(&shaken, &short_test(20.0), &FlightSettings::default(), 1).unwrap();
    let error = outcome.unwrap_err().to_string();
    assert!(error.contains("slack") || error.contains("left the model"), "{error}");
    assert!(!log.rows.is_empty() && log.rows.iter().all(|row| row.estimate.is_some()), "{} rows", log.rows.len());
}
