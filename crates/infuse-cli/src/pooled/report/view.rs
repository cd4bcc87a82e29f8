//! What the page draws: every run, and what the surface says of all designs that appear, asked of it at once.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use design_space::{Cell, Parameter};
use infuse::pooled::{Assessment, Expectation};
use page::Axis;

use crate::journal::Measured;
use crate::pooled::bands::NINE_IN_TEN;
use crate::pooled::campaign::{Access, Campaign, Origin};
use crate::pooled::failures::settings_that_failed;
use crate::problem::{Held, Response};
use crate::report::axes;
use crate::report::maps::{Maps, Plane, Thinned, axis_of, thinned};

/// What a caption says where results stand beside what is expected of them, and batches are off.
pub(super) const AS_READ: &str = " What was measured is drawn, or written, as it was read, with what its batch or source is off by; what is \
                                  expected is the mean over batches and sources.";
/// Levels at which a curve is evaluated, at most.
const MOST_LEVELS: usize = 121;

#[derive(Debug)]
pub(super) struct View<'a> {
    pub(super) campaign: &'a Campaign,
    pub(super) found: Assessment,
    pub(super) access: Access,
    /// Readings, in the order of the loop.
    pub(super) runs: Vec<Run>,
    /// Settings of runs without a value.
    pub(super) failed: Vec<Vec<f64>>,
    /// What the simulation says, as it would be measured.
    pub(super) simulated: BTreeMap<Cell, f64>,
    /// The designs along each parameter.
    pub(super) lines: Vec<Vec<Cell>>,
    /// Over each pair of parameters.
    pub(super) planes: Vec<Plane>,
    expected: BTreeMap<Cell, Expectation>,
}

/// An experiment that gave a value.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) origin: Origin,
    /// As they were made, natural.
    pub(super) settings: Vec<f64>,
    /// The design next to them.
    pub(super) cell: Cell,
    /// As measured.
    pub(super) value: f64,
}

/// What is expected of a design, as it would be measured, and the ends of the band of 90 %.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    pub(super) mean: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Probability that a run gives a value.
    pub(super) feasible: f64,
}

impl<'a> View<'a> {
    /// None before the first value.
    pub(super) fn of(campaign: &'a Campaign) -> Result<Option<Self>> {
        let Some(found) = campaign.assessment()? else {
            return Ok(None);
        };
        let response = &campaign.problem.response;
        let costs = campaign.simulated()?;
        let simulated = costs.iter().map(|&(cell, cost)| (cell, response.of_cost(cost)));
        let mut view = Self {
            campaign,
            access: campaign.access()?,
            runs: runs(campaign)?,
            failed: settings_that_failed(campaign),
            simulated: simulated.collect(),
            lines: Vec::new(),
            planes: Vec::new(),
            expected: BTreeMap::new(),
            found,
        };
        view.lines = (0..view.parameters().len()).map(|at| line(&view, at)).collect::<Result<_>>()?;
        view.planes = without_marks(&view).planes()?;
        let cells: Vec<Cell> = view.cells()?.into_iter().collect();
        let expected = campaign.expectations(&cells)?.unwrap_or_default();
        view.expected = cells.into_iter().zip(expected).collect();
        Ok(Some(view))
    }

    /// Every design that appears on the page.
    fn cells(&self) -> Result<BTreeSet<Cell>> {
        let of_lines = self.lines.iter().flatten();
        let of_planes = self.planes.iter().flat_map(|plane| &plane.designs);
        let mut cells: BTreeSet<Cell> = of_lines.chain(of_planes).copied().collect();
        for run in &self.runs {
            cells.insert(run.cell);
            for parameter in 0..self.parameters().len() {
                cells.insert(self.on_the_line(parameter, run.cell)?);
            }
        }
        for &id in self.campaign.experiments.trials.keys() {
            cells.insert(cell_of(self.campaign, id)?);
        }
        cells.insert(self.found.recommended.cell);
        Ok(cells)
    }

