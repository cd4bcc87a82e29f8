//! Figures 11 and 12 from the flights of this run.

use super::file::Setup;
use super::models::{Case, Release, Releases};
use crate::reproduction::Picture;
use page::{Axis, LineFigure, Panel, Series, line_figure};

/// Heading and lateral position, each against absolute and normalized time.
pub(crate) fn of(setup: &Setup, releases: &Releases) -> Vec<Picture> {
    let heading =
        |release: &Release| -> Vec<f64> { release.heading_rad.iter().map(|angle| angle.to_degrees()).collect() };
    let lateral = |release: &Release| -> Vec<f64> { release.lateral_m.iter().map(|y| 100.0 * y).collect() };
    let (name, masses) = match releases.case {
        Case::Similar | Case::Rounded => ("similar", "similar masses"),
        Case::PrintedMasses | Case::PrintedMassesInSimilarHulls => ("printed-masses", "the printed masses"),
    };
    let panel =
        |x_axis: Axis, y_axis: Axis, x: &dyn Fn(&Release) -> Vec<f64>, y: &dyn Fn(&Release) -> Vec<f64>| Panel {
            x_axis: Some(x_axis),
            y_axis,
            series: releases
                .models
                .iter()
                .enumerate()
                .map(|(number, model)| {
                    let series = Series::line(&model.model, &x(model), &y(model));
                    // Where all curves lie on one another, the first is seen through the gaps of the last.
                    if number == 0 { series } else { series.dashed() }
                })
                .collect(),
        };
    let absolute = |release: &Release| release.time_s.clone();
    let normalized = |release: &Release| release.normalized_time();
    let (time, scaled) = (|| Axis::new("time t", "s"), || Axis::new("normalized time a t", "s"));
    let figure = |number: u32, what: &str, panels: Vec<Panel>| {
        let title = format!("{what} after a twist of {:.0} deg, {masses}", setup.file.release.twist_deg);
        Picture {
            name: format!("figure-{number}-{name}"),
            svg: line_figure(&LineFigure { title, x_axis: scaled(), panels, shaded: None }),
            caption: format!(
                "The counterpart of Figure {number} with {masses}: {} of the three models after their release, against time \
                 and against normalized time.",
                what.to_lowercase()
            ),
        }
    };
    vec![
        figure(
            11,
            "Heading",
            vec![
                panel(time(), Axis::new("heading", "deg"), &absolute, &heading),
                panel(scaled(), Axis::new("heading", "deg"), &normalized, &heading),
            ],
        ),
        figure(
            12,
            "Lateral position",
            vec![
                panel(time(), Axis::new("lateral position y", "cm"), &absolute, &lateral),
                panel(scaled(), Axis::new("y over tether length", "1"), &normalized, &Release::normalized_lateral),
            ],
        ),
    ]
}
