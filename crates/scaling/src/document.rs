//! Parameter files: every quantity converted, everything else left as it was written.

use std::fmt;

use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

use crate::dimension::Dimension;
use crate::error::Error;
use crate::factor::Factor;
use crate::law::ScalingLaw;
use crate::units::Units;

/// Which keys hold numbers, and what else to rewrite beside a converted number.
pub struct DocumentOptions<'a> {
    /// Keys that hold a number, or a list of numbers, in the unit under `unit_key`; at first `value`.
    pub value_keys: Vec<String>,
    /// The key of the unit string; at first `unit`.
    pub unit_key: String,
    /// Asked for each converted number; sets the returned string keys of the same table (`provenance`, `source`).
    #[expect(clippy::type_complexity, reason = "a callback")]
    pub rewrite: Option<Box<dyn Fn(&Converted) -> Vec<(String, String)> + 'a>>,
}

/// A converted document.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conversion {
    /// The document with its comments, order and layout.
    pub text: String,
    /// Every number, in the order of the document, also where the factor is 1.
    pub converted: Vec<Converted>,
    /// Tables that have a unit but none of the value keys, as paths: nothing in them was touched.
    pub without_value: Vec<String>,
}

/// One converted number.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Converted {
    /// The table of the number, as a dotted path, with positions of lists in brackets.
    pub path: String,
    /// The value key, with a position in brackets for a list.
    pub key: String,
    /// The unit string; it stays.
    pub unit: String,
    /// What the unit measures.
    pub dimension: Dimension,
    /// The exact ratio.
    pub factor: Factor,
    /// The number before.
    pub old: f64,
    /// The number after.
    pub new: f64,
    /// The other string keys of the same table, as they were.
    pub others: Vec<(String, String)>,
}

impl Default for DocumentOptions<'_> {
    fn default() -> Self {
        Self { value_keys: vec!["value".to_owned()], unit_key: "unit".to_owned(), rewrite: None }
    }
}

impl fmt::Debug for DocumentOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DocumentOptions")
            .field("value_keys", &self.value_keys)
            .field("unit_key", &self.unit_key)
            .field("rewrite", &self.rewrite.is_some())
            .finish()
    }
}

impl ScalingLaw {
    /// Converts every table `{ value = 1.0, unit = "m", … }` anywhere in a TOML document, in line or not.
    ///
    /// Unit strings stay: centimeters remain centimeters.
    /// A number keeps its notation (plain or with an exponent), and where the factor is 1 its very text.
    ///
    /// # Errors
    /// [`Error::Toml`]; [`Error::AtKey`] with the path for an unknown unit, for a dimension that the law does not
    /// determine, for a value that is not a number and for one that leaves the range of f64.
    pub fn convert_document(
        &self,
        units: &Units,
        text: &str,
        options: &DocumentOptions<'_>,
    ) -> Result<Conversion, Error> {
        let mut document: DocumentMut =
            text.parse().map_err(|error: toml_edit::TomlError| Error::Toml { message: error.to_string() })?;
        let mut converter = Converter { law: self, units, options, converted: Vec::new(), without_value: Vec::new() };
        converter.table(document.as_table_mut(), "")?;
        let Converter { converted, without_value, .. } = converter;
        let mut converted_text = document.to_string();
        // The printer ends every document with a newline.
        if !text.ends_with('\n') && converted_text.ends_with('\n') {
            converted_text.pop();
        }
        // It also writes every line end as a line feed; a text of the other kind gets its own back.
        if text.contains('\n') && text.matches('\n').count() == text.matches("\r\n").count() {
            converted_text = converted_text.replace("\r\n", "\n").replace('\n', "\r\n");
        }
        Ok(Conversion { text: converted_text, converted, without_value })
    }
}

struct Converter<'a> {
    law: &'a ScalingLaw,
    units: &'a Units,
    options: &'a DocumentOptions<'a>,
    converted: Vec<Converted>,
    without_value: Vec<String>,
}

