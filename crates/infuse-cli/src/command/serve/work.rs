//! What takes long is done beside the page, one thing at a time.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Result;

use super::super::output::Output;
use crate::journal::now;
use crate::program;

/// As a shell reports a program that was stopped by Ctrl-C.
const INTERRUPTED: i32 = 130;

/// The work that goes on, or what became of the last.
#[derive(Debug, Clone, Default)]
pub(super) struct Work(Arc<Mutex<State>>);

#[derive(Debug, Clone, Default)]
pub(super) enum State {
    #[default]
    Nothing,
    /// Since then.
    Busy(String),
    /// Its text, with its notices.
    Done(Vec<String>),
    Failed(String),
}

impl Work {
    pub(super) fn state(&self) -> State {
        self.lock().clone()
    }

    /// What was said about the last work is old as soon as something else was done.
    pub(super) fn forget(&self) {
        let mut state = self.lock();
        if !matches!(*state, State::Busy(_)) {
            *state = State::Nothing;
        }
    }

    /// What is to be known about something short that was done.
    pub(super) fn say(&self, notices: Vec<String>) {
        let mut state = self.lock();
        if !matches!(*state, State::Busy(_)) {
            *state = State::Done(notices);
        }
    }

    /// Begins this, unless something goes on.
    pub(super) fn begin(&self, work: impl FnOnce() -> Result<Output> + Send + 'static) -> Result<()> {
        let mut state = self.lock();
        if matches!(*state, State::Busy(_)) {
            return Ok(());
        }
        let own = self.clone();
        std::thread::Builder::new().spawn(move || {
            let ending = match work() {
                Ok(output) => State::Done(output.notices),
                Err(error) => State::Failed(format!("{error:#}")),
            };
            *own.lock() = ending;
            // The interrupt has waited until what was simulated was written down.
            if program::is_interrupted() {
                program::interrupt(INTERRUPTED);
            }
        })?;
        *state = State::Busy(now());
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
