//! Figures 23, 24 and 26 to 28, and how the campaigns spread over the seeds.

use anyhow::{Context as _, Result};

use super::both_loops;
use super::campaigns::Step;
use super::file::Case;
use super::findings::{Findings, Found, shares};
use super::flights::{ALTITUDE, Flown, HEADING, PITCH, Quantity, ROLL, ZENITH};
use crate::gridded::{cell_panel, design_points};
use crate::reproduction::Picture;
use crate::words::number;
use page::Column;
use page::{
    Axis, CellFigure, CellPanel, ColorScale, Group, LineFigure, Panel, Reference, Series, SpreadFigure, Summary,
    cell_figure, line_figure, spread_figure,
};

/// A figure of flights: its number, how many parameters its study has, what it shows, and what the dissertation says of it.
struct FlightFigure {
    number: u32,
    n_parameters: usize,
    quantities: &'static [Quantity],
    says: &'static str,
}

const FLIGHT_FIGURES: [FlightFigure; 4] = [
    FlightFigure {
        number: 24,
        n_parameters: 2,
        quantities: &[PITCH, HEADING],
        says: "pitch and heading errors squared improve",
    },
    FlightFigure { number: 26, n_parameters: 4, quantities: &[HEADING], says: "the heading is significantly improved" },
    FlightFigure {
        number: 27,
        n_parameters: 4,
        quantities: &[ROLL, ZENITH],
        says: "the roll offset is greatly reduced, the zenith angle slightly lower",
    },
    FlightFigure {
        number: 28,
        n_parameters: 4,
        quantities: &[ALTITUDE, PITCH],
        says: "altitude and pitch tracking improve in quality",
    },
];

/// Everything there is to look at.
pub(crate) fn all(findings: &Findings) -> Result<Vec<Picture>> {
    let mut pictures = vec![true_costs(findings)];
    for (case, found) in findings.cases().filter(|(case, _)| case.space.variables.len() == 2) {
        pictures.push(designs(case, found)?);
    }
    for figure in &FLIGHT_FIGURES {
        for (case, found) in findings.cases().filter(|(case, _)| case.space.variables.len() == figure.n_parameters) {
            pictures.push(flights(case, found, figure));
        }
    }
    for (case, found) in findings.cases() {
        pictures.extend(spreads(findings, case, found));
    }
    pictures.push(both_loops::picture(findings));
    Ok(pictures)
}

/// What the optimum truly costs, iteration by iteration, in both studies.
fn true_costs(findings: &Findings) -> Picture {
    let iterations = |n: usize| Axis::new("iteration (0: the numerical model alone)", "1").counting(0, n);
    let panels = findings.cases().map(|(case, found)| {
        let runs = found.main();
        let n = case.entry.iterations;
        let x: Vec<f64> = (0..=n).map(|iteration| iteration as f64).collect();
        let of = |label: &str, cost: &dyn Fn(usize) -> f64| {
            let costs: Vec<f64> = std::iter::once(found.numerical_true_cost).chain((1..=n).map(cost)).collect();
            (label.to_owned(), costs)
        };
        let over_seeds = |iteration: usize, reading: fn(&Summary) -> f64| {
            Summary::of(&runs.over_seeds(iteration, |step| step.cost)).map_or(f64::NAN, |summary| reading(&summary))
        };
        let quiet = |iteration: usize| runs.quiet.0.get(iteration - 1).map_or(f64::NAN, |step| step.cost);
        // Drawn last and dashed, so that it is seen where it runs along the others.
        let without_noise = of("without noise", &quiet);
        let seeds = [
            of("least and most of the seeds", &|iteration| over_seeds(iteration, |summary| summary.minimum)),
            of("least and most of the seeds", &|iteration| over_seeds(iteration, |summary| summary.maximum)),
            of("median of the seeds of noise", &|iteration| over_seeds(iteration, |summary| summary.median)),
        ];
        let shown: Vec<f64> = seeds
            .iter()
            .chain([&without_noise])
            .flat_map(|(_, costs)| costs)
            .copied()
            .chain([found.best.cost])
            .collect();
        let best = Series::line("best design known", &x, &vec![found.best.cost; x.len()]).dashed();
        let seeds = seeds.iter().map(|(label, costs)| Series::line(label, &x, costs));
        let without_noise = Series::line(&without_noise.0, &x, &without_noise.1).dashed();
        Panel {
            x_axis: Some(iterations(n)),
            y_axis: Axis::new(&format!("true cost, {}", case.entry.label), "s").in_ratios(shown),
            series: std::iter::once(best).chain(seeds).chain([without_noise]).collect(),
        }
    });
    let panels: Vec<Panel> = panels.collect();
    let figure = LineFigure {
        title: "What the optimum of each iteration truly costs".to_owned(),
        x_axis: iterations(1),
        panels,
        shaded: None,
    };
    Picture {
        name: "true-costs".to_owned(),
        svg: line_figure(&figure),
        caption: "The cost in the stand-in, without noise, of the numerical optimum (iteration 0) and of the optimum of the combined \
                  surface after each iteration, with the regressor (61), beside that of the best design known. The axes are \
                  logarithmic, each with a range of its own."
            .to_owned(),
    }
}

