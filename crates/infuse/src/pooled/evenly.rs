//! Cells spread evenly over the box.

use design_space::Cell;
use rand::RngExt;

use crate::pooled::designs::Designs;
use crate::pooled::streams::{Purpose, stream};

/// Cells whose simulated responses are looked at before any other, at most.
const SCREENED: usize = 4096;

/// The scramble of the first batch, and that of the cells that are screened.
pub(crate) fn scrambles(seed: u64) -> [u32; 2] {
    let mut rng = stream(seed, Purpose::FirstBatch, 0);
    [rng.random(), rng.random()]
}

/// The cells whose simulated responses are looked at before any other: all of a grid that has few, otherwise some all over the box. They
/// follow from the seed alone, so that what is thought of a cheap simulation does not hang on what happened to be asked of it.
pub(crate) fn screened(designs: &Designs, seed: u64) -> Vec<Cell> {
    if designs.n_cells() <= SCREENED as u64 {
        return designs.cells().collect();
    }
    let [_, scramble] = scrambles(seed);
    spread(designs, SCREENED, scramble)
}

/// Of so many cells of the sequence one is to keep to the linear constraints; else any that does is taken.
const THINNED: u32 = 64;

/// Cells spread evenly over the box: a scrambled Sobol sequence, those that keep to the linear constraints.
pub(crate) fn spread(designs: &Designs, count: usize, scramble: u32) -> Vec<Cell> {
    let coordinate = |index: u32, axis: u32| {
        let round = scramble.wrapping_add(axis / sobol_burley::NUM_DIMENSIONS);
        f64::from(sobol_burley::sample(index, axis % sobol_burley::NUM_DIMENSIONS, round))
    };
    let n_parameters = designs.region().n_parameters() as u32;
    let cell = |index: u32| designs.cell_of_unit((0..n_parameters).map(|axis| coordinate(index, axis)));
    if !designs.is_confined() {
        return (0..count as u32).map(cell).collect();
    }
    let tried = (count as u32).saturating_mul(THINNED);
    let mut cells: Vec<Cell> = (0..tried).map(cell).filter(|&cell| designs.allows(cell)).take(count).collect();
    let mut rng = stream(scramble.into(), Purpose::FirstBatch, 0);
    while cells.len() < count {
        cells.push(designs.random(&mut rng));
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    /// The first 4^2 points of two dimensions of Sobol's sequence are a net: one in each of 4 by 4 squares, however scrambled.
    #[test]
    fn sixteen_cells_of_a_square_of_sixteen_are_all_different() {
        for scramble in 0..20 {
            let mut cells = spread(&Scene::new(&[4, 4]).designs, 16, scramble);
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), 16, "scramble {scramble}");
        }
    }
}
