//! What decides: which property of a plant goes with a claim that holds in some plants and not in others.
//!
//! Rank correlations of a property with the share of a plant's campaigns in which a claim holds. A p-value is the share of random
//! orders of the plants in which the largest correlation of any property looked at is at least as large: with the properties of one
//! claim, and with those of all claims (the largest of all, in one order for all).

use rand::seq::SliceRandom as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::file::Setup;
use super::judge::Judged;
use super::kept::Case;
use super::row::{Study, World};
use crate::calibration::{correlation, ranks};

/// Random orders of the plants.
pub(super) const N_ORDERS: usize = 999;
const SEED: u64 = 1;
/// Fewer plants than these on one side decide nothing.
const FEWEST: usize = 3;

/// A property of all plants, in their order.
pub(super) struct Property {
    pub(super) name: String,
    values: Vec<f64>,
}

/// The numbers that were free, and what the model is worth in a study and a world.
pub(super) fn properties(setup: &Setup, cases: &[Case<'_>], study: Study, world: World) -> Vec<Property> {
    let free = setup.keys.iter().enumerate().map(|(k, key)| Property {
        name: format!("`{key}`"),
        values: setup.plants.iter().map(|plant| plant.values[k]).collect(),
    });
    let case = |plant: u64| {
        cases.iter().find(|case| case.study == study && case.world == world && case.plant == plant)
    };
    let mut all: Vec<Property> = free.collect();
    for (name, words) in [
        ("rank_correlation", "rank correlation of model and truth"),
        ("fit_of_61", "R² of (61)"),
        ("fit_of_quadratic", "R² of the full quadratic"),
    ] {
        let value = |plant: u64| case(plant).and_then(|case| case.fact(name)).unwrap_or(f64::NAN);
        let values = setup.plants.iter().map(|plant| value(plant.number)).collect();
        all.push(Property { name: words.to_owned(), values });
    }
    let better = |plant: u64| {
        case(plant).and_then(|case| Some(case.random_better(case.numerical()?))).unwrap_or(f64::NAN)
    };
    all.push(Property {
        name: "share of random designs better than the model's optimum".to_owned(),
        values: setup.plants.iter().map(|plant| better(plant.number)).collect(),
    });
    all
}

/// What goes with one claim.
#[derive(Clone, Debug)]
pub(super) struct Decided {
    pub(super) property: String,
    pub(super) correlation: f64,
    /// With all properties of this claim.
    pub(super) p: f64,
    /// With those of all claims.
    pub(super) p_of_all: f64,
}

/// Properties and shares of a claim over the plants that have both, as ranks.
struct Looked {
    names: Vec<String>,
    properties: Vec<Vec<f64>>,
    shares: Vec<f64>,
    /// Places of its plants among all.
    plants: Vec<usize>,
}

impl Looked {
    fn new(setup: &Setup, judged: &Judged, properties: &[Property]) -> Option<Self> {
        let place = |number: u64| setup.plants.iter().position(|plant| plant.number == number);
        let (plants, shares): (Vec<usize>, Vec<f64>) =
            judged.shares.iter().filter_map(|share| Some((place(share.plant)?, share.value()))).unzip();
        let high = shares.iter().filter(|share| **share > 0.5).count();
        if high < FEWEST || shares.len() - high < FEWEST {
            return None;
        }
        let whole = properties.iter().filter(|property| plants.iter().all(|k| property.values[*k].is_finite()));
        let (names, properties) = whole
            .map(|property| {
                let values: Vec<f64> = plants.iter().map(|k| property.values[*k]).collect();
                (property.name.clone(), ranks(&values))
            })
            .unzip();
        Some(Self { names, properties, shares: ranks(&shares), plants })
    }

    /// The largest correlation by magnitude, and its property, with the shares in another order of the plants.
    fn largest(&self, order: &[usize]) -> (usize, f64) {
        // Of an order of all plants that of these.
        let mut own: Vec<usize> = (0..self.plants.len()).collect();
        own.sort_by_key(|k| order[self.plants[*k]]);
        let shares: Vec<f64> = own.iter().map(|k| self.shares[*k]).collect();
        let all = self.properties.iter().map(|property| correlation(property, &shares)).enumerate();
        all.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0))
    }
}

/// What goes with each claim; none where there are too few plants on one side.
pub(super) fn decide(setup: &Setup, judged: &[(&Judged, &[Property])]) -> Vec<Option<Decided>> {
    let looked: Vec<Option<Looked>> =
        judged.iter().map(|(judged, properties)| Looked::new(setup, judged, properties)).collect();
    let same: Vec<usize> = (0..setup.plants.len()).collect();
    let found: Vec<Option<(usize, f64)>> = looked.iter().map(|one| one.as_ref().map(|one| one.largest(&same))).collect();
    let (mut own, mut all) = (vec![0; looked.len()], vec![0; looked.len()]);
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut order = same;
    for _ in 0..N_ORDERS {
        order.shuffle(&mut rng);
        let by_chance: Vec<f64> =
            looked.iter().map(|one| one.as_ref().map_or(0.0, |one| one.largest(&order).1.abs())).collect();
        let largest = by_chance.iter().copied().fold(0.0, f64::max);
        for (k, found) in found.iter().enumerate() {
            let Some((_, value)) = found else { continue };
            own[k] += usize::from(by_chance[k] >= value.abs() - 1e-12);
            all[k] += usize::from(largest >= value.abs() - 1e-12);
        }
    }
    let p = |count: usize| (count + 1) as f64 / (N_ORDERS + 1) as f64;
    let decided = looked.iter().zip(found).enumerate().map(|(k, (looked, found))| {
        let (property, correlation) = found?;
        let property = looked.as_ref()?.names.get(property)?.clone();
        Some(Decided { property, correlation, p: p(own[k]), p_of_all: p(all[k]) })
    });
    decided.collect()
}
