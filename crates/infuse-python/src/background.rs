//! Work on a thread of its own, while the one that called listens for Ctrl-C and runs what Python has to run.

use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::refusal;

/// How often signals are looked for.
const EVERY: Duration = Duration::from_millis(50);
/// Stack of the thread, in bytes: as much as a main thread usually has.
const STACK: usize = 8 << 20;

/// What the work wants of the thread that called.
enum Wanted {
    /// An answer of the Python function at these points.
    Answer(Vec<Vec<f64>>),
    /// Nothing more: it is done.
    Nothing,
}

/// Asks the thread that called.
pub(crate) struct Caller {
    wanted: Sender<Wanted>,
    answers: Receiver<Vec<f64>>,
}

/// Why a thread ends that nobody waits for.
struct Abandoned;

impl Caller {
    /// The answer at these points. Where nobody waits for the work any more it is not gone on with: its thread, which is its
    /// own, ends here without a word.
    pub(crate) fn call(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let answer = self.wanted.send(Wanted::Answer(points.to_vec())).ok().and_then(|()| self.answers.recv().ok());
        answer.unwrap_or_else(|| resume_unwind(Box::new(Abandoned)))
    }
}

/// Does the work while other Python threads run. Ctrl-C ends the call with its exception; the work then goes on unheard until
/// its own end, or until it asks for an answer, and what it came to is dropped.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let none = |_: &[Vec<f64>]| Ok(Vec::new());
    interruptible_with(py, none, |_| work())
}

/// The same for work that needs answers of a Python function, which is called on this thread. Where it raises, the call ends
/// with that.
pub(crate) fn interruptible_with<T: Send + 'static>(
    py: Python<'_>,
    answer: impl Fn(&[Vec<f64>]) -> PyResult<Vec<f64>>,
    work: impl FnOnce(&Caller) -> T + Send + 'static,
) -> PyResult<T> {
    let ((wanted, mut wishes), (reply, answers)) = (channel(), channel());
    let caller = Caller { wanted, answers };
    let job = move || {
        let result = work(&caller);
        // Nobody may listen any more.
        let _ = caller.wanted.send(Wanted::Nothing);
        result
    };
    let thread = thread::Builder::new().stack_size(STACK).spawn(job).map_err(refusal)?;
    loop {
        let listening = &mut wishes;
        match py.detach(move || listening.recv_timeout(EVERY)) {
            Ok(Wanted::Answer(points)) => {
                // Where nobody takes the answer, the thread has ended, as the next round finds out.
                let _ = reply.send(answer(&points)?);
            }
            Ok(Wanted::Nothing) | Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
        }
    }
    match py.detach(|| thread.join()) {
        Ok(result) => Ok(result),
        Err(panic) => resume_unwind(panic),
    }
}
