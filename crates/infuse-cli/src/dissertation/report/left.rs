//! What is left of the design space, and why the rest is not.

use anyhow::Result;

use crate::dissertation::campaign::Campaign;
use crate::dissertation::findings::{dropped_by, how_many, ranges};
use crate::number::setting;
use crate::problem::{heading, step};
use page::{Column, Finding, Page, Table};

pub(super) fn write(page: &mut Page, campaign: &Campaign) -> Result<()> {
    page.section("left", "What is left");
    let retained = campaign.now.retained();
    let (n, of) = (retained.n_retained(), retained.n_cells());
    page.finding(&how_many(campaign));
    let best = campaign.now.reports().last().map(|report| &report.screening.optimum);
    let parameters = campaign.problem.region.parameters().iter();
    let rows = parameters.zip(ranges(campaign, retained)?).enumerate().map(|(index, (parameter, (least, most)))| {
        let text = |value: f64| setting(value, step(parameter));
        let ends = |from: f64, to: f64| format!("{} to {}", text(from), text(to));
        let best = best.map_or_else(|| "–".to_owned(), |best| text(best[index]));
        vec![
            heading(parameter.name(), parameter.unit()),
            ends(parameter.lower(), parameter.upper()),
            ends(least, most),
            best,
        ]
    });
    let not_all = if n < of { " Not every combination within these ranges need be left." } else { "" };
    let table = Table {
        columns: vec![
            Column::words("parameter"),
            Column::number("bounds", ""),
            Column::number("left", ""),
            Column::number("best", ""),
        ],
        rows: rows.collect(),
    };
    page.table(&table, &format!("Least and largest setting among the designs left.{not_all}"));
    let reports = campaign.now.reports();
    if !reports.is_empty() {
        let why = Finding::new("Why the rest was dropped:");
        let dropped = reports.iter().map(|report| dropped_by(campaign, report));
        page.finding(&dropped.fold(why, Finding::detail));
        page.paragraph(
            "S is how far experiments that the surface had not seen were missed. The difference of two designs, both of them \
             predicted, may be missed by 1.414 times as much. `infuse status --why` tells the numbers of any one design.",
        );
    }
    Ok(())
}
