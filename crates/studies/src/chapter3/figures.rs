//! Figure 14, and one flight of its test.

use water_channel::LogRow;

use super::findings::{Findings, in_table4};
use super::panels::PanelFlights;
use crate::reproduction::Picture;
use crate::variable::Variable;
use page::{
    Axis, ColorScale, Landscape, LineFigure, Panel, Points, Series, Shaded, landscape_panels_figure, line_figure,
};

/// Four landscapes with one scale of colors.
pub(crate) fn figure14(findings: &Findings<'_>, panels: &[PanelFlights<'_>], name: &str, physics: &str) -> Picture {
    let setup = findings.setup;
    let z_axis = Axis::new("cost (20)", "s").with_colors(ColorScale::NearLowest);
    let landscapes: Vec<Landscape> = panels
        .iter()
        .zip('a'..)
        .map(|(panel, letter)| Landscape {
            title: format!("({letter}) {}", panel.configuration.label),
            x_axis: Variable::CenterOfMass.axis(),
            y_axis: Axis::new("trim pitch", "deg"),
            z_axis: z_axis.clone(),
            x: setup.center_of_mass.places(),
            y: setup.trim_pitch.places(),
            z: panel
                .rows
                .iter()
                .map(|row| row.iter().map(|design| design.cost().unwrap_or(f64::NAN)).collect())
                .collect(),
            missing_label: "a line goes slack, or the state leaves the model".to_owned(),
            points: vec![Points::small(
                "unstable",
                panel
                    .unstable()
                    .filter(|design| design.cost().is_some())
                    .map(|design| (design.at[0], design.at[1]))
                    .collect(),
            )],
            verticals: setup.center_of_mass.table4.map_or(Vec::new(), |bounds| bounds.to_vec()),
            verticals_label: "bounds of Table 4".to_owned(),
            paths: Vec::new(),
            minimum: panel.best(|design| in_table4(setup, design)).map(|(best, _)| (best.at[0], best.at[1])),
            minimum_label: "best stable design within Table 4".to_owned(),
        })
        .collect();
    Picture {
        name: name.to_owned(),
        svg: landscape_panels_figure(&format!("Open-loop cost in {physics}"), &landscapes),
        caption: format!(
            "The counterpart of Figure 14 in {physics}: cost (20) over trim pitch and center of mass, for four settings of fin \
             incidence and lines. Colors go by the distance from the lowest cost of the four panels, so those of the two physics differ."
        ),
    }
}

/// The lowest cost of a stable design at each center of mass, in every configuration.
pub(crate) fn lowest(findings: &Findings<'_>) -> Picture {
    let setup = findings.setup;
    let x = setup.center_of_mass.places();
    let series: Vec<(&str, Vec<f64>)> = findings
        .stand_in
        .iter()
        .map(|panel| (&*panel.configuration.label, (0..x.len()).map(|place| panel.lowest_at(place)).collect()))
        .collect();
    let shown = series.iter().flat_map(|(_, costs)| costs).copied().filter(|cost| cost.is_finite());
    let figure = LineFigure {
        title: "The lowest open-loop cost at each center of mass, in the stand-in".to_owned(),
        x_axis: Axis::new("center of mass", "% chord"),
        panels: vec![Panel {
            x_axis: None,
            y_axis: Axis::new("cost (20)", "s").in_decades(shown.collect::<Vec<_>>()),
            series: series.iter().map(|(label, costs)| Series::line(label, &x, costs)).collect(),
        }],
        shaded: setup
            .center_of_mass
            .table4
            .map(|[from, to]| Shaded { label: "range of Table 4".to_owned(), spans: vec![(from, to)] }),
    };
    Picture {
        name: "lowest-costs".to_owned(),
        svg: line_figure(&figure),
        caption: "Figure 14 in short: of the stable designs with the same center of mass the one whose trim pitch gives the lowest \
                  cost (20), in each of the four configurations, flown in the stand-in. Where a curve is missing no design is stable."
            .to_owned(),
    }
}

/// What one open-loop flight looks like.
pub(crate) fn one_flight(findings: &Findings<'_>) -> Picture {
    let rows = &findings.shown.rows;
    let column = |f: fn(&LogRow) -> f64| -> Vec<f64> { rows.iter().map(f).collect() };
    let t = column(|row| row.time_s);
    let panel = |y_axis: Axis, series: Vec<Series>| Panel { x_axis: None, y_axis, series };
    let line = |k: usize| -> Vec<f64> { rows.iter().map(|row| 1000.0 * row.commands_m_s[k]).collect() };
    let figure = LineFigure {
        title: "The open-loop test: the best design of the first panel".to_owned(),
        x_axis: Axis::new("time", "s").with_range(0.0, findings.setup.profile.duration_s()),
        panels: vec![
            panel(Axis::new("flow speed", "m/s"), vec![Series::step("flow", &t, &column(|row| row.flow_speed_m_s))]),
            panel(
                Axis::new("command", "mm/s"),
                vec![
                    Series::step("line 1, center", &t, &line(0)),
                    Series::step("line 2, starboard", &t, &line(1)),
                    Series::step("line 3, port", &t, &line(2)),
                ],
            ),
            panel(
                Axis::new("heading", "deg"),
                vec![Series::line("heading", &t, &column(|row| row.heading_rad.to_degrees()))],
            ),
            panel(
                Axis::new("lateral position", "mm"),
                vec![Series::line("lateral position", &t, &column(|row| 1000.0 * row.lateral_m))],
            ),
        ],
        shaded: None,
    };
    Picture {
        name: "one-flight".to_owned(),
        svg: line_figure(&figure),
        caption: "One flight of the test in the stand-in: at each speed the three lines are reeled in, held and let out one after \
                  the other; between and after that the lines keep their lengths. The times of the sequence are ours."
            .to_owned(),
    }
}
