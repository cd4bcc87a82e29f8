//! Where all of it comes from.

use design_space::Levels;
use infuse::Role;
use infuse::pooled::StopBy;

use crate::journal::{JOURNAL, Journal};
use crate::number::{count, plain, setting};
use crate::problem::{Goal, PROBLEM, Problem, Simulator, linear_in_words, step};
use page::{Column, Page, Table};

/// The section, with the settings of the loop as the method has them.
pub(crate) fn write(page: &mut Page, problem: &Problem, journal: &Journal, from_loop: Vec<Row>) {
    page.section("provenance", "Provenance");
    page.table(&parameters(problem), "What can be set.");
    let rows = [from_problem(problem), from_loop, from_files(journal)].concat();
    let table = Table {
        columns: vec![Column::words("what"), Column::words("value")],
        rows: rows.into_iter().map(|(what, value)| vec![what.to_owned(), value]).collect(),
    };
    page.table(&table, &format!("The rest of {PROBLEM}, and what this page was made from."));
}

fn parameters(problem: &Problem) -> Table {
    let row = |(parameter, role): (&design_space::Parameter, &Option<Role>)| {
        let (levels, step) = match parameter.levels() {
            Levels::Count(n) => (n.to_string(), setting(step(parameter), step(parameter))),
            Levels::Continuous => ("any".to_owned(), "any".to_owned()),
        };
        let role = match role {
            Some(Role::Plant) => "plant",
            Some(Role::Controller) => "controller",
            None => "",
        };
        let name = parameter.name().to_owned();
        let unit = parameter.unit().to_owned();
        if let Some(choices) = parameter.choices() {
            let [first, last] = [choices.first(), choices.last()].map(|choice| choice.cloned().unwrap_or_default());
            return vec![name, unit, first, last, "choice".to_owned(), levels, role.to_owned()];
        }
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

/// What, and its value.
pub(crate) type Row = (&'static str, String);

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
        Simulator::Nothing => ("simulator", "none: experiments alone".to_owned()),
        Simulator::Table(path) => ("simulator", format!("the table {}", path.display())),
        Simulator::Program { program, .. } => ("simulator", format!("the command {}", program.command.join(" "))),
    });
    rows.push(match &problem.experiment {
        Some(made) => ("experiment", format!("the command {}", made.program.command.join(" "))),
        None => ("experiment", "by people".to_owned()),
    });
    rows.extend(problem.constraints.iter().map(|held| ("constraint", held.in_words())));
    let linear = problem.linear_constraints.iter().map(|linear| linear_in_words(&problem.region, linear));
    rows.extend(linear.map(|linear| ("linear constraint", linear)));
    if let Some(program) = &problem.can_be_built {
        rows.push(("can be built", format!("the command {}", program.command.join(" "))));
    }
    let worth = problem.worth.map_or_else(|| "not said".to_owned(), |worth| response.given(worth));
    rows.push(("least gain that another batch is worth", worth));
    if let Some(StopBy::Surface) = problem.stop_by {
        rows.push(("stops by", "the surface alone".to_owned()));
    }
    rows
}

fn from_files(journal: &Journal) -> Vec<Row> {
    let lines = journal.all.last().map_or(0, |(line, _)| *line);
    let times: Vec<&str> = journal.all.iter().filter_map(|(_, event)| event.time()).collect();
    let span = match (times.first(), times.last()) {
        (Some(first), Some(last)) => format!(", from {first} to {last}"),
        _ => String::new(),
    };
    vec![
        ("journal", format!("{JOURNAL}, {}{span}", count(lines, "line"))),
        ("made by", format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))),
    ]
}
