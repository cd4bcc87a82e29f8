//! `docs/results-speed.md`: a ratio for each task.

use std::path::Path;

use anyhow::Result;
use page::{Column, Table, quantile};

use super::lists::{GOAL, Searched};
use crate::kept;
use crate::words::{number, verdict};

const PAGE: &str = "docs/results-speed.md";

/// A task with its times.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) task: &'static str,
    pub(super) reference: &'static str,
    pub(super) goal: f64,
    /// Ours and the reference's, round by round.
    pub(super) seconds: Vec<[f64; 2]>,
    /// A part of it that it can't do without, and how long that takes.
    pub(super) part: Option<(&'static str, Vec<f64>)>,
}

/// Of the shell, its default first.
pub(super) const METHODS: [&str; 2] = ["pooled", "dissertation"];

/// A call of the shell with one method, batch by batch.
#[derive(Debug)]
pub(super) struct Called {
    pub(super) call: &'static str,
    pub(super) method: &'static str,
    pub(super) goal: f64,
    pub(super) seconds: Vec<f64>,
}

/// All of a run.
#[derive(Debug)]
pub(super) struct Measured {
    pub(super) rows: Vec<Row>,
    pub(super) searched: Vec<Searched>,
    pub(super) called: Vec<Called>,
    pub(super) built: Vec<Built>,
}

/// What was built from nothing.
#[derive(Debug)]
pub(super) struct Built {
    pub(super) words: &'static str,
    pub(super) seconds: f64,
}

impl Row {
    /// How many times as fast as the reference: lowest, median and highest over the rounds.
    fn ratios(&self) -> [f64; 3] {
        let ratios: Vec<f64> = self.seconds.iter().map(|[ours, theirs]| theirs / ours).collect();
        [0.0, 0.5, 1.0].map(|share| quantile(&ratios, share).unwrap_or(f64::NAN))
    }

    /// The part in words, how many milliseconds it takes, and how many times as fast as the reference the whole would be if it took no
    /// longer; medians over the rounds.
    fn of_part(&self) -> Option<(&'static str, f64, f64)> {
        let (words, seconds) = self.part.as_ref()?;
        let ratios: Vec<f64> = self.seconds.iter().zip(seconds).map(|([_, theirs], part)| theirs / part).collect();
        Some((*words, 1e3 * quantile(seconds, 0.5)?, quantile(&ratios, 0.5)?))
    }

    fn median_ms(&self, which: usize) -> f64 {
        let times: Vec<f64> = self.seconds.iter().map(|times| 1e3 * times[which]).collect();
        quantile(&times, 0.5).unwrap_or(f64::NAN)
    }
}

pub(super) fn write(root: &Path, measured: &Measured, n_threads: usize, versions: &str) -> Result<()> {
    kept::write(root, &[(PAGE, markdown(measured, n_threads, versions))])
}

fn markdown(measured: &Measured, n_threads: usize, versions: &str) -> String {
    let Measured { rows, searched, called, built } = measured;
    let mut text = "# How fast\n\n".to_owned();
    text += &goals(rows);
    text += &span(rows);
    text += &calls(called);
    text += &searches(searched);
    if let [first, .., all] = built.as_slice() {
        text += &format!(
            "- From nothing, {} is compiled in {} s; {} in {} s, {} times as long.\n",
            first.words,
            number(first.seconds, 0),
            all.words,
            number(all.seconds, 0),
            number(all.seconds / first.seconds, 1)
        );
    }
    text += "- Flights beside C code that CasADi writes have a goal of their own and [a page of their own](results-flights.md), by `cargo xtask speed --flights`.\n";
    text.push('\n');
    text += &table(rows).markdown();
    text += &within_reach(rows);
    text += &format!(
        "\nMedians of {} rounds of one run, ours and the reference in turn, after one for the caches; in brackets the lowest and the \
         highest ratio of a round. Surfaces and the process are asked at all 331,776 points of 24 levels in four factors, surfaces once \
         as a grid, of which only the levels are in memory, and once as points like any others; ours on {} threads, the reference ({versions}) on those that it takes, in slices that stay in the cache. \
         Ours fills an array that is kept, the reference makes one for each slice; adding up the estimates is in neither time. Both give \
         the same sums to 1e-9, but for the process: ours has a quadratic trend besides.\n\n\
         ## The shell\n\n{}\n\
         A campaign over the same 331,776 designs, whose simulations lie in a table of as many rows: five batches of 18 experiments, each \
         asked for, told and looked at. The first call reads the table, the others its index. With `dissertation` the model is its default.\n\n\
         ## Designs over a list\n\n{}\n\
         Until a search on one thread over the same points as a list reaches 99 % of the best G-efficiency that a minute on {} threads \
         finds over them as a grid; full quadratic, ten seeds. One that takes longer than two minutes counts as two minutes.\n\n\
         ## From nothing\n\n{}\n\
         Release builds, each in an empty target folder of its own, with all packages fetched before.\n\n\
         Written by `cargo xtask speed`, which needs a Python with numpy, scipy and scikit-learn; times are those of the machine, so \
         that `cargo xtask ci` does not repeat them.\n",
        rows.first().map_or(0, |row| row.seconds.len()),
        n_threads,
        calls_table(called).markdown(),
        searches_table(searched).markdown(),
        n_threads,
        builds_table(built).markdown()
    );
    text
}

