//! What the simulation said, cell by cell, and what it would say elsewhere.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;
use serde::{Deserialize, Serialize};
use surface::Data;
use surface::process::{AveragedProcess, Joint, Places, Residual, SamplerSettings, SimulationUse, Sites, Structure};

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::displacement::{Displacement, WITHIN_A_STEP, correlation, left_of, next_to, went_on};
use crate::pooled::evenly::screened;
use crate::pooled::moments::mean_and_deviation;
use crate::pooled::settings::Settings;

/// What one run gives: its cost, and the responses on which there are constraints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Responses {
    /// What is to be made small: the response, or its negative.
    #[serde(alias = "objective")]
    pub cost: f64,
    /// One per constraint, in the order of [`Settings::constraints`](crate::pooled::Settings::constraints); none where it was not
    /// measured. Missing ones at the end may be left out.
    #[serde(default)]
    pub constrained: Vec<Option<f64>>,
}

impl From<f64> for Responses {
    fn from(cost: f64) -> Self {
        Self { cost, constrained: Vec::new() }
    }
}

/// A simulation that may be asked at every cell, many at once. Any function of a cell and its natural point to a number, or to
/// [`Responses`], or else to the reason why there is none, is one.
pub trait Simulate {
    /// What it says of each of the cells, whose natural points are in the same order.
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<Responses, String>>;
}

impl<F, R> Simulate for F
where
    F: FnMut(Cell, &[f64]) -> Result<R, String>,
    R: Into<Responses>,
{
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<Responses, String>> {
        cells.iter().zip(points).map(|(&cell, point)| self(cell, point).map(Into::into)).collect()
    }
}

/// Which response of a run is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    Cost,
    /// By its place among the constraints.
    Constrained(usize),
}

impl Column {
    fn of(self, responses: &Responses) -> Option<f64> {
        match self {
            Self::Cost => Some(responses.cost),
            Self::Constrained(index) => responses.constrained.get(index).copied().flatten(),
        }
    }
}

/// Every simulation so far, with its outcome: where simulations are dear, what is known of them; where they are cheap, what is not run
/// again, and nothing that the loop says hangs on which these are.
#[derive(Debug, Clone, Default)]
pub(crate) struct Simulated {
    responses: BTreeMap<Cell, Option<Responses>>,
}

impl Simulated {
    pub(crate) fn insert(&mut self, cell: Cell, outcome: Option<Responses>) {
        self.responses.insert(cell, Self::usable(outcome));
    }

    fn usable(outcome: Option<Responses>) -> Option<Responses> {
        let is_usable = |value: f64| value.abs() <= Data::LARGEST;
        outcome.filter(|responses| is_usable(responses.cost)).map(|mut responses| {
            responses.constrained.iter_mut().for_each(|value| *value = value.filter(|value| is_usable(*value)));
            responses
        })
    }

