//! From the file to the problem: every number checked, each error with the field, the value and what is allowed.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use design_space::Region;

use super::constraints::{held, linear};
use super::costs::Costs;
use super::file::{ExperimentEntry, Input, ProblemFile, ResponseEntry, SimulationsEntry, SimulatorEntry};
use super::levels::parameter;
use super::reserved::is_reserved;
use super::{Experiment, PROBLEM, Problem, Program, Queue, Response, Scale, Simulator};
use crate::disk::unusable;
use crate::job_numbers::submits_a_job;
use crate::wording::{Entry, in_plain_words};

const SIMULATOR_QUEUE: &str = "[simulator.queue]";
const EXPERIMENT_QUEUE: &str = "[experiment.queue]";
const TIMEOUT_SECONDS: f64 = 600.0;
const LONGEST_TIMEOUT_SECONDS: f64 = 3.0e7;

impl Problem {
    /// The problem of the campaign in this folder.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(PROBLEM);
        let text = std::fs::read_to_string(&path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => anyhow!(
                "{}: no such file; a campaign is a folder with a {PROBLEM} in it, and `infuse new FOLDER` makes one",
                path.display()
            ),
            _ => unusable(&path, &error),
        })?;
        Self::parse(&text).with_context(|| path.display().to_string())
    }

    pub(crate) fn parse(text: &str) -> Result<Self> {
        let file: ProblemFile = toml::from_str(text).map_err(|error| with_hint(text, &error))?;
        ensure!(!file.title.trim().is_empty(), "`title` is {:?}, expected what is optimized, in words", file.title);
        ensure!(!file.parameters.is_empty(), "no [[parameter]], expected at least one");
        let parameters = file.parameters.iter().map(parameter).collect::<Result<Vec<_>>>()?;
        let region = Region::new(parameters)?;
        for name in region.parameters().iter().map(design_space::Parameter::name).chain([&*file.response.name]) {
            ensure!(
                !is_reserved(name),
                "`{name}` is a heading of sheets, expected another name for a parameter or response"
            );
        }
        let names: Vec<&str> =
            region.parameters().iter().map(design_space::Parameter::name).chain([&*file.response.name]).collect();
        for (place, name) in names.iter().enumerate() {
            let alike =
                names[..place].iter().find(|other| *other != name && other.to_lowercase() == name.to_lowercase());
            if let Some(other) = alike {
                bail!(
                    "`{other}` and `{name}` differ in case alone, expected another name: headings of sheets may be in any case"
                );
            }
        }
        let response = response(file.response)?;
        ensure!(
            region.index_of(&response.name).is_none(),
            "response: `{}` is also the name of a parameter, expected another",
            response.name
        );
        let simulator = match file.simulator {
            Some(entry) => simulator(entry, &region).context("[simulator]")?,
            None => Simulator::Nothing,
        };
        if let Some(SimulationsEntry::Named(name)) = &file.rule.simulations {
            ensure!(
                name == "all",
                "[loop]: `simulations` is {name:?}, expected a whole number from 2 on, simulations per batch, or \"all\""
            );
        }
        ensure!(
            simulator.is_there() || file.rule.simulations.is_none(),
            "[loop]: `simulations` is set, but there is no [simulator]; expected one, or none of both"
        );
        let experiment = file.experiment.map(|entry| experiment(entry, &region).context("[experiment]"));
        let constraints = held(file.constraints, &region, &response.name)?;
        let linear_constraints = linear(file.linear_constraints, &region)?;
        let can_be_built = file.can_be_built.map(|entry| {
            program(entry.command, entry.input, entry.timeout_seconds, None, Needs::Some, &region)
                .context("[can_be_built]")
        });
        let costs = Costs::of(&file.parameters, &file.rule)?;
        let worth = file.stop.worth;
        if let Some(worth) = worth {
            let (least, expected) = match response.scale {
                Scale::Linear => (0.0, "a positive number in the unit of the response"),
                Scale::Log => {
                    (1.0, "a factor above 1, as 1.2 for a fifth more, where `scale` of [response] is \"log\"")
                }
            };
            ensure!(worth > least && worth.is_finite(), "[stop]: `worth` is {worth:?}, expected {expected}");
        }
        Ok(Self {
            title: file.title,
            roles: file.parameters.iter().map(|entry| entry.role).collect(),
            region,
            response,
            simulator,
            experiment: experiment.transpose()?,
            constraints,
            linear_constraints,
            can_be_built: can_be_built.transpose()?,
            costs,
            seed: file.seed,
            sheets: file.sheets,
            rule: file.rule,
            worth,
            stop_by: file.stop.by,
            smooth: file.stop.smooth,
        })
    }
}

