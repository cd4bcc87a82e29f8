//! How often the response at the recommended design is within the band that is given for it.

use infuse::pooled::reported::NINE_IN_TEN;
use page::{Column, Finding, Table, quantile};

use super::families::{FAMILIES, Family};
use super::results::{Results, Row};
use super::summary::{percent, rows_of};
use super::task::{BATCHES, fresh_families};

/// The campaigns of one kind, in words, and their families.
pub(super) struct Kind<'a> {
    pub(super) words: &'static str,
    pub(super) results: &'a Results,
    families: Vec<&'static Family>,
}

impl<'a> Kind<'a> {
    pub(super) fn of_all(words: &'static str, results: &'a Results) -> Self {
        Self { words, results, families: FAMILIES.iter().collect() }
    }

    pub(super) fn misled(words: &'static str, results: &'a Results) -> Self {
        Self { words, results, families: fresh_families().collect() }
    }
}

/// Bands of some campaigns.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bands {
    campaigns: usize,
    /// Campaigns in which the truth is beyond.
    missed: usize,
    /// Median of half their widths.
    half: f64,
}

impl Bands {
    /// None if no campaign says what it expects.
    fn of(rows: &[&Row]) -> Option<Self> {
        let bands = rows.iter().filter_map(|row| Some((row.off?, NINE_IN_TEN * row.deviation?)));
        let bands: Vec<(f64, f64)> = bands.collect();
        let missed = bands.iter().filter(|(off, half)| off.abs() > *half).count();
        let half = quantile(&bands.iter().map(|(_, half)| *half).collect::<Vec<_>>(), 0.5)?;
        Some(Self { campaigns: bands.len(), missed, half })
    }

    fn held(self) -> String {
        format!("{:.0}", 100.0 * (1.0 - self.missed as f64 / self.campaigns.max(1) as f64))
    }
}

fn after(kind: &Kind<'_>, batch: usize) -> Option<Bands> {
    let rows: Vec<&Row> = kind.families.iter().flat_map(|family| rows_of(kind.results, family, batch)).collect();
    Bands::of(&rows)
}

/// How often they held, batch by batch, for each kind of campaign.
pub(super) fn finding(kinds: &[Kind<'_>]) -> Finding {
    let head = "How often the response at the recommended design is within the band of 90 % that is given for it, after batches 1 to 5:";
    let detail = |kind: &Kind<'_>| {
        let each: Option<Vec<String>> = (1..=BATCHES).map(|batch| after(kind, batch).map(Bands::held)).collect();
        each.map(|each| Finding::new(format!("{}: {} %.", kind.words, each.join(", "))))
    };
    kinds.iter().filter_map(detail).fold(Finding::new(head), Finding::detail)
}

/// The same family by family, with half the width of the band.
pub(super) fn table(kind: &Kind<'_>) -> Table {
    let after_each = (1..=BATCHES).map(|batch| Column::words(&format!("batch {batch}")));
    let mut table = Table::new(std::iter::once(Column::words("family")).chain(after_each).collect());
    for family in &kind.families {
        let cell = |batch: usize| {
            let bands = Bands::of(&rows_of(kind.results, family, batch))?;
            Some(format!("{} of {}, ± {}", bands.missed, bands.campaigns, percent(bands.half)))
        };
        let cells: Option<Vec<String>> = (1..=BATCHES).map(cell).collect();
        if let Some(cells) = cells {
            table.push(std::iter::once(family.name.to_owned()).chain(cells).collect());
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: of three campaigns one is 1.7 deviations off; one more says nothing.
    #[test]
    fn bands_are_missed_beyond_1_645_deviations() {
        let row = |off: f64, deviation: Option<f64>| Row { off: Some(off), deviation, ..Row::default() };
        let rows = [row(0.17, Some(0.1)), row(-0.16, Some(0.1)), row(0.0, Some(0.3)), row(9.0, None)];
        let found = Bands::of(&rows.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!((found.campaigns, found.missed, found.held().as_str()), (3, 1, "67"));
        assert!((found.half - 0.1645).abs() < 1e-12, "{found:?}");
        assert_eq!(Bands::of(&[]), None);
    }
}