    /// Each cell that was simulated, ascending, with what it gave.
    pub(crate) fn all(&self) -> impl Iterator<Item = (Cell, Option<&Responses>)> + '_ {
        self.responses.iter().map(|(&cell, responses)| (cell, responses.as_ref()))
    }

    pub(crate) fn contains(&self, cell: Cell) -> bool {
        self.responses.contains_key(&cell)
    }

    /// Number of cells that were simulated.
    pub(crate) fn len(&self) -> usize {
        self.responses.len()
    }

    fn at(&self, cell: Cell, column: Column) -> Option<f64> {
        column.of(self.responses.get(&cell)?.as_ref()?)
    }

    /// The cells where it gave this response, with that response.
    pub(crate) fn known(&self, column: Column) -> impl Iterator<Item = (Cell, f64)> + '_ {
        self.responses.iter().filter_map(move |(&cell, responses)| Some((cell, column.of(responses.as_ref()?)?)))
    }

    /// Runs the simulation at those of the cells where it was not run before.
    pub(crate) fn run(&mut self, designs: &Designs, cells: &[Cell], simulate: &mut dyn Simulate) -> Result<(), Error> {
        let mut seen = BTreeSet::new();
        let new = cells.iter().copied().filter(|&cell| !self.contains(cell) && seen.insert(cell));
        let new: Vec<Cell> = new.collect();
        if new.is_empty() {
            return Ok(());
        }
        let points = new.iter().map(|&cell| designs.grid().point(cell)).collect::<Result<Vec<_>, _>>()?;
        let mut responses = simulate.responses(&new, &points).into_iter();
        for cell in new {
            // One that gave fewer responses than there are designs has failed at the others.
            self.insert(cell, responses.next().and_then(Result::ok));
        }
        Ok(())
    }

    /// The response at each cell; where the simulation failed, that at the nearest of the screened ones where it did not, or of these
    /// cells themselves if it failed at all of those.
    pub(crate) fn at_or_near_all(
        &self,
        designs: &Designs,
        cells: &[Cell],
        screened: &[Cell],
        column: Column,
    ) -> Result<Option<Vec<f64>>, Error> {
        let near = |others: &[Cell]| -> Result<Option<Vec<f64>>, Error> {
            cells.iter().map(|&cell| self.at_or_near(designs, cell, others, column)).collect()
        };
        Ok(match near(screened)? {
            None => near(cells)?,
            said => said,
        })
    }

    fn at_or_near(&self, designs: &Designs, cell: Cell, others: &[Cell], column: Column) -> Result<Option<f64>, Error> {
        if let Some(response) = self.at(cell, column) {
            return Ok(Some(response));
        }
        let here = designs.coded_of(cell)?;
        let mut best: Option<(f64, f64)> = None;
        for &other in others {
            let Some(response) = self.at(other, column) else { continue };
            let there = designs.coded_of(other)?;
            let square: f64 = here.iter().zip(there).map(|(a, b)| (a - b) * (a - b)).sum();
            if best.is_none_or(|(least, _)| square < least) {
                best = Some((square, response));
            }
        }
        Ok(best.map(|(_, response)| response))
    }
}

/// Where simulated responses come from.
pub(crate) enum Source<'a> {
    /// There is no simulation.
    Nothing,
    /// It is run wherever it is needed, at the `screened` cells in any case.
    Cheap { simulate: &'a mut dyn Simulate, screened: Vec<Cell>, place: Place },
    /// It is run at few cells, and a surface through those tells the others.
    Emulated { emulator: Emulator, place: Place },
}

/// Where a simulation tells of experiments.
#[derive(Debug, Clone, Default)]
pub(crate) struct Place {
    /// How far it is displaced,
    displacement: Displacement,
    /// and that in coded units.
    coded: Vec<f64>,
    /// Standard deviation of what it says of the designs that were measured: of the cost, then of each constrained response.
    units: Vec<Option<f64>>,
}

impl Place {
    fn unit(&self, column: Column) -> f64 {
        let index = match column {
            Column::Cost => 0,
            Column::Constrained(index) => index + 1,
        };
        self.units.get(index).copied().flatten().unwrap_or_default()
    }
}

impl<'a> Source<'a> {
    /// What there is: where simulations are dear, what they said so far.
    pub(crate) fn of(
        settings: &Settings,
        designs: &Designs,
        simulated: &mut Simulated,
        simulate: Option<&'a mut dyn Simulate>,
    ) -> Result<Self, Error> {
        match (settings.simulations, simulate) {
            (Some(_), _) => Ok(Emulator::of(simulated, designs, settings)?.map_or(Self::Nothing, Self::emulated)),
            (None, Some(simulate)) => Self::cheap(designs, settings.seed, simulated, simulate),
            (None, None) => Ok(Self::Nothing),
        }
    }
}