/// How many goals are met, and by how much the others are missed.
fn goals(rows: &[Row]) -> String {
    let missed: Vec<&Row> = rows.iter().filter(|row| row.ratios()[1] < row.goal).collect();
    if missed.is_empty() {
        return "- All goals for single tasks are met in this run.\n".to_owned();
    }
    let by = |row: &&Row| {
        let times = number(row.ratios()[1], 1);
        format!("{}, {times} times as fast as {} for a goal of {}", row.task, row.reference, number(row.goal, 0))
    };
    let missed: Vec<String> = missed.iter().map(by).collect();
    let n_met = rows.len() - missed.len();
    format!(
        "- Of {} goals for single tasks {n_met} are met in this run. Missed are: {}.\n",
        rows.len(),
        missed.join("; ")
    )
}

/// What of a missed goal a part of the task already takes.
fn within_reach(rows: &[Row]) -> String {
    let missed = rows.iter().filter(|row| row.ratios()[1] < row.goal);
    let sentence = |row: &Row| {
        let (words, ms, times) = row.of_part()?;
        let verdict = if times < row.goal {
            "so the goal is out of reach for this formula on this machine"
        } else {
            "so there is room left"
        };
        let (ms, times, goal) = (number(ms, 2), number(times, 1), number(row.goal, 0));
        Some(format!(
            "- {}: {words}, take {ms} ms, {times} times as fast as {} for a goal of {goal}: {verdict}.\n",
            row.task, row.reference
        ))
    };
    let sentences: Vec<String> = missed.filter_map(sentence).collect();
    if sentences.is_empty() {
        return String::new();
    }
    format!("\nOf what is missed, what can't be done without:\n\n{}", sentences.concat())
}

/// What is gained least and most.
fn span(rows: &[Row]) -> String {
    let order = |a: &&Row, b: &&Row| a.ratios()[1].total_cmp(&b.ratios()[1]);
    let words = |row: &Row| format!("{}, {} times as fast as {}", row.task, number(row.ratios()[1], 1), row.reference);
    match (rows.iter().min_by(order), rows.iter().max_by(order)) {
        (Some(least), Some(most)) => format!("- Least is gained by: {}. Most by: {}.\n", words(least), words(most)),
        _ => String::new(),
    }
}

/// The median and the largest.
fn middle_and_most(seconds: &[f64]) -> [f64; 2] {
    [0.5, 1.0].map(|share| quantile(seconds, share).unwrap_or(f64::NAN))
}

/// The 90th percentile.
fn nine_of_ten(seconds: &[f64]) -> f64 {
    quantile(seconds, 0.9).unwrap_or(f64::NAN)
}

/// How long the calls of the default method take.
fn calls(called: &[Called]) -> String {
    let says = |called: &Called| {
        let [median, most] = middle_and_most(&called.seconds);
        format!("`{}` takes {} s, at most {} s", called.call, number(median, 2), number(most, 2))
    };
    let default: Vec<String> = called.iter().filter(|called| called.method == METHODS[0]).map(says).collect();
    let missed = called.iter().filter(|called| middle_and_most(&called.seconds)[0] > called.goal);
    let missed: Vec<String> = missed.map(|called| format!("`{}` with `{}`", called.call, called.method)).collect();
    let verdict =
        if missed.is_empty() { "all goals are met".to_owned() } else { format!("missed by {}", missed.join(", ")) };
    format!("- At 331,776 designs {}: {verdict}.\n", default.join(", "))
}

fn calls_table(called: &[Called]) -> Table {
    let row = |called: &Called| {
        let [median, most] = middle_and_most(&called.seconds);
        vec![
            format!("`{}`", called.call),
            format!("`{}`", called.method),
            number(median, 2),
            number(most, 2),
            number(called.goal, 2),
            verdict(median <= called.goal).to_owned(),
        ]
    };
    Table {
        columns: vec![
            Column::words("call"),
            Column::words("method"),
            Column::number("median", "s"),
            Column::number("longest", "s"),
            Column::number("goal for the median", "s"),
            Column::words(""),
        ],
        rows: called.iter().map(row).collect(),
    }
}

/// How long nine of ten searches take at most.
fn searches(searched: &[Searched]) -> String {
    let says = |searched: &Searched| {
        let nine = nine_of_ten(&searched.seconds);
        format!("{} s with {} runs ({})", number(nine, 1), searched.n_runs, verdict(nine <= GOAL))
    };
    let all: Vec<String> = searched.iter().map(says).collect();
    format!(
        "- Nine of ten searches over a list of as many points are within 1 % of the best after {}; the goal is {} s.\n",
        all.join(" and "),
        number(GOAL, 0)
    )
}

