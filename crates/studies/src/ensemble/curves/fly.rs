//! Figures 14, 21 and 26 on a plant.

use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;
use water_channel::{Camera, PixelNoise, Region, Rig, Sensing, TestProfile};

use super::kept::{
    BIN_S, ERROR, ITERATIONS, LARGEST, LEFT, N_RANDOM, WHOLE_IMAGE, cases_of_figure21, of_bin, of_held, of_iteration,
    of_place,
};
use crate::bat::{Bat, STAND_IN};
use crate::calibration::Plant;
use crate::chapter3::PanelFlights;
use crate::chapter6::{self, Campaigns, Case};
use crate::ensemble::cameras::{before_and_after, rows_of};
use crate::ensemble::file::Setup;
use crate::ensemble::row::{Fact, Method, Row, Study, World};
use crate::ensemble::site::lopsided_in_water;
use crate::ensemble::store::{Done, Found};
use crate::gridded::{Designs, Q2, SUP};
use crate::kept::SAMPLE_OF_LONG;
use crate::logged::Logged;

/// All three on a plant.
pub(in crate::ensemble) fn run(
    setup: &Setup,
    done: &[Done],
    plant: &Plant,
    designs: &Designs,
) -> Result<(Found, usize)> {
    let start = Instant::now();
    let (mut found, mut n_flights) = (Found::default(), 0);
    for (facts, flown) in [lowest(setup, plant), errors(setup, plant, designs)?, headings(setup, done, plant, 1)?] {
        found.facts.extend(facts);
        n_flights += flown;
    }
    found.seconds = start.elapsed().as_secs_f64();
    Ok((found, n_flights))
}

/// Facts, and flights that they took.
type Facts = (Vec<Fact>, usize);

/// Of Figure 14, panel by panel, the lowest cost of a stable design at each center of mass.
fn lowest(setup: &Setup, plant: &Plant) -> Facts {
    let study = setup.chapter3.on(plant.rig.clone());
    let places = study.center_of_mass.places();
    let (mut facts, mut n_flights) = (Vec::new(), 0);
    for (panel, configuration) in study.configurations.iter().enumerate() {
        let flights = PanelFlights::fly(&study, configuration, STAND_IN, |_| {});
        n_flights += flights.designs().count();
        let each = (0..places.len()).map(|place| (place, flights.lowest_at(place)));
        facts.extend(each.filter(|(_, cost)| cost.is_finite()).map(|(place, cost)| lowest_fact(panel, place, cost)));
    }
    (facts, n_flights)
}

fn lowest_fact(panel: usize, place: usize, value: f64) -> Fact {
    Fact { study: Study::Chapter3, world: World::Still, name: of_place(panel, place), value }
}

/// Of Figure 21, truth by truth and noise by noise, the error of the corrected model and what is left of the space.
fn errors(setup: &Setup, plant: &Plant, designs: &Designs) -> Result<Facts> {
    let on = |bat: &Bat| bat.on(plant.rig.clone(), plant.weights[1], setup.still.clone());
    let study = setup.chapter6.on(2, on);
    let flown = chapter6::fly(&study, |_| {})?;
    let cases: Vec<Case> = cases_of_figure21(&study).collect();
    let ended = Campaigns { setup: &study, flown: &flown, designs }.run(&cases, |_| {})?;
    let mut facts = Vec::new();
    for campaign in &ended {
        for wanted in ITERATIONS {
            // A campaign that came to an end stays as it was.
            let until = campaign.accuracy.iterations.iter().take_while(|iteration| iteration.iteration <= wanted);
            let iteration = until.last().context("a campaign without an iteration")?;
            let norm = &iteration.norms[Q2];
            let largest = &iteration.norms[SUP];
            let readings =
                [(ERROR, norm.error / norm.gap), (LARGEST, largest.error / largest.gap), (LEFT, iteration.share_after)];
            for (what, value) in readings {
                let name = of_iteration(&study, campaign.case, wanted, what);
                facts.push(Fact { study: Study::Chapter6, world: World::Still, name, value });
            }
        }
    }
    let n_flights = study.spaces.iter().map(|space| space.space.n_cells() * study.fidelities().len()).sum();
    Ok((facts, n_flights))
}