    pub(super) fn response(&self) -> &'a Response {
        &self.campaign.problem.response
    }

    /// Each with levels.
    pub(super) fn parameters(&self) -> &'a [Parameter] {
        self.campaign.grid.region().parameters()
    }

    /// The settings of the recommended design.
    pub(super) fn best(&self) -> &[f64] {
        &self.found.recommended.point
    }

    /// An axis of the settings of a parameter.
    pub(super) fn axis(&self, parameter: usize) -> Axis {
        let parameter = &self.parameters()[parameter];
        axis_of(parameter)
    }

    /// How far an axis along a parameter goes beyond its bounds: names need room, settings hardly any.
    pub(super) fn room(&self, parameter: usize) -> f64 {
        let parameter = &self.parameters()[parameter];
        if parameter.choices().is_some() { 0.4 } else { 0.02 * parameter.width() }
    }

    /// Whether a parameter is a choice, between which there is nothing.
    pub(super) fn is_choice(&self, parameter: usize) -> bool {
        self.parameters()[parameter].choices().is_some()
    }

    /// An axis of the response around these values.
    pub(super) fn response_axis(&self, values: impl IntoIterator<Item = f64>) -> Axis {
        axes::of_response(self.response(), &self.response().name, values)
    }

    /// The recommended design with this parameter as another design has it.
    pub(super) fn on_the_line(&self, parameter: usize, cell: Cell) -> Result<Cell> {
        let grid = &self.campaign.grid;
        let mut digits = grid.digits(self.found.recommended.cell)?;
        digits[parameter] = grid.digits(cell)?[parameter];
        Ok(grid.of_digits(&digits)?)
    }

    /// Whether settings are those of the recommended design, but for this parameter.
    pub(super) fn is_on_the_line(&self, parameter: usize, settings: &[f64]) -> bool {
        let pairs = settings.iter().zip(self.best()).zip(self.parameters()).enumerate();
        pairs
            .filter(|(index, _)| *index != parameter)
            .all(|(_, ((made, best), bounds))| (made - best).abs() <= 1e-9 * bounds.width())
    }

    /// What is expected of a design that appears on the page.
    pub(super) fn band(&self, cell: Cell) -> Option<Band> {
        let expected = self.expected.get(&cell)?;
        let mean = self.response().of_cost(expected.mean);
        let (low, high) = self.response().band(mean, NINE_IN_TEN * expected.deviation);
        Some(Band { mean, low, high, feasible: expected.feasible })
    }

    /// What is expected of a constrained response at a design that appears on the page, and the standard deviation of that.
    pub(super) fn constrained(&self, cell: Cell, constraint: usize) -> Option<(f64, f64)> {
        self.expected.get(&cell)?.constrained.get(constraint)?.expected
    }

    /// The first bound that a design of the page is not sure enough to keep to, with the probability that it does.
    pub(super) fn unsure(&self, cell: Cell) -> Option<(&'a Held, f64)> {
        let there = &self.expected.get(&cell)?.constrained;
        let mut pairs = self.campaign.problem.constraints.iter().zip(there);
        pairs
            .find(|(held, one)| one.expected.is_some() && one.within < held.constraint.probability)
            .map(|(held, one)| (held, one.within))
    }

    /// Settings of every run that measured a constrained response, with what it gave in the mean.
    pub(super) fn measured<'b>(&'b self, name: &'b str) -> impl Iterator<Item = (Vec<f64>, f64)> + 'b {
        let imported = self.campaign.imported.iter();
        let imported = imported.filter_map(move |one| Some((one.point.clone(), *one.constrained.get(name)?)));
        let readings = self.campaign.experiments.readings.iter();
        let own = readings.filter_map(move |(&id, reading)| {
            Some((self.campaign.experiments.settings_of(id), reading.mean_of(name)?))
        });
        imported.chain(own)
    }

    /// The middle of that.
    pub(super) fn expected(&self, cell: Cell) -> Option<f64> {
        self.band(cell).map(|band| band.mean)
    }
}

/// The design of an experiment of the campaign: what was asked for, or the one next to the settings really made.
pub(super) fn cell_of(campaign: &Campaign, id: u64) -> Result<Cell> {
    let experiments = &campaign.experiments;
    match experiments.readings.get(&id) {
        Some(reading) if !reading.actual.is_empty() => {
            Ok(campaign.grid.nearest_clamped(&experiments.settings_of(id))?)
        }
        _ => Ok(experiments.trial(id)?.cell),
    }
}

/// Every reading of the loop, in its order.
fn runs(campaign: &Campaign) -> Result<Vec<Run>> {
    let readings = &campaign.experiments.readings;
    let imported = campaign.imported.iter().enumerate();
    let imported =
        imported.filter_map(|(index, one)| Some((Origin::Imported(index), one.point.clone(), one.result.value()?)));
    let own = |id: u64, value: f64| (Origin::Own(id), campaign.experiments.settings_of(id), value);
    let again = readings
        .iter()
        .flat_map(|(&id, reading)| reading.again.values().filter_map(Measured::value).map(move |value| own(id, value)));
    let first = readings.iter().filter_map(|(&id, reading)| Some(own(id, reading.first.as_ref()?.value()?)));
    let run = |(origin, settings, value): (Origin, Vec<f64>, f64)| {
        let cell = match origin {
            Origin::Own(id) => cell_of(campaign, id)?,
            Origin::Imported(_) => campaign.grid.nearest_clamped(&settings)?,
        };
        Ok(Run { origin, cell, settings, value })
    };
    imported.chain(again).chain(first).map(run).collect()
}

/// The designs along a parameter, from lower to upper: its levels, thinned, that of the recommended design and both ends.
fn line(view: &View, parameter: usize) -> Result<Vec<Cell>> {
    let grid = &view.campaign.grid;
    let recommended = view.found.recommended.cell;
    let Thinned { n_levels, digits: drawn, .. } = thinned(grid, recommended, parameter, MOST_LEVELS)?;
    let mut levels = BTreeSet::from([0, u64::from(n_levels - 1)]);
    levels.extend(drawn);
    let mut digits = grid.digits(recommended)?;
    let cell = |level: u64| {
        digits[parameter] = level;
        Ok(grid.of_digits(&digits)?)
    };
    levels.into_iter().map(cell).collect()
}

/// The maps through the recommended design, without what was run.
pub(super) fn without_marks<'a>(view: &'a View) -> Maps<'a> {
    let (problem, grid) = (&view.campaign.problem, &view.campaign.grid);
    Maps { problem, grid, through: view.found.recommended.cell, marks: Vec::new() }
}
