//! The page of the benchmark: what was found, one picture, the tables.

use std::path::Path;

use anyhow::{Result, ensure};
use page::{Column, Finding, Table, quantile};

use super::bands::{self, Kind};
use super::displaced_page;
use super::families::{DECOYS, DISPLACED, FAMILIES, Family, names};
use super::figure::{Curve, PICTURED, Regrets};
use super::methods::{METHODS, UNTOLD};
use super::results::{Fresh, PEERS, Results};
use super::stopping::{self, Promise, stops};
use super::summary::{
    FLOOR, Paired, Promised, TELLING, paired, paired_after, percent, promised, regret, share_within, shared, telling,
    typical,
};
use super::task::{BATCHES, COMPARED_SEEDS, FRESH_SEEDS, SEEDS, broken_families, fresh_families};
use crate::first_screen::around;
use crate::words::capitalized;

const PAGE: &str = "docs/results-benchmark.md";
const PICTURE: &str = "docs/results-benchmark.svg";
/// A design that is worse than the best by no more than this share of the range is called close.
const CLOSE: f64 = 0.01;
/// Families on which the pooled loop was chosen. The others were not looked at for that.
const TUNED_ON: [&str; 8] =
    ["bowl-2", "stall-2", "wells-2", "hidden-2", "cliff-2", "bowl-noisy", "rough-useless", "hidden-4"];
/// On these it was seen that a choice does no harm.
const LOOKED_AT: [&str; 6] = ["bowl-4", "stall-4", "wells-4", "hartmann-4", "branin", "park-1"];
const SEEDS_OF_LOOP: &str = "1 to 30 and 101 to 130";
const SEEDS_OF_CERTIFICATE: &str = "1 to 10 and 101 to 130";
/// What would have been said without any experiment, or with none that counts.
const BLIND: [&str; 3] = ["simulation", "center", "random"];
/// Left out of the picture, beside those: a method that is there to show when a quadratic suffices.
const NOT_DRAWN: &str = "sobol-quadratic";
/// Families of which the peers ran fewer seeds are not in the picture.
const FEWEST_SEEDS: u64 = 5;

pub(super) fn write(root: &Path, kept: &[Results], fresh: &Fresh) -> Result<()> {
    crate::kept::write(root, &texts(kept, fresh)?)
}

pub(super) fn check(root: &Path, kept: &[Results], fresh: &Fresh) -> Result<()> {
    crate::kept::check(
        root,
        &texts(kept, fresh)?,
        "does not follow from the kept campaigns: run `cargo xtask benchmark`",
    )
}

fn texts(kept: &[Results], fresh: &Fresh) -> Result<[(&'static str, String); 3]> {
    let displaced = (displaced_page::PICTURE, displaced_page::picture(&fresh.displaced));
    Ok([(PAGE, markdown(kept, fresh)?), (PICTURE, picture(kept)), displaced])
}

/// A method that has rows.
struct Kept<'a> {
    results: &'a Results,
    words: &'static str,
    is_peer: bool,
    is_blind: bool,
}

fn present(kept: &[Results]) -> Vec<Kept<'_>> {
    let of = |results| {
        let name = |known: &str| known == Results::method(results);
        let peer = PEERS.iter().find(|peer| name(peer.name)).map(|peer| peer.words);
        let words = METHODS.iter().find(|method| name(method.name)).map(|method| method.words).or(peer)?;
        Some(Kept { results, words, is_peer: peer.is_some(), is_blind: BLIND.iter().any(|blind| name(blind)) })
    };
    kept.iter().filter(|results| !results.rows.is_empty()).filter_map(of).collect()
}

/// Campaigns that the first of the peers ran: families of a number of factors, and the seeds up to which it ran all of them.
struct Common {
    families: Vec<&'static Family>,
    seeds: u64,
}

impl Common {
    fn of(kept: &[Results], n_factors: usize) -> Self {
        let peer = kept.iter().find(|results| results.method() == PEERS[0].name);
        let seeds = |family: &Family| {
            let ran = |seed: &u64| peer.is_some_and(|results| results.has(family.name, *seed));
            (1..=SEEDS).take_while(ran).count() as u64
        };
        let enough = |family: &&Family| family.n_factors == n_factors && seeds(family) >= FEWEST_SEEDS;
        let families: Vec<&Family> = FAMILIES.iter().filter(enough).collect();
        Self { seeds: families.iter().map(|family| seeds(family)).min().unwrap_or(0), families }
    }

    fn words(&self) -> String {
        format!("{}, seeds 1 to {}", names(&self.families), self.seeds)
    }
}

fn picture(kept: &[Results]) -> String {
    let methods = present(kept);
    let curves = |n_factors: usize| -> Vec<Curve<'_>> {
        let Common { families, seeds } = Common::of(kept, n_factors);
        let curve = |method: &Kept<'_>| Some((method.words, typical(method.results, &families, &(1..=seeds))?));
        methods
            .iter()
            .filter(|method| !method.is_blind && method.results.method() != NOT_DRAWN)
            .filter_map(curve)
            .collect()
    };
    let panel = |n_factors: usize| (format!("regret, {n_factors} parameters"), curves(n_factors));
    let panels = PICTURED.map(panel).to_vec();
    Regrets { title: "How much worse the recommended design is than the best", panels, is_one_scale: true }.picture()
}