impl Converter<'_> {
    fn table(&mut self, table: &mut dyn TableLike, path: &str) -> Result<(), Error> {
        let unit = table.get(&self.options.unit_key).and_then(Item::as_str).map(str::to_owned);
        if let Some(unit) = unit {
            self.quantity(table, path, &unit).map_err(|error| at(path, error))?;
        }
        for (key, item) in table.iter_mut() {
            self.item(item, &join(path, key.get()))?;
        }
        Ok(())
    }

    fn item(&mut self, item: &mut Item, path: &str) -> Result<(), Error> {
        match item {
            Item::Table(table) => self.table(table, path),
            Item::ArrayOfTables(tables) => {
                tables.iter_mut().enumerate().try_for_each(|(i, table)| self.table(table, &format!("{path}[{i}]")))
            }
            Item::Value(value) => self.value(value, path),
            Item::None => Ok(()),
        }
    }

    fn value(&mut self, value: &mut Value, path: &str) -> Result<(), Error> {
        match value {
            Value::InlineTable(table) => self.table(table, path),
            Value::Array(list) => {
                list.iter_mut().enumerate().try_for_each(|(i, value)| self.value(value, &format!("{path}[{i}]")))
            }
            _ => Ok(()),
        }
    }

    fn quantity(&mut self, table: &mut dyn TableLike, path: &str, unit: &str) -> Result<(), Error> {
        let present = |key: &&String| table.contains_key(key);
        let keys: Vec<String> = self.options.value_keys.iter().filter(present).cloned().collect();
        if keys.is_empty() {
            self.without_value.push(path.to_owned());
            return Ok(());
        }
        let dimension = self.units.parse(unit)?.dimension;
        let factor = self.law.factor(&dimension)?;
        let text = |(key, item): (&str, &Item)| Some((key.to_owned(), item.as_str()?.to_owned()));
        let others: Vec<_> = table.iter().filter_map(text).filter(|(key, _)| *key != self.options.unit_key).collect();
        let mut rewritten = Vec::new();
        for key in keys {
            let Some(Item::Value(value)) = table.get_mut(&key) else {
                return Err(Error::NotANumber { found: "a table".to_owned() });
            };
            for (key, old, new) in numbers(value, &key, &factor)? {
                let converted = Converted {
                    path: path.to_owned(),
                    key,
                    unit: unit.to_owned(),
                    dimension: dimension.clone(),
                    factor: factor.clone(),
                    old,
                    new,
                    others: others.clone(),
                };
                if let Some(rewrite) = &self.options.rewrite {
                    rewritten.extend(rewrite(&converted));
                }
                self.converted.push(converted);
            }
        }
        rewritten.into_iter().for_each(|(key, text)| set_text(table, &key, &text));
        Ok(())
    }
}

/// Converts a number or a list of numbers in place; tells key, old and new value of each.
fn numbers(value: &mut Value, key: &str, factor: &Factor) -> Result<Vec<(String, f64, f64)>, Error> {
    if let Value::Array(list) = value {
        return in_list(list, key, factor);
    }
    let decor = value.decor().clone();
    let (old, text) = match value {
        Value::Float(number) => (*number.value(), written(number.as_repr())),
        Value::Integer(number) => (*number.value() as f64, written(number.as_repr())),
        _ => return Err(Error::NotANumber { found: value.type_name().to_owned() }),
    };
    let exact_integer = value.as_integer().is_none_or(|n| n.unsigned_abs() <= 1 << 53);
    if !old.is_finite() || !exact_integer {
        return Err(Error::NotANumber { found: text });
    }
    let new = factor.apply(old);
    if !new.is_finite() || (new == 0.0 && old != 0.0) {
        return Err(Error::ValueOutOfRange { value: old, factor: factor.to_string() });
    }
    if new.to_bits() != old.to_bits() {
        *value = parse_value(&in_notation_of(&text, value.is_integer(), new), new);
        *value.decor_mut() = decor;
    }
    Ok(vec![(key.to_owned(), old, new)])
}

fn in_list(list: &mut Array, key: &str, factor: &Factor) -> Result<Vec<(String, f64, f64)>, Error> {
    let each = list.iter_mut().enumerate().map(|(i, value)| numbers(value, &format!("{key}[{i}]"), factor));
    Ok(each.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// The text of a number as it stands in the document.
fn written(repr: Option<&toml_edit::Repr>) -> String {
    repr.and_then(|repr| repr.as_raw().as_str()).unwrap_or("a number").to_owned()
}

fn parse_value(text: &str, new: f64) -> Value {
    text.parse().unwrap_or_else(|_| Value::from(new))
}

/// Writes a number as its predecessor was written: as an integer, in plain decimals or with an exponent.
fn in_notation_of(old: &str, integer: bool, new: f64) -> String {
    if integer && new.fract() == 0.0 && new.abs() < 9e15 {
        return format!("{new}");
    }
    let Some(e) = old.chars().find(|c| matches!(c, 'e' | 'E')) else {
        return plain(new);
    };
    format!("{new:e}").replace('e', &e.to_string())
}

fn plain(new: f64) -> String {
    let text = format!("{new}");
    if text.contains('.') { text } else { format!("{text}.0") }
}

fn set_text(table: &mut dyn TableLike, key: &str, text: &str) {
    let decor = table.get(key).and_then(Item::as_value).map(|value| value.decor().clone());
    let mut value = Value::from(text);
    match decor {
        Some(decor) => *value.decor_mut() = decor,
        None => value.decor_mut().clear(),
    }
    table.insert(key, Item::Value(value));
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn at(path: &str, error: Error) -> Error {
    Error::AtKey { path: path.to_owned(), fault: Box::new(error) }
}