/// What the parser says, and what people most often meant.
fn with_hint(text: &str, error: &toml::de::Error) -> anyhow::Error {
    let at = error.span().map_or(0, |span| span.start).min(text.len());
    let line = text.get(..at).map_or(0, |before| before.matches('\n').count());
    let line = text.lines().nth(line).unwrap_or_default();
    let value = line.split('#').next().unwrap_or_default().split('=').nth(1).unwrap_or_default().as_bytes();
    let is_comma = value.windows(3).any(|w| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit());
    let is_list = value.trim_ascii_start().starts_with(b"[");
    let is_missing = error.message().starts_with("missing field");
    let hint = match section_meant(line) {
        Some(meant) => format!("\n{meant}"),
        None if let Some((key, section)) = section_of_unknown(error.message()) => {
            format!("\n`{key}` stands {section}")
        }
        None if error.message() == "missing field `title`" => {
            "\nwrite title = \"what is optimized\" as the first line, above all sections".to_owned()
        }
        None if error.message() == "missing field `parameter`" => {
            "\nwrite a section [[parameter]] for each thing that can be set, with its name, unit, lower and upper"
                .to_owned()
        }
        None if error.message() == "missing field `response`" || (is_missing && line.trim() == "[response]") => {
            "\nwrite a section [response] with name, unit and goal of what is measured".to_owned()
        }
        None if error.message().starts_with("unknown field") && error.message().contains(OF_THE_OTHER[0]) => {
            let keys = OF_THE_OTHER.map(|key| format!("`{key}`")).join(", ");
            format!("\nof these {keys} are for `method` = \"dissertation\" alone")
        }
        None if value.trim_ascii_start().starts_with(b".") => "\nwrite 0.5 and not .5".to_owned(),
        None if is_comma && !is_list => "\na decimal comma? write 20.5 and not 20,5".to_owned(),
        None => String::new(),
    };
    let entry = error.span().and_then(|span| Entry::at(text, span));
    let message = match names(text, error) {
        Some(names) => error.to_string().replacen(NO_NAME, &format!("expected {names}"), 1),
        None => error.to_string(),
    };
    anyhow!("{}{hint}", in_plain_words(&message, entry))
}

/// Sections of which there may be several, and of which there is but one.
const SEVERAL: [&str; 3] = ["parameter", "constraint", "linear_constraint"];
const BUT_ONE: [&str; 6] = ["response", "simulator", "experiment", "can_be_built", "loop", "stop"];

/// What was meant by a heading that is written with too few brackets, with too many, or in the plural.
fn section_meant(line: &str) -> Option<String> {
    let line = line.split('#').next()?.trim();
    let heading = line.strip_prefix('[')?.strip_suffix(']')?;
    let (name, is_double) = match heading.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
        Some(name) => (name.trim(), true),
        None => (heading.trim(), false),
    };
    let is_meant = |known: &&&str| name == **known || name.strip_suffix('s') == Some(**known);
    if let Some(known) = SEVERAL.iter().find(is_meant) {
        let with_two = if is_double { "" } else { " with two brackets" };
        return (!is_double || name != *known).then(|| format!("write [[{known}]]{with_two}: there may be several"));
    }
    let known = BUT_ONE.iter().find(is_meant)?;
    let with_one = if is_double { " with one bracket on either side" } else { "" };
    (is_double || name != *known).then(|| format!("write [{known}]{with_one}: there is but one"))
}

/// Keys of [loop] that the pooled loop does not know.
const OF_THE_OTHER: [&str; 8] = [
    "model",
    "replicates",
    "drop_from",
    "gain",
    "experiment_weight",
    "simulation_weight",
    "surfaces",
    "without_spread",
];

