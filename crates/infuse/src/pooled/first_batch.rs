//! The first batch: two thirds of it spread over the box, a third over what the simulation recommends.

use std::collections::BTreeSet;

use design_space::Cell;

use crate::Error;
use crate::pooled::designs::Designs;
use crate::pooled::evenly::{scrambles, screened, spread};
use crate::pooled::settings::Settings;
use crate::pooled::simulated::{Column, Simulated, Source};

/// One experiment in so many is for what the simulation recommends, one at least of two. With half of them a simulation that misleads
/// costs more, and one that does not is believed in the second batch anyway.
const FOR_THE_SIMULATION: usize = 3;
/// Share of the screened cells among which these are spread.
const PROMISING: f64 = 0.08;

/// `tested` are cells where experiments were made or are waited for: these are asked for again only where there are no others. Those of
/// them that are `refused` are not.
pub(crate) fn first_batch(
    designs: &Designs,
    settings: &Settings,
    (tested, refused): (&BTreeSet<Cell>, &BTreeSet<Cell>),
    simulated: &mut Simulated,
    source: &mut Source<'_>,
) -> Result<Vec<Cell>, Error> {
    let n_experiments = settings.n_experiments;
    let [scramble, _] = scrambles(settings.seed);
    let evenly = |count: usize| {
        let all = spread(designs, count + tested.len(), scramble).into_iter().filter(|cell| !refused.contains(cell));
        let (new, old): (Vec<Cell>, Vec<Cell>) = all.partition(|cell| !tested.contains(cell));
        filled(designs, new.into_iter().chain(old).take(count).collect(), count, refused)
    };
    if matches!(source, Source::Nothing) {
        return Ok(on_few_plants(designs, settings, evenly(n_experiments)));
    }
    let screened = screened(designs, settings.seed);
    let places = source.places(designs, &screened, simulated)?;
    let Some(responses) = places.simulated() else {
        return Ok(on_few_plants(designs, settings, evenly(n_experiments)));
    };
    let within = within_constraints(designs, settings, simulated, source, &screened)?;
    let mut order: Vec<usize> = (0..screened.len()).collect();
    order.sort_by(|&a, &b| within[b].cmp(&within[a]).then(responses[a].total_cmp(&responses[b])).then(a.cmp(&b)));
    order.truncate(((screened.len() as f64 * PROMISING) as usize).max(n_experiments));
    let promising = order.into_iter().map(|row| screened[row]).filter(|cell| !tested.contains(cell));
    let promising: Vec<Cell> = promising.collect();
    let share = (n_experiments / FOR_THE_SIMULATION).max(1).min(n_experiments / 2);
    let n_promising = if promising.is_empty() { 0 } else { share };
    let spread_out = evenly(n_experiments - n_promising);
    let promising = far_apart(designs, &promising, n_experiments - spread_out.len())?;
    Ok(match &settings.plants {
        // Plants of either kind.
        Some(plants) => plants.gathered(designs, &in_turn(promising, spread_out)),
        None => distinct(designs, [spread_out, promising].concat(), tested),
    })
}

/// As many cells as are to be run, where so many were refused that fewer are left: others, and then those that are left once more.
fn filled(designs: &Designs, mut cells: Vec<Cell>, count: usize, refused: &BTreeSet<Cell>) -> Vec<Cell> {
    if cells.len() < count {
        let others = designs.cells().filter(|cell| !refused.contains(cell) && !cells.contains(cell));
        cells.extend(others.take(count - cells.len()).collect::<Vec<Cell>>());
    }
    let n_left = cells.len();
    cells.into_iter().cycle().take(if n_left > 0 { count } else { 0 }).collect()
}

/// Of a grid with few cells for each experiment none is run twice as long as there is another.
const CROWDED: u64 = 4;

fn distinct(designs: &Designs, cells: Vec<Cell>, tested: &BTreeSet<Cell>) -> Vec<Cell> {
    if designs.n_cells() > CROWDED * cells.len() as u64 {
        return cells;
    }
    let mut seen: BTreeSet<Cell> = cells.iter().copied().collect();
    let mut once = BTreeSet::new();
    let other = |seen: &BTreeSet<Cell>| designs.cells().find(|cell| !seen.contains(cell) && !tested.contains(cell));
    let one = |cell: Cell| {
        if once.insert(cell) {
            return cell;
        }
        let other = other(&seen).unwrap_or(cell);
        seen.insert(other);
        other
    };
    cells.into_iter().map(one).collect()
}

fn on_few_plants(designs: &Designs, settings: &Settings, cells: Vec<Cell>) -> Vec<Cell> {
    settings.plants.as_ref().map_or_else(|| cells.clone(), |plants| plants.gathered(designs, &cells))
}

/// One of each, as long as there are both.
fn in_turn(a: Vec<Cell>, b: Vec<Cell>) -> Vec<Cell> {
    let (mut a, mut b) = (a.into_iter(), b.into_iter());
    let mut all = Vec::new();
    loop {
        let pair = (a.next(), b.next());
        if pair == (None, None) {
            return all;
        }
        all.extend(pair.0);
        all.extend(pair.1);
    }
}

/// Whether cells keep to all constraints, as far as the simulation knows.
fn within_constraints(
    designs: &Designs,
    settings: &Settings,
    simulated: &Simulated,
    source: &Source<'_>,
    cells: &[Cell],
) -> Result<Vec<bool>, Error> {
    let mut within = vec![true; cells.len()];
    for (index, constraint) in settings.constraints.iter().enumerate() {
        let places = source.known_places(designs, cells, simulated, Column::Constrained(index))?;
        let Some(values) = places.simulated() else { continue };
        within.iter_mut().zip(values).for_each(|(within, &value)| *within &= constraint.allows(value));
    }
    Ok(within)
}

/// The first of the cells, and then always the one that is farthest from all chosen so far.
fn far_apart(designs: &Designs, cells: &[Cell], count: usize) -> Result<Vec<Cell>, Error> {
    let coded: Vec<Vec<f64>> = cells.iter().map(|&cell| designs.coded_of(cell)).collect::<Result<_, _>>()?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pooled::scene::Scene;

    #[test]
    fn of_few_cells_none_is_run_twice_while_there_is_another() {
        let cells = |cells: &[u64]| cells.iter().map(|&cell| Cell::new(cell)).collect::<Vec<_>>();
        let (two, six, none) = (Scene::new(&[2]).designs, Scene::new(&[6]).designs, BTreeSet::new());
        assert_eq!(distinct(&two, cells(&[0, 0]), &none), cells(&[0, 1]));
        assert_eq!(distinct(&two, cells(&[1, 1, 1]), &none), cells(&[1, 0, 1]));
        assert_eq!(distinct(&six, cells(&[2, 5, 2, 5]), &BTreeSet::from([Cell::new(0)])), cells(&[2, 5, 1, 3]));
        assert_eq!(
            distinct(&Scene::new(&[24]).designs, cells(&[7, 7]), &none),
            cells(&[7, 7]),
            "there is room for a repeat"
        );
    }

    #[test]
    fn each_cell_is_the_farthest_from_those_before_it() {
        let line = |cells: &[u64]| cells.iter().map(|&cell| Cell::new(cell)).collect::<Vec<_>>();
        let found = far_apart(&Scene::new(&[21]).designs, &line(&[10, 0, 4, 20, 12]), 4).unwrap();
        assert_eq!(found, line(&[10, 0, 20, 4]), "of equals the first");
        assert_eq!(far_apart(&Scene::new(&[21]).designs, &[], 4).unwrap(), []);
    }
}
