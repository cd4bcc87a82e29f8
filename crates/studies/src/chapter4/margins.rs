//! How safe the numbers are: margins of the flights over the box of Table 4, and the step size of the integration.

use anyhow::Result;
use bat_dynamics::Fidelity;
use infuse::codesign::CodesignReport;
use water_channel::{Flight, FlightError, FlightRequest, FlightSettings, fly_all};

use super::file::Setup;
use super::loops::PHYSICS;
use page::{Column, Table};

/// Factors on the stabilizers' areas: the ends of Table 4 and the nominal one.
const HORIZONTAL: [f64; 3] = [0.8, 1.0, 1.4];
const VERTICAL: [f64; 3] = [0.85, 1.0, 1.85];
/// Shares of the box along each of the study's parameters.
const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Steps per sample that are compared, and the one that counts as exact.
const STEPS: [usize; 4] = [1, 2, 4, 8];
const EXACT_STEPS: usize = 16;

fn requests(setup: &Setup, fidelity: Fidelity) -> Vec<FlightRequest> {
    let at = |k: usize, share: f64| setup.bounds(k).0 + share * (setup.bounds(k).1 - setup.bounds(k).0);
    let mut requests = Vec::new();
    for x in SHARES {
        for y in SHARES {
            for horizontal in HORIZONTAL {
                for vertical in VERTICAL {
                    let mut request = setup.bat.request(&[at(0, x), at(1, y)], fidelity);
                    request.rig.plant.horizontal_stabilizer.area_factor = horizontal;
                    request.rig.plant.vertical_stabilizer.area_factor = vertical;
                    requests.push(request);
                }
            }
        }
    }
    requests
}

/// How many flights [`box_table`] takes.
pub(crate) fn n_flights() -> usize {
    PHYSICS.len() * SHARES.len() * SHARES.len() * HORIZONTAL.len() * VERTICAL.len()
}

/// Failures and margins over the box of the four design parameters of Table 4.
pub(crate) fn box_table(setup: &Setup, done: impl Fn(usize) + Sync) -> Table {
    let mut table = Table::new(vec![
        Column::new("Physics", ""),
        Column::new("Flights", "1"),
        Column::new("Failed", "1"),
        Column::new("Smallest tension", "N"),
        Column::new("Zenith angle", "deg"),
        Column::new("Peak heading", "deg"),
    ]);
    for (name, fidelity) in PHYSICS {
        let flown = fly_all(&requests(setup, fidelity), setup.bat.profile(), &FlightSettings::with_steps(1), &done);
        let extremes: Vec<_> = flown.iter().flatten().map(|flight| flight.extremes).collect();
        let fold = |f: fn(&water_channel::Extremes) -> f64, pick: fn(f64, f64) -> f64| {
            extremes.iter().map(f).reduce(pick).unwrap_or(f64::NAN)
        };
        let deg = f64::to_degrees;
        table.push(vec![
            name.to_owned(),
            flown.len().to_string(),
            failures(&flown),
            format!("{:.3}", fold(|e| e.smallest_tension_n, f64::min)),
            format!(
                "{:.1} – {:.1}",
                deg(fold(|e| e.smallest_zenith_rad, f64::min)),
                deg(fold(|e| e.largest_zenith_rad, f64::max))
            ),
            format!(
                "{:.1} – {:.1}",
                deg(fold(|e| e.peak_heading_rad, f64::min)),
                deg(fold(|e| e.peak_heading_rad, f64::max))
            ),
        ]);
    }
    table
}

/// How many flights failed, and why the first of them did.
fn failures(flown: &[std::result::Result<Flight, FlightError>]) -> String {
    let mut reasons = flown.iter().filter_map(|flight| flight.as_ref().err());
    let Some(first) = reasons.next() else { return "0".to_owned() };
    format!("{}, the first: {first}", 1 + reasons.count())
}

/// Where the optimum lies with each piece of physics, and what the model's own optimum costs there.
pub(crate) fn physics_table(setup: &Setup, optima: &[CodesignReport], start: &[f64]) -> Table {
    let best = |k| Column::new(&format!("Best {}", setup.variable(k).label()), setup.variable(k).unit());
    let mut table = Table::new(vec![
        Column::new("Physics", ""),
        best(0),
        best(1),
        Column::new("Its cost", "s"),
        Column::new("Cost of the model's optimum", "s"),
    ]);
    for ((name, fidelity), best) in PHYSICS.iter().zip(optima) {
        table.push(vec![
            (*name).to_owned(),
            format!("{:.2}", best.point[0]),
            format!("{:.2}", best.point[1]),
            format!("{:.3}", best.cost),
            setup.bat.cost(start, *fidelity).map_or_else(|reason| reason, |cost| format!("{cost:.3}")),
        ]);
    }
    table
}

/// Relative error of the cost of the design at `point` by steps per sample.
pub(crate) fn step_table(setup: &Setup, point: &[f64]) -> Result<Table> {
    let mut columns = vec![Column::new("Physics", "")];
    columns.extend(STEPS.iter().map(|steps| Column::new(&format!("{steps} a sample"), "1")));
    let mut table = Table::new(columns);
    let requests = PHYSICS.map(|(_, fidelity)| setup.bat.request(point, fidelity));
    let costs = |steps| -> Result<Vec<f64>> {
        let flown = fly_all(&requests, setup.bat.profile(), &FlightSettings::with_steps(steps), |_| {});
        let both = requests.iter().zip(flown);
        both.map(|(request, flight)| Ok(setup.bat.breakdown(&request.rig, &flight?).total)).collect()
    };
    let exact = costs(EXACT_STEPS)?;
    let all = STEPS.into_iter().map(costs).collect::<Result<Vec<_>>>()?;
    for (number, (name, _)) in PHYSICS.iter().enumerate() {
        let errors = all.iter().map(|costs| format!("{:.0e}", (costs[number] / exact[number] - 1.0).abs()));
        table.push(std::iter::once((*name).to_owned()).chain(errors).collect());
    }
    Ok(table)
}
