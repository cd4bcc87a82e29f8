//! The plant of a file: the sections and keys of [`FIELDS`] and [`OPTIONAL_FIELDS`], so that a field is declared in one place only.

use core::fmt;
use std::sync::LazyLock;

use bat_dynamics::{FIELDS, Field, OPTIONAL_FIELDS, Parameters, TetherLayout};
use serde::de::{DeserializeSeed, Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::quantity::Written;

/// The key beside the numbers of [`LAYOUT_SECTION`].
const LAYOUT: &str = "layout";
const LAYOUT_SECTION: &str = "tether";

/// A section of the fields with the keys that a file has in it.
struct Section {
    fields: &'static [Field],
    keys: Vec<&'static str>,
    /// The place of its first field among all.
    first: usize,
    /// Whether it and its keys may be left out, and are then zero.
    optional: bool,
}

static SECTIONS: LazyLock<Vec<Section>> = LazyLock::new(|| {
    let mut first = 0;
    let section = |fields: &'static [Field]| {
        let layout = (fields[0].section == LAYOUT_SECTION).then_some(LAYOUT);
        let keys = fields.iter().map(|field| field.name).chain(layout).collect();
        first += fields.len();
        Section { fields, keys, first: first - fields.len(), optional: fields[0].optional }
    };
    let same = |a: &Field, b: &Field| a.section == b.section;
    FIELDS.chunk_by(same).chain(OPTIONAL_FIELDS.chunk_by(same)).map(section).collect()
});

static NAMES: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| SECTIONS.iter().map(|section| section.fields[0].section).collect());

/// The plant's parameters, each within its own range.
pub(crate) struct PlantTable(pub(crate) Parameters);

/// What was read so far, by the position of each field in [`Parameters::fields`].
struct Gathered {
    values: Vec<Option<f64>>,
    layout: Option<TetherLayout>,
}

impl<'de> Deserialize<'de> for PlantTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Sections)
    }
}

struct Sections;

impl<'de> Visitor<'de> for Sections {
    type Value = PlantTable;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<PlantTable, A::Error> {
        let mut gathered = Gathered { values: vec![None; Parameters::fields().count()], layout: None };
        let mut seen = vec![false; SECTIONS.len()];
        while let Some(index) = map.next_key_seed(OneOf(&NAMES))? {
            seen[index] = true;
            map.next_value_seed(Keys { section: &SECTIONS[index], gathered: &mut gathered })?;
        }
        let lacking = |(section, seen): (&Section, &bool)| !(*seen || section.optional);
        if let Some(missing) = SECTIONS.iter().zip(&seen).position(lacking) {
            return Err(A::Error::missing_field(NAMES[missing]));
        }
        let mut values = gathered.values.iter().copied();
        let layout = gathered.layout.unwrap_or_default();
        // Every section is complete, so that there is a value for every field that has to have one.
        let lookup = |field: &'static Field| match values.next().flatten() {
            Some(value) => Ok(value),
            None if field.optional => Ok(0.0),
            None => Err(A::Error::missing_field(field.name)),
        };
        Ok(PlantTable(Parameters::from_fields(layout, lookup)?))
    }
}

/// Reads one section.
struct Keys<'a> {
    section: &'static Section,
    gathered: &'a mut Gathered,
}

impl<'de> DeserializeSeed<'de> for Keys<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Keys<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Section { fields, keys, first, optional } = self.section;
        let mut seen = vec![false; keys.len()];
        while let Some(index) = map.next_key_seed(OneOf(keys))? {
            seen[index] = true;
            match fields.get(index) {
                Some(field) => self.gathered.values[first + index] = Some(map.next_value_seed(Number(field))?),
                None => self.gathered.layout = Some(map.next_value()?),
            }
        }
        match seen.iter().position(|seen| !seen) {
            Some(missing) if !optional => Err(A::Error::missing_field(keys[missing])),
            _ => Ok(()),
        }
    }
}

/// Reads one number within the range of its field.
struct Number(&'static Field);

impl<'de> DeserializeSeed<'de> for Number {
    type Value = f64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<f64, D::Error> {
        let Field { unit, allowed, .. } = self.0;
        Written::deserialize(deserializer)?.within(unit, |value| allowed.admits(value), allowed.words())
    }
}

/// Reads a key as its position in a list.
struct OneOf(&'static [&'static str]);

impl<'de> DeserializeSeed<'de> for OneOf {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for OneOf {
    type Value = usize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: serde::de::Error>(self, key: &str) -> Result<usize, E> {
        self.0.iter().position(|known| *known == key).ok_or_else(|| E::unknown_field(key, self.0))
    }
}
