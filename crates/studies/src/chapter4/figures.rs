//! The figures of Chapter 4 from the flights and loops of this run.

use water_channel::LogRow;

use super::file::{Setup, Table3Row};
use super::lattice::Lattice;
use super::loops::Seeded;
use super::rows::{ERRORS, Row, Rows};
use super::seeds::{Followed, followed, over_seeds};
use crate::logged::Reading;
use crate::reproduction::Picture;
use crate::words::capitalized;
use page::{
    Axis, Group, Landscape, LineFigure, Panel, Path, Reference, Series, Shaded, SpreadFigure, landscape_figure,
    line_figure, spread_figure,
};

/// Everything that a picture can be made of.
pub(crate) struct Material<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) rows: &'a [Rows],
    pub(crate) model: &'a Lattice,
    pub(crate) stand_in: &'a Lattice,
    pub(crate) seeded: &'a [Seeded],
}

fn column(row: &Row, f: impl Fn(&LogRow) -> f64) -> Vec<f64> {
    row.logged.values(f)
}

fn time(row: &Row) -> Vec<f64> {
    column(row, |r| r.time_s)
}

/// Table 3 as a picture: both costs of every iteration, ours and theirs.
pub(crate) fn costs(m: &Material<'_>) -> Picture {
    let (ours, theirs) = (&m.rows[0].rows, &m.setup.file.published);
    let iterations = |n: usize| -> Vec<f64> { (1..=n).map(|iteration| iteration as f64).collect() };
    let our = |label: &str, cost: fn(&Row) -> f64| {
        Series::line(&format!("{label}, this run"), &iterations(ours.len()), &ours.iter().map(cost).collect::<Vec<_>>())
    };
    let their = |label: &str, cost: fn(&Table3Row) -> f64| {
        let costs: Vec<f64> = theirs.iter().map(cost).collect();
        Series::line(&format!("{label}, dissertation"), &iterations(theirs.len()), &costs).dashed()
    };
    let figure = LineFigure {
        title: "What each iteration's design costs, and what the corrected model says of it".to_owned(),
        x_axis: Axis::new("iteration", "1").counting_to(ours.len().max(theirs.len())),
        panels: vec![Panel {
            x_axis: None,
            y_axis: Axis::new("cost J", "s"),
            series: vec![
                our("experimental cost", |row| row.cost()),
                their("experimental cost", |row| row.experiment_cost),
                our("corrected numerical cost", |row| row.corrected_cost),
                their("corrected numerical cost", |row| row.corrected_cost),
            ],
        }],
        shaded: None,
    };
    Picture {
        name: "table-3".to_owned(),
        svg: line_figure(&figure),
        caption: "Table 3 as a picture, R = 0.1 as printed, no noise: the cost of each iteration's design in the stand-in (in the \
                  dissertation, in the water channel), and what the corrected numerical model says of it. Both ends were calibrated; \
                  the way between them is predicted."
            .to_owned(),
    }
}

/// The windows of the profile, merged where they touch.
fn windows(setup: &Setup) -> Shaded {
    let mut spans: Vec<(f64, f64)> = Vec::new();
    for window in setup.bat.profile().windows() {
        match spans.last_mut() {
            Some(span) if window.from_s <= span.1 => span.1 = span.1.max(window.to_s),
            _ => spans.push((window.from_s, window.to_s)),
        }
    }
    Shaded { label: "winches driven by the test".to_owned(), spans }
}

fn time_axis(setup: &Setup) -> Axis {
    Axis::new("time", "s").with_range(0.0, setup.bat.profile().duration_s())
}

/// Figure 15: flow speed and line commands.
pub(crate) fn test_profile(m: &Material<'_>) -> Picture {
    let row = m.rows[0].first();
    let t = time(row);
    let command = |line: usize| column(row, |r| 1000.0 * r.commands_m_s[line]);
    let figure = LineFigure {
        title: "Test profile: flow speed and winch commands".to_owned(),
        x_axis: time_axis(m.setup),
        panels: vec![
            Panel {
                x_axis: None,
                y_axis: Axis::new("flow speed", "m/s").with_range(0.19, 0.30),
                series: vec![Series::step("flow speed", &t, &column(row, |r| r.flow_speed_m_s))],
            },
            Panel {
                x_axis: None,
                y_axis: Axis::new("command", "mm/s"),
                series: vec![
                    Series::step("center line", &t, &command(0)),
                    Series::step("starboard line", &t, &command(1)),
                    Series::step("port line", &t, &command(2)),
                ],
            },
        ],
        shaded: Some(windows(m.setup)),
    };
    Picture {
        name: "figure-15-test-profile".to_owned(),
        svg: line_figure(&figure),
        caption: "The test (Figure 15 of the dissertation): three flow speeds, and in each a pull of 1 s at the port \
                  line followed by 2 s of hold; the commands are those of the first design in the stand-in."
            .to_owned(),
    }
}

