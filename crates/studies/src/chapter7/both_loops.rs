//! The pooled loop beside that of the dissertation and those who know less: sentences, a table, a figure.

use page::{Axis, Column, Finding, LineFigure, Panel, Series, Summary, Table, line_figure};

use super::campaigns::Runs;
use super::file::Case;
use super::findings::{Findings, Found};
use super::pooled::PooledStep;
use crate::bat::STAND_IN;
use crate::reproduction::Picture;

/// What the section is called.
pub(crate) const HEADING: &str = "The pooled loop, on the same rig";

pub(crate) const WHAT: &str = "The loop of `infuse::pooled` is not the dissertation's. It keeps all experiments and the simulation in one \
    surface, drops nothing for good, and says after every batch how much better than its recommendation another design may be. Here it \
    meets the same stand-in (no experiment was made for it either), the same cells, the same seeds of noise, and the same numbers of \
    experiments and simulations in every batch; its own draws follow from the seed of the noise. It looks for a \
    displacement of the simulation, as it does by itself, and for no drift of the stand-in, which has none. Nothing in it was tuned to this rig.";

const CAPTION: &str = "True cost: in the stand-in, without noise, of printed rows too. Regret: that less the cost of the best design known. Random \
    design: all cells of the grid that is flown in whole, each as likely. Certificate: no design is better than the recommended one by \
    more, says the pooled loop, which does not know the truth. Held: campaigns whose regret is within it.";

pub(crate) const PICTURE: &str = "both-loops";

/// What a line shows of the seeds, by name.
type Reading = (&'static str, fn(&Summary) -> f64);

/// Seconds, or a dash where there are none.
fn seconds(value: f64) -> String {
    if value.is_finite() { crate::words::number(value, 3) } else { "–".to_owned() }
}

/// A row: what was done, and what the designs of all seeds truly cost.
struct Row<'a> {
    batch: usize,
    n_experiments: usize,
    way: &'a str,
    costs: Vec<f64>,
    /// Median of the certificates, and how many held.
    certified: Option<(f64, usize)>,
}

impl Row<'_> {
    fn words(&self, best: f64) -> Vec<String> {
        let Self { batch, n_experiments, way, costs, certified } = self;
        let Some(Summary { count, minimum, median, maximum, .. }) = Summary::of(costs) else {
            return [&batch.to_string(), &n_experiments.to_string(), *way, "0", "–", "–", "–", "–", "–"]
                .map(str::to_owned)
                .to_vec();
        };
        let spread =
            if count > 1 { format!("{} … {}", seconds(minimum), seconds(maximum)) } else { "–".to_owned() };
        let (bound, held) = certified.map_or(("–".to_owned(), "–".to_owned()), |(bound, held)| {
            (seconds(bound), format!("{held} of {count}"))
        });
        let counts = [batch.to_string(), n_experiments.to_string(), (*way).to_owned(), count.to_string()];
        counts.into_iter().chain([seconds(median), spread, seconds(median - best), bound, held]).collect()
    }
}

/// How many certificates held: the true cost is above that of the best design known by no more.
fn held(steps: &[&PooledStep], best: f64) -> usize {
    steps.iter().filter(|step| step.cost - best <= step.certificate.bound).count()
}

/// Both loops, batch by batch, after those who make no experiment.
pub(crate) fn table(case: &Case, found: &Found) -> Table {
    let mut table = Table::new(vec![
        Column::new("Batch", "1"),
        Column::new("Experiments", "1"),
        Column::new("Way", ""),
        Column::new("Designs", "1"),
        Column::new("True cost, median", "s"),
        Column::new("smallest … largest", "s"),
        Column::new("Regret, median", "s"),
        Column::new("Certificate, median", "s"),
        Column::new("Held", "1"),
    ]);
    let mut push = |batch, way: &str, costs, certified| {
        let n_experiments = batch * case.entry.batch.experiments;
        table.push(Row { batch, n_experiments, way, costs, certified }.words(found.best.cost));
    };
    let flown: Vec<f64> = found.truth.values().iter().map(|(_, cost)| *cost).collect();
    push(0, "random design", flown, None);
    push(0, "center of the box", vec![found.pooled.center_cost], None);
    push(0, "simulation's own choice", vec![found.numerical_true_cost], None);
    for batch in 1..=case.entry.iterations {
        if let Some(row) = case.published.get(batch) {
            let cost = case.bat.cost(&row.point, STAND_IN).unwrap_or(f64::NAN);
            push(batch, &format!("Table {}, as printed", case.entry.table), vec![cost], None);
        }
        for runs in &found.runs {
            push(batch, &dissertations(runs), runs.over_seeds(batch, |step| step.cost), None);
        }
        let steps: Vec<&PooledStep> = found.pooled.after(batch).collect();
        let bounds: Vec<f64> = steps.iter().map(|step| step.certificate.bound).collect();
        let costs = steps.iter().map(|step| step.cost).collect();
        let certified = Summary::of(&bounds).map(|bounds| (bounds.median, held(&steps, found.best.cost)));
        push(batch, "pooled loop", costs, certified);
    }
    table
}

