//! What a plant has to meet: optima and costs that the dissertation prints, as residuals in units of their tolerance.

use anyhow::{Context as _, Result, ensure};
use bat_dynamics::Fidelity;
use serde::Deserialize;

use super::candidate::{Candidate, Flown, STUDIES, Spot};
use crate::bat::{MODEL, STAND_IN};

/// Steps of the differences that say where the lowest cost is, in per cent of chord and degrees.
const STEPS: [f64; 2] = [0.4, 1.0];
/// The spots of an optimum: the design, and those around it.
const STENCIL: [[f64; 2]; 7] = [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0], [-1.0, -1.0], [1.0, 1.0]];
/// Curvatures below this share of the cost, per unit of tolerance, count as this much: a flat valley has its minimum anywhere.
const FLATTEST: f64 = 5e-4;
/// Beyond so many tolerances residuals count by their logarithm.
const LARGE: f64 = 4.0;
/// A design that was found to be better than an optimum has to become worse by this share.
const MARGIN: f64 = 2e-4;
/// And this share is as much as a tolerance.
const MARGIN_TOLERANCE: f64 = 1e-3;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
enum FidelityName {
    #[serde(rename = "model")]
    Model,
    #[serde(rename = "stand-in")]
    StandIn,
}

impl FidelityName {
    const fn fidelity(self) -> Fidelity {
        match self {
            Self::Model => MODEL,
            Self::StandIn => STAND_IN,
        }
    }
}

/// An `[[evidence]]` entry.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EvidenceEntry {
    label: String,
    study: String,
    fidelity: FidelityName,
    center_of_mass: f64,
    pitch_set_point: f64,
    optimum: bool,
    cost: Option<f64>,
}

/// A `[[held_out]]` entry.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeldOutEntry {
    label: String,
    study: String,
    fidelity: FidelityName,
    center_of_mass: f64,
    pitch_set_point: f64,
    cost: f64,
}

/// The `[tolerance]` entry: in per cent of chord, degrees, and a share of the cost.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tolerance {
    pub(super) center_of_mass: f64,
    pub(super) pitch_set_point: f64,
    pub(super) cost: f64,
}

/// A `[[box]]` entry.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxEntry {
    study: String,
    center_of_mass: [f64; 2],
    pitch_set_point: [f64; 2],
}

/// Bounds of center of mass and pitch set point.
pub(super) type Bounds = [[f64; 2]; 2];

#[derive(Debug, Clone)]
pub(super) struct Evidence {
    pub(super) label: String,
    pub(super) study: usize,
    pub(super) fidelity: Fidelity,
    pub(super) design: [f64; 2],
    pub(super) is_optimum: bool,
    pub(super) cost: Option<f64>,
    pub(super) bounds: Bounds,
}

fn study(name: &str) -> Result<usize> {
    let found = STUDIES.iter().position(|known| *known == name);
    found.with_context(|| format!("study = `{name}`: it must be one of {}", STUDIES.join(", ")))
}

impl Tolerance {
    pub(super) fn check(&self) -> Result<()> {
        for (name, value) in
            [("center_of_mass", self.center_of_mass), ("pitch_set_point", self.pitch_set_point), ("cost", self.cost)]
        {
            ensure!(value.is_finite() && value > 0.0, "tolerance.{name} = {value}: it must be positive");
        }
        Ok(())
    }

    /// Of the two coordinates of a design.
    pub(super) const fn of_design(&self) -> [f64; 2] {
        [self.center_of_mass, self.pitch_set_point]
    }
}

/// The box of each study.
pub(super) fn bounds(entries: &[BoxEntry]) -> Result<[Bounds; 2]> {
    let mut of_each = [None; STUDIES.len()];
    for entry in entries {
        let bounds = [entry.center_of_mass, entry.pitch_set_point];
        for ([lower, upper], name) in bounds.into_iter().zip(["center_of_mass", "pitch_set_point"]) {
            ensure!(lower.is_finite() && upper.is_finite(), "box of {}: {name} must have finite ends", entry.study);
            ensure!(
                lower < upper,
                "box of {}: {name} goes from {lower} to {upper}: the first must be lower",
                entry.study
            );
        }
        let twice = of_each[study(&entry.study)?].replace(bounds);
        ensure!(twice.is_none(), "two boxes of {}: there must be one", entry.study);
    }
    let of = |index: usize| of_each[index].with_context(|| format!("no box of {}", STUDIES[index]));
    Ok([of(0)?, of(1)?])
}

