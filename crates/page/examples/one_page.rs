//! One page with a finding, a table, series over time and a landscape, and the landscape as a picture of its own.
//!
//! `cargo run --release -p infuse-page --example one_page -- page.html landscape.svg`
#![expect(clippy::print_stdout, reason = "an example talks")]

use page::{
    Axis, ColorScale, Column, Finding, Landscape, LineFigure, Page, Panel, Points, Series, Table, landscape_figure,
    line_figure,
};

/// A narrow, bent valley: most of the plane is far above its lowest place.
fn vibration(spring: f64, damper: f64) -> f64 {
    4.2 + 0.002 * (spring - 26.0).powi(2) + 9.0 * (damper - 0.8 - 0.03 * (spring - 20.0)).powi(2)
}

fn landscape() -> Landscape {
    let spring: Vec<f64> = (0..=48).map(|i| 10.0 + 0.5 * f64::from(i)).collect();
    let damper: Vec<f64> = (0..=48).map(|i| 0.5 + 0.05 * f64::from(i)).collect();
    let z = damper.iter().map(|damper| spring.iter().map(|spring| vibration(*spring, *damper)).collect()).collect();
    Landscape {
        title: "Vibration of a seat".to_owned(),
        x_axis: Axis::new("spring", "N/mm"),
        y_axis: Axis::new("damper gain", "N s/mm"),
        z_axis: Axis::new("vibration", "mm/s").with_colors(ColorScale::NearLowest),
        x: spring,
        y: damper,
        z,
        missing_label: String::new(),
        points: vec![Points::small("experiment", vec![(12.0, 0.7), (20.0, 2.4), (31.0, 1.2), (25.0, 0.9)])],
        verticals: Vec::new(),
        verticals_label: String::new(),
        paths: Vec::new(),
        minimum: Some((26.0, 0.98)),
        minimum_label: "lowest".to_owned(),
    }
}

fn decay() -> LineFigure {
    let time: Vec<f64> = (0..600).map(|i| 0.005 * f64::from(i)).collect();
    let of =
        |damping: f64| -> Vec<f64> { time.iter().map(|t| 20.0 * (-damping * t).exp() * (9.0 * t).cos()).collect() };
    LineFigure {
        title: "After a step".to_owned(),
        x_axis: Axis::new("time", "s"),
        panels: vec![Panel {
            x_axis: None,
            y_axis: Axis::new("travel", "mm"),
            series: vec![Series::line("soft", &time, &of(0.8)), Series::line("stiff", &time, &of(2.5))],
        }],
        shaded: None,
    }
}

fn main() -> std::io::Result<()> {
    let mut paths = std::env::args().skip(1);
    let path = paths.next().unwrap_or_else(|| "page.html".to_owned());
    let lowest = vibration(26.0, 0.98);
    let mut page = Page::new("A seat on a spring");
    page.key_findings(&[Finding::new(format!(
        "Best: spring 26 N/mm, damper gain 0.98 N s/mm, with {lowest:.2} mm/s."
    ))
    .with("vibration", lowest, "mm/s")]);
    let mut table = Table::new(vec![Column::words("design"), Column::number("vibration", "mm/s")]);
    for (name, spring, damper) in [("soft", 12.0, 0.6), ("best", 26.0, 0.98), ("stiff", 34.0, 2.9)] {
        table.push(vec![name.to_owned(), format!("{:.2}", vibration(spring, damper))]);
    }
    page.table(&table, "Three designs.");
    page.figure(&line_figure(&decay()), "How the seat comes to rest.");
    let picture = landscape_figure(&landscape());
    page.figure(
        &picture,
        "The whole plane. Colors change faster near the lowest value, which a linear scale would hide.",
    );
    std::fs::write(&path, page.html())?;
    println!("{path}: open it in a browser");
    if let Some(path) = paths.next() {
        std::fs::write(path, picture)?;
    }
    Ok(())
}