impl<'a> Source<'a> {
    /// A simulation that is run wherever it is needed, displaced by nothing.
    pub(crate) fn cheap(
        designs: &Designs,
        seed: u64,
        simulated: &mut Simulated,
        simulate: &'a mut dyn Simulate,
    ) -> Result<Self, Error> {
        let screened = screened(designs, seed);
        simulated.run(designs, &screened, simulate)?;
        Ok(Self::Cheap { simulate, screened, place: Place::default() })
    }

    /// One that a surface tells of, displaced by nothing.
    pub(crate) fn emulated(emulator: Emulator) -> Self {
        Self::Emulated { emulator, place: Place::default() }
    }
}

impl Source<'_> {
    /// Takes what is said from elsewhere. Where that is beyond the bounds, nobody knows more of it than how what it says of the `measured`
    /// designs differs, of each response.
    pub(crate) fn displace(
        &mut self,
        by: Displacement,
        designs: &Designs,
        measured: &[Cell],
        simulated: &Simulated,
        n_constraints: usize,
    ) -> Result<(), Error> {
        let columns = [Column::Cost].into_iter().chain((0..n_constraints).map(Column::Constrained));
        let of_it =
            |column| Ok(self.says(designs, measured, simulated, column)?.map(|said| mean_and_deviation(&said)[1]));
        // Where it is in its place, nothing lies beyond.
        let units = if by.is_none() { Vec::new() } else { columns.map(of_it).collect::<Result<_, Error>>()? };
        let new = Place { coded: by.coded(designs), displacement: by, units };
        match self {
            Self::Nothing => {}
            Self::Cheap { place, .. } | Self::Emulated { place, .. } => *place = new,
        }
        Ok(())
    }

    /// Where it tells of experiments, if that is elsewhere.
    fn place(&self) -> Option<&Place> {
        match self {
            Self::Cheap { place, .. } | Self::Emulated { place, .. } => {
                Some(place).filter(|place| !place.displacement.is_none())
            }
            Self::Nothing => None,
        }
    }

    /// The designs for which the simulation says least, lowest first: of those that were screened, or of all that are known.
    pub(crate) fn lowest(&self, simulated: &Simulated, count: usize) -> Vec<Cell> {
        let mut known: Vec<(Cell, f64)> = match self {
            Self::Nothing => Vec::new(),
            Self::Cheap { screened, .. } => {
                let of_it = |&cell: &Cell| Some((cell, simulated.at(cell, Column::Cost)?));
                screened.iter().filter_map(of_it).collect()
            }
            Self::Emulated { .. } => simulated.known(Column::Cost).collect(),
        };
        known.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        known.dedup();
        known.truncate(count);
        known.into_iter().map(|(cell, _)| cell).collect()
    }

    /// How far the simulation is displaced, if it is.
    pub(crate) fn displacement(&self) -> Option<&Displacement> {
        self.place().map(|place| &place.displacement)
    }

    /// Cells with what the simulation says at each; nothing is said if it never gave a response. Where it is displaced, its place is
    /// known to a step of the search alone: it may be off by what it says next to there.
    pub(crate) fn places(
        &mut self,
        designs: &Designs,
        cells: &[Cell],
        simulated: &mut Simulated,
    ) -> Result<Places, Error> {
        let [there, inside] = self.told_by(designs, cells);
        let around = if self.displacement().is_some() { next_to(designs, &there) } else { Vec::new() };
        if let Self::Cheap { simulate, .. } = self {
            let all: Vec<Cell> = there.iter().chain(around.iter().flatten()).chain(&inside).copied().collect();
            simulated.run(designs, &all, &mut **simulate)?;
        }
        let Some(said) = self.would_say(designs, [&there, &inside], simulated, Column::Cost)? else {
            return designs.places(cells);
        };
        let known = self.known(designs, cells);
        let about = if around.is_empty() { Vec::new() } else { self.about(designs, &there, simulated)? };
        let deviations = |next: Vec<Cell>| {
            let next = self.about(designs, &next, simulated)?;
            let off = next.iter().zip(&about).map(|(next, here)| WITHIN_A_STEP * (next - here));
            Ok(off.enumerate().map(|(place, off)| known.get(place).map_or(off, |known| known * off)).collect())
        };
        let deviations = around.into_iter().map(deviations).collect::<Result<_, Error>>()?;
        Ok(self.told(designs.places(cells)?, said, &known, Column::Cost)?.with_deviations(deviations)?)
    }

    /// What the simulation says of cells as exactly as differences are asked for: of a surface one particle will do.
    fn about(&self, designs: &Designs, cells: &[Cell], simulated: &Simulated) -> Result<Vec<f64>, Error> {
        let none = || vec![0.0; cells.len()];
        match self {
            Self::Emulated { emulator, .. } => {
                let [first, ..] = emulator.cost.particles() else { return Ok(none()) };
                Ok(first.means(&designs.places(cells)?)?)
            }
            _ => Ok(self.says(designs, cells, simulated, Column::Cost)?.unwrap_or_else(none)),
        }
    }

    /// The designs whose simulations tell of these: at most at the bounds, and as far within as that is from the place beyond. Where nothing
    /// is displaced the latter are the same, and left out.
    fn told_by(&self, designs: &Designs, cells: &[Cell]) -> [Vec<Cell>; 2] {
        let Some(by) = self.displacement() else { return [cells.to_vec(), Vec::new()] };
        let there = cells.iter().map(|&cell| by.of(designs, cell)).collect();
        [there, cells.iter().map(|&cell| by.inside(designs, cell)).collect()]
    }

    /// How what is said of each of these cells goes with what would be said if there were no bounds; nothing where all is the same.
    fn known(&self, designs: &Designs, cells: &[Cell]) -> Vec<f64> {
        let known = |displacement: &Displacement| {
            cells.iter().map(|&cell| correlation(displacement.beyond(designs, cell))).collect()
        };
        self.displacement().map_or_else(Vec::new, known)
    }

    /// What a simulation says of cells by those that tell of them; beyond the bounds, what it would say if it went on as it came.
    fn would_say(
        &self,
        designs: &Designs,
        [there, inside]: [&[Cell]; 2],
        simulated: &Simulated,
        column: Column,
    ) -> Result<Option<Vec<f64>>, Error> {
        let Some(mut said) = self.says(designs, there, simulated, column)? else { return Ok(None) };
        // Within the bounds both are the same design.
        let beyond: Vec<usize> = (0..inside.len()).filter(|&place| inside[place] != there[place]).collect();
        if beyond.is_empty() {
            return Ok(Some(said));
        }
        let inside: Vec<Cell> = beyond.iter().map(|&place| inside[place]).collect();
        let Some(inside) = self.says(designs, &inside, simulated, column)? else { return Ok(None) };
        beyond.into_iter().zip(inside).for_each(|(place, inside)| said[place] = went_on(said[place], inside));
        Ok(Some(said))
    }

    /// Places with what is said of each, as far as that is known.
    fn told(&self, places: Places, said: Vec<f64>, known: &[f64], column: Column) -> Result<Places, Error> {
        let Some(place) = self.place() else { return Ok(places.with_simulated(said)?) };
        let unit = place.unit(column);
        let unknown = known.iter().map(|&known| unit * left_of(known)).collect();
        Ok(places.with_simulated(said)?.with_unknown(unknown)?)
    }

    /// The same for any response, of cells that were simulated if that is cheap.
    pub(crate) fn known_places(
        &self,
        designs: &Designs,
        cells: &[Cell],
        simulated: &Simulated,
        column: Column,
    ) -> Result<Places, Error> {
        let places = designs.places(cells)?;
        let [there, inside] = self.told_by(designs, cells);
        match self.would_say(designs, [&there, &inside], simulated, column)? {
            Some(said) => self.told(places, said, &self.known(designs, cells), column),
            None => Ok(places),
        }
    }

    /// What is known of the simulation of these cells themselves; none where it never gave this response.
    fn says(
        &self,
        designs: &Designs,
        cells: &[Cell],
        simulated: &Simulated,
        column: Column,
    ) -> Result<Option<Vec<f64>>, Error> {
        match self {
            Self::Nothing => Ok(None),
            Self::Cheap { screened, .. } => simulated.at_or_near_all(designs, cells, screened, column),
            Self::Emulated { emulator, .. } => emulator.says(designs, cells, simulated, column),
        }
    }

    /// The simulated responses at places together; nothing where they are known.
    pub(crate) fn joint(&self, places: &Places, column: Column) -> Result<Option<Joint>, Error> {
        let emulation = self.emulation(places, column);
        Ok(emulation.map(|(process, there)| process.joint(&there)).transpose()?)
    }

    /// The variances of the differences of simulated responses to the first; nothing where they are known.
    pub(crate) fn variances_from_first(&self, places: &Places) -> Result<Option<Vec<f64>>, Error> {
        let mut sum = vec![0.0; places.n_places()];
        let Some((process, there)) = self.emulation(places, Column::Cost) else { return Ok(None) };
        let of_each = process.contrasts(&there)?;
        for contrast in &of_each {
            let pairs = sum.iter_mut().zip(&contrast.variances);
            pairs.for_each(|(sum, variance)| *sum += variance / of_each.len() as f64);
        }
        Ok(Some(sum))
    }

    /// The variances of the simulated responses; nothing where they are known.
    pub(crate) fn variances(&self, places: &Places, column: Column) -> Result<Option<Vec<f64>>, Error> {
        let Some((process, there)) = self.emulation(places, column) else { return Ok(None) };
        Ok(Some(process.marginals(&there)?.variances))
    }

    /// The surface that tells of them, and the places whose simulations tell of these.
    fn emulation<'p>(&self, places: &'p Places, column: Column) -> Option<(&AveragedProcess, Cow<'p, Places>)> {
        let Self::Emulated { emulator, place } = self else { return None };
        let is_there = place.displacement.is_none();
        let there = if is_there { Cow::Borrowed(places) } else { Cow::Owned(places.moved(&place.coded)) };
        Some((emulator.process(column)?, there))
    }
}

