//! What a run of Chapter 3 found, in numbers and in sentences made of them.

use water_channel::FlightLog;

use super::file::Setup;
use super::panels::{Design, PanelFlights};

/// Every flight of the study.
pub(crate) struct Findings<'a> {
    pub(crate) setup: &'a Setup,
    /// In the stand-in for the water channel.
    pub(crate) stand_in: Vec<PanelFlights<'a>>,
    /// In the numerical model.
    pub(crate) model: Vec<PanelFlights<'a>>,
    /// The best design of the first panel in the stand-in, sample by sample.
    pub(crate) shown: FlightLog,
    pub(crate) seconds: f64,
}

/// Whether Table 4 allows a center of mass.
pub(crate) fn is_allowed(setup: &Setup, center_of_mass: f64) -> bool {
    setup.center_of_mass.table4.is_none_or(|[lower, upper]| (lower..=upper).contains(&center_of_mass))
}

/// Whether the center of mass is one that Table 4 allows.
pub(crate) fn in_table4(setup: &Setup, design: &Design) -> bool {
    is_allowed(setup, design.at[0])
}

/// The highest cost of the stable designs within Table 4 over the lowest, panel by panel.
pub(crate) fn spans(findings: &Findings<'_>) -> Vec<f64> {
    let inside = |design: &Design| in_table4(findings.setup, design);
    findings.stand_in.iter().filter_map(|panel| Some(panel.worst(inside)?.1 / panel.best(inside)?.1)).collect()
}

/// The middle of the values, and what four fifths of them stay below and above.
pub(crate) fn spread(mut values: Vec<f64>) -> Option<[f64; 3]> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * (values.len().max(1) - 1) as f64).round() as usize).copied();
    Some([at(0.1)?, at(0.5)?, at(0.9)?])
}

/// The cost of each stable design within Table 4 relative to the same design elsewhere.
pub(crate) fn ratios(setup: &Setup, of: &PanelFlights<'_>, to: &PanelFlights<'_>) -> Vec<f64> {
    let pairs = of.designs().zip(to.designs());
    pairs
        .filter(|(a, b)| a.is_stable() && b.is_stable() && in_table4(setup, a))
        .filter_map(|(a, b)| Some(a.cost()? / b.cost()?))
        .collect()
}

/// Whether the best of the allowed designs lies where the allowed lattice ends.
pub(crate) fn is_at_an_end(setup: &Setup, design: &Design) -> bool {
    let mut x = setup.center_of_mass.places();
    x.retain(|x| is_allowed(setup, *x));
    [(x, design.at[0]), (setup.trim_pitch.places(), design.at[1])].iter().any(|(places, at)| {
        let is_end = |end: Option<&f64>| end.is_some_and(|end| (end - at).abs() < 1e-9);
        is_end(places.first()) || is_end(places.last())
    })
}

/// Where the best designs lie, and what moves them.
pub(crate) fn about_the_best(findings: &Findings<'_>) -> Vec<String> {
    let (setup, panels) = (findings.setup, &findings.stand_in);
    let inside = |design: &Design| in_table4(setup, design);
    let mut sentences = Vec::new();
    let best: Vec<&Design> = panels.iter().filter_map(|panel| Some(panel.best(inside)?.0)).collect();
    let at_an_end = best.iter().filter(|design| is_at_an_end(setup, design)).count();
    sentences.push(format!(
        "Within Table 4, {at_an_end} of the {} best designs lie at an end of the range of center of mass or trim pitch: there the \
         range decides and not the cost.",
        best.len()
    ));
    let first = &panels[0];
    if let (Some((_, low)), Some((_, high))) = (first.best(inside), first.worst(inside)) {
        sentences.push(format!(
            "In the first panel the cost varies by a factor of {:.0} over the stable designs within Table 4.",
            high / low
        ));
    }
    for panel in &panels[1..] {
        let at_best = first.best(inside).and_then(|(best, cost)| {
            let same = panel.designs().find(|design| design.at.map(f64::to_bits) == best.at.map(f64::to_bits))?;
            Some(same.cost()? / cost)
        });
        if let (Some([low, middle, high]), Some(at_best)) = (spread(ratios(setup, panel, first)), at_best) {
            sentences.push(format!(
                "{}: {middle:.2} times the cost of the same design in the first panel (median of the stable designs within Table 4; \
                 {low:.2} to {high:.2} for four fifths); {at_best:.2} times at the first panel's best design.",
                panel.configuration.label
            ));
        }
    }
    sentences
}

/// How far apart the growth rates of two panels are, at most.
pub(crate) fn growth_apart(a: &PanelFlights<'_>, b: &PanelFlights<'_>) -> Option<f64> {
    let pairs = a.designs().zip(b.designs());
    pairs
        .filter_map(|(a, b)| Some((a.growth_per_s.as_ref().ok()? - b.growth_per_s.as_ref().ok()?).abs()))
        .reduce(f64::max)
}

/// What the panels say, in sentences.
pub(crate) fn sentences(findings: &Findings<'_>) -> Vec<String> {
    let (setup, panels) = (findings.setup, &findings.stand_in);
    let inside = |design: &Design| in_table4(setup, design);
    let mut sentences = about_the_best(findings);
    for panel in &panels[1..] {
        if let Some(apart) = growth_apart(panel, &panels[0]).filter(|apart| *apart < 1e-9) {
            sentences.push(format!(
                "{}: its modes are those of the first panel (growth rates within {:.0e} 1/s). In this plant the layout decides only \
                 which way a reeled line pitches the body, so the difference in cost is the answer to the perturbation, whose times \
                 are ours, and no better or worse flight by itself.",
                panel.configuration.label,
                10.0_f64.powf(apart.max(1e-16).log10().ceil())
            ));
        }
    }
    let unstable: Vec<&Design> = panels.iter().flat_map(PanelFlights::unstable).collect();
    let model_unstable = findings.model.iter().flat_map(PanelFlights::unstable).count();
    if let Some(aft) = unstable.iter().map(|design| design.at[0]).reduce(f64::max) {
        let within = unstable.iter().filter(|design| inside(design)).count();
        sentences.push(format!(
            "{} of {} designs are unstable in the stand-in, none with the center of mass aft of {aft:.2} % chord ({within} within \
             Table 4); in the numerical model {model_unstable} are.",
            unstable.len(),
            panels.iter().flat_map(PanelFlights::designs).count()
        ));
    } else {
        sentences.push(format!("No design is unstable in the stand-in; in the numerical model {model_unstable} are."));
    }
    let terms = panels.iter().flat_map(PanelFlights::designs).filter_map(|design| design.outcome.as_ref().ok());
    if let Some([low, middle, high]) =
        spread(terms.map(|[heading, lateral]| 100.0 * lateral / (heading + lateral)).collect())
    {
        sentences.push(format!(
            "The two terms of (20) are called equally important; as weighted, the lateral position makes {middle:.1} % of the \
             cost (median; {low:.1} to {high:.1} % for four fifths): 10 deg of heading weigh as much as {:.2} m of position.",
            10.0_f64.to_radians() * (setup.weights.heading / setup.weights.lateral).sqrt()
        ));
    }
    let pairs = findings.stand_in.iter().zip(&findings.model);
    if let Some([low, middle, high]) = spread(pairs.flat_map(|(a, b)| ratios(setup, a, b)).collect()) {
        sentences.push(format!(
            "The stand-in's cost is {middle:.1} times the numerical model's at the same design (median of the stable designs within \
             Table 4; {low:.1} to {high:.1} for four fifths)."
        ));
    }
    sentences
}
