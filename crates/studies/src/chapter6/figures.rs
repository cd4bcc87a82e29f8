//! Figures 20 to 22 from the campaigns and flights of this run.

use anyhow::{Context as _, Result};

use super::campaigns::Ended;
use super::file::Case;
use super::findings::Findings;
use crate::gridded::{IterationAccuracy, NORMS, NormAccuracy, Q2, cell_panel, design_points};
use crate::reproduction::Picture;
use page::{Axis, CellFigure, CellPanel, ColorScale, LineFigure, Panel, Series, cell_figure, line_figure};

/// Everything there is to look at.
pub(crate) fn all(findings: &Findings) -> Result<Vec<Picture>> {
    let mut pictures = Vec::new();
    for space in 0..findings.setup.spaces.len() {
        for truth in 0..findings.setup.n_truths() {
            if findings.setup.spaces[space].space.region().n_parameters() == 2 {
                pictures.push(designs(findings, findings.shown(space, truth)?)?);
            }
        }
    }
    for space in 0..findings.setup.spaces.len() {
        for truth in 0..findings.setup.n_truths() {
            pictures.push(bounds(findings, space, truth));
        }
    }
    for space in 0..findings.setup.spaces.len() {
        pictures.push(gains(findings, space)?);
    }
    for space in 0..findings.setup.spaces.len() {
        pictures.push(flights(findings, findings.shown(space, findings.setup.n_truths() - 1)?)?);
    }
    Ok(pictures)
}

fn file_name(words: &str) -> String {
    words
        .to_lowercase()
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join("-")
}

/// Figure 20: the designs and the combined response at the first, a middle and the last iteration.
fn designs(findings: &Findings, ended: &Ended) -> Result<Picture> {
    let setup = &findings.setup;
    let space = &setup.spaces[ended.case.space].space;
    let reports = ended.campaign.reports();
    let mut panels = Vec::new();
    for index in chosen(reports.len()) {
        let (report, surfaces) = (&reports[index], &ended.campaign.surfaces()[index]);
        let retained = ended.campaign.retained_at(report.number).context("a closed iteration")?;
        let truth = &findings.flown[ended.case.space].truths[ended.case.truth];
        let combined = |cell| -> Result<f64> { Ok(surfaces.combined.surface().predict(&space.coded(cell)?)) };
        let share = 100.0 * retained.share();
        panels.push(CellPanel {
            title: format!("iteration {}: true cost where {share:.1} % is left, and designs", report.number),
            points: design_points(report),
            minimum: None,
            ..cell_panel(space, &retained, |cell| Ok(truth.cost(cell).clone().unwrap_or(f64::NAN)))?
        });
        panels.push(CellPanel {
            title: format!("iteration {}: combined response surface", report.number),
            points: Vec::new(),
            minimum: Some((report.screening.optimum[0], report.screening.optimum[1])),
            ..cell_panel(space, &retained, combined)?
        });
    }
    let [x, y] = [0, 1].map(|k| space.variables[k]);
    let truth = &setup.truth(ended.case.truth).label;
    let figure = CellFigure {
        title: format!("{}, {truth}: designs and combined response", setup.variant(ended.case).label),
        x_axis: x.axis(),
        y_axis: y.axis(),
        z_axis: Axis::new("cost J", "s").with_colors(ColorScale::EqualShares),
        panels,
        missing_label: "dropped by a z-test".to_owned(),
        minimum_label: "optimum of the combined surface".to_owned(),
    };
    Ok(Picture {
        name: format!("figure-20-{}", file_name(truth)),
        svg: cell_figure(&figure),
        caption: format!(
            "The counterpart of Figure 20 with {} as the truth, noise within ±{} % of the range: what is left of the \
             space at the onset of an iteration, the runs made in it, and the surface fitted to training experiments and \
             corrected simulations. Each color has equally many cells of all panels.",
            setup.truth(ended.case.truth).with_article(),
            100.0 * ended.case.noise
        ),
    })
}