fn names_or_none(families: &[&Family]) -> String {
    if families.is_empty() { "none".to_owned() } else { names(families) }
}

fn markdown(kept: &[Results], fresh: &Fresh) -> Result<String> {
    let methods = present(kept);
    let ours = &kept[0];
    ensure!(!ours.rows.is_empty(), "no campaign of the pooled loop is kept: run `cargo xtask benchmark`");
    let mut text = String::from("# The benchmark of the loops\n\n");
    text += &around(
        &findings(&methods, ours, fresh),
        "![Regret after each batch](results-benchmark.svg)",
        &format!(
            "Regret after each batch, on the campaigns that {} ran: geometric mean over families of the mean over seeds, {} % added to each.",
            PEERS[0].words,
            percent(FLOOR)
        ),
    );
    text += "\nWritten by `cargo xtask benchmark` from the campaigns kept in `fixtures/benchmark` and `fixtures/peers/results`; delete \
             rows there and they are run anew. With `--check` it fails if this page is not what they come to.\n\n";
    text += &format!(
        "The picture has the campaigns {}; {}. Those who learn nothing, the quadratic, and methods that did not run all of these campaigns are not drawn.\n\n",
        Common::of(kept, PICTURED[0]).words(),
        Common::of(kept, PICTURED[1]).words(),
    );
    text += "## Beside the others\n\n";
    text += &format!(
        "Campaigns that both ran, and the share of them in which the recommended design is worse than the best by at \
         most {} % of the range, after batches 1 to {BATCHES}. Last, the families in which one of them has less regret by more than two standard errors, after batch 3 and after batch {BATCHES}.\n\n",
        100.0 * CLOSE
    );
    text += &others_table(&methods, ours).markdown();
    text += "\n## How it is measured\n\n";
    text += &format!(
        "Each family pairs a truth with a simulation that is wrong about it; each of {SEEDS} seeds draws its own optimum, displacement, \
         mirror image and order of the axes. The truth goes from 0 to 1, every parameter has 24 levels, and a batch has 12, 14, 18, 24 \
         experiments for 2, 3, 4, 6 parameters, half as many again as `infuse` asks for by itself. Readings have normal noise. The loops may ask the simulation wherever they like. \
         Regret is the truth at the recommended design less the lowest on the grid. Peers ran fewer families and seeds, with noise of \
         their own; `fixtures/peers/README.md` says what they are given. The dissertation's loop and the quadratic are not run with \
         6 parameters: their batches have fewer experiments than the quadratic has terms.\n\n"
    );
    for sentence in cut_short(kept) {
        text += &format!("{sentence}\n\n");
    }
    text += &families_table().markdown();
    text += &regrets(&methods, ours);
    let untold = methods.iter().find(|method| method.results.method() == UNTOLD).map(|untold| untold.results);
    text += &misled(fresh);
    text += &displaced_page::section(&fresh.displaced);
    text += &promises(ours, fresh, untold);
    text += "\n## Seconds\n\nMedian time to choose a batch, and to take its results and recommend, on the machine where the rows were \
             made, other work beside it.\n\n";
    text += &seconds_table(&methods).markdown();
    Ok(text)
}

