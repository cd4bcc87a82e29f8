//! The efficiencies, terms and runs of an evaluated design.

use super::evaluation::{Coefficient, Efficiency, Evaluation, Precision};
use page::{Column, Table};

pub(super) fn efficiencies(precision: &Precision) -> Table {
    let columns = [("criterion", ""), ("value", "1"), ("efficiency", "%"), ("over", "")];
    let mut table = Table::new(columns.map(|(name, unit)| Column::new(name, unit)).to_vec());
    for Efficiency { criterion, value, percent, over } in &precision.efficiencies {
        let over = over.clone().unwrap_or_default();
        table.push(vec![criterion.clone(), format!("{value:.5}"), format!("{percent:.2}"), over]);
    }
    table
}

pub(super) fn coefficients(precision: &Precision) -> Table {
    let columns = [("number", "1"), ("term", ""), ("standard error", "1"), ("variance inflation", "1")];
    let mut table = Table::new(columns.map(|(name, unit)| Column::new(name, unit)).to_vec());
    let mut last = 0;
    for Coefficient { term, standard_error, variance_inflation } in &precision.coefficients {
        let mut cells = ["-".to_owned(), "-".to_owned()];
        if let Some(value) = variance_inflation {
            last += 1;
            cells = [last.to_string(), format!("{value:.4}")];
        }
        let [number, inflation] = cells;
        table.push(vec![number, term.clone(), format!("{standard_error:.4}"), inflation]);
    }
    table
}

pub(super) fn runs(evaluation: &Evaluation) -> Table {
    let mut columns = vec![Column::new("run", "1")];
    columns.extend(evaluation.parameters.iter().map(|parameter| Column::new(&parameter.name, parameter.unit())));
    columns.extend(evaluation.precision.iter().map(|_| Column::new("leverage", "1")));
    let mut table = Table::new(columns);
    for (index, run) in evaluation.runs.iter().enumerate() {
        let mut row = vec![(index + 1).to_string()];
        row.extend(evaluation.parameters.iter().zip(run).map(|(parameter, x)| parameter.text(*x)));
        row.extend(evaluation.precision.iter().map(|precision| format!("{:.4}", precision.leverages[index])));
        table.push(row);
    }
    table
}
