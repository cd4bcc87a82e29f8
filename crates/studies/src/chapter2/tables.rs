//! The tables of Chapter 2.

use anyhow::Result;
use scaling::Verdict;

use super::file::Analysis;
use super::findings::{Findings, magnitude, power_of_length, significant};
use super::models::Departures;
use page::{Column, Table};

/// The groups that come out, beside the listed ones.
pub(crate) fn groups(analysis: &Analysis, listed: &str) -> Table {
    let mut table =
        Table::new(vec![Column::new("variable", ""), Column::new("computed group", ""), Column::new(listed, "")]);
    let own = |group: &scaling::Group| {
        let others = group.factors().map(|(name, _)| name.to_owned());
        others.filter(|name| !analysis.groups.repeating().contains(name)).collect::<Vec<_>>()
    };
    for group in &analysis.groups {
        let listed = analysis.listed.iter().filter(|listed| own(listed) == own(group)).map(ToString::to_string);
        table.push(vec![own(group).join(", "), group.to_string(), listed.collect::<Vec<_>>().join(", ")]);
    }
    table
}

/// Every group that Table 2 determines, at every model.
pub(crate) fn similarity(findings: &Findings<'_>) -> Table {
    let mut columns = vec![Column::new("group", "")];
    columns.extend(findings.similarity.set_ups().iter().map(|set_up| Column::new(set_up.name(), "1")));
    columns.extend([Column::new("spread", "%"), Column::new("open by rounding", "%"), Column::new("verdict", "")]);
    let mut table = Table::new(columns);
    for row in findings.similarity.rows() {
        let mut cells = vec![row.group.to_string()];
        cells.extend(row.values.iter().map(|value| significant(*value, 4)));
        cells.push(format!("{:.2}", 100.0 * row.spread));
        cells.push(format!("{:.2}", 100.0 * row.rounding));
        cells.push(
            match row.verdict {
                Verdict::Match => "matches",
                Verdict::Rounding => "matches within rounding",
                Verdict::Mismatch => "DOES NOT MATCH",
            }
            .to_owned(),
        );
        table.push(cells);
    }
    table
}

/// Table 2 as printed beside what the scale factor asks for.
pub(crate) fn table_2(findings: &Findings<'_>) -> Result<Table> {
    let setup = findings.setup;
    let mut columns = vec![Column::new("variable", "")];
    columns.extend(setup.file.model.iter().map(|model| Column::new(&model.name, "1")));
    let mut table = Table::new(columns);
    let reference = &setup.file.model[setup.reference];
    type Of = fn(&super::file::Model) -> &String;
    let rows: [(&str, &str, Of, i32); 5] = [
        ("time scale a", "time_scale", |m| &m.time_scale, 2),
        ("L_c (cm)", "chord_cm", |m| &m.chord_cm, 3),
        ("L_t (cm)", "tether_cm", |m| &m.tether_cm, 2),
        ("M_a (g)", "mass_g", |m| &m.mass_g, 1),
        ("V (cm/s)", "speed_cm_s", |m| &m.speed_cm_s, 2),
    ];
    for (name, key, of, decimals) in rows {
        let mut cells = vec![format!("{name}: printed / by X_s")];
        for model in &setup.file.model {
            let law = setup.law_to(model)?;
            let factor = match key {
                "time_scale" => law.factor(&"T^-1".parse()?)?,
                "chord_cm" => law.rule("L_c")?.factor,
                "tether_cm" => law.rule("L_t")?.factor,
                "mass_g" => law.rule("M_a")?.factor,
                _ => law.rule("V")?.factor,
            };
            let required = factor.to_f64() * reference.number(key, of(reference))?;
            cells.push(format!("{} / {required:.*}", of(model), decimals as usize));
        }
        table.push(cells);
    }
    Ok(table)
}

/// The masses that would match.
pub(crate) fn remedies(findings: &Findings<'_>) -> Table {
    let mut columns = vec![Column::new("mass of each model", "")];
    columns.extend(findings.setup.file.model.iter().map(|model| Column::new(&model.name, "g")));
    let mut table = Table::new(columns);
    let mut row = |name: &str, of: &dyn Fn(&scaling::Remedy) -> f64, remedies: &scaling::Remedies| {
        let mut cells = vec![name.to_owned()];
        cells.extend(remedies.values.iter().map(|remedy| format!("{:.1}", 1000.0 * of(remedy))));
        table.push(cells);
    };
    let [by_tether, by_chord] = &findings.remedies;
    row("printed", &|remedy| remedy.present, by_tether);
    row("that matches, by the printed L_t", &|remedy| remedy.required, by_tether);
    row("that matches, by the chord (X_s)", &|remedy| remedy.required, by_chord);
    table
}

