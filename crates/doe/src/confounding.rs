//! What a term that cannot be told from others equals.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::wording::combination;

/// A term that is a linear combination of earlier terms on every point looked at.
///
/// Terms earlier in the model are kept, so dropping the `term` of each confounding leaves a model that can be
/// estimated, with the lower-order terms in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confounding {
    /// Index of the dependent term.
    pub term: usize,
    /// Its name.
    pub name: String,
    /// Indices and coefficients of the earlier terms it equals, empty if it vanishes everywhere.
    pub equals: Vec<(usize, f64)>,
    /// Their names, in the same order.
    pub equal_names: Vec<String>,
}

impl Confounding {
    /// The same with other names: one per term of the model, as of [`Model::term_names`](crate::Model::term_names);
    /// where one is missing it stays as it is.
    #[must_use]
    pub fn with_names(mut self, names: &[String]) -> Self {
        let rename = |name: &mut String, term: usize| {
            if let Some(other) = names.get(term) {
                name.clone_from(other);
            }
        };
        rename(&mut self.name, self.term);
        for (name, &(term, _)) in self.equal_names.iter_mut().zip(&self.equals) {
            rename(name, term);
        }
        self
    }
}

impl fmt::Display for Confounding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = self.equal_names.iter().zip(&self.equals).map(|(name, &(_, c))| (name.as_str(), c));
        write!(formatter, "`{}` = {}", self.name, combination(parts))
    }
}
