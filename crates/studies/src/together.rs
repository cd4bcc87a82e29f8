//! Searches that ask for one thing after the other, side by side: what all of them wait for is answered at once.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// A search, which asks as often as it likes.
pub(crate) type Search<'a, Q, A, T> = Box<dyn FnOnce(&dyn Fn(Q) -> A) -> T + Send + 'a>;

/// Runs searches, each on a thread of its own. When all that have not ended wait for an answer, `answer` is given their questions, in
/// the order of the searches, and has to answer each of them.
///
/// Which search is how fast plays no part: the questions that meet are the same in every run.
pub(crate) fn together<Q: Send, A: Send, T: Send>(
    searches: Vec<Search<'_, Q, A, T>>,
    mut answer: impl FnMut(Vec<Q>) -> Vec<A>,
) -> Vec<T> {
    thread::scope(|scope| {
        let (sender, questions) = channel();
        let mut answers = Vec::new();
        let mut threads = Vec::new();
        for (number, search) in searches.into_iter().enumerate() {
            let (to_search, from_all) = channel();
            answers.push(to_search);
            let asker = Asker { number, questions: sender.clone(), answers: from_all };
            threads.push(scope.spawn(move || search(&|question| asker.ask(question))));
        }
        drop(sender);
        let mut n_searching = threads.len();
        let mut waiting = BTreeMap::new();
        // Ends when every search has ended, in whatever way.
        for (number, question) in questions {
            match question {
                Some(question) => drop(waiting.insert(number, question)),
                None => n_searching -= 1,
            }
            if !waiting.is_empty() && waiting.len() == n_searching {
                let (numbers, asked): (Vec<usize>, Vec<Q>) = std::mem::take(&mut waiting).into_iter().unzip();
                let found = answer(asked);
                assert_eq!(found.len(), numbers.len(), "an answer for each question");
                for (number, found) in numbers.into_iter().zip(found) {
                    // A search that is no longer there needs none.
                    let _: Result<(), _> = answers[number].send(found);
                }
            }
        }
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

/// What a search asks by; that it has ended is told when it is dropped.
struct Asker<Q, A> {
    number: usize,
    questions: Sender<(usize, Option<Q>)>,
    answers: Receiver<A>,
}

impl<Q, A> Asker<Q, A> {
    fn ask(&self, question: Q) -> A {
        let sent = self.questions.send((self.number, Some(question))).is_ok();
        let answer = if sent { self.answers.recv().ok() } else { None };
        answer.expect("whoever answers stays until every search has ended")
    }
}

impl<Q, A> Drop for Asker<Q, A> {
    fn drop(&mut self) {
        let _: Result<(), _> = self.questions.send((self.number, None));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches of different length: each asks for the double of its number, and of what it got.
    fn doubling(lengths: &[usize]) -> (Vec<u64>, Vec<Vec<u64>>) {
        let searches = lengths.iter().enumerate().map(|(number, length)| -> Search<'_, u64, u64, u64> {
            let length = *length;
            Box::new(move |ask| (0..length).fold(number as u64 + 1, |value, _| ask(value)))
        });
        let mut met = Vec::new();
        let ends = together(searches.collect(), |questions| {
            met.push(questions.clone());
            questions.into_iter().map(|value| 2 * value).collect()
        });
        (ends, met)
    }

    #[test]
    fn questions_meet_in_the_order_of_the_searches_until_each_has_ended() {
        let (ends, met) = doubling(&[1, 3, 0, 2]);
        assert_eq!(ends, [2, 16, 3, 16]);
        assert_eq!(met, [vec![1, 2, 4], vec![4, 8], vec![8]]);
        assert_eq!(doubling(&[]), (Vec::new(), Vec::new()));
    }

    #[test]
    #[should_panic(expected = "no way on")]
    fn a_search_that_panics_leaves_nobody_waiting() {
        let searches: Vec<Search<'_, u64, u64, u64>> =
            vec![Box::new(|_| panic!("no way on")), Box::new(|ask| ask(ask(1)))];
        together(searches, |questions| questions);
    }
}
