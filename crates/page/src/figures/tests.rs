//! What every figure promises: it says what it shows, draws no number that is none, and stays small.

use super::*;

/// The most that a figure may weigh in a page.
const MAX_BYTES: usize = 300_000;

#[track_caller]
fn check(svg: &str, texts: &[&str]) {
    assert!(svg.starts_with("<svg viewBox=") && svg.ends_with("</svg>"), "an SVG document: {svg:.100}");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "only numbers");
    assert!(svg.len() <= MAX_BYTES, "{} bytes", svg.len());
    for text in texts {
        assert!(svg.contains(&format!(">{text}<")), "the text `{text}`");
    }
}

fn flight(amplitude: f64) -> (Vec<f64>, Vec<f64>) {
    (0..=12_000)
        .map(|sample| {
            let time = f64::from(sample) * 0.025;
            (time, (amplitude * (0.9 * time).sin()).powi(2))
        })
        .unzip()
}

fn errors() -> LineFigure {
    let (time, before) = flight(0.3);
    let (_, after) = flight(0.2);
    let panel = |quantity: &str| Panel {
        x_axis: None,
        y_axis: Axis::new(quantity, "rad²"),
        series: vec![Series::line("before", &time, &before), Series::line("after", &time, &after)],
    };
    LineFigure {
        title: "Errors & <more>".into(),
        x_axis: Axis::new("time", "s"),
        panels: vec![panel("yaw²"), panel("roll²"), panel("pitch²")],
        shaded: Some(Shaded { label: "perturbation".into(), spans: vec![(20.0, 23.0), (290.0, 400.0)] }),
    }
}

#[test]
fn line_figure_names_what_it_shows() {
    let texts = ["Errors &amp; &lt;more&gt;", "time (s)", "yaw² (rad²)", "before", "after", "perturbation", "300"];
    let svg = line_figure(&errors());
    check(&svg, &texts);
    assert_eq!(svg.matches(">before<").count(), 1, "one legend for all panels");
    assert_eq!(svg.matches(">300<").count(), 1, "one row of times");
}

#[test]
fn series_of_a_family_share_a_color_and_not_a_name() {
    let (x, y) = ([0.0, 1.0], [1.0, 2.0]);
    let series = vec![
        Series::line("a, median", &x, &y).colored_as("a"),
        Series::line("a, quartiles", &x, &y).dashed().colored_as("a"),
        Series::line("b", &x, &y),
    ];
    let panel = Panel { x_axis: None, y_axis: Axis::new("cost", "s"), series };
    let figure =
        LineFigure { title: "Bands".into(), x_axis: Axis::new("batch", "1"), panels: vec![panel], shaded: None };
    let svg = line_figure(&figure);
    check(&svg, &["a, median", "a, quartiles", "b"]);
    // Two points of each line, and its two in the legend.
    let count = |color: &str| svg.matches(&format!("fill=\"{color}\"")).count();
    assert_eq!([count(canvas::color(0)), count(canvas::color(2))], [4, 0], "{svg}");
    assert_eq!(count(canvas::color(1)), 2, "{svg}");
}

#[test]
fn same_figure_is_the_same_text() {
    let (first, second) = (line_figure(&errors()), line_figure(&errors()));
    assert!(first == second, "drawn twice");
    for clip in 1..=3 {
        assert_eq!(first.matches(&format!("url(#clip-{clip})")).count(), 1, "each panel has its clip path");
        assert_eq!(first.matches(&format!("id=\"clip-{clip}\"")).count(), 1, "each panel has its clip path");
    }
}

#[test]
fn series_with_gaps_and_steps_are_drawn() {
    let x = [0.0, 1.0, 2.0, 3.0];
    let y = [1.0, f64::NAN, -3.0, 4.0];
    let figure = LineFigure {
        title: "Shapes".into(),
        x_axis: Axis::new("iteration", "1").counting_to(3),
        panels: vec![Panel {
            x_axis: None,
            y_axis: Axis::new("value", "1").with_range(-5.0, 5.0),
            series: vec![Series::line("line", &x, &y), Series::step("step", &x, &y), Series::line("nothing", &[], &[])],
        }],
        shaded: None,
    };
    check(&line_figure(&figure), &["iteration", "value", "step", "\u{2212}4"]);
}

fn landscape(value: impl Fn(f64, f64) -> f64) -> Landscape {
    let x: Vec<f64> = (0..24).map(|i| 45.65 + 0.25 * f64::from(i)).collect();
    let y: Vec<f64> = (0..24).map(|i| 10.0 + 0.5 * f64::from(i)).collect();
    let z = y.iter().map(|y| x.iter().map(|x| value(*x, *y)).collect()).collect();
    Landscape {
        title: "Cost".into(),
        x_axis: Axis::new("center of mass", "% chord"),
        y_axis: Axis::new("pitch", "deg"),
        z_axis: Axis::new("cost", "s"),
        x,
        y,
        z,
        missing_label: "flight failed".into(),
        points: Vec::new(),
        verticals: Vec::new(),
        verticals_label: String::new(),
        paths: vec![Path { label: "optimum".into(), points: vec![(46.1, 17.3), (50.1, 18.9), (50.1, 18.9)] }],
        minimum: Some((48.0, 18.0)),
        minimum_label: "lowest".into(),
    }
}

fn bowl(x: f64, y: f64) -> f64 {
    4.0 + 0.1 * (x - 48.0).powi(2) + 0.1 * (y - 18.0).powi(2)
}

#[test]
fn landscape_names_what_it_shows() {
    let svg = landscape_figure(&landscape(bowl));
    check(&svg, &["center of mass (% chord)", "pitch (deg)", "cost (s)", "optimum", "lowest", "1", "2–3"]);
    assert!(!svg.contains("flight failed"), "nothing is missing");
}

