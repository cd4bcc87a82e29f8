//! All sets of repeating variables.

use crate::span::Span;
use crate::system::{System, Variable};

/// Every set of variables with independent dimensions that spans those of the whole system.
///
/// The search is depth first and gives up a branch as soon as its variables depend on each other, so the first sets
/// come at once even where there are millions.
#[derive(Debug, Clone)]
pub struct RepeatingSets<'a> {
    variables: &'a [Variable],
    rank: usize,
    /// Positions chosen so far, each with the span of it and those before.
    chosen: Vec<(usize, Span)>,
    /// The next position to try, or none at the end.
    next: Option<usize>,
}

impl<'a> RepeatingSets<'a> {
    pub(crate) fn new(variables: &'a [Variable], rank: usize) -> Self {
        Self { variables, rank, chosen: Vec::new(), next: Some(0) }
    }

    /// Gives up the last choice and goes on after it.
    fn back(&mut self) {
        self.next = self.chosen.pop().map(|(position, _)| position + 1);
    }
}

impl<'a> Iterator for RepeatingSets<'a> {
    type Item = Vec<&'a str>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let position = self.next?;
            if self.chosen.len() == self.rank {
                let names = self.chosen.iter().map(|(position, _)| self.variables[*position].name.as_str()).collect();
                self.back();
                return Some(names);
            }
            // Too few variables are left to complete the set.
            if self.variables.len() - position < self.rank - self.chosen.len() {
                self.back();
                continue;
            }
            let variable = &self.variables[position];
            let mut span = self.chosen.last().map_or_else(Span::default, |(_, span)| span.clone());
            if span.insert(&variable.name, variable.dimension.exponents()).is_ok() {
                self.chosen.push((position, span));
            }
            self.next = Some(position + 1);
        }
    }
}

impl System {
    /// Every set of repeating variables that works, one at a time, in lexical order of positions.
    #[must_use]
    pub fn repeating_sets(&self) -> RepeatingSets<'_> {
        RepeatingSets::new(self.variables(), self.rank())
    }
}