/// How close each method comes, and beside the pooled loop.
fn regrets(methods: &[Kept<'_>], ours: &Results) -> String {
    let mut text = String::new();
    for batch in 1..=BATCHES {
        text += &format!(
            "\n## Regret after batch {batch}\n\nMedian and 90th percentile, in % of the range, of five campaigns or more.\n\n"
        );
        text += &regret_table(methods, batch, |method| !method.is_blind).markdown();
    }
    text += "\n## Regret without learning\n\nNo reading changes these.\n\n";
    text += &regret_table(methods, BATCHES, |method| method.is_blind).markdown();
    for batch in 2..=BATCHES {
        text += &format!(
            "\n## Paired with the others after batch {batch}\n\nMean over the seeds of log10(regret of the pooled loop / regret of the other) with its standard \
             error, and how many seeds both ran: negative where the pooled loop is better, and -0.30 is half the regret. {} % of the range is added to both, so \
             that differences far below the noise do not count. Bold: the other is better by more than two standard errors.\n\n",
            percent(FLOOR)
        );
        text += &paired_table(methods, ours, batch).markdown();
    }
    text
}

/// Batches after which the loop is compared with those that no simulation misleads.
const MISLED_AFTER: [usize; 3] = [2, 3, BATCHES];

/// The pooled loop beside those that are not told of a simulation that misleads.
fn misled(fresh: &Fresh) -> String {
    let (seeds, ours) = (COMPARED_SEEDS, &fresh.compared);
    let mut text = format!(
        "\n## Where the simulation misleads\n\nThe families whose simulation hides the best or has it elsewhere, seeds {} to {}, on which \
         no choice of runs was tuned: median and 90th percentile of the regret, in % of the range, and in brackets the mean of log10(regret of the \
         pooled loop / regret of the other), as above, and how many seeds both ran. Both others know experiments only.\n\n",
        seeds.start(),
        seeds.end()
    );
    let mut columns = ["family", "after batch", "pooled loop"].map(Column::words).to_vec();
    columns.extend(fresh.untold.iter().map(|(words, _)| Column::words(words)));
    let mut table = Table::new(columns);
    let both = |results: &Results, family, batch| match regret(results, family, batch) {
        Some([median, most]) => format!("{} / {}", percent(median), percent(most)),
        None => "–".to_owned(),
    };
    for family in fresh_families() {
        for batch in MISLED_AFTER {
            let mut row = vec![family.name.to_owned(), batch.to_string(), both(ours, family, batch)];
            row.extend(fresh.untold.iter().map(|(_, other)| {
                let regret = both(other, family, batch);
                let with_pairs = |pair: Paired| format!("{regret} ({}, {})", ratio(pair), pair.n_pairs);
                paired(ours, other, family, batch).map_or(regret.clone(), with_pairs)
            }));
            table.push(row);
        }
    }
    text += &table.markdown();
    text += &format!(
        "\nThe certificate there, seeds {} to {}: in how many campaigns it was broken after each batch, the median of c, and those that \
         stop if another batch has to be worth {} % of the range.\n\n",
        FRESH_SEEDS.start(),
        FRESH_SEEDS.end(),
        100.0 * stopping::WORTH
    );
    text += &misled_certificates(&fresh.ours).markdown();
    text
}

/// Against those that no simulation misleads, by more than two standard errors.
fn what_it_costs_to_be_misled(fresh: &Fresh) -> Finding {
    let ours = &fresh.compared;
    let head = "Where the simulation hides the best or has it elsewhere, by more than two standard errors:";
    let detail = |(words, other): &(&str, Results)| {
        let after = MISLED_AFTER.map(|batch| {
            let those = |is_so: fn(Paired) -> bool| {
                let families = fresh_families().filter(|family| paired(ours, other, family, batch).is_some_and(is_so));
                names_or_none(&families.collect::<Vec<_>>())
            };
            let (less, more) = (those(Paired::is_ours_better), those(Paired::is_theirs_better));
            format!("after batch {batch} less in {less}, more in {more}")
        });
        Finding::new(format!("What is missing, against {words}: {}.", after.join("; ")))
    };
    fresh.untold.iter().map(detail).fold(Finding::new(head), Finding::detail)
}

/// What the pooled loop promises, and when it stops.
fn promises(ours: &Results, fresh: &Fresh, untold: Option<&Results>) -> String {
    let mut text = String::from(
        "\n## The certificate\n\nPromised with 90 % probability: no design is better than the recommended one by more than c. In how \
             many campaigns one was, and the median of c in % of the range, after each batch.\n\n",
    );
    text += &certificate_table(ours, |promised| Some((promised.breached, promised.width))).markdown();
    text += "\nThe same for the 90 % quantile of what the surface says may be gained, neither widened nor doubted. Where it is wide, a \
             certificate cannot be narrow.\n\n";
    text += &certificate_table(ours, |promised| promised.believed).markdown();
    if let Some(untold) = untold {
        text += "\nThe certificate of the same loop without a simulation.\n\n";
        text += &certificate_table(untold, |promised| Some((promised.breached, promised.width))).markdown();
    }
    text += "\n## What is expected\n\nThe response at the recommended design is given with a band that holds it with 90 % probability, wider \
             than the surface has it while experiments are few. In how many campaigns it was beyond, and the median of half the band in % of \
             the range.\n";
    for kind in kinds(ours, fresh, untold) {
        text += &format!("\n{}:\n\n{}", kind.words, bands::table(&kind).markdown());
    }
    text += &stopping::section(ours, fresh, untold);
    text
}

/// The campaigns of which it is told how often bands held.
fn kinds<'a>(ours: &'a Results, fresh: &'a Fresh, untold: Option<&'a Results>) -> Vec<Kind<'a>> {
    let told = Kind::of_all("With the simulation", ours);
    let misled = Kind::misled("Where the simulation misleads", &fresh.ours);
    let untold = untold.map(|untold| Kind::of_all("Without a simulation", untold));
    [Some(told), untold, Some(misled)].into_iter().flatten().collect()
}

