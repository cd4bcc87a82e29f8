//! The rows of a table of simulations, by design.

use anyhow::{Context as _, Result, bail};
use design_space::{Cell, Grid, Parameter};

use crate::journal::Constrained;
use crate::number::{plain, with_unit};
use crate::problem::Problem;
use crate::sheet::{Fault, Row, Table, none_of, point_columns};

/// What a table says, one entry per design, in the order of the cells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rows {
    cells: Vec<Cell>,
    values: Vec<f64>,
    /// One after the other for each design; not a number where the table has none.
    constrained: Vec<f64>,
    n_constraints: usize,
}

/// What a table says of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Simulated<'a> {
    pub(crate) value: f64,
    constrained: &'a [f64],
}

impl Simulated<'_> {
    /// One per constraint; not a number where the table has none.
    pub(super) const fn numbers(&self) -> &[f64] {
        self.constrained
    }

    /// One per constraint, if the table has a number for it.
    pub(crate) fn constrained(&self) -> Vec<Option<f64>> {
        self.constrained.iter().map(|&value| (!value.is_nan()).then_some(value)).collect()
    }

    pub(super) fn named(&self, problem: &Problem) -> Constrained {
        let pairs = problem.constraints.iter().zip(self.constrained());
        pairs.filter_map(|(held, value)| Some((held.name().to_owned(), value?))).collect()
    }
}

impl Rows {
    /// Each design once, and the rows that say something else than an earlier one of the same design.
    fn sorted(mut found: Vec<Found>, n_constraints: usize) -> (Self, Vec<usize>) {
        // A table in the order of the cells, as most are, is sorted at a glance.
        found.sort_by_key(|one| (one.cell, one.row));
        let (mut rows, mut contradicting) = (Self::none(n_constraints), Vec::new());
        for one in found {
            if rows.cells.last() != Some(&one.cell) {
                rows.push(one.cell, one.value, &one.constrained);
            } else if !rows.last_says(&one) {
                contradicting.push(one.row);
            }
        }
        (rows, contradicting)
    }

    /// What the simulation says of each design.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn push(&mut self, cell: Cell, value: f64, constrained: &[f64]) {
        self.cells.push(cell);
        self.values.push(value);
        self.constrained.extend_from_slice(constrained);
    }

    fn last_says(&self, found: &Found) -> bool {
        let constrained = &self.constrained[self.constrained.len() - self.n_constraints..];
        let same = |(a, b): (&f64, &f64)| {
            a.partial_cmp(b).is_some_and(std::cmp::Ordering::is_eq) || (a.is_nan() && b.is_nan())
        };
        self.values.last() == Some(&found.value) && constrained.iter().zip(&found.constrained).all(same)
    }

    /// Without a row yet.
    pub(crate) fn none(n_constraints: usize) -> Self {
        Self { cells: Vec::new(), values: Vec::new(), constrained: Vec::new(), n_constraints }
    }

    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    pub(super) fn n_constraints(&self) -> usize {
        self.n_constraints
    }

    pub(crate) fn get(&self, cell: Cell) -> Option<Simulated<'_>> {
        // In a table of all designs each stands at its own place.
        let own = usize::try_from(cell.index()).ok().filter(|&at| self.cells.get(at) == Some(&cell));
        self.at(own.or_else(|| self.cells.binary_search(&cell).ok())?)
    }

    fn at(&self, place: usize) -> Option<Simulated<'_>> {
        let constrained = &self.constrained[place * self.n_constraints..(place + 1) * self.n_constraints];
        Some(Simulated { value: *self.values.get(place)?, constrained })
    }

    /// In the order of the cells.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (Cell, Simulated<'_>)> {
        (0..self.len()).filter_map(|place| Some((self.cells[place], self.at(place)?)))
    }
}

/// A row without fault.
struct Found {
    row: usize,
    cell: Cell,
    value: f64,
    constrained: Vec<f64>,
}

/// The rows of the table with this name.
pub(super) fn read(bytes: &[u8], name: &str, problem: &Problem, grid: &Grid) -> Result<Rows> {
    let parameters = problem.region.parameters();
    let k = parameters.len();
    let table = Table::parse(bytes, &point_columns(problem)).with_context(|| name.to_owned())?;
    let (mut found, mut faults) = (Vec::with_capacity(table.rows().len()), Vec::new());
    for (index, row) in table.rows().iter().enumerate() {
        let mut point = Vec::with_capacity(k);
        for (column, parameter) in parameters.iter().enumerate() {
            match setting(&table, row, column, parameter) {
                Ok(level) => point.push(level),
                Err(fault) => faults.push(fault),
            }
        }
        let constrained = (0..problem.constraints.len()).map(|index| {
            let column = k + 1 + index;
            if table.cell(row, column).is_empty() {
                return f64::NAN;
            }
            table.number(row, column).unwrap_or_else(|expected| {
                faults.push(table.fault(row, column, expected));
                f64::NAN
            })
        });
        let constrained: Vec<f64> = constrained.collect();
        match table.number(row, k) {
            Err(expected) => faults.push(table.fault(row, k, expected)),
            Ok(value) if let Some(expected) = problem.response.without_logarithm(value) => {
                faults.push(table.fault(row, k, expected));
            }
            Ok(value) if point.len() == k => {
                found.push(Found { row: index, cell: grid.nearest(&point)?, value, constrained });
            }
            Ok(_) => {}
        }
    }
    let (rows, contradicting) = Rows::sorted(found, problem.constraints.len());
    let contradicts = |row: &Row| table.fault(row, k, "the value that an earlier row has for the same settings");
    faults.extend(contradicting.into_iter().filter_map(|row| table.rows().get(row)).map(contradicts));
    faults.sort_by_key(|fault| fault.row);
    none_of(name, &faults)?;
    if rows.len() == 0 {
        bail!("{name}: no rows, expected one per simulated point");
    }
    Ok(rows)
}

/// The level that a cell names.
fn setting(table: &Table, row: &Row, column: usize, parameter: &Parameter) -> Result<f64, Fault> {
    let value = table.setting(row, column, parameter).map_err(|expected| table.fault(row, column, expected))?;
    match parameter.snap(value) {
        Ok(level) if (level - value).abs() <= 1e-6 * parameter.width() => Ok(level),
        Ok(level) => {
            let level = with_unit(&plain(level), parameter.unit());
            let expected = format!("a level of the parameter, the nearest is {level}");
            Err(table.fault(row, column, expected))
        }
        Err(error) => Err(table.fault(row, column, error.to_string())),
    }
}
