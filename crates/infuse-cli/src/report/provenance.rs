//! Where all of it comes from.

use design_space::Levels;
use infuse::Role;
use serde::Serialize;

use crate::campaign::Campaign;
use crate::journal::{Event, JOURNAL, Journal};
use crate::number::{count, plain, setting, with_unit};
use crate::problem::{Goal, PROBLEM, Problem, Simulator, step};
use page::{Column, Page, Table};

pub(super) fn write(page: &mut Page, campaign: &Campaign, journal: &Journal) {
    let problem = &campaign.problem;
    page.section("provenance", "Provenance");
    page.table(&parameters(problem), "What can be set.");
    let rows = [from_problem(problem), from_loop(problem), from_files(journal)].concat();
    let table = Table {
        columns: vec![Column::words("what"), Column::words("value")],
        rows: rows.into_iter().map(|(what, value)| vec![what.to_owned(), value]).collect(),
    };
    page.table(&table, &format!("The rest of {PROBLEM}, and what this page was made from."));
}

fn parameters(problem: &Problem) -> Table {
    let row = |(parameter, role): (&design_space::Parameter, &Role)| {
        let (levels, step) = match parameter.levels() {
            Levels::Count(n) => (n.to_string(), setting(step(parameter), step(parameter))),
            Levels::Continuous => ("any".to_owned(), "any".to_owned()),
        };
        let role = match role {
            Role::Plant => "plant",
            Role::Controller => "controller",
        };
        let name = parameter.name().to_owned();
        let unit = parameter.unit().to_owned();
        vec![name, unit, plain(parameter.lower()), plain(parameter.upper()), step, levels, role.to_owned()]
    };
    Table {
        columns: vec![
            Column::words("parameter"),
            Column::words("unit"),
            Column::number("lower", ""),
            Column::number("upper", ""),
            Column::number("step", ""),
            Column::number("levels", ""),
            Column::words("role"),
        ],
        rows: problem.region.parameters().iter().zip(&problem.roles).map(row).collect(),
    }
}

type Row = (&'static str, String);

fn from_problem(problem: &Problem) -> Vec<Row> {
    let response = &problem.response;
    let goal = match response.goal {
        Goal::Minimize => "minimized",
        Goal::Maximize => "maximized",
    };
    let bound =
        |word: &str, bound: Option<f64>| bound.map(|bound| format!(", {word} {}", plain(bound))).unwrap_or_default();
    let limits = bound("at least", response.lower) + &bound("at most", response.upper);
    let mut rows = vec![("response", format!("{}, {goal}{limits}", response.heading()))];
    rows.push(match &problem.simulator {
        Simulator::Table(path) => ("simulator", format!("the table {}", path.display())),
        Simulator::Program { program, .. } => ("simulator", format!("the command {}", program.command.join(" "))),
    });
    rows.push(match &problem.experiment {
        Some(program) => ("experiment", format!("the command {}", program.command.join(" "))),
        None => ("experiment", "by people".to_owned()),
    });
    let worth = problem.worth.map_or_else(|| "not said".to_owned(), |w| with_unit(&plain(w), &response.unit));
    rows.push(("least gain that another batch is worth", worth));
    rows
}

fn from_loop(problem: &Problem) -> Vec<Row> {
    let settings = &problem.settings;
    let names: Vec<&str> = problem.names().collect();
    let repeats = match settings.replicates {
        0 => String::new(),
        n => format!(", {n} of them repeats"),
    };
    vec![
        ("terms of the surfaces", settings.model.term_names(&names).join(", ")),
        ("experiments per batch", format!("{}{repeats}", settings.n_experiments)),
        ("simulations per batch", settings.n_simulations.to_string()),
        ("batches at most", settings.max_iterations.to_string()),
        ("confidence of the test", plain(settings.confidence)),
        ("gain of the correction", as_written(&settings.correction.gain)),
        (
            "weight of an experiment, of a simulation",
            format!("{}, {}", plain(settings.experiment_weight), plain(settings.simulation_weight)),
        ),
        (
            "surfaces of experiments, of simulations, combined",
            [settings.surfaces.experiment, settings.surfaces.simulation, settings.surfaces.combined]
                .map(|kind| as_written(&kind))
                .join(", "),
        ),
        ("without a spread S", as_written(&settings.fallback)),
        ("seed", settings.seed.to_string()),
    ]
}

/// As it stands in files.
fn as_written(setting: &impl Serialize) -> String {
    let written = serde_json::to_value(setting).unwrap_or_default();
    written.as_str().map_or_else(|| written.to_string(), |word| word.replace('_', " "))
}

fn from_files(journal: &Journal) -> Vec<Row> {
    let lines = journal.events.last().map_or(0, |(line, _)| *line);
    let times: Vec<&str> = journal.events.iter().filter_map(|(_, event)| time(event)).collect();
    let span = match (times.first(), times.last()) {
        (Some(first), Some(last)) => format!(", from {first} to {last}"),
        _ => String::new(),
    };
    vec![
        ("journal", format!("{JOURNAL}, {}{span}", count(lines, "line"))),
        ("made by", format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))),
    ]
}

fn time(event: &Event) -> Option<&str> {
    match event {
        Event::Campaign { at, .. }
        | Event::Planned { at, .. }
        | Event::Discarded { at }
        | Event::Opened { at, .. }
        | Event::Told { at, .. }
        | Event::Imported { at, .. }
        | Event::Withdrawn { at, .. } => Some(at),
        Event::Simulated { .. } | Event::Learned(_) => None,
    }
}