/// A surface through the simulations of each response, free of noise.
#[derive(Debug)]
pub(crate) struct Emulator {
    cost: AveragedProcess,
    /// None for what was never simulated.
    constrained: Vec<Option<AveragedProcess>>,
}

impl Emulator {
    /// Particles of the emulator: hyperparameters of noiseless data are narrow.
    const PARTICLES: usize = 6;

    /// Through all simulations that gave a response; nothing for fewer than two.
    pub(crate) fn of(simulated: &Simulated, designs: &Designs, settings: &Settings) -> Result<Option<Self>, Error> {
        let through = |column| Self::through(simulated, designs, settings.seed, column);
        let Some(cost) = through(Column::Cost)? else {
            return Ok(None);
        };
        let constrained = (0..settings.constraints.len()).map(|index| through(Column::Constrained(index)));
        Ok(Some(Self { cost, constrained: constrained.collect::<Result<_, _>>()? }))
    }

    fn through(
        simulated: &Simulated,
        designs: &Designs,
        seed: u64,
        column: Column,
    ) -> Result<Option<AveragedProcess>, Error> {
        let (cells, responses): (Vec<Cell>, Vec<f64>) = simulated.known(column).unzip();
        if cells.len() < 2 {
            return Ok(None);
        }
        let data = Data::new(designs.n_factors(), designs.coded(&cells)?, responses)?;
        let smooth = Structure { simulation: SimulationUse::Ignored, residual: Residual::Smooth };
        let settings = SamplerSettings {
            structures: vec![smooth],
            noise: Some(0.0),
            particles: Self::PARTICLES,
            last_sweeps: 2,
            seed,
            ..SamplerSettings::default()
        };
        Ok(Some(AveragedProcess::new(Sites::new(&data, None)?, &settings)?))
    }

