//! Designs of kept campaigns flown again: as cameras see them, and to see that this program still flies as it did.

use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use water_channel::Camera;

use super::file::Setup;
use super::row::{Fact, Method, Row, Study, World};
use super::site::Site;
use super::store::{Done, Found};
use crate::calibration::Plant;

/// The seed whose last design is flown.
const SEED: u64 = 1;

/// The kept rows of a plant in moving water.
pub(super) fn rows_of(done: &[Done], study: Study, plant: u64) -> impl Iterator<Item = &Row> {
    let mine = done.iter().filter(move |done| done.unit == (study.name().to_owned(), plant));
    mine.flat_map(|done| &done.found.rows).filter(|row| row.world == World::Moving)
}

/// Of these the optimum of the model, and where the loop ended.
pub(super) fn before_and_after(done: &[Done], study: Study, plant: u64) -> Vec<&Row> {
    let rows = || rows_of(done, study, plant);
    let before = rows().find(|row| row.method == Method::Numerical);
    let path = rows().filter(|row| row.method == Method::Dissertation && row.seed == SEED);
    before.into_iter().chain(path.max_by_key(|row| row.step)).collect()
}

/// The designs of Figures 24 and 26 to 28 seen by cameras.
pub(super) fn run(setup: &Setup, done: &[Done], plant: &Plant) -> Result<(Found, usize)> {
    let start = Instant::now();
    let mut found = Found::default();
    let mut n_flights = 0;
    for (study, case) in [Study::Two, Study::Four].into_iter().zip(&setup.chapter7.cases) {
        let kept = before_and_after(done, study, plant.number);
        let site = Site::new(setup, &case.bat, plant, plant.weights[1], World::Cameras)?;
        let points: Vec<Vec<f64>> = kept.iter().map(|row| row.point.clone()).collect();
        for (row, readings) in kept.into_iter().zip(site.observe(&points)) {
            found.rows.push(Row { world: World::Cameras, readings, ..row.clone() });
        }
        n_flights += site.n_flights();
        found.facts.extend(blind_facts(setup, study, &site.blind_cameras()));
    }
    found.seconds = start.elapsed().as_secs_f64();
    Ok((found, n_flights))
}

/// Flights before cameras that came to their end.
pub(super) const FLOWN: &str = "flown";

/// Flights in which a camera saw no dot in any image.
pub(super) fn of_blind(camera: &str) -> String {
    format!("blind/{camera}")
}

/// In how many flights which camera was blind.
fn blind_facts(setup: &Setup, study: Study, flights: &[Vec<usize>]) -> Vec<Fact> {
    let fact = |name: String, n: usize| Fact { study, world: World::Cameras, name, value: n as f64 };
    let of_camera = |(place, camera): (usize, &Camera)| {
        fact(of_blind(&camera.name), flights.iter().filter(|blind| blind.contains(&place)).count())
    };
    let cameras = setup.sensing.cameras.iter().enumerate().map(of_camera);
    std::iter::once(fact(FLOWN.to_owned(), flights.len())).chain(cameras).collect()
}

/// How many plants are flown again by a check.
const CHECKED: usize = 2;

/// That the center of the box still shows what was kept of it, in both worlds, on some plants.
pub(super) fn fly_again(setup: &Setup, done: &[Done]) -> Result<()> {
    let case = setup.chapter7.cases.first().context("chapter7.toml has no case")?;
    for plant in setup.plants.iter().take(CHECKED) {
        for world in World::OF_CAMPAIGNS {
            let site = Site::new(setup, &case.bat, plant, plant.weights[1], world)?;
            let mine = done.iter().filter(|done| done.unit == (Study::Two.name().to_owned(), plant.number));
            let kept =
                mine.flat_map(|done| &done.found.rows).find(|row| row.world == world && row.method == Method::Center);
            let kept = kept.with_context(|| format!("plant {}: its center was not kept", plant.number))?;
            let readings = site.observe(&[case.space.region().center()]);
            let again = Row { readings: *readings.first().context("one design")?, ..kept.clone() };
            ensure!(
                again.cells() == kept.cells(),
                "{}: plant {} in {} water flies otherwise than when it was kept: {} s, {} s then",
                setup.origin.folder(),
                plant.number,
                world.name(),
                again.cost(),
                kept.cost()
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One of three cameras is turned to the floor: its flight comes to an end by the others, and is counted.
    #[test]
    fn a_blind_camera_is_counted_by_its_name() -> Result<()> {
        let mut setup = Setup::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))?;
        let last = setup.sensing.cameras.last_mut().context("a camera")?;
        last.pose.pitch_rad = -last.pose.pitch_rad;
        let name = last.name.clone();
        setup.campaigns.truth_seeds = 1;
        let (plant, case) = (&setup.plants[0], &setup.chapter7.cases[0]);
        let site = Site::new(&setup, &case.bat, plant, plant.weights[1], World::Cameras)?;
        site.observe(&[case.space.region().center()]);
        let facts = blind_facts(&setup, Study::Two, &site.blind_cameras());
        let found: Vec<(&str, f64)> = facts.iter().map(|fact| (fact.name.as_str(), fact.value)).collect();
        let (first, cameras) = found.split_first().context("facts")?;
        assert_eq!(*first, (FLOWN, 1.0));
        assert_eq!(cameras.len(), setup.sensing.cameras.len());
        for (fact, value) in cameras {
            assert!((value - f64::from(u8::from(*fact == of_blind(&name)))).abs() < 1e-12, "{fact} {value}");
        }
        Ok(())
    }
}
