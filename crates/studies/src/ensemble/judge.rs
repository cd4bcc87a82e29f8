//! What became of each claim over all plants, in a world, by the rules of all pages.

use super::claims::{Claim, JUDGED, Test};
use super::facts::N_SEARCHES;
use super::kept::Case;
use super::row::{Fact, Method, Row, World};
use crate::rules::{Count, Judged as ByRule, Standing, Verdict};
use crate::words::{PLANTS, counted};

/// A plant by its number, and in how many of its campaigns a claim holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    pub(super) plant: u64,
    pub(super) count: Count,
    /// In what share of the designs that nobody chose it would hold.
    pub(super) chance: Option<f64>,
}

/// What became of a claim in a world.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// Plants with at least one campaign; none where a claim knows no plant.
    pub(super) shares: Vec<Share>,
    /// Over all campaigns of all plants; none where there are none, or where it is not asked in this world.
    pub(super) by_rule: Option<ByRule>,
}

impl Judged {
    fn of(shares: Vec<Share>, standing: Standing) -> Self {
        let sum = |of: fn(&Share) -> usize| shares.iter().map(of).sum();
        let count = Count { holding: sum(|share| share.count.holding), cases: sum(|share| share.count.cases) };
        let chances: Vec<f64> = shares.iter().filter_map(|share| share.chance).collect();
        let by_chance = (!chances.is_empty()).then(|| chances.iter().sum::<f64>() / chances.len() as f64);
        let by_rule = (count.cases > 0).then(|| ByRule { by_chance, ..ByRule::of(count, standing) });
        Self { shares, by_rule }
    }

    /// By cases that know no plant.
    fn without_plants(count: Count, standing: Standing) -> Self {
        Self { shares: Vec::new(), by_rule: (count.cases > 0).then(|| ByRule::of(count, standing)) }
    }

    /// The same judged on these plants alone.
    pub(super) fn among(&self, plants: &[u64]) -> Self {
        let shares = self.shares.iter().copied().filter(|share| plants.contains(&share.plant)).collect();
        match self.by_rule {
            Some(judged) => Self::of(shares, judged.standing),
            None => Self { shares, by_rule: None },
        }
    }

    /// The same claim judged on other plants alone: what some design meets on any plant of both is within reach on all.
    pub(super) fn on(&self, others: &Self) -> Self {
        let standings = [self, others].map(|judged| judged.by_rule.map(|judged| judged.standing));
        match standings {
            [Some(Standing::OutOfReach), Some(standing)] | [Some(standing), Some(_)] => {
                Self::of(others.shares.clone(), standing)
            }
            _ => Self { shares: others.shares.clone(), by_rule: None },
        }
    }

    pub(super) fn verdict(&self) -> Option<Verdict> {
        self.by_rule.map(|judged| judged.verdict())
    }

    pub(super) fn is(&self, verdict: Verdict) -> bool {
        self.verdict() == Some(verdict)
    }

    /// Plants of which the word "in kind" is true by the same rule.
    pub(super) fn n_holding(&self) -> usize {
        self.shares.iter().filter(|share| share.count.most()).count()
    }

    /// In how many plants and campaigns, and by chance; none where it is not judged.
    pub(super) fn words(&self) -> Option<String> {
        let by_rule = self.by_rule?;
        let count = by_rule.count;
        let plants = format!("{} of {}", self.n_holding(), counted(self.shares.len(), PLANTS));
        let counts = if self.shares.is_empty() {
            format!("{count} cases")
        } else if count.cases == self.shares.len() {
            plants
        } else {
            format!("{plants}, {count} campaigns")
        };
        Some(format!("{counts}{}{}", by_rule.chance_words(), by_rule.tie_words()))
    }
}

