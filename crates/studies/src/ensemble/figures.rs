//! The pictures of the page.

use design_space::Parameter;
use page::{Axis, CountFigure, LineFigure, Panel, Series, count_figure, line_figure, quantile};

use super::file::Setup;
use super::kept::Case;
use super::row::{Method, Reading, Row, Study, World};
use super::tables::Both;
use crate::rules::Verdict;

/// What becomes of claims here.
const KINDS: [Verdict; 7] = [
    Verdict::InKind,
    Verdict::InPart,
    Verdict::NotReproduced,
    Verdict::NotDiscriminating,
    Verdict::OutOfReach,
    Verdict::PartlyCalibrated,
    Verdict::Check,
];

/// What became of the claims, by study and water.
pub(super) fn verdicts(all: &[Both]) -> String {
    let kinds = KINDS.map(|verdict| (verdict.short().to_owned(), verdict.color()));
    let worlds = World::OF_CAMPAIGNS.into_iter().enumerate();
    let bars = Study::ALL.into_iter().flat_map(|study| worlds.clone().map(move |(k, world)| (study, k, world)));
    let is_judged = |both: &Both, study, k: usize| both.claim.study == study && both.judged[k].verdict().is_some();
    let bars = bars.filter(|(study, k, _)| all.iter().any(|both| is_judged(both, *study, *k)));
    let bars = bars.map(|(study, k, world)| {
        let mine = all.iter().filter(|both| both.claim.study == study);
        let count = |verdict: Verdict| mine.clone().filter(|both| both.judged[k].is(verdict)).count();
        (format!("{}, {} water", study.words(), world.name()), KINDS.iter().map(|verdict| count(*verdict)).collect())
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
pub(super) type Curve<'a> = dyn Fn(usize) -> Vec<f64> + 'a;

/// Median, solid, and quartiles, dashed; what is less than the least that is drawn is drawn there.
pub(super) fn band(label: &str, x: &[f64], least: f64, curve: &Curve<'_>) -> Vec<Series> {
    let drawn = |value: f64| if value.is_finite() { value.max(least) } else { f64::NAN };
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
        let mut series = band("dissertation's loop", &x, LEAST_DRAWN_PCT, &of(Method::Dissertation));
        series.extend(band("pooled loop", &x, LEAST_DRAWN_PCT, &of(Method::Pooled)));
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
    let all = Study::OF_CAMPAIGNS.into_iter().filter(|study| has(*study));
    let all = all.flat_map(|study| World::OF_CAMPAIGNS.map(|world| (study, world)));
    line_figure(&LineFigure {
        title: "True cost above that of the best design known, over plants and seeds".to_owned(),
        x_axis: Axis::new("experiments", "1"),
        panels: all.map(panel).collect(),
        shaded: None,
    })
}

/// Squares that span more than this are drawn by decades.
const A_DECADE: f64 = 5.0;

/// What is drawn of a design against the iterations that chose it.
struct Quantity {
    words: &'static str,
    unit: &'static str,
    of: fn(&Row) -> f64,
    /// Whether it may span decades.
    is_square: bool,
    /// What the dissertation prints of it, iteration by iteration.
    printed: Option<fn(&Setup, Study) -> Vec<f64>>,
    /// A bound of ours that it may run into.
    bound: Option<fn(&Setup) -> Option<f64>>,
}

const fn quantity(words: &'static str, unit: &'static str, of: fn(&Row) -> f64) -> Quantity {
    Quantity { words, unit, of, is_square: false, printed: None, bound: None }
}

const fn printed(printed: fn(&Setup, Study) -> Vec<f64>, quantity: Quantity) -> Quantity {
    Quantity { printed: Some(printed), ..quantity }
}

/// Of Table 3.
fn printed_design(setup: &Setup, parameter: usize) -> Vec<f64> {
    setup.chapter4.file.published.iter().map(|row| row.point()[parameter]).collect()
}

/// Of Tables 5 and 6, in per cent.
fn printed_shares(setup: &Setup, study: Study) -> Vec<f64> {
    let case = setup.chapter7.cases.get(usize::from(study == Study::Four));
    case.map_or_else(Vec::new, |case| case.published.iter().map(|row| row.share).collect())
}

/// What Figures 16 to 18 and Table 3 follow over one campaign.
const OF_CHAPTER4: [Quantity; 5] = [
    square("heading squared", |row| row.of(Reading::Heading)),
    square("roll error squared", |row| row.of(Reading::Roll)),
    square("pitch error squared", |row| row.of(Reading::Pitch)),
    printed(|setup, _| printed_design(setup, 0), quantity("center of mass", "% of chord", |row| row.point[0])),
    Quantity {
        bound: Some(|setup| setup.chapter4.problem.region().parameters().get(1).map(Parameter::upper)),
        ..printed(|setup, _| printed_design(setup, 1), quantity("pitch set point", "deg", |row| row.point[1]))
    },
];

/// What Figures 20, 22, 24 and 26 to 28 do, the roll offset and the zenith angle in place of a flight.
const OF_CHAPTER7: [Quantity; 7] = [
    printed(printed_shares, quantity("left of the space", "%", |row| 100.0 * row.share)),
    quantity("S of (39)", "s", |row| row.spread),
    square("heading squared", |row| row.of(Reading::Heading)),
    square("pitch error squared", |row| row.of(Reading::Pitch)),
    quantity("roll offset", "deg", |row| row.of(Reading::RollOffset)),
    quantity("zenith angle", "deg", |row| row.of(Reading::Zenith)),
    square_of("altitude error squared", "cm²", |row| row.of(Reading::Altitude)),
];

const fn square(words: &'static str, of: fn(&Row) -> f64) -> Quantity {
    square_of(words, "deg²", of)
}

const fn square_of(words: &'static str, unit: &'static str, of: fn(&Row) -> f64) -> Quantity {
    Quantity { is_square: true, ..quantity(words, unit, of) }
}

/// One curve of Chapters 4 and 7 each as bands over all plants and seeds: the designs of the dissertation's loop, iteration by iteration.
pub(super) fn steps(setup: &Setup, cases: &[Case<'_>], batches: &dyn Fn(Study) -> [usize; 2]) -> [String; 3] {
    let figure = |study: Study, quantities: &[Quantity]| {
        let mine: Vec<&Case<'_>> = cases.iter().filter(|case| case.study == study).collect();
        let steps = [first_step(study), batches(study)[1]];
        line_figure(&LineFigure {
            title: format!("{}: designs of the loop, over plants and seeds", study.words()),
            x_axis: Axis::new("iteration", "1").counting(steps[0], steps[1]),
            panels: quantities.iter().map(|quantity| panel_of(setup, study, quantity, &mine, steps)).collect(),
            shaded: None,
        })
    };
    [figure(Study::Chapter4, &OF_CHAPTER4), figure(Study::Two, &OF_CHAPTER7), figure(Study::Four, &OF_CHAPTER7)]
}

/// In Chapter 4 the first iteration is the optimum of the model.
fn first_step(study: Study) -> usize {
    usize::from(study == Study::Chapter4)
}

fn panel_of(setup: &Setup, study: Study, quantity: &Quantity, cases: &[&Case<'_>], [first, last]: [usize; 2]) -> Panel {
    let x: Vec<f64> = (first..=last).map(|step| step as f64).collect();
    let values = |world: World, step: usize| -> Vec<f64> {
        let mine = cases.iter().filter(|case| case.world == world);
        let rows = mine.flat_map(|case| case.rows.iter());
        let rows = rows.filter(|row| row.step == step);
        let rows = rows.filter(|row| row.method == if step == 0 { Method::Numerical } else { Method::Dissertation });
        rows.map(|row| (quantity.of)(row)).filter(|value| value.is_finite()).collect()
    };
    let mut series = Vec::new();
    let mut drawn = Vec::new();
    for world in World::OF_CAMPAIGNS {
        let label = |which: &str| format!("{} water, {which}", world.name());
        let at = |share: f64| -> Vec<f64> {
            (first..=last).map(|step| quantile(&values(world, step), share).unwrap_or(f64::NAN)).collect()
        };
        let [low, median, high] = [0.25, 0.5, 0.75].map(at);
        drawn.extend(low.iter().chain(&high).copied().filter(|value| value.is_finite()));
        series.push(Series::line(&label("median"), &x, &median));
        for quartile in [low, high] {
            series.push(Series::line(&label("quartiles"), &x, &quartile).dashed().colored_as(&label("median")));
        }
    }
    if let Some(printed) = quantity.printed {
        let printed = printed(setup, study);
        let n = printed.len().min(x.len());
        drawn.extend(printed[..n].iter().filter(|value| value.is_finite()));
        series.push(Series::line("printed in the dissertation", &x[..n], &printed[..n]));
    }
    if let Some(bound) = quantity.bound.and_then(|bound| bound(setup)) {
        drawn.push(bound);
        series.push(Series::line("bound, ours", &x, &vec![bound; x.len()]).dashed());
    }
    let y_axis = Axis::new(quantity.words, quantity.unit);
    let [low, high] =
        drawn.iter().fold([f64::INFINITY, 0.0_f64], |[low, high], value| [low.min(*value), high.max(*value)]);
    let is_wide = quantity.is_square && high > A_DECADE * low;
    let y_axis = if is_wide { y_axis.in_decades(drawn) } else { y_axis.around(drawn) };
    Panel { x_axis: None, y_axis, series }
}
