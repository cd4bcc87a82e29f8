//! What came of a start: a plant, or why there is none.

/// What came of a start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Start {
    pub(super) number: u64,
    /// None where the plant was kept.
    pub(super) refusal: Option<Refusal>,
    /// The largest residual where the fit ended, in tolerances.
    pub(super) worst: Option<f64>,
}

/// A plant that meets the evidence, as its free numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub(super) start: u64,
    pub(super) values: Vec<f64>,
}

/// Why a start was not kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Refusal {
    /// It cannot fly what the evidence asks for.
    CannotFly,
    /// No plant nearby meets it.
    NotMet,
    /// The costs are lower elsewhere, whatever was tried.
    OtherOptimum,
    /// Too many designs of the box cannot fly.
    FailsInBox,
}

impl Refusal {
    pub(super) const ALL: [Self; 4] = [Self::CannotFly, Self::NotMet, Self::OtherOptimum, Self::FailsInBox];

    /// What stands for it in the kept table of starts. The table has a sum over its text, so a name stays as it is, whatever
    /// pages say.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::CannotFly => "start cannot fly what the evidence asks for",
            Self::NotMet => "evidence not met",
            Self::OtherOptimum => "costs lower elsewhere in the box",
            Self::FailsInBox => "too many designs of the box fail",
        }
    }

    /// What people read.
    pub(super) const fn words(self) -> &'static str {
        match self {
            Self::CannotFly => "start cannot fly what the evidence asks for",
            Self::NotMet => "evidence not met",
            Self::OtherOptimum => "costs lower elsewhere in the box",
            Self::FailsInBox => "too many designs of the box fail",
        }
    }
}