/// What became of a claim in a world, from the cases of plants or, where it knows no plant, from the searches for designs.
pub(super) fn judge(claim: &Claim, world: World, cases: &[Case<'_>], searches: &[&Fact]) -> Judged {
    let by = claim.judged_by(world);
    if let Test::Search(test) = &claim.test {
        let seeds = by.into_iter().flat_map(|_| 1..=N_SEARCHES);
        let count = Count::of(seeds.filter_map(|seed| test(searches, seed)));
        return Judged::without_plants(count, claim.standing_in(world));
    }
    let mine = || cases.iter().filter(|case| case.study == claim.study && Some(case.world) == by);
    let shares = mine().filter_map(|case| {
        let (outcomes, chance) = outcomes(claim, case);
        (!outcomes.is_empty()).then(|| Share { plant: case.plant, count: Count::of(outcomes), chance })
    });
    let is_within_reach = claim.of_a_place || mine().any(|case| is_within_reach(claim, case));
    let standing = if is_within_reach { claim.standing_in(world) } else { Standing::OutOfReach };
    Judged::of(shares.collect(), standing)
}

/// Whether any design that was tried on a plant, by whatever method, meets a claim about designs; others are not asked.
fn is_within_reach(claim: &Claim, case: &Case<'_>) -> bool {
    let anybody = |before: &Row, test: &dyn Fn(&Row, &Row) -> bool| case.rows.iter().any(|row| test(before, row));
    match &claim.test {
        Test::End(test) => case.numerical().is_some_and(|before| anybody(before, test)),
        Test::SinceFirst(test) => {
            paths(case).iter().filter_map(|path| path.first()).any(|before| anybody(before, test))
        }
        Test::Path(_) | Test::Kept | Test::Seed(_) | Test::Search(_) | Test::Plant(_) => true,
    }
}

/// Campaign by campaign whether a claim holds, and by chance: for how many of the designs that nobody chose it would, or for how many
/// blind draws of as many cells as are left.
fn outcomes(claim: &Claim, case: &Case<'_>) -> (Vec<bool>, Option<f64>) {
    let paths = paths(case);
    let random = case.random();
    let chance = |before: &Row, test: &dyn Fn(&Row, &Row) -> bool| {
        random.iter().filter(|row| test(before, row)).count() as f64 / random.len().max(1) as f64
    };
    let mean = |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    match &claim.test {
        Test::End(test) => {
            let Some(before) = case.numerical() else { return (Vec::new(), None) };
            let ends = paths.iter().filter_map(|path| path.last());
            (ends.map(|after| test(before, after)).collect(), Some(chance(before, test)))
        }
        Test::SinceFirst(test) => {
            let pairs: Vec<(&Row, &Row)> =
                paths.iter().filter_map(|path| Some((*path.first()?, *path.last()?))).collect();
            let chances: Vec<f64> = pairs.iter().map(|(before, _)| chance(before, test)).collect();
            (pairs.into_iter().map(|(before, after)| test(before, after)).collect(), mean(&chances))
        }
        Test::Path(test) => (paths.iter().map(|path| test(case, path)).collect(), None),
        Test::Kept => {
            let ends: Vec<&Row> = paths.iter().filter_map(|path| path.last().copied()).collect();
            let left: Vec<f64> = ends.iter().map(|row| row.share).collect();
            (ends.iter().map(|row| row.keeps_best > 0.5).collect(), mean(&left))
        }
        Test::Seed(test) => (case.seeds(JUDGED).into_iter().filter_map(|seed| test(case, seed)).collect(), None),
        Test::Search(_) => (Vec::new(), None),
        Test::Plant(test) => (test(case).into_iter().collect(), None),
    }
}

/// The campaigns that are judged.
fn paths<'a>(case: &Case<'a>) -> Vec<Vec<&'a Row>> {
    case.seeds(JUDGED).into_iter().map(|seed| case.path(JUDGED, seed)).collect()
}