    fn process(&self, column: Column) -> Option<&AveragedProcess> {
        match column {
            Column::Cost => Some(&self.cost),
            Column::Constrained(index) => self.constrained.get(index)?.as_ref(),
        }
    }

    /// What it says of cells; what was simulated is known.
    pub(crate) fn says(
        &self,
        designs: &Designs,
        cells: &[Cell],
        simulated: &Simulated,
        column: Column,
    ) -> Result<Option<Vec<f64>>, Error> {
        let Some(process) = self.process(column) else { return Ok(None) };
        let means = process.means(&designs.places(cells)?)?;
        Ok(Some(cells.iter().zip(means).map(|(&cell, mean)| simulated.at(cell, column).unwrap_or(mean)).collect()))
    }

    /// Which of the cells to simulate next, most uncertain first, each pick counted in: at most `count`.
    pub(crate) fn most_uncertain(&self, designs: &Designs, cells: &[Cell], count: usize) -> Result<Vec<Cell>, Error> {
        let places = designs.places(cells)?;
        let mut joint = self.cost.joint(&places)?;
        let mut chosen = Vec::new();
        for _ in 0..count.min(cells.len()) {
            let order = |&a: &usize, &b: &usize| joint.variance(a).total_cmp(&joint.variance(b)).then(b.cmp(&a));
            let row = (0..cells.len()).max_by(order).unwrap_or(0);
            if joint.variance(row) <= 0.0 {
                break;
            }
            chosen.push(cells[row]);
            let effect = joint.effect(row, 0.0);
            joint.measure(&effect);
        }
        Ok(chosen)
    }
}