/// What a reader should know first, then the rest.
fn findings(methods: &[Kept<'_>], ours: &Results, fresh: &Fresh) -> Vec<Finding> {
    let (tuned, others): (Vec<&Family>, Vec<&Family>) =
        FAMILIES.iter().partition(|family| TUNED_ON.contains(&family.name));
    let mut findings = vec![how_close(ours, &tuned, &others), beside_first(methods, ours)];
    findings.push(Finding::new(where_others_are_better(methods, ours)));
    let [promised, in_detail] = what_was_promised(ours, &fresh.broken);
    findings.push(promised);
    findings.push(on_fresh_seeds(&fresh.ours));

    findings.push(as_close(
        &format!(
            "Close after 2 and after {BATCHES} batches, on the campaigns that both ran, with the pooled loop in brackets:"
        ),
        methods.iter().skip(1).filter(|method| !method.is_peer && !method.is_blind),
        ours,
    ));
    if methods.iter().any(|method| method.is_peer) {
        findings.push(as_close(
            "Peers with the same budget, of which those of two fidelities are given simulations too:",
            methods.iter().skip(1).filter(|method| method.is_peer),
            ours,
        ));
    }
    let untold = methods.iter().find(|method| method.results.method() == UNTOLD);
    findings.extend(untold.map(|untold| what_a_simulation_is_worth(ours, untold.results)));
    findings.extend(untold.map(|untold| promised_without(untold.results)));
    findings.extend(
        methods.iter().find(|method| method.results.method() == PEERS[0].name).map(|peer| above_a_peer(ours, peer)),
    );
    findings.extend([Some(in_detail), where_it_is_worst(ours)].into_iter().flatten());

    findings.push(bands::finding(&kinds(ours, fresh, untold.map(|untold| untold.results))));
    findings.push(what_it_costs_to_be_misled(fresh));
    findings.push(displaced_page::finding(&fresh.displaced));
    findings.push(stopping::finding(ours, fresh));
    findings.push(tuned_on(&tuned, others.len()));
    findings
}

/// How often what the pooled loop recommends is close to the best.
fn how_close(ours: &Results, tuned: &[&Family], others: &[&Family]) -> Finding {
    let (looked_at, unseen): (Vec<&Family>, Vec<&Family>) =
        others.iter().copied().partition(|family| LOOKED_AT.contains(&family.name));
    let within = |families: &[&Family], batch| whole(share_within(ours, families.iter().copied(), batch, CLOSE));
    let all: Vec<&Family> = FAMILIES.iter().collect();
    let [early, third, late] = [2, 3, BATCHES].map(|batch| within(&all, batch));
    Finding::new(format!(
        "Of {} campaigns, {SEEDS} of each of {} families of a truth and a wrong simulation, the pooled loop comes close to the best, within \
         {} % of the range, in {early} after 2 batches, {third} after 3, {late} after {BATCHES} ({} in {} tuned on, {} in \
         {} looked at, {} in {} others).",
        shared(ours, ours, BATCHES, CLOSE).campaigns,
        FAMILIES.len(),
        100.0 * CLOSE,
        within(tuned, BATCHES),
        tuned.len(),
        within(&looked_at, BATCHES),
        looked_at.len(),
        within(&unseen, BATCHES),
        unseen.len()
    ))
}

/// How often the certificate was broken without a simulation.
fn promised_without(untold: &Results) -> Finding {
    let of_each = FAMILIES.iter().flat_map(|family| {
        (1..=BATCHES).filter_map(move |batch| promised(untold, family, batch).map(|found| (family.name, batch, found)))
    });
    let (mut n, mut broken, mut often) = (0, 0, Vec::new());
    for (family, batch, found) in of_each {
        n += found.campaigns;
        broken += found.breached;
        if found.breached as f64 > 0.1 * found.campaigns as f64 {
            often.push(format!("`{family}` after batch {batch} ({} of {})", found.breached, found.campaigns));
        }
    }
    Finding::new(format!(
        "Without a simulation its certificate was broken after {broken} of {n} batches, more often than in one campaign of ten in: {}.",
        if often.is_empty() { "none".to_owned() } else { often.join(", ") }
    ))
}

/// In which families the pooled loop comes nearer, and in which less near, than one that is not told of the simulation.
fn what_a_simulation_is_worth(ours: &Results, untold: &Results) -> Finding {
    let those = |batch: usize, is_so: fn(Paired) -> bool| {
        let families = FAMILIES.iter().filter(|family| paired(ours, untold, family, batch).is_some_and(is_so));
        families.collect::<Vec<&Family>>()
    };
    let detail = |batch: usize| {
        let (better, worse) = (those(batch, Paired::is_ours_better), those(batch, Paired::is_theirs_better));
        Finding::new(format!(
            "After batch {batch} less is missing with the simulation in {} of {} families, and more in {}.",
            better.len(),
            FAMILIES.len(),
            names_or_none(&worse)
        ))
    };
    let head = "What a simulation is worth, and what it costs to believe one that lies, by more than two standard errors against the same loop without it:";
    [2, 3, BATCHES].map(detail).into_iter().fold(Finding::new(head), Finding::detail)
}

/// Where the pooled loop is above a peer by more than one standard error, after the same batch and after two batches less.
fn above_a_peer(ours: &Results, peer: &Kept<'_>) -> Finding {
    let sentence = |own: usize, theirs: usize| {
        let sides = [(ours, own), (peer.results, theirs)];
        let pair = |family: &'static Family| Some((family, paired_after(sides, family)?));
        let all: Vec<(&Family, Paired)> = FAMILIES.iter().filter_map(pair).collect();
        let above = all.iter().filter(|(_, pair)| pair.mean > pair.error).map(|(family, _)| *family);
        let above: Vec<&Family> = above.collect();
        let of_peer = if own == theirs { String::new() } else { format!(" than {} after batch {theirs}", peer.words) };
        Finding::new(format!(
            "After batch {own} more is missing{of_peer} in {} of {} families: {}.",
            above.len(),
            all.len(),
            names_or_none(&above)
        ))
    };
    let head = format!(
        "Above {} by more than one standard error, which a method as good as it would be in one family of six:",
        peer.words
    );
    let same = (2..=BATCHES).map(|batch| sentence(batch, batch));
    same.chain([sentence(BATCHES - 2, BATCHES)]).fold(Finding::new(head), Finding::detail)
}

/// The same of the dissertation's loop and of the first of the peers, after the last batch.
fn beside_first(methods: &[Kept<'_>], ours: &Results) -> Finding {
    let first = [METHODS[1].name, PEERS[0].name];
    let clause = |method: &Kept<'_>| {
        let [own, other] = shared(ours, method.results, BATCHES, CLOSE).within.map(whole);
        format!("{} in {other} ({own})", method.words)
    };
    let clauses = methods.iter().filter(|method| first.contains(&method.results.method())).map(clause);
    Finding::new(format!(
        "As close after {BATCHES} batches, in brackets the pooled loop on the same campaigns: {}.",
        clauses.collect::<Vec<_>>().join("; ")
    ))
}

/// A share in percent.
fn whole(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// How often methods are close to the best, beside the pooled loop.
fn as_close<'a>(head: &str, methods: impl Iterator<Item = &'a Kept<'a>>, ours: &Results) -> Finding {
    let clause = |method: &Kept<'_>| {
        let [early, late] = [2, BATCHES].map(|batch| shared(ours, method.results, batch, CLOSE));
        let both = |which: usize| [early, late].map(|found| whole(found.within[which])).join(" and ");
        Finding::new(format!("{}: {} of {} ({}).", capitalized(method.words), both(1), late.campaigns, both(0)))
    };
    methods.map(clause).fold(Finding::new(head), Finding::detail)
}

