//! The table of every number with where it comes from.

use page::{Column, Table};
use water_channel::{Provenance, Record};

/// Every number of the plant, the controller, the test and the cost, with where it comes from.
pub(crate) fn provenance_table(records: &[Record]) -> Table {
    let mut table = Table::new(vec![
        Column::new("Key", ""),
        Column::new("Value", "1"),
        Column::new("Unit", ""),
        Column::new("Provenance", ""),
        Column::new("Source", ""),
    ]);
    for record in records {
        table.push(vec![
            record.key.clone(),
            record.value.to_string(),
            record.unit.clone(),
            word(record.provenance).to_owned(),
            record.source.clone(),
        ]);
    }
    table
}

/// Where a number comes from, in a word.
pub(crate) fn word(provenance: Provenance) -> &'static str {
    match provenance {
        Provenance::Given => "given",
        Provenance::Derived => "derived",
        Provenance::Estimated => "estimated",
        Provenance::Calibrated => "calibrated",
    }
}