/// Of Figure 26, the optimum of the model, where the loop ended, and one in so many of the designs that nobody chose: what one camera that
/// looks for dots in a narrow region makes of the heading.
fn headings(setup: &Setup, done: &[Done], plant: &Plant, one_in: usize) -> Result<Facts> {
    let case = setup.chapter7.cases.get(1).context("chapter7.toml has no second case")?;
    let (rig, moving) = lopsided_in_water(setup, plant)?;
    let camera = setup.one_camera();
    let on = |sensing: &Sensing, profile: &TestProfile| {
        case.bat.on(Rig { sensing: Some(sensing.clone()), ..rig.clone() }, plant.weights[1], profile.clone())
    };
    let center = case.space.region().center();
    let calm = on(&camera, &setup.still).logged(&center, STAND_IN)?;
    let whole = on(&camera, &moving).request(&center, STAND_IN).rig;
    let seen = Seen::during(&calm, &whole)?;
    let margins = [setup.regions.margins_px.as_slice(), &[WHOLE_IMAGE]].concat();
    let machines: Vec<Bat> = margins.iter().map(|margin_px| on(&seen.regions(&camera, *margin_px), &moving)).collect();
    let random = rows_of(done, Study::Four, plant.number).filter(|row| row.method == Method::Random).take(N_RANDOM);
    let rows: Vec<&Row> =
        before_and_after(done, Study::Four, plant.number).into_iter().chain(random.step_by(one_in)).collect();
    let both = rows.iter().flat_map(|row| machines.iter().map(move |bat| (*row, bat))).collect::<Vec<_>>();
    let flights: Vec<Option<Logged>> =
        both.par_iter().map(|(row, bat)| bat.logged(&row.point, STAND_IN).ok()).collect();
    let mut facts = Vec::new();
    let mut add = |name: String, value: f64| {
        facts.push(Fact { study: Study::Four, world: World::Cameras, name, value });
    };
    for (row, flights) in rows.iter().zip(flights.chunks(margins.len())) {
        for (margin_px, flight) in margins.iter().zip(flights) {
            let held = flight.as_ref().and_then(|flight| flight.flight.held_share);
            add(of_held(row.method, row.seed, *margin_px), held.unwrap_or(f64::NAN));
            let is_shown = margin_px.to_bits() == setup.regions.shown_px.to_bits() && row.method != Method::Random;
            if let Some(flight) = flight.as_ref().filter(|_| is_shown) {
                largest_errors(flight).iter().enumerate().for_each(|(bin, error)| add(of_bin(row.method, bin), *error));
            }
        }
    }
    Ok((facts, 1 + both.len()))
}

/// The largest error of the heading that was reported, in deg, in each bin of time.
fn largest_errors(flight: &Logged) -> Vec<f64> {
    let mut largest = Vec::new();
    for row in &flight.log.rows {
        let Some(estimate) = row.estimate else { continue };
        let bin = (row.time_s / BIN_S) as usize;
        largest.resize(largest.len().max(bin + 1), 0.0_f64);
        let error = estimate.pose.heading_rad - row.flow_direction_rad - row.heading_rad;
        largest[bin] = largest[bin].max(error.to_degrees().abs());
    }
    largest
}

/// Where each camera saw dots: the lowest and highest u and v.
struct Seen(Vec<[[f64; 2]; 2]>);

impl Seen {
    fn during(flight: &Logged, rig: &Rig) -> Result<Self> {
        let rig = rig.clone();
        let exact = rig.sensing.map(|sensing| Sensing { pixel_noise_px: 0.0, quantization_px: 0.0, ..sensing });
        let viewer = Rig { sensing: exact, ..rig }.viewer()?.context("a rig with cameras")?;
        let mut seen = vec![[[f64::INFINITY, f64::NEG_INFINITY]; 2]; viewer.n_cameras()];
        for estimate in flight.log.rows.iter().filter_map(|row| row.estimate) {
            for sighting in viewer.look(&estimate.pose, &mut PixelNoise::new(0)).sightings() {
                for (range, pixel) in seen[sighting.camera].iter_mut().zip(sighting.pixel) {
                    *range = [range[0].min(pixel), range[1].max(pixel)];
                }
            }
        }
        Ok(Self(seen))
    }