fn dissertations(runs: &Runs) -> String {
    format!("dissertation's loop, {}", runs.label)
}

pub(crate) fn caption(case: &Case, found: &Found) -> String {
    let most = |count: fn(&super::pooled::PooledCampaign) -> usize| {
        found.pooled.campaigns.iter().map(count).max().unwrap_or(0)
    };
    let batch = &case.entry.batch;
    format!(
        "{}: {} experiments and {} simulations in a campaign of the dissertation's loop, {} and at most {} in one of the pooled loop, \
         whose certificates are for {:.0} %. {CAPTION}",
        case.entry.label,
        case.entry.iterations * batch.experiments,
        case.entry.iterations * batch.simulations,
        most(|campaign| campaign.n_experiments),
        most(|campaign| campaign.n_simulations),
        100.0 * found.pooled.after(1).next().map_or(f64::NAN, |step| step.certificate.probability),
    )
}

/// Where both loops end in one study, in the medians, and seed by seed.
struct Ends {
    pooled: f64,
    dissertations: f64,
    lower: usize,
    n_seeds: usize,
}

impl Ends {
    fn of(case: &Case, found: &Found, runs: &Runs) -> Self {
        let (last, best) = (case.entry.iterations, found.best.cost);
        let pooled: Vec<f64> = found.pooled.after(last).map(|step| step.cost - best).collect();
        let other = runs.over_seeds(last, |step| step.cost - best);
        // Both begin with the first seed of the noise.
        let lower = pooled.iter().zip(&other).filter(|(pooled, other)| pooled < other).count();
        let n_seeds = pooled.len().min(other.len());
        let median = |regrets: &[f64]| Summary::of(regrets).map_or(f64::NAN, |summary| summary.median);
        Self { pooled: median(&pooled), dissertations: median(&other), lower, n_seeds }
    }
}

/// How many certificates there are over all batches of all studies, and how many held.
fn certificates(findings: &Findings) -> [usize; 2] {
    let each = findings.cases().flat_map(|(case, found)| {
        (1..=case.entry.iterations).map(|batch| {
            let steps: Vec<&PooledStep> = found.pooled.after(batch).collect();
            [steps.len(), held(&steps, found.best.cost)]
        })
    });
    each.fold([0, 0], |[n, held], [more, more_held]| [n + more, held + more_held])
}

/// What was found, in one sentence.
pub(crate) fn finding(findings: &Findings) -> Finding {
    let [n, held] = certificates(findings);
    let each = |regret: &dyn Fn(&Case, &Found) -> f64| {
        let words = findings.cases().map(|(case, found)| format!("{:.3}", regret(case, found)));
        words.collect::<Vec<_>>().join(" and ")
    };
    let ends = |number: usize| {
        move |case: &Case, found: &Found| found.runs.get(number).map(|runs| Ends::of(case, found, runs))
    };
    let labels: Vec<&str> = findings.cases().map(|(case, _)| case.entry.label.as_str()).collect();
    let dissertations = findings.setup.file.variant.iter().enumerate().map(|(number, variant)| {
        let regret = |case: &Case, found: &Found| ends(number)(case, found).map_or(f64::NAN, |ends| ends.dissertations);
        format!("The dissertation's loop with the {}: {} s.", variant.label, each(&regret))
    });
    let pooled = |case: &Case, found: &Found| ends(0)(case, found).map_or(f64::NAN, |ends| ends.pooled);
    let finding = Finding::new(format!(
        "So far above the best design known a loop ends with the same budget in the median ({}):",
        labels.join("; ")
    ));
    let finding = finding
        .with_sentences([format!(
            "The pooled loop, which is not the dissertation's: {} s; {held} of {n} of its certificates held.",
            each(&pooled)
        )])
        .with_sentences(dissertations)
        .with_sentences([format!(
            "The center of the box: {} s.",
            each(&|_, found| found.pooled.center_cost - found.best.cost)
        )]);
    let finding = findings.cases().fold(finding, |finding, (case, found)| {
        let name = format!("regret of the pooled loop, {}", case.entry.label);
        let finding = finding.with(&name, pooled(case, found), "s");
        found.runs.iter().fold(finding, |finding, runs| {
            let name = format!("regret of the dissertation's loop, {}, {}", case.entry.label, runs.label);
            finding.with(&name, Ends::of(case, found, runs).dissertations, "s")
        })
    });
    finding.with("certificates", n as f64, "1").with("certificates that held", held as f64, "1")
}

