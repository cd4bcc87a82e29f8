//! From the text of a TOML file to checked values, with errors that name the key, what stands there and what is allowed.

use core::fmt;
use std::path::Path;

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{self, DeserializeOwned, Expected, IntoDeserializer, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, forward_to_deserialize_any};
use serde_path_to_error::Segment;
use toml::{Table, Value};

use crate::error::FileError;
use crate::quantity::{Record, Written};

/// Reads a file and names it in every error.
pub(crate) fn read<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T, FileError>) -> Result<T, FileError> {
    let text = std::fs::read_to_string(path).map_err(|cause| FileError::Read { path: path.to_path_buf(), cause })?;
    parse(&text).map_err(|error| FileError::In { path: path.to_path_buf(), error: Box::new(error) })
}

/// Reads `text` as a `T`, and every number in it with its provenance, sorted by key.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<(T, Vec<Record>), FileError> {
    let top = Value::Table(text.parse::<Table>()?);
    match read_as(&top) {
        Ok(value) => {
            let mut found = Vec::new();
            records(&top, String::new(), &mut found);
            Ok((value, found))
        }
        Err((keys, fault)) => Err(fault.at(&keys, || expected_at::<T>(&top, &keys, &fault))),
    }
}

fn read_as<T: DeserializeOwned>(top: &Value) -> Result<T, (Vec<Segment>, Fault)> {
    serde_path_to_error::deserialize(Node(top))
        .map_err(|error| (error.path().iter().cloned().collect(), error.into_inner()))
}

/// What should stand where `fault` misses a key: what `T` says of a truth value there, which is nowhere allowed.
fn expected_at<T: DeserializeOwned>(top: &Value, keys: &[Segment], fault: &Fault) -> String {
    let Fault::Missing { name } = fault else { return String::new() };
    let mut probed = top.clone();
    let place = keys.iter().try_fold(&mut probed, |value, key| match key {
        Segment::Map { key } => value.get_mut(key),
        Segment::Seq { index } => value.get_mut(*index),
        _ => None,
    });
    if let Some(table) = place.and_then(Value::as_table_mut) {
        table.insert((*name).to_owned(), Value::Boolean(true));
    }
    match read_as::<T>(&probed) {
        Err((_, Fault::Value { expected, .. })) => expected,
        _ => String::new(),
    }
}

/// Collects every table with a `value` as a number.
fn records(value: &Value, key: String, found: &mut Vec<Record>) {
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match value {
        Value::Table(table) if table.contains_key("value") => {
            if let Ok(Written { value, unit, provenance, source }) = Written::deserialize(Node(value)) {
                found.push(Record { key, value, unit, provenance, source });
            }
        }
        Value::Table(table) => table.iter().for_each(|(name, value)| records(value, below(name), found)),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(index, value)| records(value, format!("{key}[{index}]"), found));
        }
        _ => {}
    }
}

/// What is wrong at one place of a file.
#[derive(Debug)]
enum Fault {
    Unknown { name: String, known: &'static [&'static str] },
    Missing { name: &'static str },
    Value { found: String, expected: String },
    Other { message: String },
}

impl Fault {
    /// The error that names the place; `expected` is asked what stands where a key is missing.
    fn at(&self, keys: &[Segment], expected: impl FnOnce() -> String) -> FileError {
        let place = written(keys);
        let below = |name: &str| if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") };
        match self {
            Self::Unknown { name, known } => unknown_key(place, name, known),
            Self::Missing { name } => FileError::MissingKey { key: below(name), expected: expected() },
            Self::Value { found, expected } => {
                FileError::Value { key: place, found: found.clone(), expected: expected.clone() }
            }
            Self::Other { message } => {
                FileError::Value { key: place, found: message.clone(), expected: "readable".to_owned() }
            }
        }
    }
}

/// Edits up to which a key counts as a slip of another.
const LARGEST_SLIP: usize = 2;

fn unknown_key(key: String, name: &str, known: &[&str]) -> FileError {
    let mut known = known.to_vec();
    known.sort_unstable();
    let similar = known
        .iter()
        .map(|other| (strsim::damerau_levenshtein(other, name), *other))
        .filter(|(edits, _)| *edits <= LARGEST_SLIP)
        .min()
        .map(|(_, other)| other.to_owned());
    FileError::UnknownKey { key, known: known.join(", "), similar }
}

/// Keys as people write them: `flow[0].speed`.
fn written(keys: &[Segment]) -> String {
    keys.iter().fold(String::new(), |path, key| match key {
        Segment::Map { key } if path.is_empty() => key.clone(),
        Segment::Map { key } => format!("{path}.{key}"),
        Segment::Seq { index } => format!("{path}[{index}]"),
        _ => path,
    })
}

/// `a, b or c`.
fn choices(words: &[&str]) -> String {
    match words {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => words.concat(),
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::Other { message: message.to_string() }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let found = match found {
            Unexpected::Map => "a table".to_owned(),
            Unexpected::Seq => "an array".to_owned(),
            Unexpected::Float(value) => value.to_string(),
            Unexpected::Signed(value) => value.to_string(),
            Unexpected::Str(text) => format!("{text:?}"),
            Unexpected::Bool(value) => value.to_string(),
            other => other.to_string(),
        };
        Self::Value { found, expected: expected.to_string() }
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn unknown_variant(found: &str, expected: &'static [&'static str]) -> Self {
        Self::Value { found: format!("{found:?}"), expected: choices(expected) }
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::Unknown { name: name.to_owned(), known }
    }

    fn missing_field(name: &'static str) -> Self {
        Self::Missing { name }
    }
}

/// A value of a file as serde reads it, with [`Fault`] for its errors: that of `toml` has them as a sentence only.
struct Node<'a>(&'a Value);

impl Node<'_> {
    fn instead_of(&self, expected: String) -> Fault {
        let found = match self.0 {
            Value::Table(_) => "a table".to_owned(),
            Value::Array(_) => "an array".to_owned(),
            plain => plain.to_string(),
        };
        Fault::Value { found, expected }
    }
}

impl<'de> Deserializer<'de> for Node<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            Value::String(text) => visitor.visit_str(text),
            Value::Integer(value) => visitor.visit_i64(*value),
            Value::Float(value) => visitor.visit_f64(*value),
            Value::Boolean(value) => visitor.visit_bool(*value),
            Value::Datetime(date) => Err(de::Error::invalid_type(Unexpected::Other(&date.to_string()), &visitor)),
            Value::Array(items) => visitor.visit_seq(SeqDeserializer::new(items.iter().map(Node))),
            Value::Table(table) => {
                visitor.visit_map(MapDeserializer::new(table.iter().map(|(key, value)| (key.as_str(), Node(value)))))
            }
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        words: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.0 {
            Value::String(word) => visitor.visit_enum(word.as_str().into_deserializer()),
            _ => Err(self.instead_of(choices(words))),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        if self.0.is_str() { self.deserialize_any(visitor) } else { Err(self.instead_of("a text".to_owned())) }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        if self.0.is_array() {
            self.deserialize_any(visitor)
        } else {
            Err(self.instead_of("an array of tables".to_owned()))
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str bytes byte_buf unit unit_struct newtype_struct tuple
        tuple_struct map struct identifier ignored_any
    }
}

impl IntoDeserializer<'_, Fault> for Node<'_> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}
