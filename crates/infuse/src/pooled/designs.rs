//! The designs that a campaign chooses from: cells of a grid, however many.

use design_space::{Cell, Combinations, Grid, Levels, Parameter, Region};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use surface::process::Places;

use crate::Error;
use crate::pooled::constraint::LinearConstraint;

/// All designs: combinations of levels that keep to the linear constraints. A parameter without levels has as many as make no
/// difference.
#[derive(Debug, Clone)]
pub(crate) struct Designs {
    region: Region,
    grid: Grid,
    constraints: Vec<LinearConstraint>,
    /// A design that keeps to them.
    allowed: Cell,
    /// As many do, counted where they are few; as if all did otherwise.
    n_allowed: u64,
}

/// A design that keeps to the constraints is drawn so many times before one is built.
const DRAWN: usize = 50;
/// So many are built at most: the nearest point that keeps to them, and a level below or above.
const BUILT: usize = 2000;
/// Steps from constraint to constraint.
const PROJECTIONS: usize = 200;

impl Designs {
    /// Levels along a continuous parameter: steps of a thousandth of its width, or of the first of these shares with which all
    /// designs can be counted.
    pub(crate) const FINE: [u32; 7] = [1001, 501, 201, 101, 51, 21, 11];

    pub(crate) fn of(region: &Region, constraints: &[LinearConstraint], rng: &mut ChaCha8Rng) -> Result<Self, Error> {
        let with = |fine: u32| -> Result<Grid, Error> {
            let finely = |parameter: &Parameter| match parameter.levels() {
                Levels::Count(_) => Ok(parameter.clone()),
                Levels::Continuous => parameter.clone().with_levels(fine),
            };
            let parameters = region.parameters().iter().map(finely).collect::<Result<_, _>>()?;
            Ok(Grid::of(&Region::new(parameters)?)?)
        };
        let [finest, coarser @ ..] = Self::FINE;
        // The first refusal names what a person may change.
        let grid = with(finest).or_else(|error| coarser.into_iter().find_map(|fine| with(fine).ok()).ok_or(error))?;
        let n_allowed = grid.n_cells();
        let mut designs =
            Self { region: region.clone(), grid, constraints: Vec::new(), allowed: Cell::new(0), n_allowed };
        designs.keep_to(constraints, rng)?;
        Ok(designs)
    }

    /// The same designs but for those that break one of these constraints.
    pub(crate) fn keep_to(&mut self, constraints: &[LinearConstraint], rng: &mut ChaCha8Rng) -> Result<(), Error> {
        let next = Self { constraints: constraints.to_vec(), ..self.clone() };
        let small = self.n_cells() <= 100_000;
        let found = if small { next.cells().next() } else { next.draw(rng).or_else(|| next.build(rng)) };
        let Some(allowed) = found else {
            return Err(Error::NoDesignAllowed { n_constraints: constraints.len() });
        };
        let are_counted = small && !constraints.is_empty();
        let n_allowed = if are_counted { next.cells().count() as u64 } else { self.n_cells() };
        *self = Self { allowed, n_allowed, ..next };
        Ok(())
    }

