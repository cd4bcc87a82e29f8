//! `infuse`: campaigns of experiments and simulations from a shell.

mod arguments;
mod campaign;
mod command;
mod disk;
mod dissertation;
mod echo;
mod findings;
mod folder;
mod job_numbers;
mod journal;
mod left_running;
mod number;
mod pooled;
mod problem;
mod program;
mod queue;
mod report;
mod sheet;
mod shell;
mod simulator;
mod spread;
mod wording;

use std::io::Write as _;
use std::process::ExitCode;

use arguments::Arguments;
use command::Output;

/// As a shell reports a program that was stopped by Ctrl-C.
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    let arguments = match Arguments::read() {
        Ok(arguments) => arguments,
        Err(error) => return not_understood(&error),
    };
    // Without it an interrupt ends the program at once, which loses nothing either.
    let _ = ctrlc::set_handler(|| program::interrupt(i32::from(INTERRUPTED)));
    survive_file_size_limits();
    let outcome = command::run(&arguments);
    let is_json = arguments.common.json;
    let written = match &outcome {
        Ok(output) => show(output, is_json),
        Err(error) if is_json => {
            writeln!(std::io::stdout(), "{}", serde_json::json!({ "error": wording::of_error(error) }))
        }
        Err(error) => writeln!(std::io::stderr(), "error: {}", wording::of_error(error)),
    };
    if let Err(error) = &written
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        let _ = writeln!(
            std::io::stderr(),
            "error: the answer cannot be written ({error}); what was done stands in the folder"
        );
    }
    match outcome {
        _ if program::is_interrupted() => ExitCode::from(INTERRUPTED),
        Ok(_) if written.is_ok() => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}

/// Help and version that were asked for, or what is wrong with the words of the command.
fn not_understood(error: &clap::Error) -> ExitCode {
    let wants_json = std::env::args_os().skip(1).take_while(|word| word != "--").any(|word| word == "--json");
    if !error.use_stderr() || !wants_json {
        error.exit();
    }
    let text = error.to_string();
    let said = text.strip_prefix("error: ").unwrap_or(&text).trim_end();
    let _ = writeln!(std::io::stdout(), "{}", serde_json::json!({ "error": said }));
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

fn show(output: &Output, is_json: bool) -> std::io::Result<()> {
    // In JSON they are among the rest.
    for notice in output.notices.iter().filter(|_| !is_json) {
        writeln!(std::io::stderr(), "note: {}", shown(notice))?;
    }
    let mut stdout = std::io::stdout().lock();
    if is_json {
        writeln!(stdout, "{}", output.json)?
    } else {
        writeln!(stdout, "{}", shown(output.text.trim_end()))?
    }
    stdout.flush()
}

/// What people wrote may hold characters that would steer a terminal.
fn shown(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' && c != '\t' { ' ' } else { c }).collect()
}

/// A write beyond the limit of a shell ends with an error that names the file, and not the program.
#[cfg(unix)]
fn survive_file_size_limits() {
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

#[cfg(not(unix))]
const fn survive_file_size_limits() {}
