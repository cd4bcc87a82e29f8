//! Pictures of designs: how good they are, and where they predict badly.

use anyhow::Result;
use doe::{EvaluationSettings, Model, PredictionVariance, Space, VarianceSlice, evaluate};

use super::findings::{Findings, GRID, Verified};
use crate::reproduction::Picture;
use page::{Axis, Landscape, LineFigure, Panel, Points, Series, landscape_panels_figure, line_figure};

/// Where the axes of a surface end: a little beyond the region, so that runs on its edge are drawn whole.
const EDGE: f64 = 1.05;
/// Levels per axis of a variance surface.
const SURFACE_LEVELS: usize = 61;

/// Efficiency over the number of runs, ours and the published ones.
pub(crate) fn record(verified: &Verified) -> Result<Picture> {
    let mut series = Vec::new();
    // In two factors the lines would lie on one another.
    for factors in 3..=5 {
        let kept: Vec<(f64, f64)> = verified
            .rows
            .iter()
            .filter(|row| row.size.0 == factors)
            .map(|row| (row.size.1 as f64, row.kept.efficiency.percent))
            .collect();
        let published = verified.record.published.values().filter(|case| case.factors == factors);
        let published: Vec<(f64, f64)> = published.map(|case| (case.runs as f64, case.cube)).collect();
        let line = |label: &str, points: Vec<(f64, f64)>| {
            let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            Series::line(&format!("K = {factors}, {label}"), &x, &y)
        };
        series.push(line("kept here", kept));
        series.push(line("best published", published).dashed());
    }
    let figure = LineFigure {
        title: "G-efficiency over the cube, full quadratic model".to_owned(),
        x_axis: Axis::new("number of runs N", "1"),
        panels: vec![Panel { x_axis: None, y_axis: Axis::new("G-efficiency", "%"), series }],
        shaded: None,
    };
    Ok(Picture {
        name: "record".to_owned(),
        svg: line_figure(&figure),
        caption: "The kept designs beside the best published ones, all over the whole cube, for three to five factors."
            .to_owned(),
    })
}

/// The two-factor designs with their prediction variance.
pub(crate) fn surfaces(verified: &Verified) -> Result<Picture> {
    let model = Model::quadratic(2)?;
    let mut landscapes = Vec::new();
    for row in verified.rows.iter().filter(|row| row.size.0 == 2) {
        let variance = PredictionVariance::of(&model, &row.kept.design)?;
        let slice = VarianceSlice::of(&variance, [0, 1], &[0.0, 0.0], SURFACE_LEVELS)?;
        let (runs, terms) = (row.size.1 as f64, model.n_terms() as f64);
        landscapes.push(Landscape {
            title: format!("N = {}, G-efficiency {:.2} %", row.size.1, row.kept.efficiency.percent),
            x_axis: Axis::new("x1", "coded").with_range(-EDGE, EDGE).with_step(0.5),
            y_axis: Axis::new("x2", "coded").with_range(-EDGE, EDGE).with_step(0.5),
            z_axis: Axis::new("N v(x) / p: 1 is the least possible maximum", "1").with_range(0.4, 1.4),
            x: slice.levels.clone(),
            y: slice.levels.clone(),
            z: slice
                .variances
                .chunks(SURFACE_LEVELS)
                .map(|line| line.iter().map(|v| runs * v / terms).collect())
                .collect(),
            missing_label: String::new(),
            points: vec![Points::small("run", row.kept.design.runs().map(|run| (run[0], run[1])).collect())],
            verticals: Vec::new(),
            verticals_label: String::new(),
            paths: Vec::new(),
            minimum: None,
            minimum_label: String::new(),
        });
    }
    Ok(Picture {
        name: "surfaces".to_owned(),
        svg: landscape_panels_figure("Prediction variance of the kept designs in two factors", &landscapes),
        caption: "Where each design in two factors predicts badly: its prediction variance, scaled so that designs of different \
                  size compare. A G-optimal design has several equal maxima."
            .to_owned(),
    })
}

fn fractions_of(label: &str, model: &Model, space: &Space, design: &doe::Design) -> Result<Series> {
    let evaluation = evaluate(model, space, design, &EvaluationSettings::default())?;
    let (mut x, mut y) = (Vec::new(), Vec::new());
    if let Some(precision) = evaluation.precision {
        x = precision.fraction_of_space.fractions;
        y = precision.fraction_of_space.variances;
    }
    let x: Vec<f64> = x.iter().map(|fraction| 100.0 * fraction).collect();
    let scale = design.n_runs() as f64 / model.n_terms() as f64;
    let y: Vec<f64> = y.iter().map(|v| scale * v).collect();
    Ok(Series::line(label, &x, &y))
}

fn fractions_figure(title: &str, series: Vec<Series>) -> String {
    line_figure(&LineFigure {
        title: title.to_owned(),
        x_axis: Axis::new("share of the design space", "%"),
        panels: vec![Panel { x_axis: None, y_axis: Axis::new("N v / p not exceeded", "1"), series }],
        shaded: None,
    })
}

/// Fraction-of-design-space curves of some kept designs.
pub(crate) fn fractions(verified: &Verified) -> Result<Picture> {
    let mut series = Vec::new();
    for size in [(2, 8), (3, 12), (4, 18), (5, 26)] {
        if let Some(kept) = verified.record.kept.get(&size) {
            let (model, space) = (Model::quadratic(size.0)?, Space::cube(size.0)?);
            series.push(fractions_of(&format!("K = {}, N = {}", size.0, size.1), &model, &space, &kept.design)?);
        }
    }
    Ok(Picture {
        name: "fractions".to_owned(),
        svg: fractions_figure("How much of the cube is predicted how well", series),
        caption: "Fraction of design space: the scaled prediction variance that a share of the cube does not exceed. The right \
                  end is what G-optimality makes small."
            .to_owned(),
    })
}

/// The same for the designs on the case study's grid.
pub(crate) fn grid_fractions(findings: &Findings) -> Result<Picture> {
    let mut series = Vec::new();
    for row in &findings.grid {
        let model = Model::named(row.model, GRID.len())?;
        series.push(fractions_of(
            &format!("{}, N = {}", row.model, row.runs),
            &model,
            &Space::grid(&GRID)?,
            &row.found.design,
        )?);
    }
    Ok(Picture {
        name: "fractions-grid".to_owned(),
        svg: fractions_figure("The same on the grid of the case study, 24 levels in each of four factors", series),
        caption: "Fraction of design space of the designs that this run found on the grid.".to_owned(),
    })
}
