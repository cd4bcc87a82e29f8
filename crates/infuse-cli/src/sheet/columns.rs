//! The columns of a sheet, and of any table of points.

use super::table::Column;
use crate::problem::Problem;

/// A column per parameter, and one for the response: what a table of points has.
pub(crate) fn point_columns(problem: &Problem) -> Vec<Column> {
    let (parameters, response) = (problem.region.parameters(), &problem.response);
    let mut columns: Vec<Column> = parameters.iter().map(|p| Column::required(p.name(), p.unit())).collect();
    columns.push(Column::required(&response.name, &response.unit));
    columns.extend(problem.constraints.iter().map(|held| Column::optional(held.name(), &held.unit)));
    columns
}

/// The columns of a sheet, in order.
pub(crate) struct Columns {
    pub(crate) all: Vec<Column>,
    n_parameters: usize,
    n_constraints: usize,
}

impl Columns {
    pub(crate) const RUN: usize = 0;
    pub(crate) const ID: usize = 1;
    pub(crate) const REPEATS: usize = 2;

    pub(crate) fn of(problem: &Problem) -> Self {
        let parameters = problem.region.parameters();
        let response = &problem.response;
        let mut all = vec![Column::optional("run", ""), Column::required("id", ""), Column::optional("repeats", "")];
        all.extend(parameters.iter().map(|parameter| Column::optional(parameter.name(), parameter.unit())));
        all.push(Column::required(&response.name, &response.unit));
        all.extend(problem.constraints.iter().map(|held| Column::optional(held.name(), &held.unit)));
        all.push(Column::optional("failed", ""));
        let actual = |parameter: &design_space::Parameter| {
            Column::optional(&format!("actual {}", parameter.name()), parameter.unit())
        };
        all.extend(parameters.iter().map(actual));
        all.push(Column::optional("note", ""));
        Self { all, n_parameters: parameters.len(), n_constraints: problem.constraints.len() }
    }

    pub(crate) fn setting(&self, parameter: usize) -> usize {
        3 + parameter
    }

    pub(crate) fn response(&self) -> usize {
        3 + self.n_parameters
    }

    /// Of a response that has to stay within bounds.
    pub(crate) fn constrained(&self, constraint: usize) -> usize {
        4 + self.n_parameters + constraint
    }

    pub(crate) fn failed(&self) -> usize {
        4 + self.n_parameters + self.n_constraints
    }

    pub(crate) fn actual(&self, parameter: usize) -> usize {
        5 + self.n_parameters + self.n_constraints + parameter
    }

    pub(crate) fn note(&self) -> usize {
        5 + 2 * self.n_parameters + self.n_constraints
    }
}