/// On which campaigns something was chosen.
fn tuned_on(tuned: &[&Family], n_others: usize) -> Finding {
    let details = [
        format!("Seeds {SEEDS_OF_LOOP} for the loop, {SEEDS_OF_CERTIFICATE} for the certificate."),
        "Of `hidden-4` the sceptic's share of the second batch and of the cells that are looked at, seeds 1 to 60."
            .to_owned(),
        format!(
            "The other {n_others} families were not looked at but for that share, and the next: `{}`, seeds 1 to 40 and 101 to 112.",
            LOOKED_AT.join("`, `")
        ),
        "How much of the first batch is for the simulation: of all families but those of six parameters, seeds 201 to 220, and of `hidden-2`, `hidden-4` and `rough-useless` 221 to 260."
            .to_owned(),
        "How much of a batch goes to where no run is near: of all families but those of six parameters, seeds 201 to 208, of six of them 221 to 240, \
         of the decoys 201 to 216; a share that does not depend on the simulation was given up after seeds 1 to 20 of all, and 61 to 120 of \
         `hidden-2` and `hidden-4`, had been run."
            .to_owned(),
        "How little readings that crowd count in the certificate, and the reserve for a narrow well: of all families and the decoys, seeds \
         201 to 220, of `hidden-4` to 300, of `hidden-2` and the decoys to 240; without a simulation 201 to 208; after `hidden-4` and the \
         decoys, seeds 301 to 360, had shown that it was needed. The first was lowered once more for the width on seeds 1 to 20."
            .to_owned(),
        "How little a run has to gain to be made where no run is near instead, and the reserve beside a simulation that is of use: of all \
         families but those of six parameters, and of those where the simulation misleads, seeds 201 to 220, of `lacking-2` and `lacking-3` \
         to 240; the reserve also of `hidden-2`, `hidden-4` and the decoys to 240. Seeds 361 to 420 of `lacking-2` and `lacking-3` had \
         shown that both were needed, so that what is told of the certificate there is of others."
            .to_owned(),
        "How many of a batch those runs may be, and from which batch on: of 16 families, seeds 201 to 220, `lacking-2`, `lacking-3`, \
         `hidden-2`, `hidden-4` and `decoy-4` among them; that they are more than a quarter only where there is little noise, after \
         seeds 1 to 20 of all and 361 to 379 of those where the simulation misleads had shown what it costs elsewhere."
            .to_owned(),
        "That what is far better than all others say is looked around, and what the certificate holds for it: `hidden-4`, `decoy-2`, \
         `lacking-2` and `lacking-3`, and wells and cones like those of `pit-2` and `pit-3` that are no family here, seeds 201 to 225."
            .to_owned(),
        "On how many sides of a find runs are made, how deep a well may be of which the rim was met, that one repeat is enough where \
         results have many digits, and the reserve beside a simulation that is of use once more: `pit-2` and `pit-3`, seeds 201 to 241, \
         `lacking-2` and `lacking-3` to 215, and all families, 216 to 221. How far what is drawn is widened: all families, 216 to 221, \
         after 1 to 20 had shown that it was too wide with four parameters."
            .to_owned(),
        "That the best of a few runs that agree is looked around, too: `pit-2` and `pit-3`, seeds 201 to 240, and all families but those of \
         six parameters, 216 to 220."
            .to_owned(),
        "That the reserve does not depend on what the simulation is worth, that it is held until twenty designs a parameter were run, and how \
         it falls: of `pit-3`, seeds 201 to 240 and 361 to 480; how high it is, seeds 1 to 20 of all families and 481 to 540 of those where \
         the simulation misleads."
            .to_owned(),
        "By how much bands are widened while experiments are few: of 15 families, seeds 201 to 212, with the simulation and without, and \
         random fields and choices that are no family here."
            .to_owned(),
        "No peer was tuned, but that SMT is used in the best of three ways on ten campaigns.".to_owned(),
    ];
    let head = Finding::new(format!("Tuned on {}:", names(tuned)));
    head.with_sentences(details)
}