impl EvidenceEntry {
    pub(super) fn check(self, bounds: &[Bounds; 2]) -> Result<Evidence> {
        let Self { label, study: name, fidelity, center_of_mass, pitch_set_point, optimum, cost } = self;
        let study = study(&name)?;
        let design = [center_of_mass, pitch_set_point];
        let inside = design.iter().zip(bounds[study]).all(|(value, [lower, upper])| (lower..=upper).contains(value));
        ensure!(inside, "{label}: {design:?} is not in the box of {name}");
        ensure!(optimum || cost.is_some(), "{label}: evidence is an optimum, or has a cost, or both");
        ensure!(
            cost.is_none_or(|cost| cost.is_finite() && cost > 0.0),
            "{label}: cost = {}: it must be positive and finite",
            cost.unwrap_or(f64::NAN)
        );
        let (fidelity, bounds) = (fidelity.fidelity(), bounds[study]);
        Ok(Evidence { label, study, fidelity, design, is_optimum: optimum, cost, bounds })
    }
}

impl HeldOutEntry {
    pub(super) fn check(self, bounds: &[Bounds; 2]) -> Result<Evidence> {
        let Self { label, study, fidelity, center_of_mass, pitch_set_point, cost } = self;
        let cost = Some(cost);
        EvidenceEntry { label, study, fidelity, center_of_mass, pitch_set_point, optimum: false, cost }.check(bounds)
    }
}

impl Evidence {
    /// The designs that have to be flown for it.
    pub(super) fn spots(&self) -> Vec<Spot> {
        let stencil = if self.is_optimum { &STENCIL[..] } else { &STENCIL[..1] };
        let spot = |step: &[f64; 2]| {
            let design = core::array::from_fn(|k| self.design[k] + step[k] * STEPS[k]);
            Spot::new(self.fidelity, design)
        };
        stencil.iter().map(spot).collect()
    }

    /// How far it is from being met, in tolerances; `costs` are those of the spots.
    pub(super) fn residuals(&self, costs: &[f64], tolerance: &Tolerance) -> Vec<f64> {
        let mut residuals = Vec::new();
        if self.is_optimum {
            residuals.extend(self.displacement(costs, tolerance).0);
        }
        residuals.extend(self.cost.map(|cost| (costs[0] / cost - 1.0) / tolerance.cost));
        residuals
    }

    /// What it asks for and what was found, number by number; `costs` are those of the spots.
    fn rows(&self, costs: &[f64], tolerance: &Tolerance) -> Vec<Found> {
        let mut rows = Vec::new();
        if self.is_optimum {
            let (steps, _) = self.displacement(costs, tolerance);
            let design = core::array::from_fn(|k| self.design[k] + steps[k] * tolerance.of_design()[k]);
            rows.extend(self.places(design, tolerance));
        }
        rows.extend(self.cost.map(|printed| {
            let (found, allowed) = (costs[0], tolerance.cost * printed);
            Found { label: self.label.clone(), what: "cost, s", printed, found, allowed }
        }));
        rows
    }

    /// Its optimum, where the lowest cost was found at a design.
    pub(super) fn places(&self, design: [f64; 2], tolerance: &Tolerance) -> [Found; 2] {
        let names = ["center of mass, % chord", "pitch set point, deg"];
        core::array::from_fn(|k| Found {
            label: self.label.clone(),
            what: names[k],
            printed: self.design[k],
            found: design[k],
            allowed: tolerance.of_design()[k],
        })
    }

    /// From the design to the lowest cost within the bounds, as the quadratic through the spots has it, in tolerances; and what
    /// is gained on the way there, as far as a tolerance.
    fn displacement(&self, costs: &[f64], tolerance: &Tolerance) -> ([f64; 2], f64) {
        // In units of tolerance.
        let step: [f64; 2] = core::array::from_fn(|k| STEPS[k] / tolerance.of_design()[k]);
        let slope = [(costs[2] - costs[1]) / (2.0 * step[0]), (costs[4] - costs[3]) / (2.0 * step[1])];
        let second = |low: f64, high: f64, step: f64| (low - 2.0 * costs[0] + high) / (step * step);
        let (a, c) = (second(costs[1], costs[2], step[0]), second(costs[3], costs[4], step[1]));
        let around: f64 = costs[1..5].iter().sum();
        let b = (costs[5] + costs[6] + 2.0 * costs[0] - around) / (2.0 * step[0] * step[1]);
        let (a, b, c) = curved(a, b, c, FLATTEST * costs[0]);
        // A bound that is as near as a tolerance is good enough. One that is farther shows nothing of how far it is to go.
        let near = |room: f64| if room.abs() <= 1.0 { room } else { room.signum() * f64::INFINITY };
        let room = core::array::from_fn(|k| {
            self.bounds[k].map(|bound| near((bound - self.design[k]) / tolerance.of_design()[k]))
        });
        let step = lowest_within([a, b, c], slope, room);
        let [x, y] = step.map(|step| step.clamp(-1.0, 1.0));
        let gain = -(slope[0] * x + slope[1] * y + 0.5 * (a * x * x + c * y * y) + b * x * y);
        (step, gain.max(0.0))
    }
}

