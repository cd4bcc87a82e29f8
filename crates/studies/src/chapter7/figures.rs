//! Figures 23, 24 and 26 to 28, and how the campaigns spread over the seeds.

use anyhow::{Context as _, Result};

use super::campaigns::Step;
use super::file::Case;
use super::findings::{Findings, Found, shares};
use super::flights::{ALTITUDE, Flown, HEADING, PITCH, Quantity, ROLL, ZENITH};
use crate::gridded::{cell_panel, design_points};
use crate::reproduction::Picture;
use crate::words::number;
use page::Column;
use page::{
    Axis, CellFigure, CellPanel, ColorScale, Group, LineFigure, Panel, Reference, Series, SpreadFigure, cell_figure,
    line_figure, spread_figure,
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
    let mut pictures = Vec::new();
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
    Ok(pictures)
}

/// Figure 23: the runs of every iteration and the combined response surface.
fn designs(case: &Case, found: &Found) -> Result<Picture> {
    let space = &case.space;
    let campaign = &found.main().quiet_campaign;
    let mut panels = Vec::new();
    for (report, surfaces) in campaign.reports().iter().zip(campaign.surfaces()) {
        let retained = campaign.retained_at(report.iteration).context("a closed iteration")?;
        let share = shares(campaign, report.iteration).unwrap_or(f64::NAN);
        let truth = |cell| Ok(found.truth.cost(cell).clone().unwrap_or(f64::NAN));
        let combined = |cell| -> Result<f64> { Ok(surfaces.combined.surface().predict(&space.coded(cell)?)) };
        let (x, y) = (report.screening.optimum[0], report.screening.optimum[1]);
        panels.push(CellPanel {
            title: format!("iteration {}: runs, true cost, {share:.1} % left", report.iteration),
            points: design_points(report),
            ..cell_panel(space, &retained, truth)?
        });
        panels.push(CellPanel {
            title: format!("iteration {}: combined surface", report.iteration),
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
