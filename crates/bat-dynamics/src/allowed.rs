//! Ranges of physical numbers, with words for messages.

/// What values a parameter may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// Any finite number.
    Finite,
    /// Zero or more.
    NonNegative,
    /// More than zero.
    Positive,
    /// An angle above 0 and at most a quarter turn.
    AcuteAngle,
    /// An angle of less than a half turn to either side.
    ShortOfHalfTurn,
}

impl Allowed {
    /// Whether `value` (in SI) is allowed.
    #[must_use]
    pub fn admits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::NonNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::AcuteAngle => value > 0.0 && value <= core::f64::consts::FRAC_PI_2,
                Self::ShortOfHalfTurn => value.abs() < core::f64::consts::PI,
            }
    }

    /// In words, for an error message.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Finite => "a finite number",
            Self::NonNegative => "finite and zero or more",
            Self::Positive => "finite and more than zero",
            Self::AcuteAngle => "more than 0 and at most pi/2 rad",
            Self::ShortOfHalfTurn => "short of a half turn to either side",
        }
    }
}
