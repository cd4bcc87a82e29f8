//! What the page says in sentences of more than one row: where a word hangs on one case, what the models are worth, what the test keeps,
//! where campaigns run into a bound.

use std::collections::BTreeSet;

use design_space::Region;
use page::{Column, Finding, Table};

use super::cameras::{FLOWN, of_blind};
use super::claims::{JUDGED, Test};
use super::file::Setup;
use super::judge::met_by;
use super::kept::Case;
use super::row::{Method, Study, World};
use super::tables::Both;
use crate::rules::{Count, Verdict};
use crate::words::{PLANTS, counted, number};

/// A model ranks designs well from this rank correlation on.
const RANKS_WELL: f64 = 0.7;
/// On a bound within this part of the width: rounding.
const AT_BOUND: f64 = 1e-6;

/// The words that hang on a single case.
pub(super) fn ties(setup: &Setup, all: &[Both]) -> Option<Finding> {
    let mut found = Vec::new();
    for (both, k) in all.iter().flat_map(|both| [(both, 0), (both, 1)]) {
        let judged = &both.judged[k];
        let Some(rule) = judged.by_rule.filter(|rule| rule.ties().contains(&true)) else { continue };
        let [count_ties, chance_ties] = rule.ties();
        let mut words = Vec::new();
        if count_ties {
            words.push(format!("it holds in {} cases, exactly {:.0} %", rule.count, 100.0 * rule.count.share()));
        }
        if chance_ties {
            let designs = judged.shares.len() * setup.campaigns.random_designs as usize;
            let of = match both.claim.test {
                Test::End(_) => format!(", {} of {designs} designs", designs / 2),
                _ => String::new(),
            };
            words.push(format!("by chance in exactly 50 %{of}"));
        }
        found.push(format!("{}, {} water: {}.", both.claim.place, World::OF_CAMPAIGNS[k].name(), words.join(", ")));
    }
    let head = "Words that hang on one case, because a share is exactly that of the rule:";
    (!found.is_empty()).then(|| Finding::new(head).with_sentences(found))
}

