//! The page of the sheet: what to do next, the rows of the form, and what is known.

use anyhow::Result;
use design_space::Parameter;
use infuse::pooled::Trial;
use maud::{Markup, html};
use page::Finding;

use super::form::{Refused, Row, field, known, state};
use super::frame::{document, sentences, text};
use super::work::State;
use crate::campaign::{Campaign, Stage};
use crate::number::count;
use crate::problem::{Held, shown};
use crate::sheet::to_fill_in;

/// While something goes on the page is loaded again.
const REFRESH_S: u32 = 2;

/// What the page shows besides the campaign.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) work: State,
    /// What `status` says.
    pub(super) known: Vec<Vec<Finding>>,
    pub(super) notices: Vec<String>,
    /// Rows that were sent and not taken.
    pub(super) refused: Refused,
    /// Why something that was sent was not done.
    pub(super) error: Option<String>,
}

pub(super) fn page(campaign: &dyn Campaign, shown: &Shown) -> Result<String> {
    let stage = campaign.stage()?;
    let is_busy = matches!(shown.work, State::Busy(_));
    let is_waiting = is_busy && shown.refused.is_empty();
    let title = &campaign.problem().title;
    let body = html! {
        h1 { (title) }
        (next(campaign, &stage, shown))
        // What is typed while the page looks again would be lost.
        @if !is_waiting { (form(campaign, &shown.refused)) }
        h2 { "What is known" }
        @for block in &shown.known { section { (sentences(block)) } }
        @if campaign.experiments().readings.values().any(|reading| reading.first.as_ref().is_some_and(|first| first.value().is_some())) {
            h2 { "Pictures" }
            iframe class="pictures" src="/pictures" title="Pictures of what is known, drawn again as results come" {}
        }
        (more(campaign, is_busy))
    };
    Ok(document(title, is_waiting.then_some(REFRESH_S), &body))
}

/// What to do next, and what became of what was done.
fn next(campaign: &dyn Campaign, stage: &Stage, shown: &Shown) -> Markup {
    html! {
        div class="next" {
            @match &shown.work {
                State::Busy(since) => p class="busy" {
                    strong { "Choosing the next experiments, and simulating" } ", since " (since)
                    ". This page looks again by itself; it may be closed meanwhile."
                },
                State::Nothing | State::Done(_) | State::Failed(_) => (to_do(campaign, stage)),
            }
            @match &shown.work {
                State::Failed(error) => p class="fault" role="alert" { (text(error)) },
                State::Done(notices) => @for notice in notices { p { "Note: " (text(notice)) } },
                State::Nothing | State::Busy(_) => {},
            }
            @for notice in &shown.notices { p { "Note: " (text(notice)) } }
            @if let Some(error) = &shown.error { p class="fault" role="alert" { (text(error)) } }
            @if !shown.refused.is_empty() {
                p class="fault" role="alert" {
                    "Nothing was taken"
                    @if !shown.refused.values().all(Row::is_right) { ": see the rows with a red bar" }
                    ". What was typed is still there."
                }
            }
        }
    }
}

fn to_do(campaign: &dyn Campaign, stage: &Stage) -> Markup {
    let n = campaign.experiments().n_outstanding();
    let button = |words: &str, name: Option<&str>| {
        html! {
            form method="post" action="/ask" {
                button class="main" name=[name] value=[name.map(|_| "yes")] { (words) }
            }
        }
    };
    html! {
        @match stage {
            Stage::Pending => p {
                strong { "Run the experiments below in their order" } ", fill in what they gave, and save: "
                (count(n, "result")) " to go. What is empty is left for later."
            },
            Stage::Ready => {
                p { strong { "Next: choose the experiments of the next batch." } " This may simulate for a while." }
                (button("Choose the next experiments", None))
            },
            Stage::Ended { reason, may_go_on } => {
                p { strong { "Ended: " } (text(reason)) "." }
                @if *may_go_on { (button("Go on all the same", Some("anyway"))) }
            },
        }
    }
}

/// The batches that are waited for; or the last one, so that it can be corrected.
fn form(campaign: &dyn Campaign, refused: &Refused) -> Markup {
    let experiments = campaign.experiments();
    let mut batches = experiments.open_batches();
    if batches.is_empty() {
        batches.extend(experiments.last_batch());
    }
    let seed = campaign.problem().seed;
    html! {
        @if !batches.is_empty() {
            form method="post" action="/tell" autocomplete="off" {
                @for batch in batches {
                    h2 { "Batch " (batch) }
                    ol class="sheet" {
                        @for (index, (trial, repeats)) in experiments.in_run_order(batch, seed).iter().enumerate() {
                            (row(campaign, index + 1, trial, *repeats, refused.get(&trial.id.number())))
                        }
                    }
                }
            }
        }
    }
}

