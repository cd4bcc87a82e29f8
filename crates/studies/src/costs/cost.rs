//! What a flight costs.

use std::fmt;

use water_channel::FlightError;

/// A flight's cost, or the reason why there is none, in words.
pub(crate) type Cost = Result<f64, String>;

/// The same as it is remembered and kept.
pub(crate) type Flown = Result<f64, Failure>;

/// Why a flight has no cost. Two are the same if they are of one kind, whatever the words say.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(super) kind: Kind,
    pub(super) words: String,
}

/// What becomes of a flight without a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// It does not begin.
    Start,
    /// It leaves the model.
    LeftTheModel,
    /// A line goes slack.
    Slack,
    /// What is none of these.
    Other,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Start, Self::LeftTheModel, Self::Slack, Self::Other];

    /// What stands for it in files.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::LeftTheModel => "left-the-model",
            Self::Slack => "slack",
            Self::Other => "other",
        }
    }

    pub(super) fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl Failure {
    /// The name of its kind: the same whatever the words say.
    #[cfg(feature = "global")]
    pub(crate) fn name(&self) -> &'static str {
        self.kind.name()
    }
}

impl PartialEq for Failure {
    fn eq(&self, other: &Self) -> bool {
        self.kind == other.kind
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl From<FlightError> for Failure {
    fn from(error: FlightError) -> Self {
        let kind = match error {
            FlightError::Start(_) => Kind::Start,
            FlightError::LeftTheModel(_) => Kind::LeftTheModel,
            FlightError::Slack { .. } => Kind::Slack,
            _ => Kind::Other,
        };
        Self { kind, words: error.to_string() }
    }
}

impl From<Failure> for String {
    fn from(failure: Failure) -> Self {
        failure.words
    }
}