/// Claims in kind in moving water that come out without any simulation as often.
pub(super) fn without_simulation(all: &[Both], cases: &[Case<'_>]) -> Option<String> {
    let words = all.iter().filter(|both| both.judged[1].is(Verdict::InKind)).filter_map(|both| {
        let own = met_by(&both.claim, JUDGED, World::Moving, cases)?;
        let alone = met_by(&both.claim, Method::Alone, World::Moving, cases)?;
        (alone.share() >= own.share()).then(|| {
            let [own, alone] = [own, alone].map(|count| 100.0 * count.share());
            format!("{} ({alone:.1} % of the campaigns, with simulation {own:.1} %)", both.claim.place)
        })
    });
    let words: Vec<String> = words.collect();
    (!words.is_empty()).then(|| {
        format!(
            "In kind in moving water, but met as often by a regression on the same experiments that knows no simulation: {}.",
            words.join("; ")
        )
    })
}

/// Lowest, median and highest.
fn spread(values: &[f64], digits: usize) -> String {
    let at = |share: f64| number(page::quantile(values, share).unwrap_or(f64::NAN), digits);
    format!("{} ({} to {})", at(0.5), at(0.0), at(1.0))
}

/// What the models of these plants are worth in each study, over designs that nobody chose.
pub(super) fn worth_by_study(cases: &[Case<'_>]) -> Finding {
    let of = |study: Study| cases.iter().filter(move |case| case.study == study && case.world == World::Still);
    let mut words = Vec::new();
    for study in Study::OF_CAMPAIGNS {
        let ranks: Vec<f64> = of(study).filter_map(|case| case.fact("rank_correlation")).collect();
        let better: Vec<f64> =
            of(study).filter_map(|case| Some(100.0 * case.random_better(case.numerical()?))).collect();
        if !ranks.is_empty() {
            words.push(format!("{}: {} and {} %.", study.words(), spread(&ranks, 2), spread(&better, 0)));
        }
    }
    Finding::new(
        "Rank correlation of model and stand-in over designs that nobody chose, and the share of these that is better than the model's optimum, \
         in still water, median (lowest to highest plant):",
    )
    .with_sentences(words)
}

/// Whether any of the models ranks designs well.
pub(super) fn worth(cases: &[Case<'_>]) -> Finding {
    let all = cases.iter().filter_map(|case| Some((case.fact("rank_correlation")?, case.plant)));
    let mut well: Vec<u64> = all.clone().filter(|(rank, _)| *rank >= RANKS_WELL).map(|(_, plant)| plant).collect();
    well.sort_unstable();
    well.dedup();
    let highest = all.map(|(rank, _)| rank).fold(f64::NEG_INFINITY, f64::max);
    Finding::new(if well.is_empty() {
        format!(
            "No plant of this ensemble has a model that ranks designs well: the highest rank correlation, of all studies in both waters, is {}.",
            number(highest, 2)
        )
    } else {
        format!(
            "In {} a model ranks designs well in some study, with a rank correlation of {RANKS_WELL} or more.",
            counted(well.len(), PLANTS)
        )
    })
}

/// What the test that drops cells keeps, beside blind draws.
pub(super) fn kept_best(all: &[Both], cases: &[Case<'_>]) -> String {
    let mut words = Vec::new();
    let mut worse = Vec::new();
    for both in all.iter().filter(|both| matches!(both.claim.test, Test::Kept)) {
        for (world, judged) in World::OF_CAMPAIGNS.into_iter().zip(&both.judged) {
            let Some((rule, chance)) = judged.by_rule.and_then(|rule| Some((rule, rule.by_chance?))) else { continue };
            let case = format!("{} in {} water", both.claim.study.words(), world.name());
            words.push(format!(
                "{case} {} campaigns, {:.1} %, and by a blind draw {:.1} %",
                rule.count,
                100.0 * rule.count.share(),
                100.0 * chance
            ));
            if rule.count.share() < chance {
                worse.push(case);
            }
        }
    }
    let follows = if worse.is_empty() {
        "It never keeps it less often than a blind draw.".to_owned()
    } else {
        format!(
            "Less often than by a blind draw: {}; there the test drops the best sooner than other cells.",
            worse.join(", ")
        )
    };
    let still: Vec<&Case<'_>> =
        cases.iter().filter(|case| case.study == Study::Four && case.world != World::Cameras).collect();
    let ends = still.iter().flat_map(|case| case.ends(JUDGED));
    format!(
        "The test of Section 5.5 keeps the best design known in so many campaigns, where a blind draw of as many cells as are left would keep it \
         as often as they are a part of the space: {}. {follows} With four parameters, {} campaigns, the best known is the cheapest that any \
         compared method chose, and a better one may have been dropped or kept unseen.",
        words.join("; "),
        ends.count()
    )
}

/// Which cameras saw no dot in any image of a flight, in how many flights and on how many plants.
pub(super) fn blind_cameras(setup: &Setup, cases: &[Case<'_>]) -> String {
    let seen: Vec<&Case<'_>> = cases.iter().filter(|case| case.fact(FLOWN).is_some()).collect();
    let plants = |cases: &[&Case<'_>]| cases.iter().map(|case| case.plant).collect::<BTreeSet<u64>>().len();
    let n_flights: f64 = seen.iter().filter_map(|case| case.fact(FLOWN)).sum();
    let blind = setup.sensing.cameras.iter().filter_map(|camera| {
        let of = |case: &Case<'_>| case.fact(&of_blind(&camera.name)).unwrap_or(0.0);
        let mine: Vec<&Case<'_>> = seen.iter().copied().filter(|case| of(case) > 0.0).collect();
        let n: f64 = mine.iter().map(|case| of(case)).sum();
        (n > 0.0).then(|| format!("`{}` in {n}, on {}", camera.name, counted(plants(&mine), PLANTS)))
    });
    let blind: Vec<String> = blind.collect();
    let all = format!("{n_flights} of these flights on {} came to their end", counted(plants(&seen), PLANTS));
    if blind.is_empty() {
        format!("{all}, and in none was a camera blind, which is without a dot in any of its images.")
    } else {
        format!("{all}; blind, which is without a dot in any of its images, was camera {}.", blind.join("; "))
    }
}

/// The box of a study, natural.
fn region(setup: &Setup, study: Study) -> Option<&Region> {
    match study {
        Study::Chapter4 => Some(setup.chapter4.problem.region()),
        Study::Two => setup.chapter7.cases.first().map(|case| case.space.region()),
        Study::Four => setup.chapter7.cases.get(1).map(|case| case.space.region()),
        Study::Chapter3 | Study::Chapter6 => None,
    }
}

/// Whether a design lies on an end of the range of some parameter.
fn is_on_edge(region: &Region, point: &[f64]) -> bool {
    region.parameters().iter().zip(point).any(|(parameter, x)| {
        let slack = AT_BOUND * parameter.width();
        *x <= parameter.lower() + slack || *x >= parameter.upper() - slack
    })
}

/// How many of the designs that were chosen lie on an edge of the box, where a parameter cannot go on as it went.
pub(super) fn edges(setup: &Setup, cases: &[Case<'_>]) -> Table {
    let mut table = Table::new(vec![
        Column::words("study"),
        Column::words("water"),
        Column::words("optimum of the model, plants"),
        Column::words("end of the dissertation's loop, campaigns"),
        Column::words("end of the pooled loop, campaigns"),
    ]);
    for study in Study::OF_CAMPAIGNS {
        let Some(region) = region(setup, study) else { continue };
        for world in World::OF_CAMPAIGNS {
            let mine = || cases.iter().filter(move |case| case.study == study && case.world == world);
            let optima = Count::of(mine().filter_map(Case::numerical).map(|row| is_on_edge(region, &row.point)));
            let ends =
                |method| Count::of(mine().flat_map(|case| case.ends(method)).map(|row| is_on_edge(region, &row.point)));
            table.push(vec![
                study.words().to_owned(),
                world.name().to_owned(),
                optima.to_string(),
                ends(JUDGED).to_string(),
                ends(Method::Pooled).to_string(),
            ]);
        }
    }
    table
}

/// Campaigns of Chapter 4 that end on the upper bound of the pitch.
pub(super) fn at_bound(setup: &Setup, cases: &[Case<'_>]) -> String {
    let Some(pitch) = setup.chapter4.problem.region().parameters().get(1) else { return String::new() };
    let is_at = |x: f64| x >= pitch.upper() - AT_BOUND * pitch.width();
    let words = World::OF_CAMPAIGNS.map(|world| {
        let mine = cases.iter().filter(|case| case.study == Study::Chapter4 && case.world == world);
        let ends: Vec<f64> = mine.flat_map(|case| case.ends(JUDGED)).map(|row| row.point[1]).collect();
        let n = ends.iter().filter(|x| is_at(**x)).count();
        format!("{n} of {} campaigns in {} water", ends.len(), world.name())
    });
    let printed = setup.chapter4.file.published.last().map_or(f64::NAN, |row| row.pitch_set_point);
    format!(
        "In Chapter 4 the dissertation's loop ends exactly on the upper bound of the pitch, {} deg, in {}. That bound is ours: of these \
         campaigns, that the pitch rises (Table 3) says no more than that they run into it, beyond the {printed} deg to which the optimum of the stand-in was fitted.",
        pitch.upper(),
        words.join(" and ")
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::row::Fact;
    use super::*;

    #[test]
    fn blind_cameras_are_named_with_flights_and_plants() {
        let setup = Setup::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).expect("the ensemble");
        let fact =
            |name: &str, value: f64| Fact { study: Study::Two, world: World::Cameras, name: name.to_owned(), value };
        let words = |blind: [f64; 2]| {
            let facts = blind.map(|n| [fact(FLOWN, 8.0), fact(&of_blind("below"), n), fact(&of_blind("side"), 0.0)]);
            let cases: Vec<Case<'_>> = (7..)
                .zip(&facts)
                .map(|(plant, facts)| Case {
                    study: Study::Two,
                    world: World::Cameras,
                    plant,
                    rows: Vec::new(),
                    facts: facts.iter().collect(),
                })
                .collect();
            blind_cameras(&setup, &cases)
        };
        let none = words([0.0, 0.0]);
        assert!(none.starts_with("16 of these flights on 2 plants") && none.contains("in none"), "{none}");
        let one = words([0.0, 3.0]);
        assert!(one.contains("`below` in 3, on 1 plant") && !one.contains("side"), "{one}");
    }
}
