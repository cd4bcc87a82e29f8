//! One module per command; each gives what to print, as text and as JSON.

mod ask;
mod cancel;
mod check;
mod confirm;
mod import;
mod log;
mod made;
mod manual;
mod new;
mod output;
mod report;
mod run;
mod serve;
mod settings;
mod status;
mod taken_back;
mod taken_over;
mod tell;
mod undo;
mod what_if;

use std::time::Duration;

use anyhow::{Context as _, Result};

use crate::arguments::{Arguments, Command};
use crate::campaign::Wish;
pub(crate) use output::Output;

pub(crate) fn run(arguments: &Arguments) -> Result<Output> {
    let common = &arguments.common;
    let wait = Duration::try_from_secs_f64(common.wait)
        .with_context(|| format!("--wait is {:?}, expected a number of seconds from 0", common.wait))?;
    let folder = &*common.campaign;
    match &arguments.command {
        Command::New { folder } => new::new(folder),
        Command::Ask { sheet, anyway, more, resimulate } => {
            let wish = Wish { anyway: *anyway, more: *more };
            ask::ask(folder, wait, sheet.as_deref(), wish, *resimulate)
        }
        Command::WhatIf { settings, grid } => what_if::what_if(folder, settings.as_deref(), grid.as_deref()),
        Command::Confirm { runs, sheet } => confirm::confirm(folder, wait, *runs, sheet.as_deref()),
        Command::Check => check::check(folder),
        Command::Undo => undo::undo(folder, wait, None),
        Command::Log => log::log(folder),
        Command::Cancel => cancel::cancel(folder, wait),
        Command::Tell(tell) => tell::tell(folder, wait, tell),
        Command::Import { withdraw: Some(source), .. } => import::withdraw(folder, wait, source),
        Command::Import { file, source, .. } => {
            import::import(folder, wait, file.as_deref().context("expected a table")?, source.as_deref())
        }
        Command::Status { why } => status::status(folder, why.as_deref()),
        Command::Report { output } => report::report(folder, output.as_deref()),
        Command::Completions { shell } => manual::completions(*shell),
        Command::Licenses => Ok(manual::licenses()),
        Command::Man { folder } => manual::manual(folder.as_deref()),
        Command::Serve { port, token_file } => {
            serve::serve(folder, wait, *port, token_file.as_deref(), arguments.common.json)
        }
        Command::Run { batches, anyway } => run::run(folder, wait, *batches, *anyway),
    }
}
