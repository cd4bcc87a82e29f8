//! What a task of the queue runs, as a shell script: it needs nothing but a folder that all machines see.

use std::path::Path;

use crate::shell::in_quotes as quoted;

/// Seconds between the end of a run and that of its task, at most, if both are stopped.
const PATIENCE: u32 = 2;

/// The script of a submission: task k makes `runs_per_task` runs from number (k − 1) `runs_per_task` + 1 on, those that
/// have a result excepted.
///
/// A run writes to files of its own and renames them; last of all appears its `.done` with the exit code, so that a result is
/// there as a whole or not at all, and twice does no harm.
/// A scheduler that stops a task ends its processes one after the other, and the run may be first: what a signal ended waits a
/// moment for the end of this shell, too, before it counts as a result.
pub(super) fn of_a_task(runs: &Path, runs_per_task: usize, seconds: f64) -> String {
    let runs = quoted(&runs.display().to_string());
    format!(
        r#"#!/bin/sh
# Written by infuse. Makes the runs of one task; the number of the task is the argument, or what the scheduler says.
cd {runs} || exit 1
task=${{1:-${{SLURM_ARRAY_TASK_ID:-${{HQ_TASK_ID:-${{PBS_ARRAY_INDEX:-${{PBS_ARRAYID:-${{LSB_JOBINDEX:-${{SGE_TASK_ID:-}}}}}}}}}}}}}}
case $task in
'' | *[!0-9]*) echo "infuse: no number of a task" >&2; exit 2 ;;
esac
limit=
if command -v timeout > /dev/null 2>&1; then limit="timeout -k 10 {seconds}"; fi
run=$(((task - 1) * {runs_per_task} + 1))
last=$((task * {runs_per_task}))
while [ "$run" -le "$last" ]; do
    if [ -e "$run.sh" ] && [ ! -e "$run.done" ]; then
        own="$run.$(hostname 2> /dev/null || echo here).$$"
        $limit sh "./$run.sh" > "$own.out" 2> "$own.err" < "$run.in"
        code=$?
        # Hang-up, interrupt, kill, end: whoever stops the whole task ends this shell next, and there is no result.
        case $code in 129 | 130 | 137 | 143) sleep {PATIENCE} ;; esac
        mv -f "$own.out" "$run.out" && mv -f "$own.err" "$run.err" || exit 1
        echo "$code" > "$own.done" && mv -f "$own.done" "$run.done" || exit 1
    fi
    run=$((run + 1))
done
"#
    )
}

/// The script of one run: a command, from the folder of the campaign.
pub(super) fn of_a_run(folder: &Path, words: &[String]) -> String {
    let folder = quoted(&folder.display().to_string());
    let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    format!("cd {folder} || exit 1\nexec {}\n", words.join(" "))
}

/// Numbers as schedulers write them: "1-4,7".
pub(super) fn ranges(tasks: &[usize]) -> String {
    let mut ranges: Vec<(usize, usize)> = Vec::new();
    for &task in tasks {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == task => *last = task,
            _ => ranges.push((task, task)),
        }
    }
    let words = ranges.iter().map(|(first, last)| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    });
    words.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_written_as_ranges() {
        assert_eq!(ranges(&[1, 2, 3, 4, 7]), "1-4,7");
        assert_eq!(ranges(&[5]), "5");
        assert_eq!(ranges(&[1, 3, 4]), "1,3-4");
        assert_eq!(ranges(&[]), "");
    }

    #[test]
    fn words_of_a_command_stay_whole_in_a_shell() {
        let words = ["./solve it.sh", "it's", "$HOME `x`", ""].map(str::to_owned);
        let script = of_a_run(&std::env::temp_dir(), &words).replace("exec", "printf '%s\\n'");
        let said = std::process::Command::new("sh").args(["-c", &script]).output().expect("a shell");
        assert_eq!(String::from_utf8_lossy(&said.stdout), "./solve it.sh\nit's\n$HOME `x`\n\n");
    }
}