/// What the parser says of a number where a name is expected.
const NO_NAME: &str = "wanted string or table";

/// The names that are allowed where something else stands: what the parser says of a name that it does not know.
fn names(text: &str, error: &toml::de::Error) -> Option<String> {
    let span = error.span().filter(|_| error.message() == NO_NAME)?;
    let with_a_name = format!("{}\"?\"{}", text.get(..span.start)?, text.get(span.end..)?);
    let said = toml::from_str::<ProblemFile>(&with_a_name).err()?;
    Some(said.message().strip_prefix("unknown variant `?`, expected ")?.to_owned())
}

/// Keys of which people look for the section.
const SECTIONS: [(&str, &[&str]); 7] = [
    ("at the top of the file, above all sections", &["title", "seed", "sheets"]),
    (
        "under [loop]",
        &[
            "method",
            "experiments",
            "simulations",
            "batches",
            "confidence",
            "noise",
            "displaced",
            "blocks",
            "plants",
            "experiment_cost",
            "cost_unit",
        ],
    ),
    ("under [stop]", &["worth", "by", "smooth"]),
    ("under [response]", &["goal", "scale"]),
    ("under [simulator]", &["table", "command", "jobs", "input", "timeout_seconds"]),
    ("under [[constraint]]", &["probability"]),
    ("under [[parameter]]", &["levels", "step", "choices", "change_cost", "role"]),
];

/// Where a key belongs that stands where it is not known.
fn section_of_unknown(message: &str) -> Option<(&str, &'static str)> {
    let key = message.strip_prefix("unknown field `")?.split('`').next()?;
    SECTIONS.iter().find(|(_, keys)| keys.contains(&key)).map(|(section, _)| (key, *section))
}

fn response(entry: ResponseEntry) -> Result<Response> {
    let ResponseEntry { name, unit, goal, scale, lower, upper } = entry;
    let is_plain = !name.trim().is_empty() && name.trim() == name && !name.contains(['[', ']', ',', ';', '"', '\n']);
    ensure!(is_plain, "response: `name` is {name:?}, expected words without brackets, quotes, commas or semicolons");
    let is_plain = unit.trim() == unit && !unit.contains(['[', ']', ',', ';', '"', '\n']);
    ensure!(is_plain, "response: `unit` is {unit:?}, expected one without brackets, quotes, commas or semicolons");
    for (key, bound) in [("lower", lower), ("upper", upper)] {
        if let Some(value) = bound {
            ensure!(value.is_finite(), "response: `{key}` is {value:?}, expected a finite number");
        }
    }
    if let Some((lower, upper)) = lower.zip(upper) {
        ensure!(lower < upper, "response: `lower` is {lower:?}, expected less than `upper`, which is {upper:?}");
    }
    let response = Response { name, unit, goal, scale, lower, upper };
    if let Some((upper, expected)) = upper.and_then(|upper| Some((upper, response.without_logarithm(upper)?))) {
        bail!("response: `upper` is {upper:?}, expected {expected}");
    }
    Ok(response)
}

fn simulator(entry: SimulatorEntry, region: &Region) -> Result<Simulator> {
    match (entry.table, entry.command) {
        (Some(table), None) => {
            ensure!(
                entry.input.is_none()
                    && entry.timeout_seconds.is_none()
                    && entry.jobs.is_none()
                    && entry.queue.is_none(),
                "a `table` is not run, expected neither `input` nor `timeout_seconds` nor `jobs` nor [simulator.queue] beside it"
            );
            Ok(Simulator::Table(table))
        }
        (None, Some(command)) => {
            let jobs = match entry.jobs {
                Some(0) => bail!("`jobs` is 0, expected at least 1"),
                Some(jobs) => jobs,
                None => std::thread::available_parallelism().map_or(1, usize::from),
            };
            ensure!(
                entry.queue.is_none() || entry.jobs.is_none(),
                "`jobs` is for runs on this machine, expected none beside [simulator.queue]: its `options` say how many run at once"
            );
            let queue =
                entry.queue.map(|entry| Queue::of(entry, SIMULATOR_QUEUE)).transpose().context(SIMULATOR_QUEUE)?;
            Ok(Simulator::Program {
                program: program(
                    command,
                    entry.input,
                    entry.timeout_seconds,
                    Some(SIMULATOR_QUEUE),
                    Needs::All,
                    region,
                )?,
                jobs,
                queue,
            })
        }
        (None, None) => bail!("needs `command` = [\"program\", \"argument\", ...] or `table` = \"file.csv\""),
        (Some(_), Some(_)) => bail!("has both `command` and `table`, expected one of them"),
    }
}