/// The symmetric matrix [[a, b], [b, c]] with no eigenvalue below `least`.
fn curved(a: f64, b: f64, c: f64, least: f64) -> (f64, f64, f64) {
    let (mean, half) = ((a + c) / 2.0, ((a - c) / 2.0).hypot(b));
    let [low, high] = [mean - half, mean + half].map(|value| value.max(least));
    if half == 0.0 {
        return (low, 0.0, low);
    }
    // The projections on both eigenvectors, weighted anew.
    let (cos, sin) = ((a - c) / (2.0 * half), b / half);
    let (middle, width) = ((low + high) / 2.0, (high - low) / 2.0);
    (middle + width * cos, width * sin, middle - width * cos)
}

/// The lowest point of x'Hx/2 + g'x in a box that holds the origin.
fn lowest_within([a, b, c]: [f64; 3], g: [f64; 2], room: Bounds) -> [f64; 2] {
    let value = |x: [f64; 2]| 0.5 * (a * x[0] * x[0] + c * x[1] * x[1]) + b * x[0] * x[1] + g[0] * x[0] + g[1] * x[1];
    let determinant = a * c - b * b;
    let free = [(b * g[1] - c * g[0]) / determinant, (b * g[0] - a * g[1]) / determinant];
    if free.iter().zip(room).all(|(x, [lower, upper])| (lower..=upper).contains(x)) {
        return free;
    }
    let edges = (0..2).flat_map(|end| {
        let x = [room[0][end], (-(g[1] + b * room[0][end]) / c).clamp(room[1][0], room[1][1])];
        let y = [(-(g[0] + b * room[1][end]) / a).clamp(room[0][0], room[0][1]), room[1][end]];
        [x, y].into_iter().filter(|at| at.iter().all(|x| x.is_finite()))
    });
    edges.min_by(|x, y| value(*x).total_cmp(&value(*y))).unwrap_or([0.0; 2])
}

/// A published number, and what a plant has in its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    /// Of the evidence.
    pub(super) label: String,
    pub(super) what: &'static str,
    pub(super) printed: f64,
    pub(super) found: f64,
    /// How far apart both may be.
    pub(super) allowed: f64,
}

impl Found {
    /// How far apart they are, in units of what is allowed.
    pub(super) fn tolerances(&self) -> f64 {
        (self.found - self.printed).abs() / self.allowed
    }
}

/// A design that was better than the optimum of some evidence, where it should not be.
#[derive(Debug, Clone)]
pub(super) struct Rival {
    /// Which of the evidence.
    pub(super) evidence: usize,
    pub(super) design: [f64; 2],
}

/// All that a candidate is fitted to, and the designs that this takes.
#[derive(Debug, Clone)]
pub(super) struct Aims<'a> {
    evidence: &'a [Evidence],
    tolerance: Tolerance,
    rivals: Vec<Rival>,
}

impl<'a> Aims<'a> {
    pub(super) fn new(evidence: &'a [Evidence], tolerance: Tolerance) -> Self {
        Self { evidence, tolerance, rivals: Vec::new() }
    }

    pub(super) fn add(&mut self, rival: Rival) {
        self.rivals.push(rival);
    }

    pub(super) fn spots(&self) -> Vec<Spot> {
        let rivals = self.rivals.iter().map(|rival| Spot::new(self.evidence[rival.evidence].fidelity, rival.design));
        self.evidence.iter().flat_map(Evidence::spots).chain(rivals).collect()
    }

    /// All that is asked for, row by row; `flown` belongs to the spots.
    pub(super) fn rows(&self, candidate: &Candidate, flown: &[Flown]) -> Vec<Found> {
        let mut rest = flown;
        let rows = self.evidence.iter().flat_map(|evidence| {
            let (own, others) = rest.split_at(evidence.spots().len());
            rest = others;
            let costs: Vec<f64> = own.iter().map(|flown| flown.cost(&candidate.weights[evidence.study])).collect();
            evidence.rows(&costs, &self.tolerance)
        });
        rows.collect()
    }

    /// In tolerances; `flown` belongs to the spots.
    pub(super) fn residuals(&self, candidate: &Candidate, flown: &[Flown]) -> Vec<f64> {
        let mut residuals = Vec::new();
        let mut rest = flown;
        let mut at_optima = Vec::new();
        for evidence in self.evidence {
            let (own, others) = rest.split_at(evidence.spots().len());
            rest = others;
            let weights = &candidate.weights[evidence.study];
            let costs: Vec<f64> = own.iter().map(|flown| flown.cost(weights)).collect();
            residuals.extend(evidence.residuals(&costs, &self.tolerance));
            let gain = if evidence.is_optimum { evidence.displacement(&costs, &self.tolerance).1 } else { 0.0 };
            at_optima.push(costs[0] - gain);
        }
        for (rival, flown) in self.rivals.iter().zip(rest) {
            let cost = flown.cost(&candidate.weights[self.evidence[rival.evidence].study]);
            let lead = (1.0 + MARGIN) - cost / at_optima[rival.evidence];
            residuals.push(lead.max(0.0) / MARGIN_TOLERANCE);
        }
        residuals.into_iter().map(eased).collect()
    }
}

