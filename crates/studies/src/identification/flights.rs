//! What a flight cost, term by term: each pair of unknowns and a design is flown once.

use water_channel::CostBreakdown;

use crate::known::Known;

/// The cost of a flight, term by term, or why there is none.
pub(super) type Flown = Result<CostBreakdown, String>;

/// Unknowns of the model, and a design; without unknowns it is the stand-in that flies.
pub(super) type Pair<'a> = (&'a [f64], &'a [f64]);

/// The flights that are known, by the bits of both. Those of one study: of other files nothing is known.
#[derive(Debug, Default)]
pub(super) struct Flights(Known<[Vec<u64>; 2], Flown>);

fn bits((unknowns, design): Pair<'_>) -> [Vec<u64>; 2] {
    [unknowns, design].map(|values| values.iter().map(|x| x.to_bits()).collect())
}

impl Flights {
    /// Those of all pairs: what is not known, each pair once, by `fly`.
    pub(super) fn of(&self, pairs: &[Pair<'_>], fly: impl FnOnce(&[Pair<'_>]) -> Vec<Flown>) -> Vec<Flown> {
        let keys: Vec<[Vec<u64>; 2]> = pairs.iter().map(|pair| bits(*pair)).collect();
        self.0.of(&keys, |missing| fly(&missing.iter().map(|k| pairs[*k]).collect::<Vec<_>>()))
    }

    /// Knows this flight from now on, which somebody else flew.
    pub(super) fn know(&self, pair: Pair<'_>, flown: Flown) {
        self.0.know(bits(pair), flown);
    }

    /// How many were flown, and not known from somebody else.
    pub(super) fn n_flown(&self) -> usize {
        self.0.n_made()
    }

    /// All that are known, with unknowns and design, in an order that does not depend on who flew first.
    pub(super) fn all(&self) -> Vec<([Vec<f64>; 2], Flown)> {
        let floats = |bits: Vec<u64>| bits.into_iter().map(f64::from_bits).collect();
        self.0.all().into_iter().map(|(key, flown)| (key.map(floats), flown)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_is_flown_once_and_told_from_all_others() {
        let flights = Flights::default();
        let flown = |pairs: &[Pair<'_>]| -> Vec<Flown> {
            pairs.iter().map(|(unknowns, design)| Err(format!("{unknowns:?} {design:?}"))).collect()
        };
        let pairs: [Pair<'_>; 4] = [(&[], &[3.0]), (&[1.0], &[2.0]), (&[1.0], &[3.0]), (&[1.0, 2.0], &[3.0])];
        let [d, a, b, c] = pairs;
        assert_eq!(flights.of(&[a, b, a], flown), flown(&[a, b, a]));
        let second = flights.of(&[c, b], |pairs| {
            assert_eq!(pairs, [c]);
            flown(pairs)
        });
        assert_eq!(second, flown(&[c, b]));
        flights.know(d, Err("of old".to_owned()));
        assert_eq!(
            flights.of(&[d, b], |_| panic!("all are known")),
            [Err("of old".to_owned()), flown(&[b])[0].clone()]
        );
        let all: Vec<[Vec<f64>; 2]> = flights.all().into_iter().map(|(pair, _)| pair).collect();
        assert_eq!(all, pairs.map(|(unknowns, design)| [unknowns, design].map(<[f64]>::to_vec)));
        assert_eq!(flights.n_flown(), 3);
    }
}
