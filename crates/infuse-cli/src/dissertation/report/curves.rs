//! The surfaces along one parameter after the other, through the best design.

use anyhow::Result;
use page::palette::{BLUE, GREEN, INK, LIGHT_BLUE, ORANGE, VERMILION};
use page::{Chart, Grid, Key, Mark, Page, Stroke};

use super::last::{Last, Origin};
use crate::dissertation::findings::ranges;

const SIZE_PX: (f64, f64) = (448.0, 270.0);
/// Places at which a curve is evaluated.
const POINTS: u32 = 121;

type Line = Vec<(f64, f64)>;

pub(super) fn write(page: &mut Page, last: &Last) -> Result<()> {
    let ranges = ranges(last.campaign, last.campaign.now.retained())?;
    let figures = ranges.iter().enumerate().map(|(parameter, &range)| figure(last, parameter, range));
    let figures = figures.collect::<Result<Vec<_>>>()?;
    page.subheading(&format!("Along each parameter, through the best design of batch {}", last.report.number));
    let is_flat = last.parameters().len() == 1;
    let place = if is_flat {
        "Experiments are drawn as measured."
    } else {
        "An experiment was made at other settings of the other parameters, so it is not drawn as measured, but as far from \
         the curve as it was from the combined surface."
    };
    let extrapolated = if last.report.number > 1 {
        " Beyond what was left when the batch began, curves are extrapolated."
    } else {
        ""
    };
    page.charts(
        &figures,
        &legend(last),
        &format!(
            "The combined surface is the one that designs are judged by: it joins training experiments with simulations \
             that earlier batches have corrected. {place} Validation experiments were not used for it; how far they are \
             off is S.{extrapolated}"
        ),
    );
    Ok(())
}

fn figure(last: &Last, parameter: usize, range: (f64, f64)) -> Result<Chart> {
    let surfaces = last.surfaces;
    let lines = [
        (curve(last, &surfaces.simulation, parameter)?, Stroke::Dashes, ORANGE),
        (curve(last, &surfaces.numerical, parameter)?, Stroke::Dots, GREEN),
        (curve(last, &surfaces.combined, parameter)?, Stroke::Solid, BLUE),
    ];
    let points = points(last, parameter)?;
    let best = (last.report.screening.optimum[parameter], last.response().of_cost(last.report.screening.optimum_value));
    let bounds = &last.parameters()[parameter];
    let room = 0.02 * bounds.width();
    let run_at = points.iter().map(|(point, _)| point.0);
    let x = last.axis(parameter).covering(bounds.lower() - room, bounds.upper() + room, run_at);
    let drawn = lines.iter().flat_map(|(line, ..)| line.iter().map(|point| point.1));
    let y = last.response_axis().around(drawn.chain(points.iter().map(|(point, _)| point.1)));
    let mut chart = Chart::new(SIZE_PX, &x, &y, Grid::Hidden);
    chart.band(range.0, range.1, LIGHT_BLUE);
    chart.outline();
    for (line, stroke, color) in &lines {
        chart.line(line, *stroke, color);
    }
    for (point, origin) in points {
        chart.mark(point, mark(origin), INK);
    }
    chart.mark(best, Mark::Target, VERMILION);
    Ok(chart)
}

fn curve(last: &Last, surface: &infuse::global::TracedSurface, parameter: usize) -> Result<Line> {
    let bounds = &last.parameters()[parameter];
    let point = |index: u32| {
        let x = bounds.lower() + bounds.width() * f64::from(index) / f64::from(POINTS - 1);
        Ok((x, last.value(surface, &last.moved(&[(parameter, x)]))?))
    };
    (0..POINTS).map(point).collect()
}

/// The experiments that gave a value, moved along the combined surface to the line.
fn points(last: &Last, parameter: usize) -> Result<Vec<((f64, f64), Origin)>> {
    let combined = &last.surfaces.combined;
    let mut points = Vec::new();
    for run in &last.runs {
        let Some(cost) = run.cost else { continue };
        let x = run.settings[parameter];
        let missed = last.response().of_cost(cost) - last.value(combined, &run.settings)?;
        points.push(((x, last.value(combined, &last.moved(&[(parameter, x)]))? + missed), run.origin));
    }
    Ok(points)
}

fn mark(origin: Origin) -> Mark {
    match origin {
        Origin::Training => Mark::Dot,
        Origin::Validation => Mark::Ring,
        Origin::Imported => Mark::Square,
    }
}

fn legend(last: &Last) -> Vec<Key> {
    let mut keys = vec![
        Key::new("combined surface").line(Stroke::Solid, BLUE),
        Key::new("simulation alone").line(Stroke::Dashes, ORANGE),
        Key::new("corrected simulation").line(Stroke::Dots, GREEN),
        Key::new("best design").mark(Mark::Target, VERMILION),
    ];
    let is_there = |origin: Origin| last.runs.iter().any(|run| run.origin == origin && run.cost.is_some());
    for (origin, text) in [
        (Origin::Training, "training experiment"),
        (Origin::Validation, "validation experiment"),
        (Origin::Imported, "imported experiment"),
    ] {
        if is_there(origin) {
            keys.push(Key::new(text).mark(mark(origin), INK));
        }
    }
    keys.push(Key::new("range of the designs left").field(LIGHT_BLUE));
    keys
}