    pub(crate) fn region(&self) -> &Region {
        &self.region
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Coordinates of a place: one per number, and for a choice one for each way to choose, where there are more than two.
    pub(crate) fn n_factors(&self) -> usize {
        self.region.parameters().iter().map(n_axes).sum()
    }

    /// The coordinates of a place that belong to some parameters.
    pub(crate) fn axes_of(&self, parameters: &[usize]) -> Vec<usize> {
        let of_each = self.region.parameters().iter().enumerate();
        let owners: Vec<usize> = of_each.flat_map(|(index, one)| std::iter::repeat_n(index, n_axes(one))).collect();
        (0..owners.len()).filter(|&axis| parameters.contains(&owners[axis])).collect()
    }

    /// Readings that it takes to tell a plane from its noise.
    pub(crate) fn n_to_tell(&self) -> usize {
        self.n_factors() + 2
    }

    /// Readings before which nothing is promised: three more than a plane has terms. With one or two more, what they differ by beside it is
    /// as likely as not a small part of their noise.
    pub(crate) fn n_to_promise(&self) -> usize {
        self.n_factors() + 4
    }

    /// Terms of a full quadratic: the mean, one effect per number and one less than ways per choice, products of two of
    /// different parameters, squares of numbers.
    pub(crate) fn n_terms(&self) -> usize {
        let effects: Vec<usize> = self.region.parameters().iter().map(n_effects).collect();
        let all: usize = effects.iter().sum();
        let products = (all * all - effects.iter().map(|n| n * n).sum::<usize>()) / 2;
        let squares = self.region.parameters().iter().filter(|parameter| parameter.choices().is_none()).count();
        1 + all + products + squares
    }

    /// Whether there are no more designs than a quadratic has terms: it fits whatever they read, and none lies between others.
    pub(crate) fn are_few(&self) -> bool {
        self.n_allowed() <= self.n_terms() as u64
    }

    pub(crate) fn n_cells(&self) -> u64 {
        self.grid.n_cells()
    }

    /// Those of them that keep to the constraints, counted where they are few; as if all did otherwise.
    pub(crate) fn n_allowed(&self) -> u64 {
        self.n_allowed
    }

    pub(crate) fn combinations(&self) -> &Combinations {
        self.grid.combinations()
    }

    /// Whether a cell keeps to the linear constraints.
    pub(crate) fn allows(&self, cell: Cell) -> bool {
        self.constraints.is_empty() || self.grid.point(cell).is_ok_and(|point| self.allows_point(&point))
    }

    fn allows_point(&self, point: &[f64]) -> bool {
        self.constraints.iter().all(|constraint| constraint.allows(point))
    }

    /// All cells that keep to the linear constraints, in order.
    pub(crate) fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.grid.cells().filter(|&cell| self.allows(cell))
    }

    /// Coordinates of a cell.
    pub(crate) fn coded_of(&self, cell: Cell) -> Result<Vec<f64>, Error> {
        let coded = self.grid.coded(cell)?;
        if !self.has_choices() {
            return Ok(coded);
        }
        Ok(self.apart(&self.grid.point(cell)?, coded))
    }

    /// Coordinates of a natural point, on the grid or off it.
    pub(crate) fn coded_point(&self, point: &[f64]) -> Result<Vec<f64>, Error> {
        Ok(self.apart(point, self.region.coded(point)?))
    }

    /// A choice has no order: each of more than two lies as far from any other as from the next.
    fn apart(&self, point: &[f64], coded: Vec<f64>) -> Vec<f64> {
        let of_each = self.region.parameters().iter().zip(point.iter().zip(coded));
        let axes = of_each.flat_map(|(parameter, (&natural, coded))| match n_axes(parameter) {
            1 => vec![coded],
            count => (0..count).map(|place| if (place as f64 - natural).abs() < 0.5 { 1.0 } else { -1.0 }).collect(),
        });
        axes.collect()
    }

    fn has_choices(&self) -> bool {
        self.region.parameters().iter().any(|parameter| parameter.choices().is_some())
    }

    /// Coordinates of cells, row by row.
    pub(crate) fn coded(&self, cells: &[Cell]) -> Result<Vec<f64>, Error> {
        let mut coordinates = Vec::with_capacity(cells.len() * self.n_factors());
        for &cell in cells {
            coordinates.extend(self.coded_of(cell)?);
        }
        Ok(coordinates)
    }

    /// Cells as places, without a simulation.
    pub(crate) fn places(&self, cells: &[Cell]) -> Result<Places, Error> {
        Ok(Places::new(self.n_factors(), &self.coded(cells)?)?)
    }

    /// The cell in which a point of the unit cube lies.
    pub(crate) fn cell_of_unit(&self, unit: impl Iterator<Item = f64>) -> Cell {
        let digits: Vec<u64> = self
            .combinations()
            .counts()
            .iter()
            .zip(unit)
            .map(|(&count, u)| ((u * count as f64) as u64).min(count - 1))
            .collect();
        Cell::new(self.combinations().index(&digits))
    }