/// In how many cases the ends of another method meet a claim about the ends of the loop; none of other claims.
pub(super) fn met_by(claim: &Claim, method: Method, world: World, cases: &[Case<'_>]) -> Option<Count> {
    let mine = cases.iter().filter(|case| case.study == claim.study && Some(case.world) == claim.judged_by(world));
    let mut outcomes = Vec::new();
    for case in mine {
        match &claim.test {
            Test::End(test) => {
                let before = case.numerical()?;
                outcomes.extend(case.ends(method).into_iter().map(|end| test(before, end)));
            }
            Test::SinceFirst(test) => {
                for path in paths(case) {
                    let Some(before) = path.first() else { continue };
                    // Methods with campaigns of their own: each beside the campaign of the same seed.
                    let mut ends = case.ends(method);
                    if method.has_seeds() {
                        ends.retain(|end| end.seed == before.seed);
                    }
                    outcomes.extend(ends.into_iter().map(|end| test(before, end)));
                }
            }
            _ => return None,
        }
    }
    (!outcomes.is_empty()).then(|| Count::of(outcomes))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::claims::Place;
    use crate::ensemble::claims;
    use crate::ensemble::file::Setup;
    use crate::ensemble::row::{N_READINGS, Reading, Study};

    fn claim(place: &Place, study: Study) -> Claim {
        let setup = Setup::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).expect("the ensemble");
        let mut all = claims::all(&setup).into_iter();
        all.find(|claim| claim.place == *place && claim.study == study).expect("a claim of this place")
    }

    fn row(method: Method, seed: u64, share: f64, keeps_best: f64, (reading, value): (Reading, f64)) -> Row {
        let mut readings = [1.0; N_READINGS];
        readings[reading as usize] = value;
        let step = usize::from(method == JUDGED);
        let (study, world, point) = (Study::Two, World::Moving, vec![50.0, 8.0]);
        Row { study, world, method, seed, step, point, share, spread: 1.0, keeps_best, readings }
    }

    fn judged(claim: &Claim, plants: &[Vec<Row>]) -> Judged {
        let cases: Vec<Case<'_>> = (1..)
            .zip(plants)
            .map(|(plant, rows)| Case {
                study: claim.study,
                world: World::Moving,
                plant,
                rows: rows.iter().collect(),
                facts: Vec::new(),
            })
            .collect();
        judge(claim, World::Moving, &cases, &[])
    }

    /// Five campaigns that keep the best, or not, with so much of the space left.
    fn campaigns(left: f64, keep: usize) -> Vec<Row> {
        let keeps = |seed: usize| f64::from(u8::from(seed <= keep));
        (1..=5).map(|seed| row(JUDGED, seed as u64, left, keeps(seed), (Reading::Cost, 1.0))).collect()
    }

    #[test]
    fn what_the_test_keeps_is_held_against_a_blind_draw() {
        let claim = claim(&Place::Section("5.5".to_owned()), Study::Two);
        let found = judged(&claim, &[campaigns(0.6, 5), campaigns(0.7, 5)]);
        assert_eq!(found.verdict(), Some(Verdict::NotDiscriminating), "{found:?}");
        assert_eq!(found.words().as_deref(), Some("2 of 2 plants, 10 of 10 campaigns; by chance 65 %"));
        let found = judged(&claim, &[campaigns(0.2, 5), campaigns(0.3, 4)]);
        assert_eq!(found.verdict(), Some(Verdict::InKind), "nine of ten, one draw in four");
        let words = "1 of 2 plants, 9 of 10 campaigns; by chance 25 % (count exactly at the limit)";
        assert_eq!(found.words().as_deref(), Some(words), "a plant counts where all five hold");
    }

    #[test]
    fn a_word_and_the_number_of_plants_do_not_contradict_each_other() {
        let claim = claim(&Place::Section("5.5".to_owned()), Study::Two);
        let plants: Vec<Vec<Row>> = (0..30).map(|_| campaigns(0.2, 4)).collect();
        let found = judged(&claim, &plants);
        assert_eq!((found.verdict(), found.n_holding()), (Some(Verdict::InPart), 0), "four of five on each plant");
    }

    /// What no design meets on these plants alone, or on those alone, may be within reach on the others.
    #[test]
    fn what_any_plant_reaches_is_within_reach_on_others() {
        let of = |holding: usize, standing: Standing| {
            Judged::of(vec![Share { plant: 1, count: Count { holding, cases: 20 }, chance: Some(0.0) }], standing)
        };
        let verdict = |near: Standing, others: Standing| of(0, near).on(&of(1, others)).verdict();
        let (out, within) = (Standing::OutOfReach, Standing::StandIn);
        assert_eq!(verdict(out, out), Some(Verdict::OutOfReach));
        assert_eq!([verdict(out, within), verdict(within, out)], [Some(Verdict::NotReproduced); 2]);
        let not_asked = Judged { shares: Vec::new(), by_rule: None };
        assert_eq!(not_asked.on(&of(1, within)).verdict(), None);
        assert_eq!(of(1, within).on(&not_asked).verdict(), None);
    }

    #[test]
    fn what_no_plant_could_fail_is_a_check() {
        let claim = claim(&Place::Section("2.3".to_owned()), Study::Two);
        let plant = |pitch: f64| vec![row(Method::Center, 0, 1.0, f64::NAN, (Reading::SteadyPitch, pitch))];
        let verdict = |pitches: &[f64]| {
            let plants: Vec<Vec<Row>> = pitches.iter().map(|pitch| plant(*pitch)).collect();
            judged(&claim, &plants).verdict()
        };
        assert_eq!(verdict(&[0.0, 1e-8]), Some(Verdict::Check));
        assert_eq!(verdict(&[0.0, 0.2]), Some(Verdict::NotReproduced), "if one fails it after all");
    }

    #[test]
    fn fitted_ends_are_those_of_still_water() {
        use crate::rules::Standing;
        let claim = claim(&Place::Figure(24), Study::Two);
        let standing = [World::Still, World::Moving].map(|world| claim.standing_in(world));
        assert_eq!(standing, [Standing::FittedEnds, Standing::StandIn]);
    }
}