#[cfg(test)]
mod tests {
    use design_space::{Parameter, Region};
    use rand::SeedableRng as _;

    use super::*;

    fn designs() -> Designs {
        let number = |name: &str| Parameter::continuous(name, "1", 0.0, 1.0).unwrap().with_levels(11).unwrap();
        let region = Region::new(vec![number("x"), number("y")]).unwrap();
        Designs::of(&region, &[], &mut rand_chacha::ChaCha8Rng::seed_from_u64(1)).unwrap()
    }

    fn cell(designs: &Designs, x: u64, y: u64) -> Cell {
        Cell::new(designs.combinations().index(&[x, y]))
    }

    #[test]
    fn where_it_failed_the_nearest_response_stands_for_it() {
        let (designs, mut simulated) = (designs(), Simulated::default());
        let others = [(9, 9, 1.0), (4, 3, 2.0), (1, 2, 3.0), (3, 4, 4.0), (7, 2, 5.0)].map(|(x, y, response)| {
            let cell = cell(&designs, x, y);
            simulated.insert(cell, Some(Responses::from(response)));
            cell
        });
        for (x, y, expected) in [(4, 3, 2.0), (4, 2, 2.0), (8, 8, 1.0), (1, 1, 3.0), (10, 0, 5.0), (3, 6, 4.0)] {
            simulated.insert(cell(&designs, 5, 5), None);
            let here = [cell(&designs, x, y)];
            let found = simulated.at_or_near_all(&designs, &here, &others, Column::Cost).unwrap();
            assert_eq!(found, Some(vec![expected]), "at {x}, {y}");
        }
        // Level with two: the first of those.
        let here = [cell(&designs, 3, 3)];
        let near = |others: &[Cell]| simulated.at_or_near_all(&designs, &here, others, Column::Cost).unwrap();
        assert_eq!(near(&others), Some(vec![2.0]));
        assert_eq!(near(&[]), None, "it failed there, and no other is known");
        let both = [here[0], others[3]];
        let found = simulated.at_or_near_all(&designs, &both, &[], Column::Cost).unwrap();
        assert_eq!(found, Some(vec![4.0, 4.0]), "those that were asked for themselves");
    }

