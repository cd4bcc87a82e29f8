//! What can be typed.

use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory as _, Parser, Subcommand};

/// Which experiments to run next, what they taught, and when to stop.
///
/// A campaign is a folder with a file `campaign.toml`: what can be set, what is measured, and a rough simulation. From
/// a few experiments and many simulations `infuse` learns where the simulation is wrong, and asks for the next experiments
/// where they count.
#[derive(Debug, Parser)]
#[command(name = "infuse", version, after_help = FIRST_STEPS)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) common: Common,
}

impl Arguments {
    /// As they were typed, or what is wrong with them.
    pub(crate) fn read() -> Result<Self, clap::Error> {
        let arguments = Self::try_parse()?;
        let Command::Tell(tell) = &arguments.command else { return Ok(arguments) };
        let Some(fault) = tell.fault() else { return Ok(arguments) };
        let mut all = Self::command();
        all.build();
        let command = all.find_subcommand("tell").cloned().unwrap_or(all);
        Err(command.clone().error(ErrorKind::ArgumentConflict, fault))
    }
}

const FIRST_STEPS: &str = "\
First steps:
  infuse new my-rig        make a folder with a campaign.toml that works; edit it until it describes your rig
  cd my-rig
  infuse check             is it right, and what will it cost?
  infuse ask               run the simulations, and write sheet-1.csv with the experiments to run
                           ... run them, and fill in the column of the response ...
  infuse tell sheet-1.csv  take the sheet back, wholly or partly filled
  infuse status            the best design so far, what was learned, and whether to go on
  infuse ask               the next experiments; and so on, until it says why to stop
  infuse confirm           a few runs that measure what was gained
  infuse report            one HTML page with all of it";

