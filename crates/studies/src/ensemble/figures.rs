//! The pictures of the page.

use page::{Axis, CountFigure, LineFigure, Panel, Series, count_figure, line_figure, palette, quantile};

use super::judge::Verdict;
use super::kept::Case;
use super::row::{Method, Study, World};
use super::tables::Both;

fn color(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::InKind => palette::GREEN,
        Verdict::InPart => palette::ORANGE,
        Verdict::Not => palette::VERMILION,
        Verdict::NotDiscriminating => "#bbbbbb",
        Verdict::PartlyCalibrated | Verdict::NotJudged => "#888888",
    }
}

/// What became of the claims, by study and water.
pub(super) fn verdicts(all: &[Both]) -> String {
    let kinds = Verdict::COUNTED.map(|verdict| (verdict.to_string(), color(verdict)));
    let worlds = World::OF_CAMPAIGNS.into_iter().enumerate();
    let bars = Study::ALL.into_iter().flat_map(|study| worlds.clone().map(move |(k, world)| (study, k, world)));
    let bars = bars.map(|(study, k, world)| {
        let mine = all.iter().filter(|both| both.claim.study == study);
        let count = |verdict: Verdict| mine.clone().filter(|both| both.judged[k].verdict == verdict).count();
        (format!("{}, {} water", study.words(), world.name()), Verdict::COUNTED.iter().map(|v| count(*v)).collect())
    });
    count_figure(&CountFigure {
        title: "What became of the claims over the ensemble".to_owned(),
        x_axis: Axis::new("claims", "1"),
        kinds: kinds.into(),
        bars: bars.collect(),
    })
}

/// Designs that are nearer to the best are drawn as if they were so far above it: the axis has no zero.
const LEAST_DRAWN_PCT: f64 = 0.1;

/// A reading of a way after a batch, over all plants and seeds.
type Curve<'a> = dyn Fn(usize) -> Vec<f64> + 'a;

/// Median, solid, and quartiles, dashed.
fn band(label: &str, x: &[f64], curve: &Curve<'_>) -> Vec<Series> {
    let drawn = |value: f64| if value.is_finite() { value.max(LEAST_DRAWN_PCT) } else { f64::NAN };
    let at = |share: f64| -> Vec<f64> {
        (0..x.len()).map(|step| quantile(&curve(step), share).map_or(f64::NAN, drawn)).collect()
    };
    let (median, quartiles) = (format!("{label}, median"), format!("{label}, quartiles"));
    let line = |share: f64| Series::line(&quartiles, x, &at(share)).dashed().colored_as(&median);
    vec![Series::line(&median, x, &at(0.5)), line(0.25), line(0.75)]
}

/// Cost above that of the best design known against the number of experiments, in per cent.
pub(super) fn regret(cases: &[Case<'_>], batches: &dyn Fn(Study) -> [usize; 2]) -> String {
    let panel = |(study, world): (Study, World)| {
        let [experiments, last] = batches(study);
        let x: Vec<f64> = (0..=last).map(|batch| (experiments * batch) as f64).collect();
        let mine: Vec<&Case<'_>> = cases.iter().filter(|case| case.study == study && case.world == world).collect();
        let of = |method: Method| {
            let mine = &mine;
            move |batch: usize| -> Vec<f64> {
                mine.iter()
                    .flat_map(|case| {
                        // In Chapter 4 the first iteration is the optimum of the model.
                        let before = batch == 0;
                        let rows = case.rows.iter().filter(move |row| {
                            if before {
                                row.method == Method::Numerical
                            } else {
                                row.method == method && row.step == batch
                            }
                        });
                        rows.map(|row| 100.0 * case.regret(row))
                    })
                    .collect()
            }
        };
        let mut series = band("dissertation's loop", &x, &of(Method::Dissertation));
        series.extend(band("pooled loop", &x, &of(Method::Pooled)));
        let of_all = |method: Method| -> Vec<f64> {
            mine.iter().flat_map(|case| case.ends(method).into_iter().map(|row| 100.0 * case.regret(row))).collect()
        };
        for (label, method) in
            [("random design, median", Method::Random), ("center of the box, median", Method::Center)]
        {
            let level = quantile(&of_all(method), 0.5).unwrap_or(f64::NAN);
            series.push(Series::line(label, &x, &vec![level; x.len()]));
        }
        let step = experiments as f64;
        let highest = (0..=last).filter_map(|batch| quantile(&of(Method::Dissertation)(batch), 0.75));
        let highest = highest.filter(|value| value.is_finite()).fold(10.0, f64::max);
        Panel {
            x_axis: Some(Axis::new("experiments", "1").with_range(0.0, step * last as f64).with_step(step)),
            y_axis: Axis::new(&format!("{}, {}", study.words(), world.name()), "%")
                .in_decades([LEAST_DRAWN_PCT, highest]),
            series,
        }
    };
    let has = |study: Study| cases.iter().any(|case| case.study == study);
    let all = Study::ALL.into_iter().filter(|study| has(*study));
    let all = all.flat_map(|study| World::OF_CAMPAIGNS.map(|world| (study, world)));
    line_figure(&LineFigure {
        title: "True cost above that of the best design known, over plants and seeds".to_owned(),
        x_axis: Axis::new("experiments", "1"),
        panels: all.map(panel).collect(),
        shaded: None,
    })
}