#[test]
fn landscape_counts_what_is_missing() {
    let svg = landscape_figure(&landscape(|x, y| if x < 46.0 { f64::NAN } else { bowl(x, y) }));
    check(&svg, &["blank: flight failed (48 of 576)"]);
}

#[test]
fn landscape_without_any_value_is_blank() {
    let svg = landscape_figure(&landscape(|_, _| f64::NAN));
    check(&svg, &["blank: flight failed (576 of 576)"]);
}

#[test]
fn landscape_of_one_value_is_drawn() {
    check(&landscape_figure(&landscape(|_, _| 4.0)), &["cost (s)"]);
}

#[test]
fn far_higher_corner_does_not_flatten_the_rest() {
    let svg = landscape_figure(&landscape(|x, y| bowl(x, y) + if x > 51.0 { 1000.0 } else { 0.0 }));
    check(&svg, &["cost (s)"]);
    assert!(!svg.contains(">1000<"), "the colors end with the bowl");
}

#[test]
fn scale_of_colors_says_what_it_does() {
    let with = |colors: ColorScale| {
        let mut landscape = landscape(|x, y| bowl(x, y).powi(4));
        landscape.z_axis = landscape.z_axis.with_colors(colors);
        landscape
    };
    check(&landscape_figure(&with(ColorScale::NearLowest)), &["lowest", "+100", "cost (s) above the lowest, 256"]);
    let mirrored = landscape_figure(&with(ColorScale::NearHighest));
    check(&mirrored, &["highest"]);
    assert!(mirrored.contains(">cost (s) below the highest, "), "the bar says so");
    check(&landscape_figure(&with(ColorScale::EqualShares)), &["cost (s), equally many cells in each color"]);
    let z_axis = Axis::new("cost", "s").with_colors(ColorScale::NearLowest);
    let z = with(ColorScale::NearLowest).z;
    let (x, y) = (with(ColorScale::NearLowest).x, with(ColorScale::NearLowest).y);
    let figure = CellFigure {
        title: "Cells".into(),
        x_axis: Axis::new("spring", "N"),
        y_axis: Axis::new("damper", "N s"),
        z_axis,
        panels: vec![CellPanel { title: "one".into(), x, y, z, points: Vec::new(), minimum: None }],
        missing_label: String::new(),
        minimum_label: String::new(),
    };
    let svg = cell_figure(&figure);
    check(&svg, &["lowest", "cost (s) above the lowest, 256"]);
    let fills: std::collections::BTreeSet<&str> = svg.split("fill=\"#").skip(1).map(|rest| &rest[..6]).collect();
    assert!(fills.len() > 6, "the cells have many colors: {fills:?}");
}

#[test]
fn panels_share_their_scale_of_colors_and_their_legend() {
    let of = |title: &str, value: fn(f64, f64) -> f64| Landscape {
        title: title.into(),
        points: vec![Points::small("unstable", vec![(47.0, 15.0)])],
        ..landscape(value)
    };
    let panels = [
        of("low", bowl),
        of("high", |x, y| 2.0 * bowl(x, y)),
        of("gap", |x, y| if x < 46.0 { f64::NAN } else { bowl(x, y) }),
    ];
    let svg = landscape_panels_figure("Three", &panels);
    let texts = ["Three", "low", "high", "gap", "center of mass (% chord)", "pitch (deg)", "unstable", "lowest"];
    check(&svg, &texts);
    check(&svg, &["blank: flight failed", "20"]);
    for once in ["unstable", "lowest", "blank: flight failed", "cost (s)"] {
        assert_eq!(svg.matches(&format!(">{once}<")).count(), 1, "`{once}` is said once");
    }
    check(&landscape_panels_figure("None", &[]), &["None"]);
}

#[test]
fn panel_with_an_axis_of_its_own_shows_it() {
    let (t, y) = flight(0.3);
    let half: Vec<f64> = t.iter().map(|t| 0.5 * t).collect();
    let panel = |axis: Option<Axis>, x: &[f64]| Panel {
        x_axis: axis,
        y_axis: Axis::new("heading", "rad"),
        series: vec![Series::line("model", x, &y)],
    };
    let figure = LineFigure {
        title: "Two times".into(),
        x_axis: Axis::new("unused", "s"),
        panels: vec![panel(Some(Axis::new("time", "s")), &t), panel(Some(Axis::new("normalized time", "1")), &half)],
        shaded: None,
    };
    let svg = line_figure(&figure);
    check(&svg, &["Two times", "time (s)", "normalized time", "300", "140"]);
    assert!(!svg.contains("unused"), "an axis that no panel uses");
}

#[test]
fn spread_names_what_it_shows() {
    let figure = SpreadFigure {
        title: "Cost over seeds".into(),
        y_axis: Axis::new("cost", "s"),
        groups: vec![
            Group { label: "R = 0.1".into(), values: vec![vec![6.8, 6.9, f64::NAN], vec![6.1, 6.3, 6.2], vec![]] },
            Group { label: "R = 1".into(), values: vec![vec![6.5]] },
        ],
        reference: Some(Reference { label: "printed".into(), values: vec![6.85, 6.12, 5.81] }),
    };
    let texts = ["iteration", "3", "cost (s)", "R = 0.1", "R = 1", "printed"];
    check(&spread_figure(&figure), &texts);
}

#[test]
fn spread_of_nothing_is_drawn() {
    let figure =
        SpreadFigure { title: "Nothing".into(), y_axis: Axis::new("cost", "s"), groups: Vec::new(), reference: None };
    check(&spread_figure(&figure), &["Nothing"]);
}
