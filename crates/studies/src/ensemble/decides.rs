//! What decides: which property of a plant goes with a claim that holds in some plants and not in others.
//!
//! Rank correlations of a property with the share of a plant's campaigns in which a claim holds. A p-value is the share of random
//! orders of the plants in which the largest correlation of any property looked at is at least as large: with the properties of one
//! claim; and, of that p-value, the share of orders in which any claim has one as small.

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use super::file::Setup;
use super::judge::Judged;
use super::kept::Case;
use super::row::{Study, World};
use crate::correlation::{Centered, ranks};

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

/// The numbers that were free, where the water moves by what the sides differ, and what the model is worth in a study and a world.
pub(super) fn properties(setup: &Setup, cases: &[Case<'_>], study: Study, world: World) -> Vec<Property> {
    let free = setup.keys.iter().enumerate().map(|(k, key)| Property {
        name: format!("`{key}`"),
        values: setup.plants.iter().map(|plant| plant.values[k]).collect(),
    });
    let case = |plant: u64| cases.iter().find(|case| case.study == study && case.world == world && case.plant == plant);
    let mut all: Vec<Property> = free.collect();
    if world == World::Moving {
        let sides: Vec<Vec<(&str, f64)>> = setup.plants.iter().map(|plant| setup.sides(plant.number)).collect();
        let keys = sides.first().into_iter().flatten().map(|(key, _)| *key);
        all.extend(keys.enumerate().map(|(k, key)| Property {
            name: format!("`{key}`, from side to side"),
            values: sides.iter().map(|sides| sides[k].1).collect(),
        }));
    }
    for (name, words) in [
        ("rank_correlation", "rank correlation of model and truth"),
        ("fit_of_61", "R² of (61)"),
        ("fit_of_quadratic", "R² of the full quadratic"),
    ] {
        let value = |plant: u64| case(plant).and_then(|case| case.fact(name)).unwrap_or(f64::NAN);
        let values = setup.plants.iter().map(|plant| value(plant.number)).collect();
        all.push(Property { name: words.to_owned(), values });
    }
    let better =
        |plant: u64| case(plant).and_then(|case| Some(case.random_better(case.numerical()?))).unwrap_or(f64::NAN);
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
    properties: Vec<Centered>,
    shares: Vec<f64>,
    /// Places of its plants among all.
    plants: Vec<usize>,
}

impl Looked {
    fn new(setup: &Setup, judged: &Judged, properties: &[Property]) -> Option<Self> {
        let place = |number: u64| setup.plants.iter().position(|plant| plant.number == number);
        let (plants, shares): (Vec<usize>, Vec<f64>) =
            judged.shares.iter().filter_map(|share| Some((place(share.plant)?, share.count.share()))).unzip();
        let high = shares.iter().filter(|share| **share > 0.5).count();
        if high < FEWEST || shares.len() - high < FEWEST {
            return None;
        }
        let whole = properties.iter().filter(|property| plants.iter().all(|k| property.values[*k].is_finite()));
        let (names, properties) = whole
            .map(|property| {
                let values: Vec<f64> = plants.iter().map(|k| property.values[*k]).collect();
                (property.name.clone(), Centered::of(&ranks(&values)))
            })
            .unzip();
        Some(Self { names, properties, shares: ranks(&shares), plants })
    }

    /// The largest correlation by magnitude, and its property, with the shares in another order of the plants.
    fn largest(&self, order: &[usize]) -> (usize, f64) {
        // Of an order of all plants that of these.
        let mut own: Vec<usize> = (0..self.plants.len()).collect();
        own.sort_by_key(|k| order[self.plants[*k]]);
        let shares = Centered::of(&own.iter().map(|k| self.shares[*k]).collect::<Vec<_>>());
        let all = self.properties.iter().map(|property| property.correlation(&shares)).enumerate();
        all.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0))
    }
}

/// What goes with each claim; none where there are too few plants on one side.
pub(super) fn decide(setup: &Setup, judged: &[(&Judged, &[Property])]) -> Vec<Option<Decided>> {
    let looked: Vec<Option<Looked>> =
        judged.iter().map(|(judged, properties)| Looked::new(setup, judged, properties)).collect();
    let same: Vec<usize> = (0..setup.plants.len()).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut order = same.clone();
    let mut orders = vec![same.clone()];
    for _ in 0..N_ORDERS {
        order.shuffle(&mut rng);
        orders.push(order.clone());
    }
    // Of each claim, the largest correlation in every order; the first is the true one.
    let largest: Vec<Option<Vec<f64>>> = looked
        .iter()
        .map(|one| one.as_ref().map(|one| orders.iter().map(|order| one.largest(order).1.abs()).collect()))
        .collect();
    let p: Vec<Option<Vec<f64>>> = largest.iter().map(|values| values.as_deref().map(shares_as_large)).collect();
    let least: Vec<f64> = (0..orders.len()).map(|k| p.iter().flatten().map(|p| p[k]).fold(1.0, f64::min)).collect();
    let decided = looked.iter().zip(&p).map(|(looked, p)| {
        let (looked, p) = (looked.as_ref()?, p.as_ref()?);
        let (property, correlation) = looked.largest(&same);
        let as_small = least.iter().filter(|least| **least <= p[0] + 1e-12).count();
        let p_of_all = as_small as f64 / least.len() as f64;
        Some(Decided { property: looked.names.get(property)?.clone(), correlation, p: p[0], p_of_all })
    });
    decided.collect()
}

/// For each value the share of all that are at least as large.
fn shares_as_large(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let smaller = |value: f64| sorted.partition_point(|other| *other < value - 1e-12);
    values.iter().map(|value| (values.len() - smaller(*value)) as f64 / values.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::judge::Share;
    use crate::rules::Count;

    fn setup() -> Setup {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        Setup::read(&root).expect("the ensemble")
    }

    fn judged(setup: &Setup, holds: impl Fn(usize) -> bool) -> Judged {
        let share = |(k, plant): (usize, &crate::calibration::Plant)| Share {
            chance: None,
            plant: plant.number,
            count: Count { holding: if holds(k) { 5 } else { 0 }, cases: 5 },
        };
        let shares = setup.plants.iter().enumerate().map(share).collect();
        Judged { shares, by_rule: None }
    }

    #[test]
    fn a_property_that_decides_is_found_and_one_that_does_not_is_not_significant() {
        let setup = setup();
        let all = properties(&setup, &[], Study::Two, World::Still);
        let mut values: Vec<f64> = all[3].values.clone();
        values.sort_by(f64::total_cmp);
        let middle = values[values.len() / 2];
        let decided = judged(&setup, |k| all[3].values[k] < middle);
        let alternating = judged(&setup, |k| k % 2 == 0);
        let rare = judged(&setup, |k| k < 2);
        let found = decide(&setup, &[(&decided, &all), (&alternating, &all), (&rare, &all)]);
        let first = found[0].as_ref().expect("half of the plants");
        assert_eq!(first.property, all[3].name);
        assert!(first.correlation < -0.8 && first.p <= 0.002 && first.p_of_all <= 0.01, "{first:?}");
        let second = found[1].as_ref().expect("half of the plants");
        assert!(second.p > 0.05 && second.p_of_all >= second.p, "{second:?}");
        assert!(found[2].is_none(), "two plants decide nothing");
    }

    #[test]
    fn shares_count_from_above() {
        assert_eq!(shares_as_large(&[3.0, 1.0, 2.0, 2.0]), [0.25, 1.0, 0.75, 0.75]);
    }
}