fn where_others_are_better(methods: &[Kept<'_>], ours: &Results) -> String {
    let mut compared = 0;
    let (mut better, mut blind) = (Vec::new(), Vec::new());
    for method in methods.iter().skip(1) {
        for family in &FAMILIES {
            if let Some(found) = paired(ours, method.results, family, BATCHES) {
                compared += usize::from(!method.is_blind);
                if found.is_theirs_better() {
                    let list = if method.is_blind { &mut blind } else { &mut better };
                    list.push(format!("{} in `{}`", method.words, family.name));
                }
            }
        }
    }
    let of_blind = match blind.as_slice() {
        [] => String::new(),
        blind => format!(" Of those that learn nothing: {}.", blind.join(", ")),
    };
    if better.is_empty() {
        return format!(
            "No method that learns is better by more than two standard errors after {BATCHES} batches, in {compared} \
             comparisons.{of_blind}"
        );
    }
    format!(
        "Better than the pooled loop by more than two standard errors after {BATCHES} batches, in {} of {compared} comparisons \
         with methods that learn: {}.{of_blind}",
        better.len(),
        better.join(", ")
    )
}

/// The methods of which campaigns are missing.
fn cut_short(kept: &[Results]) -> impl Iterator<Item = String> {
    METHODS.iter().filter_map(|method| {
        let results = kept.iter().find(|results| results.method() == method.name)?;
        let families = FAMILIES.iter().filter(|family| method.can(family));
        let ran = |family: &Family| (1..=SEEDS).filter(|seed| results.has(family.name, *seed)).count();
        let fewer: Vec<String> = families
            .map(|family| (family, ran(family)))
            .filter(|(_, ran)| *ran < SEEDS as usize)
            .map(|(family, ran)| format!("{ran} in `{}`", family.name))
            .collect();
        let words = method.words;
        (!fewer.is_empty()).then(|| format!("Fewer than {SEEDS} campaigns of {words} were run: {}.", fewer.join(", ")))
    })
}

fn where_it_is_worst(ours: &Results) -> Option<Finding> {
    let found = |family: &'static Family| Some((family, regret(ours, family, BATCHES)?));
    let worst = FAMILIES.iter().filter_map(found).max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    worst.map(|(family, [median, most])| {
        Finding::new(format!(
            "The pooled loop is worst in `{}`: after {BATCHES} batches the median of what is missing is {} % of the range, and in one \
             campaign of ten it is {} % or more.",
            family.name,
            percent(median),
            percent(most)
        ))
    })
}

/// How it does in the families whose simulation misleads, in campaigns on which nothing was chosen.
fn on_fresh_seeds(fresh: &Results) -> Finding {
    let [first, last] = [FRESH_SEEDS.start(), FRESH_SEEDS.end()];
    let shares = fresh_families().filter_map(|family| Some((share_broken(&by_batch(fresh, family)?), family.name)));
    let (most, worst) = shares.fold((0.0, "none"), |worst, one| if one.0 > worst.0 { one } else { worst });
    let head = format!(
        "Where the simulation misleads, seeds {first} to {last}, on which nothing was chosen, its certificate is broken after up to {} % of \
         the batches, in `{worst}` ([more](#where-the-simulation-misleads)). {} By family:",
        percent(most),
        telling_promises(fresh, &mut fresh_families())
    );
    let detail = |family: &'static Family| {
        let each = by_batch(fresh, family)?;
        let stop = stops_in_words(fresh, family);
        let broken = percent(share_broken(&each));
        Some(Finding::new(format!(
            "In `{}` its certificate was broken after {broken} % of the batches; {stop}.",
            family.name
        )))
    };
    fresh_families().filter_map(detail).fold(Finding::new(head), Finding::detail)
}

/// How many campaigns of a family stop, and of these how many too early.
fn stops_in_words(results: &Results, family: &Family) -> String {
    let stopping = stops(results, family, Promise::Bound);
    match stopping.stopped {
        0 => "no campaign stops".to_owned(),
        stopped => format!("{} of {stopped} campaigns that stop do so too early", stopping.too_early),
    }
}

/// What was promised after each batch.
fn by_batch(results: &Results, family: &Family) -> Option<Vec<Promised>> {
    (1..=BATCHES).map(|batch| promised(results, family, batch)).collect()
}

fn share_broken(each: &[Promised]) -> f64 {
    let [batches, broken] =
        [|one: &Promised| one.campaigns, |one: &Promised| one.breached].map(|of| each.iter().map(of).sum::<usize>());
    broken as f64 / batches.max(1) as f64
}

