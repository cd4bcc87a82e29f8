//! What was measured.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::{check_count, check_each, check_finite};

/// The readings of one experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    pub(super) design: Vec<f64>,
    pub(super) values: Vec<f64>,
    pub(super) deviations: Vec<f64>,
}

/// What was measured: at each design one reading of every response, with its standard deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, try_from = "Fields")]
pub struct Measurements {
    responses: Vec<String>,
    rows: Vec<Row>,
    n_failed: usize,
}

/// As they stand in a file, before they are checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    responses: Vec<String>,
    rows: Vec<Row>,
    n_failed: usize,
}

impl TryFrom<Fields> for Measurements {
    type Error = Error;

    fn try_from(Fields { responses, rows, n_failed }: Fields) -> Result<Self, Error> {
        let mut measurements = Self { n_failed, ..Self::new(responses)? };
        for Row { design, values, deviations } in rows {
            measurements.push(&design, &values, &deviations)?;
        }
        Ok(measurements)
    }
}

impl Measurements {
    /// No experiment yet, of these responses.
    ///
    /// # Errors
    ///
    /// [`Error::Responses`] for no response, and for one without a name or with the name of another.
    pub fn new(responses: Vec<String>) -> Result<Self, Error> {
        let refuse = |name: &str, expected| Err(Error::Responses { name: name.to_owned(), expected });
        if responses.is_empty() {
            return refuse("", "at least one response");
        }
        for (index, name) in responses.iter().enumerate() {
            if name.trim().is_empty() {
                return refuse(name, "a name for every response");
            }
            if responses[..index].contains(name) {
                return refuse(name, "a name of its own for every response");
            }
        }
        Ok(Self { responses, rows: Vec::new(), n_failed: 0 })
    }

    /// One experiment: where it was made, and each response with its standard deviation, in the unit of the response.
    ///
    /// Where the noise is estimated, only the ratios of the deviations matter.
    ///
    /// # Errors
    ///
    /// [`Error::WrongCount`] for a design, values or deviations of another length than before, [`Error::Entry`] for a number that
    /// is not finite or a deviation that is not positive.
    pub fn push(&mut self, design: &[f64], values: &[f64], standard_deviations: &[f64]) -> Result<(), Error> {
        if let Some(first) = self.rows.first() {
            check_count("design", first.design.len(), design.len(), "setting of the first experiment")?;
        }
        let n_responses = self.responses.len();
        check_count("values", n_responses, values.len(), "response")?;
        check_count("standard_deviations", n_responses, standard_deviations.len(), "response")?;
        check_finite("design", design)?;
        check_finite("values", values)?;
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        check_each("standard_deviations", standard_deviations, "a positive number", is_positive)?;
        self.rows.push(Row {
            design: design.to_vec(),
            values: values.to_vec(),
            deviations: standard_deviations.to_vec(),
        });
        Ok(())
    }

    /// An experiment that gave nothing: counted, and left out.
    pub fn push_failed(&mut self) {
        self.n_failed += 1;
    }

    /// Names of the responses.
    #[must_use]
    pub fn responses(&self) -> &[String] {
        &self.responses
    }

    /// Experiments with readings.
    #[must_use]
    pub fn n_experiments(&self) -> usize {
        self.rows.len()
    }

    /// Experiments without.
    #[must_use]
    pub fn n_failed(&self) -> usize {
        self.n_failed
    }

    /// Where each experiment with readings was made, in the order of telling.
    pub(crate) fn designs(&self) -> impl Iterator<Item = &[f64]> {
        self.rows.iter().map(|row| row.design.as_slice())
    }

    /// Readings of all experiments together.
    #[must_use]
    pub fn n_readings(&self) -> usize {
        self.rows.len() * self.responses.len()
    }

    /// The experiments in an order of their own, so that the order of measuring changes not a bit of what is found.
    pub(super) fn in_order(&self) -> Vec<&Row> {
        let key = |row: &Row| [row.design.clone(), row.values.clone(), row.deviations.clone()].concat();
        let mut rows: Vec<(Vec<f64>, &Row)> = self.rows.iter().map(|row| (key(row), row)).collect();
        rows.sort_by(|(a, _), (b, _)| {
            let differing = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
            differing.unwrap_or(std::cmp::Ordering::Equal)
        });
        rows.into_iter().map(|(_, row)| row).collect()
    }
}