/// Small residuals as they are, large ones by their order of magnitude: far away nothing is linear.
fn eased(residual: f64) -> f64 {
    LARGE * (residual / LARGE).asinh()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(bounds: Bounds) -> Evidence {
        Evidence {
            label: "an optimum".to_owned(),
            study: 0,
            fidelity: MODEL,
            design: [48.0, 10.0],
            is_optimum: true,
            cost: None,
            bounds,
        }
    }

    const TOLERANCE: Tolerance = Tolerance { center_of_mass: 0.3, pitch_set_point: 1.0, cost: 0.02 };

    fn found(bounds: Bounds, cost: impl Fn(f64, f64) -> f64) -> [f64; 2] {
        let evidence = evidence(bounds);
        let costs: Vec<f64> =
            evidence.spots().iter().map(|spot| cost(spot.design[0] - 48.0, spot.design[1] - 10.0)).collect();
        let ([x, y], _) = evidence.displacement(&costs, &TOLERANCE);
        [x * 0.3, y]
    }

    /// Differences of a quadratic are exact: the lowest point by hand.
    #[test]
    fn quadratic_is_followed_to_its_lowest_point() {
        let wide = [[40.0, 60.0], [0.0, 30.0]];
        // Gradient [2 x + y - 1, 2 y + x - 5] vanishes at x = -1, y = 3.
        let [x, y] = found(wide, |x, y| 50.0 + x * x + y * y + x * y - x - 5.0 * y);
        assert!((x + 1.0).abs() < 1e-9 && (y - 3.0).abs() < 1e-9, "{x} {y}");
        // With y at most 1 the lowest x is 0; a bound that is far away shows nothing.
        let [x, y] = found([[40.0, 60.0], [0.0, 12.0]], |x, y| 50.0 + x * x + y * y + x * y - x - 5.0 * y);
        assert!((x + 1.0).abs() < 1e-9 && (y - 3.0).abs() < 1e-9, "{x} {y}");
        let [x, y] = found([[40.0, 60.0], [0.0, 11.0]], |x, y| 50.0 + x * x + y * y + x * y - x - 5.0 * y);
        assert!(x.abs() < 1e-9 && (y - 1.0).abs() < 1e-9, "{x} {y}");
    }

    /// The rows of evidence are its residuals, in the units of what is printed.
    #[test]
    fn rows_say_what_the_residuals_say() {
        let evidence = Evidence { cost: Some(52.0), ..evidence([[40.0, 60.0], [0.0, 30.0]]) };
        let cost = |x: f64, y: f64| 50.0 + x * x + y * y + x * y - x - 5.0 * y;
        let spots = evidence.spots();
        let costs: Vec<f64> = spots.iter().map(|spot| cost(spot.design[0] - 48.0, spot.design[1] - 10.0)).collect();
        let rows = evidence.rows(&costs, &TOLERANCE);
        let residuals = evidence.residuals(&costs, &TOLERANCE);
        assert_eq!((rows.len(), residuals.len()), (3, 3));
        for (row, residual) in rows.iter().zip(residuals) {
            assert!((row.tolerances() - residual.abs()).abs() < 1e-9, "{row:?} {residual}");
        }
        // The lowest point by hand.
        assert!((rows[0].found - 47.0).abs() < 1e-9 && (rows[1].found - 13.0).abs() < 1e-9, "{rows:?}");
    }

    /// A saddle has no lowest point: it is looked for downhill, and at the bound.
    #[test]
    fn saddle_leads_to_the_bound() {
        let [x, y] = found([[40.0, 60.0], [9.0, 11.0]], |x, y| 50.0 + x * x - y * y - 0.5 * y);
        assert!(x.abs() < 1e-9 && (y - 1.0).abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn curvature_is_raised_in_its_own_direction_only() {
        // Eigenvalues 3 and -1 along the diagonals.
        let (a, b, c) = curved(1.0, 2.0, 1.0, 0.5);
        assert!((a - 1.75).abs() < 1e-12 && (b - 1.25).abs() < 1e-12 && (c - 1.75).abs() < 1e-12, "{a} {b} {c}");
        let (a, b, c) = curved(4.0, 0.5, 2.0, 0.1);
        assert!((a - 4.0).abs() < 1e-12 && (b - 0.5).abs() < 1e-12 && (c - 2.0).abs() < 1e-12, "{a} {b} {c}");
    }
}