/// The certificate in the families whose simulation misleads.
fn misled_certificates(fresh: &Results) -> Table {
    let heads = [
        "family",
        "truth and simulation",
        "campaigns",
        "broken, by batch",
        "c, % of the range",
        "stopped",
        "too early",
    ];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for family in fresh_families() {
        let Some(each) = by_batch(fresh, family) else { continue };
        let list = |of: &dyn Fn(&Promised) -> String| each.iter().map(of).collect::<Vec<_>>().join(", ");
        let stopping = stops(fresh, family, Promise::Bound);
        table.push(vec![
            family.name.to_owned(),
            family.words().to_owned(),
            stopping.campaigns.to_string(),
            format!("{} ({} %)", list(&|one| one.breached.to_string()), percent(share_broken(&each))),
            list(&|one| percent(one.width)),
            stopping.stopped.to_string(),
            stopping.too_early.to_string(),
        ]);
    }
    table
}

/// How many promises of these families could be broken, and were.
fn telling_promises(results: &Results, families: &mut dyn Iterator<Item = &'static Family>) -> String {
    let of_each = families.map(|family| telling(results, family));
    let [n, broken] = of_each.fold([0, 0], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    format!(
        "Of the {n} promises of less than {:.0} % of the range, which alone can well be broken, {broken} were ({} %).",
        100.0 * TELLING,
        percent(broken as f64 / n.max(1) as f64)
    )
}

fn what_was_promised(ours: &Results, again: &Results) -> [Finding; 2] {
    let (mut campaigns, mut breached, mut elsewhere) = (0, 0, [0, 0]);
    let mut worst = (0.0, String::new());
    for family in &FAMILIES {
        for batch in 1..=BATCHES {
            if let Some(found) = promised(ours, family, batch) {
                campaigns += found.campaigns;
                breached += found.breached;
                if !TUNED_ON.contains(&family.name) {
                    elsewhere = [elsewhere[0] + found.breached, elsewhere[1] + found.campaigns];
                }
                let share = found.breached as f64 / found.campaigns.max(1) as f64;
                if share > worst.0 {
                    worst = (share, format!("`{}` after batch {batch}", family.name));
                }
            }
        }
    }
    let width = |n_factors: usize| {
        let widths = FAMILIES.iter().filter(|family| family.n_factors == n_factors);
        let widths: Vec<f64> = widths.filter_map(|family| Some(promised(ours, family, BATCHES)?.width)).collect();
        quantile(&widths, 0.5).map_or("–".to_owned(), percent)
    };
    let promised = Finding::new(format!(
        "Its certificate, which promises with 90 % probability that no design is better by more than c, was broken after {breached} of {campaigns} batches \
         ({} %). {}",
        percent(breached as f64 / campaigns.max(1) as f64),
        telling_promises(ours, &mut FAMILIES.iter())
    ));
    let details = [
        format!(
            "In the families on which no choice of the loop was tuned it was broken after {} of {} batches.",
            elsewhere[0], elsewhere[1]
        ),
        format!(
            "Most often in {}: {:.0} % of the campaigns.{}",
            if worst.1.is_empty() { "none" } else { &worst.1 },
            100.0 * worst.0,
            broken_again(again)
        ),
        format!(
            "After batch {BATCHES} c is {} % of the range with 2 parameters, {} % with 4 and {} % with 6 (median of the families' medians).",
            width(2),
            width(4),
            width(6)
        ),
    ];
    [promised, Finding::new("About the certificate:").with_sentences(details)]
}

/// Of the families that are run on fresh seeds for it, how often it was broken there.
fn broken_again(again: &Results) -> String {
    let of_family = |family: &Family| {
        let each = by_batch(again, family)?;
        let broken = each.iter().map(|one| one.breached.to_string()).collect::<Vec<_>>().join(", ");
        let campaigns = each.first()?.campaigns;
        Some(format!(
            "of {campaigns} campaigns of `{}` in {broken} after batches 1 to {BATCHES}; {}",
            family.name,
            stops_in_words(again, family)
        ))
    };
    let of_each: Vec<String> = broken_families().filter_map(of_family).collect();
    if of_each.is_empty() {
        return String::new();
    }
    format!(" On fresh seeds, {} to {}, {}.", FRESH_SEEDS.start(), FRESH_SEEDS.end(), of_each.join("; "))
}

fn others_table(methods: &[Kept<'_>], ours: &Results) -> Table {
    let heads = ["other method", "campaigns", "other, %", "pooled loop, %", "pooled loop better", "other better"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for method in methods.iter().skip(1) {
        let each: Vec<_> = (1..=BATCHES).map(|batch| shared(ours, method.results, batch, CLOSE)).collect();
        let shares = |which: usize| {
            each.iter().map(|shared| format!("{:.0}", 100.0 * shared.within[which])).collect::<Vec<_>>().join(", ")
        };
        let counts = |is_better: fn(Paired) -> bool| {
            let after = |batch| {
                let all: Vec<_> =
                    FAMILIES.iter().filter_map(|family| paired(ours, method.results, family, batch)).collect();
                format!("{} of {}", all.iter().filter(|paired| is_better(**paired)).count(), all.len())
            };
            [3, BATCHES].map(after).join(", ")
        };
        table.push(vec![
            method.words.to_owned(),
            each.last().map_or(0, |shared| shared.campaigns).to_string(),
            shares(1),
            shares(0),
            counts(Paired::is_ours_better),
            counts(Paired::is_theirs_better),
        ]);
    }
    table
}

fn families_table() -> Table {
    let heads = ["family", "parameters", "noise, %", "truth and simulation", "tuned on"];
    let mut table = Table::new(heads.map(Column::words).to_vec());
    for family in FAMILIES.iter().chain(&DECOYS).chain(&DISPLACED) {
        let tuned = match family.name {
            name if TUNED_ON.contains(&name) => "yes",
            name if LOOKED_AT.contains(&name) || DECOYS.iter().any(|decoy| decoy.name == name) => "looked at",
            name if DISPLACED.iter().any(|displaced| displaced.name == name) => "other seeds",
            _ => "no",
        };
        let (size, noise) = (family.n_factors.to_string(), format!("{:.0}", 100.0 * family.noise()));
        table.push(vec![family.name.to_owned(), size, noise, family.words().to_owned(), tuned.to_owned()]);
    }
    table
}

fn regret_table(methods: &[Kept<'_>], batch: usize, keep: impl Fn(&Kept<'_>) -> bool) -> Table {
    let methods: Vec<&Kept<'_>> = methods.iter().filter(|method| keep(method)).collect();
    let mut columns = vec![Column::words("family")];
    columns.extend(methods.iter().map(|method| Column::words(method.words)));
    let mut table = Table::new(columns);
    for family in &FAMILIES {
        let cell = |method: &&Kept<'_>| match regret(method.results, family, batch) {
            Some([median, most]) => format!("{} / {}", percent(median), percent(most)),
            None => "–".to_owned(),
        };
        let mut row = vec![family.name.to_owned()];
        row.extend(methods.iter().map(cell));
        table.push(row);
    }
    table
}

/// The mean of the logarithm with its standard error.
fn ratio(pair: Paired) -> String {
    // No minus before a zero.
    let mean = (100.0 * pair.mean).round() / 100.0 + 0.0;
    format!("{mean:.2} ± {:.2}", pair.error)
}

fn paired_table(methods: &[Kept<'_>], ours: &Results, batch: usize) -> Table {
    let methods: Vec<&Kept<'_>> = methods.iter().skip(1).filter(|method| !method.is_blind).collect();
    let mut columns = vec![Column::words("family")];
    columns.extend(methods.iter().map(|method| Column::words(method.words)));
    let mut table = Table::new(columns);
    for family in &FAMILIES {
        let cell = |method: &&Kept<'_>| match paired(ours, method.results, family, batch) {
            Some(found) => {
                let cell = format!("{} ({})", ratio(found), found.n_pairs);
                if found.is_theirs_better() { format!("**{cell}**") } else { cell }
            }
            None => "–".to_owned(),
        };
        let mut row = vec![family.name.to_owned()];
        row.extend(methods.iter().map(cell));
        table.push(row);
    }
    table
}

fn certificate_table(ours: &Results, of: impl Fn(Promised) -> Option<(usize, f64)>) -> Table {
    let mut columns = vec![Column::words("family")];
    columns.extend((1..=BATCHES).map(|batch| Column::words(&format!("batch {batch}"))));
    let mut table = Table::new(columns);
    for family in &FAMILIES {
        let cell = |batch| {
            let found = promised(ours, family, batch)?;
            let (breached, width) = of(found)?;
            Some(format!("{breached} of {}, c {}", found.campaigns, percent(width)))
        };
        let mut row = vec![family.name.to_owned()];
        row.extend((1..=BATCHES).map(|batch| cell(batch).unwrap_or("–".to_owned())));
        table.push(row);
    }
    table
}

fn seconds_table(methods: &[Kept<'_>]) -> Table {
    let mut table = Table::new(["method", "2 parameters", "4 parameters", "6 parameters"].map(Column::words).to_vec());
    for method in methods {
        let cell = |n_factors: usize| {
            let of_size =
                |name: &str| FAMILIES.iter().any(|family| family.name == name && family.n_factors == n_factors);
            let rows: Vec<[f64; 2]> = method
                .results
                .rows
                .iter()
                .filter(|row| of_size(&row.family))
                .map(|row| [row.ask_seconds, row.tell_seconds])
                .collect();
            let median = |which: usize| quantile(&rows.iter().map(|seconds| seconds[which]).collect::<Vec<_>>(), 0.5);
            match (median(0), median(1)) {
                (Some(ask), Some(tell)) if ask + tell > 0.0 => Some(format!("{ask:.2} and {tell:.2}")),
                _ => None,
            }
        };
        let cells = [2, 4, 6].map(cell);
        if cells.iter().any(Option::is_some) {
            let cells = cells.map(|cell| cell.unwrap_or("–".to_owned()));
            table.push([&[method.words.to_owned()][..], &cells].concat());
        }
    }
    table
}
