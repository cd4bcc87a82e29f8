//! `infuse check`: whether a campaign is right, and what it will cost.

mod budget;
mod tried;

use std::path::Path;

use anyhow::Result;
use design_space::Levels;
use page::Finding;
use serde_json::{Value, json};

use super::output::Output;
use crate::campaign::{Campaign, Stage};
use crate::findings::next;
use crate::folder;
use crate::journal::JOURNAL;
use crate::number::{count, plain, with_unit};
use crate::problem::{PROBLEM, Problem, Scale, linear_in_words};
use crate::shell::sheet_path;

pub(crate) fn check(folder: &Path) -> Result<Output> {
    let mut campaign = folder::read(folder)?;
    let notices = campaign.take_notices();
    let problem = campaign.problem();
    let budget = campaign.budget()?;
    let tried = tried::try_commands(&*campaign, &budget.grid)?;
    let mut findings = vec![right(problem)];
    findings.extend(tried.findings);
    let (costs, mut json) = budget::in_words(&*campaign, &budget, tried.took)?;
    findings.extend(costs);
    let stage = campaign.stage()?;
    findings.push(files(&*campaign, &stage));
    findings.push(next(&*campaign, &stage));
    json["simulation"] = tried.json;
    json["seconds_per_simulation"] = tried.took.map_or(Value::Null, |took| json!(took.as_secs_f64()));
    json["can_be_built"] = json!(tried.can_be_built);
    json["experiments_made"] = json!(campaign.experiments().n_made());
    Ok(Output::new(&findings, json, notices))
}

fn right(problem: &Problem) -> Finding {
    let parts = problem.region.parameters().iter().map(|parameter| {
        let levels = match parameter.levels() {
            Levels::Count(n) => count(n as usize, "setting"),
            Levels::Continuous => "any setting".to_owned(),
        };
        let bounds = match parameter.choices() {
            Some(choices) => return Finding::new(format!("{}: {}.", parameter.name(), choices.join(", "))),
            None => {
                format!("{} to {}", plain(parameter.lower()), with_unit(&plain(parameter.upper()), parameter.unit()))
            }
        };
        Finding::new(format!("{}: {bounds}, {levels}.", parameter.name()))
    });
    let response = &problem.response;
    let scale = match response.scale {
        Scale::Linear => "",
        Scale::Log => ", on a logarithmic scale",
    };
    let sentence = format!("{PROBLEM} is right. {} is better of {}{scale}.", response.better(), response.heading());
    let sentence = sentence.replace("right. lower", "right. Lower").replace("right. higher", "right. Higher");
    let held = problem.constraints.iter().map(|held| Finding::new(format!("{}.", held.in_words())));
    let linear = problem.linear_constraints.iter();
    let linear = linear.map(|linear| Finding::new(format!("{}.", linear_in_words(&problem.region, linear))));
    let parts = parts.chain(held).chain(linear);
    parts.fold(Finding::new(sentence), Finding::detail)
}

fn files(campaign: &dyn Campaign, stage: &Stage) -> Finding {
    let (folder, problem) = (campaign.folder(), campaign.problem());
    let first = sheet_path(folder, problem.sheets, campaign.experiments().last_batch().unwrap_or(0) + 1, None);
    let n = campaign.experiments().n_made();
    let so_far = if n > 0 { format!(" Told so far: {}.", count(n, "experiment")) } else { String::new() };
    let journal =
        if folder == Path::new(".") { JOURNAL.to_owned() } else { folder.join(JOURNAL).display().to_string() };
    Finding::new(match stage {
        Stage::Ended { may_go_on: false, .. } => format!("The journal is {journal}.{so_far}"),
        _ => format!("The next sheet will be {}, the journal {journal}.{so_far}", first.display()),
    })
}
