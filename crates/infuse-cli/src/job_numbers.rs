//! Commands that submit a job, told by the words they consist of and by what they print.

use anyhow::{Result, bail};

use crate::number::plain;
use crate::program::Ran;

/// So many plain whole numbers in a row are enough to be sure if they follow each other without a gap. Each run beside
/// leaves room for one gap more, and takes two numbers more: with twenty side by side, six even responses below 40 would
/// pass for numbers of jobs otherwise.
const SURE: usize = 5;
const SURE_PER_RUN_BESIDE: usize = 2;
/// And so many if each is larger than all before: others submit in between. Of different designs one such series in 40,000
/// is no numbers of jobs. Runs side by side may be exchanged, so it takes as many times more.
const SURE_WITH_GAPS: usize = 8;

/// The scheduler's own command, if a `command` calls one, itself or through a shell or `env`: it prints the number of a
/// job and no value.
pub(crate) fn submits_a_job(command: &[String]) -> Option<&str> {
    let is_break = |c: char| c.is_whitespace() || ";|&()`$\"'".contains(c);
    let script = |word: &&String| word.contains(char::is_whitespace);
    let of_shell = command.iter().filter(script).flat_map(|text| text.split(is_break));
    let words: Vec<&str> = command.iter().filter(|word| !script(word)).map(String::as_str).chain(of_shell).collect();
    let name = |word: &&str| word.rsplit('/').next().unwrap_or_default().len();
    let names = words.iter().map(|word| &word[word.len() - name(word)..]);
    let called: Vec<&str> = names.collect();
    let begins = ["sbatch", "qsub", "bsub"];
    let first = called.first().copied().unwrap_or_default();
    let passes_on = ["env", "sh", "bash", "dash", "zsh", "nice", "timeout", "time", "nohup", "srun"].contains(&first);
    let n_looked_at = if passes_on { called.len() } else { 1 };
    let of_slurm = called.iter().take(n_looked_at).find(|name| begins.contains(name)).copied();
    let submits = called.contains(&"submit");
    of_slurm.or_else(|| called.iter().take(n_looked_at).find(|name| **name == "hq" && submits).copied())
}

/// Watches what a command prints, run by run: whole numbers that follow each other, or that rise all the time, are the
/// numbers of jobs.
///
/// A response may be whole, and two of them may follow each other, but not the first five of different designs that run one at a
/// time, nor do eight rise from the first to the last. Once anything else was printed nothing is suspected any more.
#[derive(Debug, Default)]
pub(crate) struct JobNumbers {
    seen: Vec<f64>,
    is_settled: bool,
}

impl JobNumbers {
    /// Whether a run may yet turn out to have printed the number of a job: what it gave is not to be believed so far.
    /// `side_by_side`: how many runs are under way at a time, whose numbers may be exchanged.
    ///
    /// # Errors
    ///
    /// It did.
    pub(crate) fn suspects(&mut self, ran: &Ran, side_by_side: usize) -> Result<bool> {
        let Ran::Value { value, is_plain_and_whole: true, .. } = ran else {
            self.is_settled = true;
            return Ok(false);
        };
        if self.is_settled {
            return Ok(false);
        }
        self.seen.push(*value);
        let (is_dense, rises) = (self.is_dense(side_by_side), self.rises(side_by_side));
        self.is_settled = !is_dense && !rises;
        let n = self.seen.len();
        let sure = SURE + SURE_PER_RUN_BESIDE * side_by_side.saturating_sub(1);
        if is_dense && n >= sure || rises && n >= SURE_WITH_GAPS * side_by_side {
            let seen: Vec<String> = self.seen.iter().map(|value| plain(*value)).collect();
            bail!(
                "`command` printed {} for {} designs: whole numbers that rise from run to run are the numbers of jobs and no \
                 values; let the queue's own table submit the program, or, if they are values, print {{\"value\": {}}}",
                seen.join(", "),
                seen.len(),
                seen[0],
            );
        }
        Ok(!self.is_settled)
    }