    /// A cell drawn evenly; where few keep to the constraints, one that does.
    pub(crate) fn random(&self, rng: &mut ChaCha8Rng) -> Cell {
        self.draw(rng).or_else(|| self.build(rng)).unwrap_or(self.allowed)
    }

    /// A cell drawn evenly, unless most break a constraint.
    fn draw(&self, rng: &mut ChaCha8Rng) -> Option<Cell> {
        let drawn = (0..DRAWN).map(|_| Cell::new(rng.random_range(0..self.n_cells())));
        drawn.into_iter().find(|&cell| self.allows(cell))
    }

    /// A cell at a point that was moved onto the constraints that it broke (Kaczmarz' projections).
    fn build(&self, rng: &mut ChaCha8Rng) -> Option<Cell> {
        let widths: Vec<f64> = self.region.parameters().iter().map(Parameter::width).collect();
        (0..BUILT).find_map(|_| {
            let mut point: Vec<f64> =
                self.region.parameters().iter().map(|p| p.lower() + p.width() * rng.random::<f64>()).collect();
            for step in 0..PROJECTIONS {
                let constraint = &self.constraints[step % self.constraints.len()];
                let excess = constraint.excess(&point);
                let square: f64 = constraint.coefficients.iter().zip(&widths).map(|(c, w)| (c * w).powi(2)).sum();
                if excess > 0.0 && square > 0.0 {
                    for ((x, c), (w, p)) in
                        point.iter_mut().zip(&constraint.coefficients).zip(widths.iter().zip(self.region.parameters()))
                    {
                        *x = (*x - excess * c * w * w / square).clamp(p.lower(), p.upper());
                    }
                }
            }
            // Drawn between two choices as well, so it is moved to one of them.
            let middle = self.combinations().digits(self.grid.nearest_clamped(&point).ok()?.index());
            let near = (0..DRAWN).map(|_| {
                let step = |(&digit, &count): (&u64, &u64)| {
                    (digit + rng.random_range(0..3_u64)).saturating_sub(1).min(count - 1)
                };
                let digits: Vec<u64> = middle.iter().zip(self.combinations().counts()).map(step).collect();
                Cell::new(self.combinations().index(&digits))
            });
            near.collect::<Vec<_>>().into_iter().find(|&cell| self.allows(cell))
        })
    }

    /// A cell some steps away: every digit moves by up to `share` of its axis, at least one step for some; one choice in three is
    /// made anew.
    pub(crate) fn near(&self, cell: Cell, share: f64, rng: &mut ChaCha8Rng) -> Cell {
        for _ in 0..DRAWN {
            let mut digits = self.combinations().digits(cell.index());
            let counts = self.combinations().counts().iter().zip(self.region.parameters());
            for (digit, (&count, parameter)) in digits.iter_mut().zip(counts) {
                if parameter.choices().is_some() {
                    if rng.random::<f64>() < 1.0 / 3.0 {
                        *digit = rng.random_range(0..count);
                    }
                    continue;
                }
                let reach = ((count - 1) as f64 * share).max(1.0);
                let step = (reach * (2.0 * rng.random::<f64>() - 1.0)).round();
                *digit = (*digit as f64 + step).clamp(0.0, (count - 1) as f64) as u64;
            }
            let near = Cell::new(self.combinations().index(&digits));
            if self.allows(near) {
                return near;
            }
        }
        cell
    }

    /// The cells that differ from this one by `stride` steps along one axis, for each axis and both directions, or by any other
    /// choice; those that keep to the constraints.
    pub(crate) fn star(&self, cell: Cell, shares: f64) -> Vec<Cell> {
        let digits = self.combinations().digits(cell.index());
        let mut star = Vec::with_capacity(2 * digits.len());
        let counts = self.combinations().counts().iter().zip(self.region.parameters());
        for (axis, (&count, parameter)) in counts.enumerate() {
            let stride = (((count - 1) as f64 * shares).round() as u64).max(1);
            let mut push = |digit: u64| {
                if digit != digits[axis] {
                    let mut moved = digits.clone();
                    moved[axis] = digit;
                    star.push(Cell::new(self.combinations().index(&moved)));
                }
            };
            if parameter.choices().is_some() {
                (0..count).for_each(push);
            } else {
                push(digits[axis].saturating_sub(stride));
                push((digits[axis] + stride).min(count - 1));
            }
        }
        star.retain(|&cell| self.allows(cell));
        star
    }