/// The first, the middle and the last of so many, once each.
fn chosen(n: usize) -> Vec<usize> {
    let mut chosen = vec![0, n / 2, n.saturating_sub(1)];
    chosen.dedup();
    chosen.retain(|index| *index < n);
    chosen
}

/// Below it an error is rounding.
const LEAST_SHOWN: f64 = 1e-8;

/// A gap where an error is rounding.
fn shown(error: f64) -> f64 {
    if error > LEAST_SHOWN { error } else { f64::NAN }
}

/// An axis of errors: powers of ten.
fn error_axis(what: &str, errors: impl IntoIterator<Item = f64>) -> Axis {
    Axis::new(what, "s").in_decades(errors.into_iter().filter(|error| error.is_finite()))
}

/// Figure 21: the error of the corrected model with its bounds, noise by noise, and the shrinking of the space.
fn bounds(findings: &Findings, space: usize, truth: usize) -> Picture {
    let setup = &findings.setup;
    let main: Vec<&Ended> = findings.main(space, truth);
    let numbers =
        |ended: &Ended| -> Vec<f64> { ended.accuracy.iterations.iter().map(|i| i.iteration as f64).collect() };
    let series = |ended: &Ended, f: &dyn Fn(&IterationAccuracy) -> f64| -> Vec<f64> {
        ended.accuracy.iterations.iter().map(f).collect()
    };
    // One range for all panels, so that heights compare.
    let readings: [fn(&NormAccuracy) -> f64; 4] = [|n| n.error, |n| n.finite_bound, |n| n.proposition, |n| n.gap];
    let all: Vec<f64> = main
        .iter()
        .flat_map(|ended| &ended.accuracy.iterations)
        .flat_map(|i| readings.map(|reading| shown(reading(&i.norms[Q2]))))
        .collect();
    let mut panels: Vec<Panel> = main
        .iter()
        .map(|ended| {
            let x = numbers(ended);
            let [error, bound, proposition, gap] =
                readings.map(|reading| series(ended, &|i| shown(reading(&i.norms[Q2]))));
            Panel {
                x_axis: None,
                y_axis: error_axis(&format!("error, noise {} %", 100.0 * ended.case.noise), all.iter().copied()),
                series: vec![
                    Series::line("error of the corrected model", &x, &error),
                    Series::line("what it cannot exceed", &x, &bound).dashed(),
                    Series::line("right-hand side of (55)", &x, &proposition).dashed(),
                    Series::line("error without correction", &x, &gap),
                ],
            }
        })
        .collect();
    let shares = main.iter().flat_map(|ended| &ended.accuracy.iterations).map(|i| 100.0 * i.share_after);
    let most_left = if shares.fold(0.0, f64::max) > 40.0 { 100.0 } else { 40.0 };
    panels.push(Panel {
        x_axis: None,
        y_axis: Axis::new("space left", "%").with_range(0.0, most_left).with_step(0.25 * most_left),
        series: main
            .iter()
            .map(|ended| {
                let label = format!("space left, noise {} %", 100.0 * ended.case.noise);
                Series::line(&label, &numbers(ended), &series(ended, &|i| 100.0 * i.share_after))
            })
            .collect(),
    });
    let (label, name) = (&setup.spaces[space].entry.label, &setup.truth(truth).label);
    let figure = LineFigure {
        title: format!("{label}, {name}: error of the corrected model and its bounds"),
        x_axis: Axis::new("iteration", "1").with_range(1.0, setup.file.iterations.iterations as f64),
        panels,
        shaded: None,
    };
    Picture {
        name: format!("figure-21-{}-{}", file_name(label), file_name(name)),
        svg: line_figure(&figure),
        caption: format!(
            "The counterpart of Figure 21 for {label}, with {} as the truth, {}: how far the corrected model is from it, norm (42) with {}, noise \
             by noise, and the space that is left. The right-hand side of (55) bounds the limit alone.",
            setup.truth(truth).with_article(),
            setup.first_variant().label,
            NORMS[Q2]
        ),
    }
}