fn squared(m: &Material<'_>, what: &str, number: u32, error: Reading) -> Picture {
    let (before, after) = (m.rows[0].first(), m.rows[0].last());
    let figure = LineFigure {
        title: format!("{} error squared, before and after infusion", capitalized(what)),
        x_axis: time_axis(m.setup),
        panels: vec![Panel {
            x_axis: None,
            y_axis: Axis::new(&format!("{what} error squared"), "deg²"),
            series: vec![
                Series::line(&label(m.setup, "before", before), &time(before), &before.squared_deg2(error)),
                Series::line(&label(m.setup, "after", after), &time(after), &after.squared_deg2(error)),
            ],
        }],
        shaded: None,
    };
    Picture {
        name: format!("figure-{number}-{what}"),
        svg: line_figure(&figure),
        caption: format!(
            "{} error squared over the test in the stand-in (Figure {number} of the dissertation, where the flights \
             are experiments): mean {:.2} deg² before, {:.2} deg² after.",
            capitalized(what),
            before.mean_squared_deg2(error),
            after.mean_squared_deg2(error)
        ),
    }
}

fn label(setup: &Setup, when: &str, row: &Row) -> String {
    format!("{when}: iteration {}, {}", row.iteration, setup.words(&row.point))
}

/// Figures 16 to 18.
pub(crate) fn errors(m: &Material<'_>) -> [Picture; 3] {
    ERRORS.map(|(what, number, error)| squared(m, what, number, error))
}

fn landscape(m: &Material<'_>, lattice: &Lattice, name: &'static str, title: &str, caption: &str) -> Picture {
    let (axes, z) = lattice.box_rows();
    let [x, y] = axes;
    let (lowest, cost) = lattice.lowest();
    let figure = Landscape {
        title: title.to_owned(),
        x_axis: m.setup.variable(0).axis(),
        y_axis: m.setup.variable(1).axis(),
        z_axis: Axis::new("cost J", "s"),
        x,
        y,
        z,
        missing_label: "flight failed".to_owned(),
        points: Vec::new(),
        verticals: Vec::new(),
        verticals_label: String::new(),
        paths: m
            .rows
            .iter()
            .take(3)
            .map(|rows| Path {
                label: rows.label.clone(),
                points: rows.rows.iter().map(|row| (row.point[0], row.point[1])).collect(),
            })
            .collect(),
        minimum: Some((lowest[0], lowest[1])),
        minimum_label: format!("lowest of the lattice: {cost:.3} s"),
    };
    Picture { name: name.to_owned(), svg: landscape_figure(&figure), caption: caption.to_owned() }
}

/// The two cost landscapes with the path of the optimum.
pub(crate) fn landscapes(m: &Material<'_>) -> [Picture; 2] {
    [
        landscape(
            m,
            m.model,
            "landscape-model",
            "What the model believes: cost of the uncorrected numerical model",
            "Cost of the numerical model over the box, with the path of the optimum; numbers are iterations, R is the trust in \
             the measured slopes.",
        ),
        landscape(
            m,
            m.stand_in,
            "landscape-stand-in",
            "What the experiments see: cost in the stand-in for the water channel",
            "Cost in the stand-in (stall and added mass) over the box, with the path of the optimum; numbers are iterations, \
             R is the trust in the measured slopes. An engineer never sees this picture: the loop saw five points of it per \
             iteration.",
        ),
    ]
}

/// What noise does to the path.
pub(crate) fn spreads(m: &Material<'_>) -> Vec<Picture> {
    let noise = &m.setup.file.noise;
    let picture = |followed: Followed| {
        let what = &followed.column.name;
        let groups =
            m.seeded.iter().map(|s| Group { label: s.label.clone(), values: over_seeds(m.setup, s, &followed) });
        let figure = SpreadFigure {
            title: format!("{what} over {} noise seeds", noise.seeds),
            y_axis: Axis::new(&what.to_lowercase(), &followed.column.unit),
            groups: groups.collect(),
            reference: Some(Reference {
                label: "dissertation, Table 3".to_owned(),
                values: m.setup.file.published.iter().map(followed.published).collect(),
            }),
        };
        Picture {
            name: followed.picture.to_owned(),
            svg: spread_figure(&figure),
            caption: format!(
                "{what} per iteration over {} noise seeds: median, quartiles and extremes; noise within \
                 ±{} % of J. Rows of iteration 1 were calibrated, the others are predicted.",
                noise.seeds,
                100.0 * noise.share
            ),
        }
    };
    followed(m.setup).map(picture).into()
}