    #[test]
    fn two_simulations_are_enough_for_an_emulator_and_one_is_not() {
        let (designs, mut simulated) = (designs(), Simulated::default());
        let settings = Settings::new(5);
        simulated.insert(cell(&designs, 0, 0), Some(Responses::from(1.0)));
        assert!(Emulator::of(&simulated, &designs, &settings).unwrap().is_none());
        simulated.insert(cell(&designs, 10, 10), Some(Responses::from(2.0)));
        let emulator = Emulator::of(&simulated, &designs, &settings).unwrap().unwrap();
        // The farthest corners are least known; what is simulated is known.
        let cells = [(0, 0), (1, 0), (10, 0), (0, 10), (9, 10)].map(|(x, y)| cell(&designs, x, y));
        let mut found = emulator.most_uncertain(&designs, &cells, 2).unwrap();
        found.sort_unstable();
        assert_eq!(found, [cells[3], cells[2]]);
    }

    /// By the share of a step, at its own place and along each axis there and back; one that is in its place is off by nothing.
    #[test]
    fn a_displaced_simulation_may_be_off_by_what_it_says_next_to_there() {
        let designs = designs();
        let says = |point: &[f64]| 7.0 * point[0] * point[0] + point[1];
        let places = |by: [i64; 2], cells: &[Cell]| {
            let mut simulate = |_: Cell, point: &[f64]| Ok::<f64, String>(says(point));
            let mut simulated = Simulated::default();
            let mut source = Source::cheap(&designs, 1, &mut simulated, &mut simulate).unwrap();
            source.displace(Displacement(by.to_vec()), &designs, cells, &simulated, 0).unwrap();
            source.places(&designs, cells, &mut simulated).unwrap()
        };
        let cells = [cell(&designs, 3, 4), cell(&designs, 8, 10)];
        let found = places([2, -1], &cells);
        let at = |x: i64, y: i64| says(&[x.min(10) as f64 / 10.0, y as f64 / 10.0]);
        for (way, [x, y]) in [[-1, 0], [1, 0], [0, -1], [0, 1]].into_iter().enumerate() {
            for (place, [a, b]) in [[5, 3], [10, 9]].into_iter().enumerate() {
                let expected = (at(a + x, b + y) - at(a, b)) / 12.0_f64.sqrt();
                assert!((found.deviations()[way][place] - expected).abs() < 1e-14, "way {way} at place {place}");
            }
        }
        assert!(places([0, 0], &cells).deviations().is_empty(), "it is in its place");
    }

    /// Of 11 levels one lies 0.2 coded units from the next. A simulation that is a plane goes on as one; three levels beyond the bounds, along
    /// both axes together, little is known of it, and no more than how much it varies over the designs that were measured.
    #[test]
    fn beyond_the_bounds_a_simulation_tells_the_less_the_farther() {
        let designs = designs();
        let mut simulate = |_: Cell, point: &[f64]| Ok::<f64, String>(40.0 * point[0] + point[1]);
        let mut simulated = Simulated::default();
        let measured = [(2, 1), (4, 3), (7, 1), (9, 8)].map(|(x, y)| cell(&designs, x, y));
        let mut source = Source::cheap(&designs, 1, &mut simulated, &mut simulate).unwrap();
        let said = source.places(&designs, &measured, &mut simulated).unwrap().simulated().unwrap().to_vec();
        let mean = said.iter().sum::<f64>() / 4.0;
        let deviation = (said.iter().map(|said| said * said).sum::<f64>() / 4.0 - mean * mean).sqrt();
        source.displace(Displacement(vec![3, -2]), &designs, &measured, &simulated, 0).unwrap();
        let cells = [(7, 2), (8, 2), (10, 0), (7, 1)];
        let of_each = cells.map(|(x, y)| 4.0 * (x + 3) as f64 + 0.1 * (y as f64 - 2.0));
        let cells = cells.map(|(x, y)| cell(&designs, x, y));
        let found = source.places(&designs, &cells, &mut simulated).unwrap();
        let beyond = [0.0, 0.2, 0.6_f64.hypot(0.4), 0.2];
        for (place, (beyond, expected)) in beyond.into_iter().zip(of_each).enumerate() {
            assert!((found.simulated().unwrap()[place] - expected).abs() < 1e-12, "{expected} at place {place}");
            let known = (-0.5 * (beyond / 0.4_f64).powi(2)).exp();
            let unknown = deviation * (1.0 - known * known).sqrt();
            assert!((found.unknown()[place] - unknown).abs() < 1e-9, "{unknown} at place {place}");
        }
        source.displace(Displacement::default(), &designs, &measured, &simulated, 0).unwrap();
        assert!(source.places(&designs, &cells, &mut simulated).unwrap().unknown().is_empty(), "it is in its place");
    }

