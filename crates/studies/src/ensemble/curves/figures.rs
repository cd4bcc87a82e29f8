//! Figures 14, 21 and 26 over the ensemble, from what is kept of them.

use page::{Axis, LineFigure, Panel, Series, Shaded, line_figure, quantile};

use super::kept::{
    BIN_S, ERROR, ITERATIONS, LEFT, N_RANDOM, WHOLE_IMAGE, cases_of_figure21, of_bin, of_held, of_iteration, of_place,
    over,
};
use crate::chapter6;
use crate::ensemble::figures::band;
use crate::ensemble::file::Setup;
use crate::ensemble::kept::Case;
use crate::ensemble::row::{Method, Study, World};

/// Half of the plants must have a value, or none is drawn.
fn of_most(values: Vec<f64>, cases: &[Case<'_>], study: Study) -> Vec<f64> {
    let plants = cases.iter().filter(|case| case.study == study).count();
    if 2 * values.len() < plants { Vec::new() } else { values }
}

/// Figure 14: the lowest cost at each center of mass.
pub(in crate::ensemble) fn lowest(setup: &Setup, cases: &[Case<'_>]) -> String {
    let study = &setup.chapter3;
    let x = study.center_of_mass.places();
    let curve = |panel: usize| {
        move |place: usize| {
            let values = over(cases, Study::Chapter3, World::Still, &of_place(panel, place));
            of_most(values, cases, Study::Chapter3)
        }
    };
    let drawn = (0..study.configurations.len()).flat_map(|panel| {
        let of = curve(panel);
        (0..x.len()).flat_map(move |place| {
            let values = of(place);
            [0.25, 0.75].into_iter().filter_map(move |share| quantile(&values, share))
        })
    });
    let drawn: Vec<f64> = drawn.collect();
    let panels = (0..study.configurations.len()).map(|panel| Panel {
        x_axis: None,
        y_axis: Axis::new(&format!("cost, panel {}", panel + 1), "s").in_decades(drawn.clone()),
        series: band("lowest cost", &x, 0.0, &curve(panel)),
    });
    line_figure(&LineFigure {
        title: "Figure 14: the lowest open-loop cost at each center of mass, over plants".to_owned(),
        x_axis: Axis::new("center of mass", "% chord"),
        panels: panels.collect(),
        shaded: study
            .center_of_mass
            .table4
            .map(|[from, to]| Shaded { label: "range of Table 4".to_owned(), spans: vec![(from, to)] }),
    })
}

/// Errors that are less are drawn as if they were so large: the axis has no zero.
const LEAST_DRAWN_PCT: f64 = 0.1;

/// Figure 21: the error of the corrected model and what is left of the space, iteration by iteration.
pub(in crate::ensemble) fn errors(setup: &Setup, cases: &[Case<'_>]) -> String {
    let study = &setup.chapter6;
    let x = ITERATIONS.map(|iteration| iteration as f64);
    let shown: Vec<_> = cases_of_figure21(study).collect();
    let of = |case: chapter6::Case, what: &'static str| {
        move |step: usize| -> Vec<f64> {
            let name = of_iteration(study, case, ITERATIONS[step], what);
            over(cases, Study::Chapter6, World::Still, &name).into_iter().map(|share| 100.0 * share).collect()
        }
    };
    let panel = |noise: f64, what: &'static str, y_axis: Axis| {
        let mine = shown.iter().filter(|case| case.noise.to_bits() == noise.to_bits());
        let least = if what == ERROR { LEAST_DRAWN_PCT } else { 0.0 };
        let series = mine.flat_map(|case| band(&study.truth(case.truth).label, &x, least, &of(*case, what)));
        Panel { x_axis: None, y_axis, series: series.collect() }
    };
    let shares = &study.file.noise.shares;
    let highest = shown.iter().flat_map(|case| {
        let of = of(*case, ERROR);
        (0..x.len()).filter_map(move |step| quantile(&of(step), 0.75))
    });
    // One range for all panels, so that heights compare.
    let highest = highest.fold(100.0, f64::max);
    let errors = shares.iter().map(|noise| {
        let label = format!("error, noise {} %", 100.0 * noise);
        panel(*noise, ERROR, Axis::new(&label, "%").in_decades([LEAST_DRAWN_PCT, highest]))
    });
    let left = shares.iter().map(|noise| {
        let label = format!("space left, noise {} %", 100.0 * noise);
        panel(*noise, LEFT, Axis::new(&label, "%").with_range(0.0, 100.0).with_step(25.0))
    });
    line_figure(&LineFigure {
        title: "Figure 21, 2 parameters: error of the corrected model and space left, over plants".to_owned(),
        x_axis: Axis::new("iteration", "1").with_range(1.0, study.file.iterations.iterations as f64),
        panels: errors.chain(left).collect(),
        shaded: None,
    })
}

/// The designs of Figure 26, in words, and those that nobody chose.
pub(super) const DESIGNS: [(Method, &str); 3] = [
    (Method::Numerical, "model's optimum"),
    (Method::Dissertation, "end of the loop"),
    (Method::Random, "designs that nobody chose"),
];

/// Of each design of a method on all plants the share of the images without a pose, with so many pixels to spare and before the whole image;
/// not finite where it cannot fly so.
fn held(cases: &[Case<'_>], method: Method, margin_px: f64) -> impl Iterator<Item = [f64; 2]> {
    let mine = cases.iter().filter(|case| case.study == Study::Four && case.world == World::Cameras);
    mine.flat_map(move |case| {
        let held = move |seed: u64, margin_px: f64| case.fact(&of_held(method, seed, margin_px));
        (0..=N_RANDOM as u64).filter_map(move |seed| Some([held(seed, margin_px)?, held(seed, WHOLE_IMAGE)?]))
    })
}

/// Of how many designs of all plants poses are lost, with so many pixels to spare; how many cannot fly so; how many of them fly before the
/// whole image: the others say nothing about regions.
pub(super) fn lost(cases: &[Case<'_>], method: Method, margin_px: f64) -> [usize; 3] {
    let mut counts = [0; 3];
    for [held, _] in held(cases, method, margin_px).filter(|[_, whole]| whole.is_finite()) {
        counts[0] += usize::from(held > 0.0);
        counts[1] += usize::from(held.is_nan());
        counts[2] += 1;
    }
    counts
}

/// How many designs there are, and how many of them cannot fly even before the whole image.
pub(super) fn fallen(cases: &[Case<'_>], method: Method) -> [usize; 2] {
    let whole = || held(cases, method, WHOLE_IMAGE).map(|[held, _]| held);
    [whole().count(), whole().filter(|held| held.is_nan()).count()]
}

/// Figure 26: errors of the heading that was reported, and how many plants have any.
pub(in crate::ensemble) fn headings(setup: &Setup, cases: &[Case<'_>]) -> String {
    let n_bins = (setup.still.duration_s() / BIN_S).ceil() as usize;
    let t: Vec<f64> = (0..n_bins).map(|bin| bin as f64 * BIN_S).collect();
    let at = |method: Method, bin: usize| over(cases, Study::Four, World::Cameras, &of_bin(method, bin));
    let drawn: Vec<f64> = DESIGNS
        .iter()
        .flat_map(|(method, _)| (0..n_bins).flat_map(|bin| at(*method, bin)))
        .filter(|error| *error > 0.0)
        .collect();
    let errors = [DESIGNS[0], DESIGNS[1]].map(|(method, words)| {
        let share = |label: &str, share: f64| {
            let y: Vec<f64> = (0..n_bins).map(|bin| quantile(&at(method, bin), share).unwrap_or(f64::NAN)).collect();
            Series::step(label, &t, &y)
        };
        Panel {
            x_axis: Some(Axis::new("time", "s").with_range(0.0, setup.still.duration_s())),
            y_axis: Axis::new(&format!("error, {words}"), "deg").in_decades(drawn.iter().copied()),
            series: vec![
                share("median plant", 0.5),
                share("nine of ten plants are below", 0.9),
                share("worst plant", 1.0),
            ],
        }
    });
    let margins = &setup.regions.margins_px;
    let counts = DESIGNS.map(|(method, words)| {
        let y: Vec<f64> = margins
            .iter()
            .map(|margin_px| {
                let [lose, fail, n] = lost(cases, method, *margin_px);
                100.0 * (lose + fail) as f64 / n.max(1) as f64
            })
            .collect();
        Series::line(words, margins, &y)
    });
    let last = margins.last().copied().unwrap_or(1.0);
    let panels = errors.into_iter().chain([Panel {
        x_axis: Some(Axis::new("pixels to spare", "px").with_range(0.0, last)),
        y_axis: Axis::new("lose poses or the flight", "%").with_range(0.0, 100.0).with_step(25.0),
        series: counts.into(),
    }]);
    line_figure(&LineFigure {
        title: "Errors of the heading where a camera loses dots, over plants".to_owned(),
        x_axis: Axis::new("time", "s"),
        panels: panels.collect(),
        shaded: None,
    })
}
