//! The tables of Chapter 3.

use super::findings::{Findings, in_table4};
use super::panels::PanelFlights;
use page::{Column, Table};

pub(crate) fn best_table(findings: &Findings<'_>, panels: &[PanelFlights<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("configuration", ""),
        Column::new("center of mass", "% chord"),
        Column::new("trim pitch", "deg"),
        Column::new("cost", "s"),
        Column::new("heading", "%"),
        Column::new("lateral", "%"),
        Column::new("growth", "1/s"),
        Column::new("whole lattice", ""),
    ]);
    for panel in panels {
        let whole = panel.best(|_| true).map_or("none".to_owned(), |(design, cost)| {
            format!("{:.2} % chord, {:.0} deg: {cost:.4} s", design.at[0], design.at[1])
        });
        let mut row = vec![panel.configuration.label.clone()];
        row.extend(match panel.best(|design| in_table4(findings.setup, design)) {
            None => vec!["none".to_owned(); 6],
            Some((design, cost)) => {
                let terms = design.outcome.clone().unwrap_or([f64::NAN; 2]);
                vec![
                    format!("{:.2}", design.at[0]),
                    format!("{:.0}", design.at[1]),
                    format!("{cost:.4}"),
                    format!("{:.1}", 100.0 * terms[0] / cost),
                    format!("{:.1}", 100.0 * terms[1] / cost),
                    design.growth_per_s.as_ref().map_or("–".to_owned(), |growth| format!("{growth:.2}")),
                ]
            }
        });
        row.push(whole);
        table.push(row);
    }
    table
}

pub(crate) fn count_table(panels: &[PanelFlights<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::new("configuration", ""),
        Column::new("designs", "1"),
        Column::new("slack line", "1"),
        Column::new("left the model, or no trim", "1"),
        Column::new("no equilibrium at some speed", "1"),
        Column::new("unstable", "1"),
        Column::new("of these without a cost", "1"),
        Column::new("unstable up to", "% chord"),
    ]);
    for panel in panels {
        let furthest = panel.unstable().map(|design| design.at[0]).reduce(f64::max);
        table.push(vec![
            panel.configuration.label.clone(),
            panel.designs().count().to_string(),
            panel.slack().to_string(),
            panel.other_failures().to_string(),
            panel.without_equilibrium().to_string(),
            panel.unstable().count().to_string(),
            panel.unstable().filter(|design| design.cost().is_none()).count().to_string(),
            furthest.map_or("–".to_owned(), |x| format!("{x:.2}")),
        ]);
    }
    table
}