    /// All different, and with no more gaps than runs that have not ended leave.
    fn is_dense(&self, side_by_side: usize) -> bool {
        let mut sorted = self.seen.clone();
        sorted.sort_by(f64::total_cmp);
        let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return true };
        let is_twice = |pair: &[f64]| pair[1] - pair[0] < 0.5;
        let most = (sorted.len() - 1 + side_by_side - 1) as f64 + 0.5;
        !sorted.windows(2).any(is_twice) && last - first <= most
    }

    /// Each larger than those that had ended when it began.
    fn rises(&self, side_by_side: usize) -> bool {
        let later = self.seen.iter().skip(side_by_side);
        let mut highest = f64::NEG_INFINITY;
        self.seen.iter().zip(later).all(|(earlier, later)| {
            highest = highest.max(*earlier);
            *later > highest
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split('|').map(str::to_owned).collect()
    }

    #[test]
    fn schedulers_are_found_behind_a_shell_and_env_and_nowhere_else() {
        let submits = [
            "sbatch|--parsable|x.sh",
            "/usr/bin/sbatch|x.sh",
            "env|sbatch|--parsable|{x}",
            "env|A=1|/opt/slurm/bin/sbatch|x.sh",
            "sh|-c|cd run && sbatch --parsable x.sh {x}",
            "bash|-c|echo $(qsub x)",
            "hq|submit|--wait|x",
            "sh|-c|/opt/hq submit x",
        ];
        for text in submits {
            assert!(submits_a_job(&words(text)).is_some(), "{text}");
        }
        for text in ["./simulate|{x}", "./simulate|--mode|sbatch", "sh|-c|cat sbatch.txt", "hq|server", "python3|x.py"]
        {
            assert_eq!(submits_a_job(&words(text)), None, "{text}");
        }
    }

    fn whole(value: f64) -> Ran {
        Ran::Value { value, others: BTreeMap::new(), is_plain_and_whole: true }
    }

    /// Whether each of these is held back, up to the one at which the command is refused.
    fn held_back(values: &[f64], side_by_side: usize) -> (Vec<bool>, bool) {
        let (mut numbers, mut held) = (JobNumbers::default(), Vec::new());
        for value in values {
            match numbers.suspects(&whole(*value), side_by_side) {
                Ok(is_suspect) => held.push(is_suspect),
                Err(_) => return (held, true),
            }
        }
        (held, false)
    }

    #[test]
    fn numbers_of_jobs_are_told_from_whole_responses() {
        assert_eq!(held_back(&[4712.0, 4713.0, 4714.0, 4715.0, 4716.0], 1), (vec![true; 4], true));
        // Two at a time, and the second was faster.
        let two = [4713.0, 4712.0, 4714.0, 4716.0, 4715.0, 4718.0, 4717.0];
        assert_eq!(held_back(&two, 2), (vec![true; 6], true));
        // Twenty at a time: whole responses of a few designs lie as near to each other as numbers of jobs would.
        assert_eq!(held_back(&[10.0, 12.0, 20.0, 22.0, 34.0, 32.0, 16.0, 12.0], 20), (vec![true; 8], false));
        let twenty: Vec<f64> = (0..60).map(|run| f64::from(4711 + (run ^ 3))).collect();
        assert_eq!(held_back(&twenty, 20), (vec![true; 42], true));
        assert_eq!(
            held_back(&[3.0, 4.0, 4.0, 5.0, 6.0, 7.0, 8.0], 1),
            (vec![true, true, false, false, false, false, false], false)
        );
        // Others submit in between; or two jobs for each run, two runs at a time.
        let with_gaps = [4711.0, 4715.0, 4716.0, 4722.0, 4723.0, 4730.0, 4731.0, 4739.0];
        assert_eq!(held_back(&with_gaps, 1), (vec![true; 7], true));
        let exchanged: Vec<f64> = (0..16).map(|run| 100.0 + 2.0 * f64::from(run ^ 1)).collect();
        assert_eq!(held_back(&exchanged, 2), (vec![true; 15], true));
        assert_eq!(held_back(&[12.0, 31.0, 14.0], 1), (vec![true, true, false], false));
        let mut numbers = JobNumbers::default();
        let said = Ran::Value { value: 4.0, others: BTreeMap::new(), is_plain_and_whole: false };
        assert!(!numbers.suspects(&said, 1).expect("an object"));
        assert!((5..20).all(|value| !numbers.suspects(&whole(f64::from(value)), 1).expect("settled")));
    }
}