fn experiment(entry: ExperimentEntry, region: &Region) -> Result<Experiment> {
    let queue = entry.queue.map(|entry| Queue::of(entry, EXPERIMENT_QUEUE)).transpose().context(EXPERIMENT_QUEUE)?;
    Ok(Experiment {
        program: program(
            entry.command,
            entry.input,
            entry.timeout_seconds,
            Some(EXPERIMENT_QUEUE),
            Needs::All,
            region,
        )?,
        queue,
    })
}

fn program(
    command: Vec<String>,
    input: Option<Input>,
    timeout: Option<f64>,
    queue: Option<&str>,
    needs: Needs,
    region: &Region,
) -> Result<Program> {
    ensure!(
        command.first().is_some_and(|program| !program.is_empty()),
        "`command` is {command:?}, expected a program and its arguments"
    );
    if let Some(scheduler) = submits_a_job(&command) {
        bail!(
            "`command` calls `{scheduler}`, which prints the number of a job and no value; put the program itself here{}",
            queue.map_or_else(String::new, |queue| format!(", and `kind` of the scheduler under {queue}"))
        );
    }
    let input = input.unwrap_or_default();
    let seconds = timeout.unwrap_or(TIMEOUT_SECONDS);
    ensure!(
        seconds > 0.0 && seconds <= LONGEST_TIMEOUT_SECONDS,
        "`timeout_seconds` is {seconds:?}, expected a positive number up to {LONGEST_TIMEOUT_SECONDS:e}"
    );
    let names = || region.parameters().iter().map(design_space::Parameter::name);
    let found: Vec<&str> = command.iter().flat_map(|argument| placeholders(argument)).collect();
    let missing: Vec<&str> = names().filter(|name| !found.contains(name)).collect();
    let in_braces = |names: &[&str]| names.iter().map(|name| format!("{{{name}}}")).collect::<Vec<_>>().join(", ");
    let is_missed = match needs {
        Needs::All => !missing.is_empty(),
        Needs::Some => missing.len() == names().count(),
    };
    // Braces are nobody's but a program's own, unless a parameter is missing, whose name may be misspelled.
    let unknown: Vec<&str> = found.iter().copied().filter(|found| !names().any(|name| name == *found)).collect();
    let strange = || match unknown.as_slice() {
        [] => String::new(),
        unknown => format!("; {} is no parameter", in_braces(unknown)),
    };
    ensure!(
        input == Input::Json || !is_missed,
        "`command` has {}no {}, so the program cannot know {}{}; put {} among the arguments, or set `input` = \"json\"",
        if found.is_empty() { String::new() } else { format!("{}, but ", in_braces(&found)) },
        in_braces(&missing),
        if missing.len() == 1 { "it" } else { "them" },
        strange(),
        if missing.len() == 1 { "it" } else { "them" },
    );
    ensure!(
        input == Input::Json || missing.is_empty() || unknown.is_empty(),
        "`command` has {}, which is no parameter, expected some of {}; braces of its own are for a command that names every \
         parameter, or stand in a script",
        in_braces(&unknown),
        in_braces(&names().collect::<Vec<_>>()),
    );
    Ok(Program { command, input, timeout: Duration::from_secs_f64(seconds) })
}

/// Which parameters a command is to be given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Needs {
    All,
    /// At least one: whatever it is not given is nothing to it.
    Some,
}

/// What stands between braces.
fn placeholders(argument: &str) -> impl Iterator<Item = &str> {
    argument.split('{').skip(1).filter_map(|rest| rest.split_once('}').map(|(name, _)| name))
}