#[derive(Debug, Args)]
pub(crate) struct Common {
    /// The folder of the campaign
    #[arg(short = 'C', long, global = true, default_value = ".", value_name = "FOLDER")]
    pub(crate) campaign: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Wait this long for another infuse in the same folder
    #[arg(long, global = true, default_value_t = 5.0, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(crate) wait: f64,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make a folder with a campaign.toml that works, as a beginning
    New {
        /// The folder to make; it must not hold a campaign yet
        folder: PathBuf,
    },
    /// Say whether campaign.toml is right, try one simulation, and say what the campaign will cost
    ///
    /// It writes nothing down, and submits nothing to a queue.
    Check,
    /// Say which experiments to run now, and write them to a sheet
    ///
    /// Begins the next batch if none is waited for: designs it, and runs its simulations. Asking again gives the same
    /// experiments until they have a result. Interrupt it when you like; what was simulated is remembered.
    Ask {
        /// Where the sheet goes [default: sheet-N.csv in the folder of the campaign]
        #[arg(long, value_name = "FILE")]
        sheet: Option<PathBuf>,
        /// Begin another batch even if it seems not worth it
        #[arg(long)]
        anyway: bool,
        /// Hand out another batch while experiments are still waited for
        #[arg(long)]
        more: bool,
        /// From the next batch on, simulate everything again, because the simulator itself was changed
        #[arg(long)]
        resimulate: bool,
    },
    /// Stop the simulations and experiments that are in the queue of a cluster; what was finished counts
    Cancel,
    /// Take the results of experiments
    Tell(Tell),
    /// Take experiments that were made before the campaign, with where they come from
    ///
    /// They count as much as those of the campaign itself. The file has one column per parameter and one for the response,
    /// headed like those of a sheet, and may have one headed `source`, which then says it for each row.
    Import {
        /// The table, or the folder of another campaign of the same rig, with other bounds or levels, say
        #[arg(required_unless_present = "withdraw")]
        file: Option<PathBuf>,
        /// Where these experiments come from: a notebook, a report, a date; of a table with a column `source` it stands before
        /// what that says, and may be left out
        #[arg(long)]
        source: Option<String>,
        /// From now on use nothing more that was imported from this source, as the journal has it
        #[arg(long, value_name = "SOURCE", conflicts_with_all = ["file", "source"])]
        withdraw: Option<String>,
    },
    /// Take the last thing back that was done: a tell, an import, a confirm, or an ask of which nothing was told
    ///
    /// Nothing is erased: a line of the journal says that what it names does not count. Called again it takes back what was
    /// done before that. What was simulated stays known.
    Undo,
    /// Say what happened and when, in order
    Log,
    /// Say where the campaign stands: the best design, what was learned, what is left, and whether to go on
    Status {
        /// Say why a design may still be the best, or why not: "spring=21000,damper=1500"
        #[arg(long, value_name = "NAME=VALUE,...")]
        why: Option<String>,
    },
    /// Say what is expected of any design, with its band: "spring=34,damper=1500"
    #[command(override_usage = "infuse what-if <NAME=VALUE,...>\n       infuse what-if --grid <FILE>")]
    WhatIf {
        /// The settings of the design
        #[arg(required_unless_present = "grid", value_name = "NAME=VALUE,...")]
        settings: Option<String>,
        /// Write the same for designs all over the grid to a table
        #[arg(long, value_name = "FILE", conflicts_with = "settings")]
        grid: Option<PathBuf>,
    },
    /// Plan a few runs at the recommended design, the best measured and the simulation's own choice, and say what they gained
    ///
    /// These runs are compared with each other alone: what was measured before has helped to choose the designs, and so
    /// flatters them.
    Confirm {
        /// Runs of each design
        #[arg(long, default_value_t = 3, value_name = "N", value_parser = count::<usize>, allow_negative_numbers = true)]
        runs: usize,
        /// Where the sheet goes [default: sheet-N.csv in the folder of the campaign]
        #[arg(long, value_name = "FILE")]
        sheet: Option<PathBuf>,
    },
    /// Write one HTML page that stands alone: sheets, surfaces, what is left, bounds, history
    Report {
        /// Where it goes [default: report.html in the folder of the campaign]
        #[arg(long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Ask and tell by itself until the end, when the experiment, too, is a command
    Run {
        /// At most this many batches now
        #[arg(long, value_name = "N", value_parser = count::<usize>, allow_negative_numbers = true)]
        batches: Option<usize>,
        /// Go on even if another batch seems not worth it
        #[arg(long)]
        anyway: bool,
    },
    /// Serve today's sheet as a page for a browser on this machine, until Ctrl-C
    ///
    /// Prints the address of the page, which holds a secret word: whoever has it may write to the campaign. Nothing but this
    /// machine is answered. The shell may be used beside it.
    Serve {
        /// The port on 127.0.0.1; 0 takes any that is free
        #[arg(long, default_value_t = 0, value_name = "N", allow_negative_numbers = true)]
        port: u16,
        /// Take the secret word from this file instead of a new one: at least 16 letters, digits, `-` or `_`
        #[arg(long, value_name = "FILE")]
        token_file: Option<PathBuf>,
    },
    /// Print the license of this program, and those of all that it contains of others
    Licenses,
    /// Print what makes a shell complete `infuse` and its options
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, in the form that `man` reads
    Man {
        /// Write it and the page of each command to this folder instead
        #[arg(long, value_name = "FOLDER")]
        folder: Option<PathBuf>,
    },
}

/// The ways to tell results, each with an example.
const TELL_USAGE: &str = "\
infuse tell <SHEET> [OPTIONS]                      infuse tell sheet-1.csv
       infuse tell --id <ID> --value <VALUE> [OPTIONS]    infuse tell --id 3 --value 12.5
       infuse tell --id <ID> --failed <REASON> [OPTIONS]  infuse tell --id 3 --failed \"it leaked\"";

#[derive(Debug, Args)]
#[command(override_usage = TELL_USAGE)]
pub(crate) struct Tell {
    /// A filled sheet; rows without a value and without a reason are left for later
    pub(crate) sheet: Option<PathBuf>,
    /// One experiment by its id, without a sheet
    #[arg(long, value_parser = count::<u64>, allow_negative_numbers = true)]
    pub(crate) id: Option<u64>,
    /// Its value
    #[arg(long, value_parser = result, allow_negative_numbers = true)]
    pub(crate) value: Option<f64>,
    /// Or that it gave none, and why
    #[arg(long, value_name = "REASON")]
    pub(crate) failed: Option<String>,
    /// The responses that have to stay within bounds: "travel=11.2"
    #[arg(long, value_name = "NAME=VALUE,...")]
    pub(crate) constrained: Option<String>,
    /// Settings that were made otherwise: "spring=21010,damper=1500"
    #[arg(long, value_name = "NAME=VALUE,...")]
    pub(crate) actual: Option<String>,
    /// It is one more run of an experiment that has a result already
    #[arg(long)]
    pub(crate) again: bool,
    /// A remark for the journal
    #[arg(long)]
    pub(crate) note: Option<String>,
    /// Replace the results known of the same experiments; with the dissertation's loop as long as no later batch rests on them
    #[arg(long)]
    pub(crate) correct: bool,
    /// With --id and --correct: which of several runs of the experiment to replace, 1 for the first
    #[arg(long, value_name = "NUMBER", value_parser = count::<usize>, allow_negative_numbers = true)]
    pub(crate) run: Option<usize>,
}

impl Tell {
    /// What is wrong with the options beside each other, if anything is.
    fn fault(&self) -> Option<&'static str> {
        let of_one = [
            ("--value needs --id beside it, the number of the experiment in its sheet", self.value.is_some()),
            ("--failed needs --id beside it, the number of the experiment in its sheet", self.failed.is_some()),
            ("--constrained needs --id and --value beside it", self.constrained.is_some()),
            ("--actual needs --id beside it, and --value or --failed", self.actual.is_some()),
            ("--again needs --id beside it, and --value or --failed", self.again),
            (
                "--note needs --id beside it, and --value or --failed; a sheet has a column for notes",
                self.note.is_some(),
            ),
        ];
        if self.run.is_some() && (self.id.is_none() || !self.correct) {
            return Some(
                "--run needs --id and --correct beside it: it says which of several runs of an experiment to replace",
            );
        }
        match (&self.sheet, self.id) {
            (_, None) if let Some((fault, _)) = of_one.iter().find(|(_, is_set)| *is_set) => Some(fault),
            (None, None) => Some("nothing to take, expected a sheet, or --id with --value or --failed"),
            (Some(_), Some(_)) => Some("a sheet and --id at once, expected one of them"),
            (Some(_), None) => None,
            (None, Some(_)) => match (self.value.is_some(), self.failed.is_some()) {
                (false, false) => Some("--id alone says no result, expected --value or --failed beside it"),
                (true, true) => Some("--value and --failed at once, expected one of them"),
                _ if self.again && self.correct => {
                    Some("--again and --correct at once, expected one of them: one more run, or the same put right")
                }
                _ => None,
            },
        }
    }
}

/// A number from 1 on.
fn count<N: std::str::FromStr + PartialEq + From<u8>>(text: &str) -> Result<N, &'static str> {
    let count = text.parse().ok().filter(|count| *count != N::from(0));
    count.ok_or("expected a whole number from 1 on")
}

/// A result as in a cell of a sheet.
fn result(text: &str) -> Result<f64, String> {
    crate::number::parse(text.trim()).map_err(|fault| format!("expected {}", fault.of_result()))
}