    /// The cameras with regions of interest about what each saw, as far as its image goes; one that saw nothing keeps its own.
    fn regions(&self, sensing: &Sensing, margin_px: f64) -> Sensing {
        let around = |camera: &Camera, &[u, v]: &[[f64; 2]; 2]| {
            let whole = Region::whole(camera.width_px, camera.height_px);
            let region = Region {
                left_px: (u[0] - margin_px).max(whole.left_px),
                right_px: (u[1] + margin_px).min(whole.right_px),
                top_px: (v[0] - margin_px).max(whole.top_px),
                bottom_px: (v[1] + margin_px).min(whole.bottom_px),
            };
            let is_seen = region.left_px < region.right_px && region.top_px < region.bottom_px;
            Camera { region: if is_seen { region } else { camera.region }, ..camera.clone() }
        };
        let cameras = sensing.cameras.iter().zip(&self.0).map(|(camera, seen)| around(camera, seen)).collect();
        Sensing { cameras, ..sensing.clone() }
    }
}

/// That a plant still shows what was kept of Figures 14 and 26 on it, as far as one in so many of their places and designs says.
pub(in crate::ensemble) fn fly_again(setup: &Setup, done: &[Done], plant: &Plant) -> Result<()> {
    let unit = ("curves".to_owned(), plant.number);
    let kept = done.iter().find(|done| done.unit == unit).context("its curves were not kept")?;
    let kept: Vec<Vec<String>> = kept.found.facts.iter().map(Fact::cells).collect();
    let agrees = |fact: &Fact| {
        let (Fact { name, value, .. }, number) = (fact, plant.number);
        ensure!(
            kept.contains(&fact.cells()),
            "plant {number} flies otherwise than when its curves were kept: `{name}` is {value} now"
        );
        Ok(())
    };
    let study = setup.chapter3.on(plant.rig.clone());
    let panels = study.configurations.iter().enumerate();
    let n_places = study.center_of_mass.places().len();
    let all = panels.flat_map(|(panel, configuration)| (0..n_places).map(move |place| (panel, configuration, place)));
    // Nothing is kept of places where no design is stable.
    let is_kept = |panel, place| kept.iter().flatten().any(|cell| *cell == of_place(panel, place));
    let of_kept = all.filter(|(panel, _, place)| is_kept(*panel, *place));
    for (panel, configuration, place) in of_kept.step_by(SAMPLE_OF_LONG) {
        let value = PanelFlights::fly_lowest_at(&study, configuration, STAND_IN, place);
        agrees(&lowest_fact(panel, place, value))?;
    }
    headings(setup, done, plant, SAMPLE_OF_LONG)?.0.iter().try_for_each(agrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region([left_px, right_px, top_px, bottom_px]: [f64; 4]) -> Region {
        Region { left_px, right_px, top_px, bottom_px }
    }

    /// About what was seen, within the image; a camera that saw nothing looks where it looked before.
    #[test]
    fn regions_lie_about_what_was_seen() -> Result<()> {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let sensing = water_channel::SensingFile::read(root.join("fixtures/bat/sensing.toml"))?.sensing;
        let nothing = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let seen = Seen(vec![[[100.0, 200.0], [50.0, 60.0]], [[5.0, 630.0], [470.0, 480.0]], nothing]);
        let regions: Vec<Region> = seen.regions(&sensing, 20.0).cameras.iter().map(|camera| camera.region).collect();
        let expected =
            [region([80.0, 220.0, 30.0, 80.0]), region([0.0, 640.0, 450.0, 480.0]), sensing.cameras[2].region];
        assert_eq!(regions, expected);
        Ok(())
    }

    /// With no pixel to spare a camera still sees every dot that it saw.
    #[test]
    fn all_that_was_seen_lies_within_the_regions() -> Result<()> {
        let setup = Setup::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))?;
        let (plant, case) = (&setup.plants[0], &setup.chapter7.cases[1]);
        let camera = Sensing { pixel_noise_px: 0.0, ..setup.one_camera() };
        let on = |sensing: &Sensing| {
            let rig = Rig { sensing: Some(sensing.clone()), ..plant.rig.clone() };
            case.bat.on(rig, plant.weights[1], setup.still.clone())
        };
        let center = case.space.region().center();
        let calm = on(&camera).logged(&center, STAND_IN)?;
        let seen = Seen::during(&calm, &on(&camera).request(&center, STAND_IN).rig)?;
        let held = |margin_px: f64| -> Result<Option<f64>> {
            Ok(on(&seen.regions(&camera, margin_px)).logged(&center, STAND_IN)?.flight.held_share)
        };
        assert_eq!(held(0.5)?, Some(0.0), "the log has one sample in four: half a pixel to spare");
        assert!(largest_errors(&calm).iter().all(|error| *error < 0.5), "without lost dots the heading is reported");
        Ok(())
    }
}
