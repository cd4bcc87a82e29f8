//! The first batch: half of it spread over the box, half over what the simulation recommends.

use design_space::Cell;
use rand::RngExt;

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::simulated::{Simulated, Source};
use crate::pooled::streams::{Purpose, stream};

/// Share of the screened cells among which the second half is spread.
const PROMISING: f64 = 0.08;
/// Cells whose simulated responses are looked at, at most.
const SCREENED: usize = 4096;

/// `attempt` counts first batches that gave no response at all: each spreads its runs anew.
pub(crate) fn first_batch(
    designs: &Designs,
    n_experiments: usize,
    seed: u64,
    attempt: usize,
    simulated: &mut Simulated,
    source: &mut Source<'_, '_>,
) -> Result<Vec<Cell>, Error> {
    let mut rng = stream(seed, Purpose::FirstBatch, attempt);
    let (scramble, other) = (rng.random(), rng.random());
    if matches!(source, Source::Nothing) {
        return Ok(spread(designs, n_experiments, scramble));
    }
    let screened: Vec<Cell> = if designs.n_cells() <= SCREENED as u64 {
        designs.grid().cells().collect()
    } else {
        spread(designs, SCREENED, other)
    };
    let places = source.places(designs, &screened, simulated)?;
    let Some(responses) = places.simulated() else {
        return Ok(spread(designs, n_experiments, scramble));
    };
    let mut order: Vec<usize> = (0..screened.len()).collect();
    order.sort_by(|&a, &b| responses[a].total_cmp(&responses[b]).then(a.cmp(&b)));
    order.truncate(((screened.len() as f64 * PROMISING) as usize).max(n_experiments));
    let promising: Vec<Cell> = order.into_iter().map(|row| screened[row]).collect();
    let mut cells = spread(designs, n_experiments.div_ceil(2), scramble);
    cells.extend(far_apart(designs, &promising, n_experiments - cells.len())?);
    Ok(cells)
}

/// Cells spread evenly over the box: a scrambled Sobol sequence.
pub(crate) fn spread(designs: &Designs, count: usize, scramble: u32) -> Vec<Cell> {
    let coordinate = |index: u32, axis: u32| {
        let round = scramble.wrapping_add(axis / sobol_burley::NUM_DIMENSIONS);
        f64::from(sobol_burley::sample(index, axis % sobol_burley::NUM_DIMENSIONS, round))
    };
    let n_factors = designs.n_factors() as u32;
    (0..count as u32).map(|index| designs.cell_of_unit((0..n_factors).map(|axis| coordinate(index, axis)))).collect()
}

/// The first of the cells, and then always the one that is farthest from all chosen so far.
fn far_apart(designs: &Designs, cells: &[Cell], count: usize) -> Result<Vec<Cell>, Error> {
    let coded: Vec<Vec<f64>> = cells.iter().map(|&cell| designs.grid().coded(cell)).collect::<Result<_, _>>()?;
    let mut distances = vec![f64::INFINITY; cells.len()];
    let (mut chosen, mut next) = (Vec::with_capacity(count), 0);
    while chosen.len() < count && !cells.is_empty() {
        chosen.push(cells[next]);
        for (distance, there) in distances.iter_mut().zip(&coded) {
            let square: f64 = coded[next].iter().zip(there).map(|(a, b)| (a - b) * (a - b)).sum();
            *distance = distance.min(square);
        }
        let farthest = (0..cells.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]).then(b.cmp(&a)));
        next = farthest.unwrap_or(0);
    }
    Ok(chosen)
}