    /// What an emulator knows of a design that is told of by a simulated one is all there is to know; of one that was simulated itself it
    /// is that of the design two levels farther on.
    #[test]
    fn a_displaced_emulator_knows_designs_by_others() {
        let (designs, mut simulated) = (designs(), Simulated::default());
        for (x, y, response) in [(0, 0, 1.0), (10, 10, 2.0), (3, 7, 0.5), (8, 1, 1.7)] {
            simulated.insert(cell(&designs, x, y), Some(Responses::from(response)));
        }
        let emulator = Emulator::of(&simulated, &designs, &Settings::new(5)).unwrap().unwrap();
        let mut source = Source::emulated(emulator);
        let cells = [(1, 8), (3, 7), (9, 10)].map(|(x, y)| cell(&designs, x, y));
        let in_place = source.places(&designs, &cells, &mut simulated).unwrap();
        let farther_on = cell(&designs, 5, 6);
        let expected = source.places(&designs, &[farther_on], &mut simulated).unwrap();
        let variance = source.variances(&expected, Column::Cost).unwrap().unwrap()[0];
        source.displace(Displacement(vec![2, -1]), &designs, &cells, &simulated, 0).unwrap();
        let places = source.places(&designs, &cells, &mut simulated).unwrap();
        assert_eq!(places.simulated().unwrap()[0].to_bits(), 0.5_f64.to_bits(), "of the design at 3 and 7");
        assert!((places.simulated().unwrap()[1] - expected.simulated().unwrap()[0]).abs() < 1e-12);
        let found = source.variances(&places, Column::Cost).unwrap().unwrap();
        assert!(found[0] < 1e-6 && (found[1] - variance).abs() < 1e-9 && variance > 1e-3, "{found:?}, {variance}");
        assert_eq!((in_place.deviations().len(), places.deviations().len()), (0, 4));
    }

    /// The difference of a design to itself is known; those to others no better than each particle knows them, and no worse than
    /// all of them together.
    #[test]
    fn differences_of_emulated_responses_are_known_as_their_joint_distribution_says() {
        let (designs, mut simulated) = (designs(), Simulated::default());
        for (x, y, response) in [(0, 0, 1.0), (10, 10, 2.0), (3, 7, 0.5), (8, 1, 1.7)] {
            simulated.insert(cell(&designs, x, y), Some(Responses::from(response)));
        }
        let source = Source::emulated(Emulator::of(&simulated, &designs, &Settings::new(5)).unwrap().unwrap());
        let cells = [(5, 5), (0, 0), (5, 5), (10, 0)].map(|(x, y)| cell(&designs, x, y));
        let places = designs.places(&cells).unwrap();
        let found = source.variances_from_first(&places).unwrap().unwrap();
        let joint = source.joint(&places, Column::Cost).unwrap().unwrap();
        assert_eq!(found.len(), 4);
        for (place, variance) in found.iter().enumerate() {
            let most = joint.variance(0) + joint.variance(place) - 2.0 * joint.covariances(0)[place];
            assert!(*variance <= most + 1e-9, "{variance} at {place}, {most} together");
            assert_eq!(*variance > 1e-6, place % 2 == 1, "{variance} at {place}");
        }
        assert!(Source::Nothing.variances_from_first(&places).unwrap().is_none());
    }
}
