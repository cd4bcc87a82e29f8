//! What the simulation said, cell by cell, and what it would say elsewhere.

use std::collections::{BTreeMap, BTreeSet};

use design_space::Cell;
use surface::Data;
use surface::process::{AveragedProcess, Joint, Places, Residual, SamplerSettings, SimulationUse, Sites, Structure};

use crate::pooled::designs::Designs;
use crate::{Error, Outcome};

/// A simulation that may be asked at every cell.
pub type Simulate<'a> = dyn Simulator + 'a;

/// What can simulate many designs at once; every function from a cell and its natural point to a response, or to the reason why
/// there is none, is one.
pub trait Simulator {
    /// One response, or the reason why there is none, for each of the cells, whose natural points are in the same order.
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<f64, String>>;
}

impl<F: FnMut(Cell, &[f64]) -> Result<f64, String>> Simulator for F {
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<f64, String>> {
        cells.iter().zip(points).map(|(&cell, point)| self(cell, point)).collect()
    }
}

/// Every simulation so far, with its outcome.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Simulated {
    responses: BTreeMap<Cell, Option<f64>>,
}

impl Simulated {
    pub(crate) fn insert(&mut self, cell: Cell, outcome: &Outcome) {
        let usable = outcome.cost().filter(|response| response.abs() <= Data::LARGEST);
        self.responses.insert(cell, usable);
    }

    pub(crate) fn contains(&self, cell: Cell) -> bool {
        self.responses.contains_key(&cell)
    }

    /// Number of cells that were simulated.
    pub(crate) fn len(&self) -> usize {
        self.responses.len()
    }

    /// The cells where it gave a response, with that response.
    pub(crate) fn known(&self) -> impl Iterator<Item = (Cell, f64)> + '_ {
        self.responses.iter().filter_map(|(&cell, response)| response.map(|response| (cell, response)))
    }

    /// The cells with the lowest responses, lowest first.
    pub(crate) fn lowest(&self, count: usize) -> Vec<Cell> {
        let mut known: Vec<(Cell, f64)> = self.known().collect();
        known.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        known.truncate(count);
        known.into_iter().map(|(cell, _)| cell).collect()
    }

    /// Runs the simulation at those of the cells where it was not run before.
    pub(crate) fn run(&mut self, designs: &Designs, cells: &[Cell], simulate: &mut Simulate<'_>) -> Result<(), Error> {
        let mut seen = BTreeSet::new();
        let new = cells.iter().copied().filter(|&cell| !self.contains(cell) && seen.insert(cell));
        let new: Vec<Cell> = new.collect();
        if new.is_empty() {
            return Ok(());
        }
        let points = new.iter().map(|&cell| designs.grid().point(cell)).collect::<Result<Vec<_>, _>>()?;
        let mut responses = simulate.responses(&new, &points).into_iter();
        for &cell in &new {
            let missing = || Err("the simulation gave fewer responses than designs".to_owned());
            self.insert(cell, &responses.next().unwrap_or_else(missing).into());
        }
        Ok(())
    }

    /// The response at a cell; where the simulation failed, that at the nearest cell where it did not.
    fn at_or_near(&self, designs: &Designs, cell: Cell) -> Result<Option<f64>, Error> {
        if let Some(response) = self.responses.get(&cell).copied().flatten() {
            return Ok(Some(response));
        }
        let here = designs.grid().coded(cell)?;
        let mut best: Option<(f64, f64)> = None;
        for (other, response) in self.known() {
            let there = designs.grid().coded(other)?;
            let square: f64 = here.iter().zip(there).map(|(a, b)| (a - b) * (a - b)).sum();
            if best.is_none_or(|(least, _)| square < least) {
                best = Some((square, response));
            }
        }
        Ok(best.map(|(_, response)| response))
    }
}

/// Where simulated responses come from.
pub(crate) enum Source<'a, 'b> {
    /// There is no simulation.
    Nothing,
    /// It is run wherever it is needed.
    Cheap(&'a mut Simulate<'b>),
    /// It is run at few cells, and a surface through those tells the others.
    Emulated(Emulator),
}

impl Source<'_, '_> {
    /// Cells with what the simulation says at each; nothing is said if it never gave a response.
    pub(crate) fn places(
        &mut self,
        designs: &Designs,
        cells: &[Cell],
        simulated: &mut Simulated,
    ) -> Result<Places, Error> {
        let places = designs.places(cells)?;
        let responses: Option<Vec<f64>> = match self {
            Self::Nothing => None,
            Self::Cheap(simulate) => {
                simulated.run(designs, cells, &mut **simulate)?;
                cells.iter().map(|&cell| simulated.at_or_near(designs, cell)).collect::<Result<_, _>>()?
            }
            Self::Emulated(emulator) => {
                let means = emulator.process.means(&places);
                let known = |(&cell, mean)| simulated.responses.get(&cell).copied().flatten().unwrap_or(mean);
                Some(cells.iter().zip(means).map(known).collect())
            }
        };
        match responses {
            Some(responses) => Ok(places.with_simulated(responses)?),
            None => Ok(places),
        }
    }

    /// The simulated responses at places together; nothing where they are known.
    pub(crate) fn joint(&self, places: &Places) -> Option<Joint> {
        match self {
            Self::Emulated(emulator) => Some(emulator.process.joint(places)),
            _ => None,
        }
    }

    /// The variances of the differences of simulated responses to the first; nothing where they are known.
    pub(crate) fn variances_from_first(&self, places: &Places) -> Option<Vec<f64>> {
        match self {
            Self::Emulated(emulator) => {
                let mut sum = vec![0.0; places.n_places()];
                let of_each = emulator.process.contrasts(places);
                for contrast in &of_each {
                    let pairs = sum.iter_mut().zip(&contrast.variances);
                    pairs.for_each(|(sum, variance)| *sum += variance / of_each.len() as f64);
                }
                Some(sum)
            }
            _ => None,
        }
    }

    /// The variances of the simulated responses; nothing where they are known.
    pub(crate) fn variances(&self, places: &Places) -> Option<Vec<f64>> {
        match self {
            Self::Emulated(emulator) => Some(emulator.process.marginals(places).variances),
            _ => None,
        }
    }
}

/// A surface through the simulations, free of noise.
#[derive(Debug)]
pub(crate) struct Emulator {
    process: AveragedProcess,
}

impl Emulator {
    /// Particles of the emulator: hyperparameters of noiseless data are narrow.
    const PARTICLES: usize = 6;

    /// Through all simulations that gave a response; nothing for fewer than two.
    pub(crate) fn of(simulated: &Simulated, designs: &Designs, seed: u64) -> Result<Option<Self>, Error> {
        let (cells, responses): (Vec<Cell>, Vec<f64>) = simulated.known().unzip();
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
        Ok(Some(Self { process: AveragedProcess::new(Sites::new(&data, None)?, &settings)? }))
    }

    /// Which of the cells to simulate next, most uncertain first, each pick counted in: at most `count`.
    pub(crate) fn most_uncertain(&self, designs: &Designs, cells: &[Cell], count: usize) -> Result<Vec<Cell>, Error> {
        let places = designs.places(cells)?;
        let mut joint = self.process.joint(&places);
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