fn searches_table(searched: &[Searched]) -> Table {
    let row = |searched: &Searched| {
        let [median, most] = middle_and_most(&searched.seconds);
        vec![
            searched.n_runs.to_string(),
            number(searched.best, 3),
            number(median, 1),
            number(nine_of_ten(&searched.seconds), 1),
            number(most, 1),
        ]
    };
    Table {
        columns: vec![
            Column::number("runs", ""),
            Column::number("best G-efficiency", "%"),
            Column::number("median", "s"),
            Column::number("90th percentile", "s"),
            Column::number("longest", "s"),
        ],
        rows: searched.iter().map(row).collect(),
    }
}

fn builds_table(built: &[Built]) -> Table {
    let all = built.last().map_or(f64::NAN, |all| all.seconds);
    let row = |one: &Built| vec![one.words.to_owned(), number(one.seconds, 0), number(100.0 * one.seconds / all, 0)];
    Table {
        columns: vec![
            Column::words("what is compiled"),
            Column::number("time", "s"),
            Column::number("of everything", "%"),
        ],
        rows: built.iter().map(row).collect(),
    }
}

fn table(rows: &[Row]) -> Table {
    let row = |row: &Row| {
        let [low, median, high] = row.ratios().map(|ratio| number(ratio, 1));
        vec![
            row.task.to_owned(),
            row.reference.to_owned(),
            number(row.median_ms(0), 2),
            number(row.median_ms(1), 1),
            format!("{median} ({low} to {high})"),
            number(row.goal, 0),
        ]
    };
    Table {
        columns: vec![
            Column::words("task"),
            Column::words("reference"),
            Column::number("ours", "ms"),
            Column::number("reference", "ms"),
            Column::number("times as fast", ""),
            Column::number("goal", ""),
        ],
        rows: rows.iter().map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_it_is_said_which_goals_are_missed_and_by_how_much() {
        let row = |task, ratio: f64| Row {
            task,
            reference: "another",
            goal: 12.0,
            seconds: vec![[1.0, ratio]; 3],
            part: None,
        };
        let rows = [row("a quick task", 36.0), row("a slow task", 11.5), row("a task", 12.0)];
        let missed = "- Of 3 goals for single tasks 2 are met in this run. Missed are: a slow task, 11.5 times as fast as another for a goal of 12.\n";
        assert_eq!(goals(&rows), missed);
        let span = span(&rows);
        assert!(span.contains("Least is gained by: a slow task") && span.contains("Most by: a quick task"), "{span}");
    }

    #[test]
    fn a_part_that_misses_the_goal_says_that_it_is_out_of_reach() {
        let row = |part: f64| Row {
            task: "a task",
            reference: "another",
            goal: 12.0,
            seconds: vec![[0.002, 0.020], [0.002, 0.022]],
            part: Some(("its sums alone", vec![part; 2])),
        };
        let out = "- a task: its sums alone, take 1.80 ms, 11.7 times as fast as another for a goal of 12: so the goal is out of reach";
        assert!(within_reach(&[row(0.0018)]).contains(out), "{}", within_reach(&[row(0.0018)]));
        assert!(
            within_reach(&[row(0.0015)])
                .contains("14.0 times as fast as another for a goal of 12: so there is room left")
        );
        let met = Row { seconds: vec![[0.001, 0.022]], ..row(0.0005) };
        assert_eq!(within_reach(&[met]), "");
    }

    #[test]
    fn ratios_are_those_of_rounds() {
        let seconds = vec![[0.001, 0.010], [0.002, 0.030], [0.001, 0.040]];
        let row = Row { task: "a task", reference: "a reference", goal: 12.0, seconds, part: None };
        let off =
            row.ratios().into_iter().zip([10.0_f64, 15.0, 40.0]).map(|(found, expected)| (found - expected).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{:?}", row.ratios());
        let built = [Built { words: "the half", seconds: 20.0 }, Built { words: "the whole", seconds: 50.0 }];
        let searched = vec![Searched { n_runs: 18, best: 77.8, seconds: (1..=10).map(f64::from).collect() }];
        let called =
            |call, seconds: [f64; 3]| Called { call, method: METHODS[0], goal: 0.5, seconds: seconds.to_vec() };
        let called = vec![called("ask", [0.3, 0.2, 0.9]), called("tell", [0.6, 0.7, 0.1])];
        let measured = Measured { rows: vec![row], searched, called, built: built.into() };
        let text = markdown(&measured, 2, "numpy 2");
        let calls = "- At 331,776 designs `ask` takes 0.30 s, at most 0.90 s, `tell` takes 0.60 s, at most 0.70 s: missed by `tell` with `pooled`.";
        assert!(text.contains(calls), "{text}");
        assert!(text.contains("of the best after 9.1 s with 18 runs (missed); the goal is 5 s."), "{text}");
        assert!(
            text.contains("15.0 (10.0 to 40.0)") && text.contains("- All goals for single tasks are met in this run."),
            "{text}"
        );
        let compiled = "- From nothing, the half is compiled in 20 s; the whole in 50 s, 2.5 times as long.";
        assert!(text.contains(compiled) && text.contains("| the half | 20 | 40 |"), "{text}");
    }
}
