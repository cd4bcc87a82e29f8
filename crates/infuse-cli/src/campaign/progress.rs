//! How far runs are, on a terminal.

use indicatif::{HumanDuration, ProgressBar, ProgressFinish, ProgressState, ProgressStyle};
use std::io::Write as _;
use std::time::Duration;

/// A bar, and what was said of the queue.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    said: String,
}

impl Progress {
    /// Of so many runs, named in the plural.
    pub(crate) fn new(what: &str, n: usize) -> Self {
        let bar = ProgressBar::new(n as u64);
        let style = ProgressStyle::with_template(&format!("{what} {{bar:30}} {{pos}}/{{len}}{{left}} {{msg}}"))
            .map(|style| style.with_key("left", time_left));
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.tick();
        Self { bar, said: String::new() }
    }

    /// The bar, which may be moved on from anywhere.
    pub(crate) fn bar(&self) -> ProgressBar {
        self.bar.clone()
    }

    /// So many runs are in a queue, and what is wrong with it, said once.
    pub(crate) fn queued(&mut self, n: usize, trouble: &str) {
        self.bar.set_message(format!("({n} in the queue)"));
        if !trouble.is_empty() && self.said != trouble {
            trouble.clone_into(&mut self.said);
            let note = format!("note: {trouble}: nobody knows what is in the queue; asking again");
            // Without a terminal it is the only sign of life.
            self.bar.suspend(|| drop(writeln!(std::io::stderr(), "{note}")));
        }
    }
}

/// Shows that something is being computed, until it is dropped.
pub(crate) fn busy(what: String) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(what).with_finish(ProgressFinish::AndClear);
    spinner.enable_steady_tick(Duration::from_millis(200));
    spinner
}

/// How long it takes still, as soon as that is known.
fn time_left(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    if state.pos() > 0 {
        let _ = write!(out, ", {:#} left", HumanDuration(state.eta()));
    }
}
