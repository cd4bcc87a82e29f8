//! What the page of the ensemble begins with: what was found, the first screen first.

use page::{Finding, quantile};

use super::curves;
use super::file::Setup;
use super::kept::Case;
use super::row::{Method, Reading, Study, World};
use super::sentences;
use super::store::Store;
use super::tables::Both;
use crate::rules::Verdict;
use crate::words::{PLANTS, capitalized, counted};

/// The first screen, and what else was found.
pub(super) fn findings(setup: &Setup, store: &Store, cases: &[Case<'_>], all: &[Both]) -> Vec<Finding> {
    let mut findings =
        vec![on_plants(setup, all), Finding::new(capitalized(&in_short(all, 1))), ends(cases), sentences::worth(cases)];

    findings.extend(in_kind(all));
    findings.extend(sentences::without_simulation(all, cases).map(Finding::new));
    findings.extend(sentences::ties(setup, all));
    let counts = Finding::new("Of the claims that do not count:");
    findings.push(counts.with_sentences((0..World::OF_CAMPAIGNS.len()).map(|k| not_counted(all, k))));
    findings.push(sentences::worth_by_study(cases));
    findings.extend(World::OF_CAMPAIGNS.map(|world| regrets(cases, world)));
    findings.push(Finding::new(noise_words(cases)));
    findings.push(curves::lost_poses(setup, cases));
    findings.push(extent(setup, store, cases));
    findings
}

/// How many claims became what, world by world.
pub(super) fn counts(all: &[Both]) -> Vec<String> {
    (0..World::OF_CAMPAIGNS.len()).map(|k| capitalized(&in_short(all, k))).collect()
}

fn n_of(all: &[Both], k: usize, verdict: Verdict) -> usize {
    all.iter().filter(|both| both.judged[k].is(verdict)).count()
}

/// What became of the claims in a world, those that do not count taken together.
fn in_short(all: &[Both], k: usize) -> String {
    let of = |verdict: Verdict| n_of(all, k, verdict);
    let verdicts: Vec<Verdict> = all.iter().filter_map(|both| both.judged[k].verdict()).collect();
    format!(
        "in {} water {} of {} claims hold in kind, {} in part and {} do not. {} do not count, {} of these because designs that \
         nobody chose meet them, too.",
        World::OF_CAMPAIGNS[k].name(),
        of(Verdict::InKind),
        verdicts.len(),
        of(Verdict::InPart),
        of(Verdict::NotReproduced),
        verdicts.iter().filter(|verdict| !verdict.counts()).count(),
        of(Verdict::NotDiscriminating)
    )
}

fn not_counted(all: &[Both], k: usize) -> String {
    let of = |verdict: Verdict| n_of(all, k, verdict);
    format!(
        "In {} water {} do not discriminate, {} are met by no design that was tried, {} were partly calibrated, and {} could not fail.",
        World::OF_CAMPAIGNS[k].name(),
        of(Verdict::NotDiscriminating),
        of(Verdict::OutOfReach),
        of(Verdict::PartlyCalibrated),
        of(Verdict::Check)
    )
}

/// What the claims were looked at on, and what became of them there.
fn on_plants(setup: &Setup, all: &[Both]) -> Finding {
    Finding::new(format!(
        "The dissertation on {} that meet its published numbers, a cloud about one of them: {}",
        counted(setup.plants.len(), PLANTS),
        in_short(all, 0)
    ))
}

/// The claims that come out in kind in moving water.
fn in_kind(all: &[Both]) -> Option<Finding> {
    let mine = all.iter().filter(|both| both.judged[1].is(Verdict::InKind));
    let words = mine.map(|both| {
        let tie = both.judged[1].by_rule.map_or("", |judged| judged.tie_words());
        format!("{} ({}){tie}.", both.claim.words(), both.claim.place)
    });
    let words: Vec<String> = words.collect();
    (!words.is_empty()).then(|| Finding::new("In kind in moving water:").with_sentences(words))
}

/// How much was flown, and on what.
fn extent(setup: &Setup, store: &Store, cases: &[Case<'_>]) -> Finding {
    let [flights, seconds] = store.took();
    let plants = |study: Study| cases.iter().filter(|case| case.study == study && case.world == World::Still).count();
    let words = Study::OF_CAMPAIGNS.map(|study| format!("{} ({})", plants(study), study.words()));
    let of_four = match setup.campaigns.seeds_of_four {
        same if same == setup.campaigns.seeds => String::new(),
        other => format!(" ({other} with four parameters)"),
    };
    Finding::new(format!(
        "{}, {}{of_four}, two worlds: {flights:.0} flights in {:.0} minutes, those of campaigns that took the place of others counted with them.",
        counted(setup.plants.len(), PLANTS),
        counted(setup.campaigns.seeds as usize, ["seed", "seeds"]),
        seconds / 60.0
    ))
    .with_sentences([
        format!("Plants by study: {}.", words.join(", ")),
        "They are a cloud about one plant, and not as many independent answers ([how they were drawn](results-calibration.md)).".to_owned(),
        "No experiment was made in water.".to_owned(),
    ])
}

fn noise_words(cases: &[Case<'_>]) -> String {
    let random = cases.iter().filter(|case| case.world == World::Moving).flat_map(|case| case.ends(Method::Random));
    let shares: Vec<f64> =
        random.map(|row| row.of(Reading::CostSd) / row.cost()).filter(|share| share.is_finite()).collect();
    let median = quantile(&shares, 0.5).unwrap_or(f64::NAN);
    format!(
        "In moving water one flight differs from the next of the same design by {:.1} % of the cost (standard deviation, median over plants and \
         random designs).",
        100.0 * median
    )
}

/// The median cost above the best design known, in a world, of the campaigns of a study by a method.
fn regret(cases: &[Case<'_>], world: World, study: Study, method: Method) -> Option<f64> {
    let mine = cases.iter().filter(|case| case.study == study && case.world == world);
    let regrets: Vec<f64> = mine.flat_map(|case| case.ends(method).into_iter().map(|row| case.regret(row))).collect();
    quantile(&regrets, 0.5)
}

/// The studies that were flown in a world.
fn studies(cases: &[Case<'_>], world: World) -> Vec<Study> {
    let has = |study: &Study| regret(cases, world, *study, Method::Numerical).is_some();
    Study::OF_CAMPAIGNS.into_iter().filter(has).collect()
}

/// The medians of a method, study by study, in percent.
fn medians(cases: &[Case<'_>], world: World, method: Method) -> Vec<String> {
    let all = studies(cases, world).into_iter().filter_map(|study| regret(cases, world, study, method));
    all.map(|regret| format!("{:.1}", 100.0 * regret)).collect()
}

fn listed_studies(cases: &[Case<'_>], world: World) -> String {
    studies(cases, world).into_iter().map(Study::words).collect::<Vec<_>>().join("; ")
}

/// How well campaigns end in moving water.
fn ends(cases: &[Case<'_>]) -> Finding {
    let each = |method: Method| crate::words::listed(&medians(cases, World::Moving, method));
    Finding::new(format!(
        "In moving water the dissertation's loop ends {} % above the best design known, in the median ({}, the last a lower limit); the pooled loop {} %, and the \
         optimum of the model lies {} % above it.",
        each(Method::Dissertation),
        listed_studies(cases, World::Moving),
        each(Method::Pooled),
        each(Method::Numerical)
    ))
}

fn regrets(cases: &[Case<'_>], world: World) -> Finding {
    let each = |words: &str, method: Method| format!("{words}: {} %.", medians(cases, world, method).join(", "));
    Finding::new(format!(
        "Median cost above the best design known in {} water ({}, the last a lower limit):",
        world.name(),
        listed_studies(cases, world)
    ))
    .with_sentences([
        each("Dissertation's loop", Method::Dissertation),
        each("Pooled loop", Method::Pooled),
        each("Sobol points and a Gaussian process", Method::Process),
        each("Optimum of the model", Method::Numerical),
        each("Center of the box", Method::Center),
        each("Random design", Method::Random),
    ])
}