/// What is to be read under the table of a study.
pub(crate) fn words(case: &Case, found: &Found) -> Vec<String> {
    let best = found.best.cost;
    let mut words: Vec<String> = found
        .runs
        .iter()
        .map(|runs| {
            let Ends { pooled, dissertations, lower, n_seeds } = Ends::of(case, found, runs);
            format!(
                "After the last batch the pooled loop ends {pooled:.3} s above the best design known in the median, the dissertation's \
                 loop with the {} {dissertations:.3} s; with the same noise it ends lower for {lower} of {n_seeds} seeds.",
                runs.label
            )
        })
        .collect();
    let without = [
        ("the center of the box", found.pooled.center_cost - best),
        ("the simulation's own choice", found.numerical_true_cost - best),
    ];
    let without = without.map(|(what, regret)| format!("{what} {regret:.3} s"));
    words.push(format!("Without any experiment: {}.", without.join(", ")));
    let last: Vec<&PooledStep> = found.pooled.after(case.entry.iterations).collect();
    let bounds: Vec<f64> = last.iter().map(|step| step.certificate.bound).collect();
    if let Some(bounds) = Summary::of(&bounds) {
        words.push(format!(
            "The certificate is wide: after the last batch it is {:.3} s in the median, with a range of the true cost of {:.2} s. It held \
             in {} of {} campaigns there.",
            bounds.median,
            found.truth.range(),
            held(&last, best),
            last.len()
        ));
    }
    words
}

/// A design that is nearer to the best than this, in s, is drawn as if it were so far above it: the axis has no zero.
const NEAREST_DRAWN_S: f64 = 1e-4;

/// True cost against experiments, both loops, in both studies.
pub(crate) fn picture(findings: &Findings) -> Picture {
    let figure = LineFigure {
        title: "Regret of the recommended design: its true cost above that of the best known".to_owned(),
        x_axis: Axis::new("experiments", "1"),
        panels: findings.cases().map(|(case, found)| panel(case, found)).collect(),
        shaded: None,
    };
    Picture {
        name: PICTURE.to_owned(),
        svg: line_figure(&figure),
        caption: "The cost in the stand-in, without noise, of the design that each loop recommends after so many experiments, less \
                  that of the best design known: medians over the seeds of noise, and the least and most of the seeds. At 0 \
                  experiments: the optimum of the numerical model. Designs within 0.1 ms of the best are drawn there. The axes of \
                  the regret are logarithmic, each with a range of its own."
            .to_owned(),
    }
}

fn panel(case: &Case, found: &Found) -> Panel {
    let n = case.entry.iterations;
    let x: Vec<f64> = (0..=n).map(|batch| (batch * case.entry.batch.experiments) as f64).collect();
    let above = |cost: f64| (cost - found.best.cost).clamp(NEAREST_DRAWN_S, f64::INFINITY);
    let drawn = |costs: &dyn Fn(usize) -> Vec<f64>, reading: fn(&Summary) -> f64| -> Vec<f64> {
        let later =
            (1..=n).map(|batch| Summary::of(&costs(batch)).map_or(f64::NAN, |summary| above(reading(&summary))));
        std::iter::once(above(found.numerical_true_cost)).chain(later).collect()
    };
    let (mut series, mut shown) = (Vec::new(), Vec::new());
    let mut draw = |way: &str, costs: &dyn Fn(usize) -> Vec<f64>, readings: &[Reading]| {
        for (name, reading) in readings {
            let values = drawn(costs, *reading);
            shown.extend(values.iter().copied().filter(|value| value.is_finite()));
            let line = Series::line(&format!("{way}, {name}"), &x, &values).colored_as(way);
            series.push(if *name == "median" { line } else { line.dashed() });
        }
    };
    let all: [Reading; 3] =
        [("median", |s| s.median), ("least and most", |s| s.minimum), ("least and most", |s| s.maximum)];
    for (number, runs) in found.runs.iter().enumerate() {
        // Of the other regressors the median is enough.
        let readings = if number == 0 { &all[..] } else { &all[..1] };
        draw(&dissertations(runs), &|batch| runs.over_seeds(batch, |step| step.cost), readings);
    }
    draw("pooled loop", &|batch| found.pooled.after(batch).map(|step| step.cost).collect(), &all);
    let step = case.entry.batch.experiments as f64;
    Panel {
        x_axis: Some(Axis::new("experiments", "1").with_range(0.0, step * n as f64).with_step(step)),
        y_axis: Axis::new(&format!("regret, {}", case.entry.label), "s").in_decades(shown),
        series,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_median_spread_regret_and_certificates_as_far_as_there_are_any() {
        let row = |costs: &[f64], certified| {
            let row = Row { batch: 2, n_experiments: 24, way: "a loop", costs: costs.to_vec(), certified };
            row.words(1.5).join("|")
        };
        assert_eq!(row(&[3.0, 1.0, 2.0], Some((0.75, 2))), "2|24|a loop|3|2.000|1.000 … 3.000|0.500|0.750|2 of 3");
        assert_eq!(row(&[1.25], None), "2|24|a loop|1|1.250|–|−0.250|–|–");
        assert_eq!(row(&[f64::NAN], None), "2|24|a loop|0|–|–|–|–|–", "a design that does not fly");
    }
}