fn row(campaign: &dyn Campaign, run: usize, trial: &Trial, repeats: Option<u64>, refused: Option<&Row>) -> Markup {
    let (problem, experiments) = (campaign.problem(), campaign.experiments());
    let id = trial.id.number();
    let has_result = experiments.has_result(trial.id);
    let known = known(problem, experiments.readings.get(&id));
    // Who has seen what is known now may replace it.
    let was = state(problem, trial, &known);
    let mark = match (refused, has_result) {
        (Some(row), _) if !row.is_right() => "refused",
        (_, true) => "told",
        (_, false) => "open",
    };
    html! {
        li id={ "row-" (id) } class=(mark) {
            div class="head" {
                span class="run" { "Run " (run) }
                span class="id" {
                    "experiment " (id)
                    @if let Some(first) = repeats { ", repeats " (first) }
                    @if has_result { " " span class="done" { "has a result" } }
                }
            }
            dl class="settings" {
                @for (parameter, &setting) in problem.region.parameters().iter().zip(&trial.point) {
                    div {
                        dt { (parameter.name()) }
                        dd { (shown(parameter, setting)) @if shows(parameter.unit()) { " " small { (parameter.unit()) } } }
                    }
                }
            }
            @if let Some(fault) = refused.and_then(|row| row.fault.as_ref()) { p class="fault" { (text(fault)) } }
            input type="hidden" name=(field(id, None)) value=(was);
            (fields(campaign, id, &known, refused))
        }
    }
}

fn shows(unit: &str) -> bool {
    !["", "1"].contains(&unit)
}

/// What is measured, in sight; why it failed, other settings and the note behind a word, unless they say something.
fn fields(campaign: &dyn Campaign, id: u64, known: &[String], refused: Option<&Row>) -> Markup {
    let problem = campaign.problem();
    let headings = to_fill_in(problem);
    let n_measured = 1 + problem.constraints.len();
    let value = |place: usize| match refused {
        Some(row) => row.typed.get(place).map_or("", String::as_str),
        None => known.get(place).map_or("", String::as_str),
    };
    let is_fault = |place: usize| refused.is_some_and(|row| row.faults.contains_key(&place));
    let is_open = (n_measured..headings.len()).any(|place| !value(place).is_empty() || is_fault(place));
    let input = |place: usize| {
        // Choices and reasons are words.
        let parameter = place.checked_sub(n_measured + 1).and_then(|at| problem.region.parameters().get(at));
        let choices = parameter.and_then(Parameter::choices);
        let is_number = place < n_measured || parameter.is_some_and(|parameter| parameter.choices().is_none());
        let bounds = place.checked_sub(1).and_then(|at| problem.constraints.get(at)).map(Held::bounds);
        let name = field(id, Some(place));
        let fault = refused.and_then(|row| row.faults.get(&place));
        html! {
            label class=[fault.map(|_| "wrong")] {
                span { (headings[place]) @if let Some(bounds) = bounds { ": " (bounds) } }
                @if let Some(choices) = choices { (choice(&name, choices, value(place))) } @else {
                    input type="text" name=(name) value=(value(place)) inputmode=[is_number.then_some("decimal")]
                        autofocus[fault.is_some()] aria-invalid=[fault.map(|_| "true")] aria-describedby=[fault.map(|_| format!("{name}-fault"))];
                }
                @if let Some(fault) = fault { span class="fault" id={ (name) "-fault" } { (text(fault)) } }
            }
        }
    };
    html! {
        div class="fields" {
            @for place in 0..n_measured { (input(place)) }
            button name="row" value=(id) { @if known.iter().all(String::is_empty) { "Save" } @else { "Correct" } }
        }
        details open[is_open] {
            summary { "It failed, was set otherwise, or needs a note" }
            div class="fields" { @for place in n_measured..headings.len() { (input(place)) } }
        }
    }
}

/// One of these, or as it was asked for; what was typed by other means is kept.
fn choice(name: &str, choices: &[String], value: &str) -> Markup {
    let is_other = !value.is_empty() && !choices.iter().any(|choice| choice == value);
    html! {
        select name=(name) {
            option value="" selected[value.is_empty()] { "as asked for" }
            @for choice in choices { option value=(choice) selected[choice == value] { (choice) } }
            @if is_other { option value=(value) selected { (value) } }
        }
    }
}

fn more(campaign: &dyn Campaign, is_busy: bool) -> Markup {
    let (problem, experiments) = (campaign.problem(), campaign.experiments());
    let (has_begun, is_pending) = (experiments.last_batch().is_some(), experiments.n_outstanding() > 0);
    let has_queue =
        problem.simulator.queue().is_some() || problem.experiment.as_ref().is_some_and(|one| one.queue.is_some());
    html! {
        nav {
            a href="/" { "Look again" }
            @if has_begun { a href="/report" { "The report" } }
            @if has_begun && !is_busy { a href="/confirm" { "Confirm what was gained" } }
            @if is_pending && !is_busy { a href="/more" { "Another batch beside this one" } }
            @if has_queue { a href="/cancel" { "Stop what is in the queue" } }
            @if has_begun && !is_busy { a href="/undo" { "Take the last thing back" } }
            a href="/status.json" { "All numbers (JSON)" }
        }
    }
}