/// Figure 23: the runs of every iteration and the combined response surface.
fn designs(case: &Case, found: &Found) -> Result<Picture> {
    let space = &case.space;
    let campaign = &found.main().quiet_campaign;
    let mut panels = Vec::new();
    for (report, surfaces) in campaign.reports().iter().zip(campaign.surfaces()) {
        let retained = campaign.retained_at(report.number).context("a closed iteration")?;
        let share = shares(campaign, report.number).unwrap_or(f64::NAN);
        let truth = |cell| Ok(found.truth.cost(cell).clone().unwrap_or(f64::NAN));
        let combined = |cell| -> Result<f64> { Ok(surfaces.combined.surface().predict(&space.coded(cell)?)) };
        let (x, y) = (report.screening.optimum[0], report.screening.optimum[1]);
        panels.push(CellPanel {
            title: format!("iteration {}: runs, true cost, {share:.1} % left", report.number),
            points: design_points(report),
            ..cell_panel(space, &retained, truth)?
        });
        panels.push(CellPanel {
            title: format!("iteration {}: combined surface", report.number),
            minimum: Some((x, y)),
            ..cell_panel(space, &retained, combined)?
        });
    }
    let [x, y] = [0, 1].map(|k| space.variables[k]);
    let figure = CellFigure {
        title: format!("{}, {}: runs and combined response", case.entry.label, found.main().label),
        x_axis: x.axis(),
        y_axis: y.axis(),
        z_axis: Axis::new("cost J", "s").with_colors(ColorScale::EqualShares),
        panels,
        missing_label: "dropped by a z-test".to_owned(),
        minimum_label: "optimum of the combined surface".to_owned(),
    };
    Ok(Picture {
        name: "figure-23".to_owned(),
        svg: cell_figure(&figure),
        caption: "The counterpart of Figure 23, without noise. Left: what is left of the space at the onset of an \
                  iteration with its true cost in the stand-in, and the runs made there. Right: the surface fitted to \
                  training experiments and corrected simulations. Each color has equally many cells of all panels."
            .to_owned(),
    })
}

/// How the numerical and the infused optimum fly in the stand-in.
fn flights(case: &Case, found: &Found, figure: &FlightFigure) -> Picture {
    let both = [("numerical optimum", &found.flights.before), ("infused optimum", &found.flights.after)];
    let label = |name: &str, point: &[f64]| format!("{name}: {}", case.space.words(point));
    let panel = |axis: Axis, map: &dyn Fn(&Flown) -> Vec<f64>| Panel {
        x_axis: None,
        y_axis: axis,
        series: both
            .iter()
            .map(|(name, flown)| Series::line(&label(name, &flown.point), &flown.times(), &map(flown)))
            .collect(),
    };
    let mut panels = Vec::new();
    let mut means = Vec::new();
    for quantity in figure.quantities {
        let Quantity { name, unit, is_error, has_mean, .. } = quantity;
        panels.push(panel(Axis::new(name, unit), &|flown| flown.values(quantity)));
        if *is_error {
            let axis = Axis::new(&format!("{name}²"), &format!("{unit}²"));
            panels.push(panel(axis, &|flown| flown.values(quantity).iter().map(|value| value * value).collect()));
            let [a, b] = both.map(|(_, flown)| number(flown.mean_square(quantity), 3));
            means.push(format!("mean square of the {name} {a} {unit}² before, {b} {unit}² after"));
        }
        if *has_mean {
            let [a, b] = both.map(|(_, flown)| number(flown.mean(quantity), 2));
            means.push(format!("mean {name} {a} {unit} before, {b} {unit} after"));
        }
    }
    let names: Vec<&str> = figure.quantities.iter().map(|quantity| quantity.name).collect();
    let drawn = LineFigure {
        title: format!("{}: {} in the stand-in", case.entry.label, names.join(", ")),
        x_axis: Axis::new("time", "s").with_range(0.0, case.bat.profile().duration_s()),
        panels,
        shaded: None,
    };
    Picture {
        name: format!("figure-{}", figure.number),
        svg: line_figure(&drawn),
        caption: format!(
            "The counterpart of Figure {}, of which the dissertation says that {}; here: {}. Both designs fly in the stand-in; the \
             infused optimum is the last one of the loop without noise.",
            figure.number,
            figure.says,
            means.join("; ")
        ),
    }
}

/// How every variable and the share spread over the seeds, beside the published rows.
fn spreads(findings: &Findings, case: &Case, found: &Found) -> Vec<Picture> {
    type Reading<'a> = Box<dyn Fn(&Step) -> f64 + 'a>;
    let mut quantities: Vec<(Column, Reading<'_>)> = Vec::new();
    for (k, variable) in case.space.variables.iter().enumerate() {
        quantities.push((variable.column(), Box::new(move |step| step.point[k])));
    }
    let n_variables = quantities.len();
    quantities.push((Column::new("Space left", "%"), Box::new(|step| step.share)));
    let draw = |(number, (column, reading)): (usize, &(Column, Reading<'_>))| {
        let groups = found.runs.iter().map(|runs| Group {
            label: runs.label.clone(),
            values: (1..=case.entry.iterations).map(|iteration| runs.over_seeds(iteration, reading)).collect(),
        });
        let published = case
            .published
            .iter()
            .skip(1)
            .map(|row| reading(&Step { point: row.point.clone(), cost: f64::NAN, share: row.share }));
        let axis = Axis::new(&column.name, &column.unit);
        let figure = SpreadFigure {
            title: format!("{}: {} over the noise seeds", case.entry.label, column.name),
            // No part is more than the whole.
            y_axis: if number < n_variables { axis } else { axis.with_range(0.0, 100.0) },
            groups: groups.collect(),
            reference: Some(Reference {
                label: format!("dissertation, Table {}", case.entry.table),
                values: published.collect(),
            }),
        };
        Picture {
            name: format!("seeds-table-{}-{}", case.entry.table, number + 1),
            svg: spread_figure(&figure),
            caption: format!(
                "{} after each iteration, {}, noise within ±{} % of the range of the true cost.",
                column.name,
                case.entry.label,
                100.0 * findings.setup.file.noise.share
            ),
        }
    };
    quantities.iter().enumerate().map(draw).collect()
}