/// How every variable scales, and what the dissertation says of it.
pub(crate) fn laws(findings: &Findings<'_>) -> Result<Table> {
    let setup = findings.setup;
    let law = setup.full_scale_law()?;
    let mut table = Table::new(vec![
        Column::new("law", ""),
        Column::new("full scale / laboratory", "1"),
        Column::new("power of length", "1"),
        Column::new("stated in the dissertation", ""),
    ]);
    for rule in law.rules() {
        let power = power_of_length(&rule);
        let mut stated = Vec::new();
        for statement in setup.file.stated.iter().filter(|stated| stated.variable == rule.quantity) {
            let verdict = if statement.power()? == power { "agrees" } else { "DIFFERS" };
            stated.push(format!("{} ({}): {verdict}", statement.power()?, statement.place));
        }
        table.push(vec![
            rule.to_string(),
            significant(rule.factor.to_f64(), 6),
            power.to_string(),
            if stated.is_empty() { "–".to_owned() } else { stated.join("; ") },
        ]);
    }
    Ok(table)
}

/// Chord, speed and viscosity at every scale.
pub(crate) fn reynolds(findings: &Findings<'_>) -> Result<Table> {
    let mut table = Table::new(vec![Column::new("set-up", ""), Column::new("Reynolds number of the chord", "1")]);
    for (name, number) in findings.setup.reynolds()? {
        table.push(vec![name, format!("{number:.0}")]);
    }
    Ok(table)
}

/// How far the models' curves are apart.
pub(crate) fn collapse(findings: &Findings<'_>) -> Table {
    let mut columns = vec![
        Column::new("flights", ""),
        Column::new("heading against t", "%"),
        Column::new("heading against a t", "%"),
        Column::new("y against t", "%"),
        Column::new("y / L_t against a t", "%"),
    ];
    columns.extend(findings.setup.file.model.iter().map(|model| Column::new(&format!("period, {}", model.name), "s")));
    columns.push(Column::new("spread of a × period", "%"));
    let mut table = Table::new(columns);
    let per_cent = |share: f64| if share < 1e-6 { magnitude(100.0 * share) } else { format!("{:.1}", 100.0 * share) };
    for releases in &findings.releases {
        let (Departures { heading, lateral }, normalized) = (releases.apart(), releases.apart_when_normalized());
        let mut cells = vec![releases.case.words().to_owned()];
        cells.extend([heading, normalized.heading, lateral, normalized.lateral].map(per_cent));
        cells.extend(releases.models.iter().map(|model| format!("{:.2}", model.period_s)));
        cells.push(per_cent(spread(releases.models.iter().map(|model| model.time_scale * model.period_s))));
        table.push(cells);
    }
    table
}

/// The largest value over the smallest, less one.
pub(crate) fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (least, most) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
    most / least - 1.0
}

/// Every number of the rig at both scales.
pub(crate) fn full_scale(findings: &Findings<'_>) -> Table {
    let mut table = Table::new(vec![
        Column::new("key", ""),
        Column::new("unit", ""),
        Column::new("laboratory", "1"),
        Column::new("full scale", "1"),
        Column::new("ratio", ""),
    ]);
    for number in &findings.full_scale.rig().converted {
        table.push(vec![
            number.path.clone(),
            number.unit.clone(),
            number.old.to_string(),
            number.new.to_string(),
            number.factor.to_string(),
        ]);
    }
    table
}

/// The test flown at both scales.
pub(crate) fn both_scales(findings: &Findings<'_>) -> Table {
    let mut table = Table::new(vec![
        Column::new("physics", ""),
        Column::new("duration: laboratory / full scale", "s"),
        Column::new("cost (21): laboratory / full scale", "s"),
        Column::new("largest difference in dimensionless form", "1"),
        Column::new("in", ""),
        Column::new("of the cost", "1"),
    ]);
    for flight in &findings.full_scale.flights {
        table.push(vec![
            flight.physics.to_owned(),
            format!("{:.0} / {:.0}", flight.duration_s[0], flight.duration_s[1]),
            format!("{:.4} / {:.3}", flight.cost_s[0], flight.cost_s[1]),
            magnitude(flight.largest_difference),
            flight.largest_difference_in.clone(),
            magnitude(flight.cost_difference),
        ]);
    }
    table
}