/// The error for each gain, at the noise that the figures show.
fn gains(findings: &Findings, space: usize) -> Result<Picture> {
    let setup = &findings.setup;
    let noise = findings.shown(space, 0)?.case.noise;
    let panels = (0..setup.n_truths())
        .map(|truth| {
            let wanted =
                |case: &Case| case.space == space && case.truth == truth && case.noise.to_bits() == noise.to_bits();
            let of = findings
                .ended
                .iter()
                .filter(|ended| wanted(&ended.case))
                .filter(|ended| setup.variant(ended.case).is_general());
            let curves = of.map(|ended| {
                let iterations = &ended.accuracy.iterations;
                let x: Vec<f64> = iterations.iter().map(|i| i.iteration as f64).collect();
                let y: Vec<f64> = iterations.iter().map(|i| shown(i.norms[Q2].error)).collect();
                (&*setup.variant(ended.case).label, x, y)
            });
            let curves: Vec<(&str, Vec<f64>, Vec<f64>)> = curves.collect();
            Panel {
                x_axis: None,
                y_axis: error_axis(
                    &format!("error, {}", setup.truth(truth).short),
                    curves.iter().flat_map(|(_, _, y)| y).copied(),
                ),
                series: curves.iter().map(|(label, x, y)| Series::line(label, x, y)).collect(),
            }
        })
        .collect();
    let label = &setup.spaces[space].entry.label;
    let figure = LineFigure {
        title: format!("{label}: error of the corrected model for each gain, noise {} %", 100.0 * noise),
        x_axis: Axis::new("iteration", "1").with_range(1.0, setup.file.iterations.iterations as f64),
        panels,
        shaded: None,
    };
    Ok(Picture {
        name: format!("gains-{}", file_name(label)),
        svg: line_figure(&figure),
        caption: format!(
            "How fast the corrected model comes close for each gain, {label}; norm (42) with {}.",
            NORMS[Q2]
        ),
    })
}

/// Figure 22: how the optima of the first and the last iteration fly in the truth.
fn flights(findings: &Findings, ended: &Ended) -> Result<Picture> {
    let setup = &findings.setup;
    let space = &setup.spaces[ended.case.space];
    let truth = setup.truth(ended.case.truth);
    let reports = ended.campaign.reports();
    let (first, last) = (reports.first().context("an iteration")?, reports.last().context("an iteration")?);
    let mut panels = [("heading", Vec::new()), ("zenith angle", Vec::new())];
    for (when, report) in [("first", first), ("last", last)] {
        let logged = space.bat.logged(&report.screening.optimum, truth.fidelity())?;
        let t = logged.times();
        let label = format!("{when} optimum: {}", findings.point_words(ended.case.space, &report.screening.optimum));
        let heading = logged.values(|row| row.heading_rad.to_degrees());
        let zenith = logged.values(|row| row.zenith_rad().to_degrees());
        panels[0].1.push(Series::line(&label, &t, &heading));
        panels[1].1.push(Series::line(&label, &t, &zenith));
    }
    let label = &space.entry.label;
    let figure = LineFigure {
        title: format!("{label}: the optima of the first and the last iteration, {}", truth.label),
        x_axis: Axis::new("time", "s").with_range(0.0, space.bat.profile().duration_s()),
        panels: panels
            .into_iter()
            .map(|(name, series)| Panel { x_axis: None, y_axis: Axis::new(name, "deg"), series })
            .collect(),
        shaded: None,
    };
    Ok(Picture {
        name: format!("figure-22-{}", file_name(label)),
        svg: line_figure(&figure),
        caption: format!(
            "The counterpart of Figure 22, {label}: heading and zenith angle of the optima of iterations 1 and {} with {} as the truth, \
             {}, noise {} %.",
            last.number,
            truth.with_article(),
            setup.variant(ended.case).label,
            100.0 * ended.case.noise
        ),
    })
}
