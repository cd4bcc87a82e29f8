//! How finely a parameter can be set.

use serde::de::{Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The settings a parameter can take between its bounds.
///
/// In a file it is the word `"continuous"` or a whole number of levels:
///
/// ```
/// use design_space::Levels;
/// assert_eq!(serde_json::from_str::<Levels>("24").unwrap(), Levels::Count(24));
/// assert_eq!(serde_json::from_str::<Levels>("\"continuous\"").unwrap(), Levels::Continuous);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Levels {
    /// Any value between the bounds.
    #[default]
    Continuous,
    /// This many equally spaced values, both bounds included; at least 2, checked where a
    /// [`Parameter`](crate::Parameter) is made.
    Count(u32),
}

const WORD: &str = "continuous";

impl Serialize for Levels {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Continuous => serializer.serialize_str(WORD),
            Self::Count(count) => serializer.serialize_u32(*count),
        }
    }
}

impl<'de> Deserialize<'de> for Levels {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LevelsVisitor)
    }
}

struct LevelsVisitor;

impl Visitor<'_> for LevelsVisitor {
    type Value = Levels;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "the word \"{WORD}\" or a whole number of levels, at least 2")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Levels, E> {
        if word == WORD { Ok(Levels::Continuous) } else { Err(E::invalid_value(Unexpected::Str(word), &self)) }
    }

    fn visit_u64<E: serde::de::Error>(self, count: u64) -> Result<Levels, E> {
        u32::try_from(count).map(Levels::Count).map_err(|_| E::invalid_value(Unexpected::Unsigned(count), &self))
    }

    fn visit_i64<E: serde::de::Error>(self, count: i64) -> Result<Levels, E> {
        u32::try_from(count).map(Levels::Count).map_err(|_| E::invalid_value(Unexpected::Signed(count), &self))
    }
}