    /// Whether designs are confined by more than their bounds.
    pub(crate) fn is_confined(&self) -> bool {
        !self.constraints.is_empty()
    }
}

fn n_effects(parameter: &Parameter) -> usize {
    parameter.choices().map_or(1, |choices| choices.len() - 1)
}

/// A choice of more than two has an axis for each.
fn n_axes(parameter: &Parameter) -> usize {
    match parameter.choices().map(<[String]>::len) {
        None | Some(2) => 1,
        Some(count) => count,
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    fn numbers(count: usize, levels: u32) -> Region {
        let number = |index: usize| {
            let number = Parameter::continuous(format!("x{index}"), "1", 0.0, 1.0).expect("a number");
            number.with_levels(levels).expect("levels")
        };
        Region::new((0..count).map(number).collect()).expect("a region")
    }

    /// Of 21^6 designs one in 2e5 has a sum of 5.7 or more: they are built, and many different ones.
    #[test]
    fn designs_in_a_far_corner_are_built_not_drawn() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let corner = LinearConstraint::at_least(&[1.0; 6], 5.7);
        let designs = Designs::of(&numbers(6, 21), &[corner], &mut rng).expect("some are in the corner");
        let found: std::collections::BTreeSet<Cell> = (0..50).map(|_| designs.random(&mut rng)).collect();
        assert!(found.iter().all(|&cell| designs.allows(cell)), "{found:?}");
        assert!(found.len() >= 10, "only {} different ones", found.len());
    }

    /// A tenth of 21 levels is two steps; a share of nothing still is one.
    #[test]
    fn neighbors_are_within_the_share_of_their_axes() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let designs = Designs::of(&numbers(2, 21), &[], &mut rng).expect("designs");
        for (share, reach) in [(0.1, 2), (0.0, 1)] {
            let middle = designs.combinations().index(&[12, 7]);
            let mut seen = std::collections::BTreeSet::new();
            for _ in 0..400 {
                let digits = designs.combinations().digits(designs.near(Cell::new(middle), share, &mut rng).index());
                let steps = [digits[0] as i64 - 12, digits[1] as i64 - 7];
                assert!(steps.iter().all(|step| step.abs() <= reach), "{steps:?} for {share}");
                seen.insert(steps);
            }
            assert_eq!(seen.len() as i64, (2 * reach + 1).pow(2), "all steps come");
        }
    }

    /// Two choices have as many terms as pairs; numbers those of (K + 1)(K + 2)/2.
    #[test]
    fn terms_are_those_of_a_full_quadratic() {
        let number = |name: &str| Parameter::continuous(name, "1", -1.0, 1.0)?.with_levels(5);
        let choice =
            |name: &str, count: usize| Parameter::categorical(name, (0..count).map(|way| format!("way {way}")));
        let terms = |parameters| {
            let region = Region::new(parameters).expect("a region");
            Designs::of(&region, &[], &mut ChaCha8Rng::seed_from_u64(1)).expect("designs").n_terms()
        };
        let numbers = |count: usize| (0..count).map(|k| number(&format!("x{k}")).expect("a number"));
        for count in 1..7 {
            assert_eq!(terms(numbers(count).collect()), (count + 1) * (count + 2) / 2);
        }
        for (a, b) in [(2, 2), (2, 3), (5, 4)] {
            assert_eq!(terms(vec![choice("a", a).expect("ways"), choice("b", b).expect("ways")]), a * b);
        }
        // 1; a, b; x; ax, bx; x².
        assert_eq!(terms(vec![choice("a", 3).expect("ways"), number("x").expect("a number")]), 7);
    }
}
