//! `docs/results-ensemble.md`, from what is kept and from nothing else.

use std::path::Path;

use anyhow::Result;

use super::beyond::Beyond;
use super::claims;
use super::curves;
use super::decides::{self, Decided, Property};
use super::evidence;
use super::figures;
use super::file::Setup;
use super::findings;
use super::judge::judge;
use super::kept::{Case, Ensembles, Kept, cases, searches};
use super::row::{Fact, Study, World};
use super::sentences;
use super::store::Store;
use super::tables::{self, Both};
use crate::first_screen::around;
use crate::kept;
use crate::rules::{self, Verdict};

const PAGE: &str = "docs/results-ensemble.md";
const VERDICTS: &str = "docs/results-ensemble.svg";
const REGRET: &str = "docs/results-ensemble-regret.svg";
const OF_CHAPTER4: &str = "docs/results-ensemble-chapter4.svg";
const OF_TWO: &str = "docs/results-ensemble-chapter7-two.svg";
const OF_FOUR: &str = "docs/results-ensemble-chapter7-four.svg";
const OF_CHAPTER3: &str = "docs/results-ensemble-chapter3.svg";
const OF_CHAPTER6: &str = "docs/results-ensemble-chapter6.svg";
const LOST_DOTS: &str = "docs/results-ensemble-lost-dots.svg";

pub(super) fn write(root: &Path, ensembles: &Ensembles) -> Result<()> {
    kept::write(root, &texts(ensembles))
}

/// That the committed page follows from what is kept.
pub(super) fn check(root: &Path, ensembles: &Ensembles) -> Result<()> {
    let remedy = "does not follow from the campaigns kept: run `cargo xtask reproduce-all --ensemble --page`";
    kept::check(root, &texts(ensembles), remedy)
}

/// What became of every claim.
pub(super) fn judged(setup: &Setup, cases: &[Case<'_>], searches: &[&Fact]) -> Vec<Both> {
    let both = |claim| {
        let judged = World::OF_CAMPAIGNS.map(|world| judge(&claim, world, cases, searches));
        Both { claim, judged }
    };
    let mut all = claims::all(setup);
    all.extend(curves::claims(setup));
    all.sort_by(|a, b| a.place.cmp(&b.place));
    all.into_iter().map(both).collect()
}

fn texts(Ensembles { near: Kept { setup, store }, beyond }: &Ensembles) -> [(&'static str, String); 9] {
    let [cases, cases_beyond] = [store, &beyond.store].map(|store| cases(&store.done));
    let all = judged(setup, &cases, &searches(&store.done));
    let beyond = Beyond::of(beyond, &all, &cases_beyond);
    let batches = |study: Study| batches(setup, study);
    let regret = figures::regret(&cases, &batches);
    let [of_chapter4, of_two, of_four] = figures::steps(setup, &cases, &batches);
    [
        (PAGE, markdown((setup, store), &cases, &all, &beyond)),
        (VERDICTS, format!("{}\n", figures::verdicts(&all))),
        (REGRET, format!("{regret}\n")),
        (OF_CHAPTER4, format!("{of_chapter4}\n")),
        (OF_TWO, format!("{of_two}\n")),
        (OF_FOUR, format!("{of_four}\n")),
        (OF_CHAPTER3, format!("{}\n", curves::lowest(setup, &cases))),
        (OF_CHAPTER6, format!("{}\n", curves::errors(setup, &cases))),
        (LOST_DOTS, format!("{}\n", curves::headings(setup, &cases))),
    ]
}

/// Experiments of a batch, and batches.
fn batches(setup: &Setup, study: Study) -> [usize; 2] {
    let of_case = |k: usize| {
        setup.chapter7.cases.get(k).map_or([0, 0], |case| [case.entry.batch.experiments, case.entry.iterations])
    };
    match study {
        Study::Chapter4 => {
            let settings = setup.chapter4.loop_settings(&setup.chapter4.file.variant[0]);
            [2 * settings.experiment_steps.len() + 1, settings.max_iterations]
        }
        Study::Two => of_case(0),
        Study::Chapter3 | Study::Chapter6 => [0, 0],
        Study::Four => of_case(1),
    }
}

const HOW: &str = "Written by `cargo xtask reproduce-all --ensemble` from what is kept in `fixtures/bat/ensemble`: a row for each design that \
    somebody chose, with what it truly shows. A run that is killed goes on where it was, `--page` writes this page alone, and `--check`, a \
    part of `cargo xtask ci`, holds it against what is kept, and flies the center of the box again on two plants and Figures 14 and 26 on one; `--check --all`, \
    a part of `cargo xtask proofs`, runs a unit of each kind anew on the last plant.";

const WORLDS: &str = "**Still water**: the stand-in as it was calibrated, its state known, and bounded noise added to the cost as the files of \
    the chapters say. **Moving water**: turbulence, vortex shedding and a hull whose sides differ, drawn plant by plant, lines of unequal length among them: by the number of the start that a plant came of, so that plants of \
    one number, here and from farther away, differ alike; an experiment is one \
    flight, and no noise is added. What a design truly costs there is the mean over a few flights whose seeds are the same for all designs. \
    The numerical model knows nothing of either: it stays still and symmetric. Nothing was fitted in moving water.";

const BEST_KNOWN: &str = "The best design known is the cheapest that any of them came upon, or a search in still water. With four parameters there \
    was no such search, so that it is the cheapest that one of those compared here chose, and what lies above it is a lower limit; in moving \
    water it is the least of some hundred means over a few flights.";

fn rule(n_random: u64) -> String {
    format!(
        "{}\nOver the ensemble the cases are the campaigns of all plants. A plant is counted where the claim would be in kind on it alone: with \
         five seeds, where all five of its campaigns hold. By chance: {n_random} Sobol points in place of the end of the loop, mean over plants; \
         for the test that drops cells, the share of cells that are left. A statement about a plant counts each plant once, and no design can \
         meet it by chance, nor one about how much an iteration drops.",
        rules::words_markdown()
    )
}

fn markdown((setup, store): (&Setup, &Store), cases: &[Case<'_>], all: &[Both], beyond: &Beyond<'_>) -> String {
    let mut text = format!("# {}\n\n", setup.title);
    let mut findings = findings::findings(setup, store, cases, all);
    findings.extend(beyond.finding());
    text += &around(
        &findings,
        "![What became of the claims](results-ensemble.svg)",
        "A box for each claim; gray ones do not count.",
    );
    text +=
        &format!("\n{HOW}\n\n{WORLDS}\n\n## The rule for each word\n\n{}\n\n", rule(setup.campaigns.random_designs));
    text += &claim_by_claim(all, cases);
    text += &who_chooses(setup, cases);
    text += &what_designs_show(cases);
    text += &curves_words(setup, cases);
    text += &what_is_left(setup, cases, all);
    text += &seen_by_cameras(setup, cases);
    text += &evidence::section(all, cases);
    text += &beyond.section();
    text += &decided(setup, cases, all);
    text += "\n## What was estimated\n\nOf the moving world the dissertation says nothing.\n\n";
    text += &tables::estimates(&setup.estimates()).markdown();
    text
}

/// What became of each claim, and who else meets it.
fn claim_by_claim(all: &[Both], cases: &[Case<'_>]) -> String {
    let mut text = "## Claim by claim\n\n".to_owned();
    text += &tables::claims(all).markdown();
    text += "\n## Who else meets it\n\nClaims about the end of the loop that come out somewhere: in how many per cent of the cases it meets them, and \
             in how many those who do not use it, or a model. Beside the model's optimum, or the loop's first design, as above.\n\n";
    text += &tables::met_by_others(all, cases).markdown();
    text
}

/// How good the designs are that each method chooses, and where they lie.
fn who_chooses(setup: &Setup, cases: &[Case<'_>]) -> String {
    let mut text = format!(
        "\n## Who chooses how well\n\nWith equal numbers of experiments, except for those who make none. The pooled loop takes the numerical model as it stands, and looks \
         for no displacement of it. Medians over plants and seeds with quartiles. {BEST_KNOWN} {}\n\n",
        sentences::at_bound(setup, cases)
    );
    text += &tables::baselines(cases).markdown();
    text += "\n### On the edge of the box\n\nHow many of these designs lie on an end of the range of some parameter. Where the optimum of the model \
             does, a claim that the loop leads away from it can hardly fail; where the end does, the range decides, and not the loop.\n\n";
    text += &sentences::edges(setup, cases).markdown();
    text += "\n![Cost above the best known against experiments](results-ensemble-regret.svg)\n\nMedians over all plants and seeds, and \
             quartiles; what is less than 0.1 % is drawn there. At 0 experiments: the optimum of the numerical model. In Chapter 4 the loop's design of an \
             iteration is the one around which its experiments are made, so that the first is the same.\n\n";
    text
}

/// The readings of designs, in a table and iteration by iteration.
fn what_designs_show(cases: &[Case<'_>]) -> String {
    let mut text = "## What designs show\n\nMedians over plants and seeds with quartiles.\n\n".to_owned();
    text += &tables::flights(cases).markdown();
    text += "\n![Chapter 4, iteration by iteration](results-ensemble-chapter4.svg)\n\nWhat Figures 16 to 18 and Table 3 show of one campaign, over all: the \
             designs of the dissertation's loop, means over their flights. At the first stands the optimum of the model.\n";
    text += "\n![Chapter 7, 2 parameters, iteration by iteration](results-ensemble-chapter7-two.svg)\n\nWhat Figures 20, 22, 24, 26 and 28 show of one \
             campaign, and of Figure 27 the roll offset and the zenith angle, over all; at 0 the optimum of the model. With four parameters:\n";
    text += "\n![Chapter 7, 4 parameters, iteration by iteration](results-ensemble-chapter7-four.svg)\n";
    text
}

/// What is left of the space, and what experiments scatter by.
fn what_is_left(setup: &Setup, cases: &[Case<'_>], all: &[Both]) -> String {
    let mut text = "\n## What is left of the space\n\nAfter each iteration of the dissertation's loop, median over plants and seeds with quartiles.\n\n".to_owned();
    let published = |study: Study, step: usize| {
        let case = setup.chapter7.cases.get(usize::from(study == Study::Four))?;
        Some(case.published.get(step)?.share)
    };
    text += &tables::spaces(cases, &published).markdown();
    text += &format!("\n{}\n", sentences::kept_best(all, cases));
    text += &format!(
        "\n## Noise that has a cause\n\nIn moving water the same design costs something else in every flight: over {} flights of each \
         random design. In still water the files add at most {:.0} % of the cost (Chapter 4) and {:.0} % of its range (Chapter 7).\n\n",
        setup.campaigns.truth_seeds,
        100.0 * setup.chapter4.file.noise.share,
        100.0 * setup.chapter7.file.noise.share
    );
    text += &tables::noise(cases).markdown();
    text
}

/// Designs flown again before cameras.
fn seen_by_cameras(setup: &Setup, cases: &[Case<'_>]) -> String {
    let mut text = "\n## Seen by cameras\n\nWith cameras a flight takes several times as long, so that in campaigns the state is known. Here the model's optimum and one last design of \
             each plant are flown again with the three cameras of `sensing.toml`, whose dots may leave the view: then the pose is held. Medians \
             over plants.\n\n".to_owned();
    text += &tables::cameras(cases).markdown();
    text += &format!("\n{}\n", sentences::blind_cameras(setup, cases));
    text += &format!(
        "\nThe dissertation has spikes in the heading of the model's optimum over the last 30 s (Figure 26, Section 7.2), where a pair of dots leaves the region of interest for a moment; here they come with the third pull at the port line. With three cameras and ten \
         dots no pair is missed. Here one camera, `{}`, sees dots {} alone, and looks for them only about where it sees them while the center of the box flies \
         in still water, with a few pixels to spare on each side; then designs fly in moving water. How many pixels was chosen after a look at flights of seven plants, so that the spikes are no prediction. Below four dots the last pose is held. \
         Four dots in a plane that a camera looks at squarely fit two poses, and a controller that is given the wrong one flies into the floor: {} \
         Errors of the heading that is reported are drawn and listed with {} px to spare, the largest of each {} s, one sample in four, the delay included, where the flight comes to its end; the loop's designs are those of the first seed.\n\n![Spikes of the heading over plants](results-ensemble-lost-dots.svg)\n\n{}",
        setup.regions.camera,
        setup.regions.dots.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        curves::fallen_in_words(cases),
        setup.regions.shown_px,
        curves::BIN_S,
        curves::table_of_headings(setup, cases).markdown()
    );
    text
}

/// The section on curves that no campaign gives.
fn curves_words(setup: &Setup, cases: &[Case<'_>]) -> String {
    let mut text = format!(
        "\n## Open loop, on all plants\n\nFigure 14: of the stable designs with the same center of mass the one whose trim pitch gives the lowest cost \
         (20), in the stand-in. Panels from the top: {}. Where less than half of the plants have a stable design nothing is drawn. The table looks within Table 4 alone, where nearly every curve falls to its aft end: there the range decides, and not the cost. The [page of Chapter 3](results-chapter3.md) \
         compares all designs, here it is the best pitch at each place; medians \
         over plants with quartiles.\n\n![Figure 14 over plants](results-ensemble-chapter3.svg)\n\n{}",
        setup.chapter3.configurations.iter().map(|one| one.label.as_str()).collect::<Vec<_>>().join("; "),
        curves::table_of_lowest(setup, cases).markdown()
    );
    text += &format!(
        "\n## The corrected model, on all plants\n\nFigure 21 with two parameters: the norm (42) of the error of the corrected model over what is left, as a \
         share of that without correction, {}. Medians over plants with quartiles; what a campaign ends with, because one cell is left, is carried on. With stall alone the first correction does harm on most plants: the surfaces of one \
         batch are further off than the model. Four parameters, {} flights a plant, were not flown here; the \
         [page of Chapter 6](results-chapter6-full.md) has them for one.\n\n![Figure 21 over plants](results-ensemble-chapter6.svg)\n\n{}",
        setup.chapter6.first_variant().label,
        setup
            .chapter6
            .spaces
            .iter()
            .map(|space| space.space.n_cells() * setup.chapter6.fidelities().len())
            .max()
            .unwrap_or(0),
        curves::table_of_errors(setup, cases).markdown()
    );
    text
}

/// The section on what goes with claims that hold in some plants only.
fn decided(setup: &Setup, cases: &[Case<'_>], all: &[Both]) -> String {
    let mut entries: Vec<(&Both, usize, Vec<Property>)> = Vec::new();
    for both in all {
        for (k, world) in World::OF_CAMPAIGNS.into_iter().enumerate() {
            if both.judged[k].verdict().is_some_and(Verdict::counts) {
                entries.push((both, k, decides::properties(setup, cases, both.claim.study, world)));
            }
        }
    }
    let judged: Vec<_> =
        entries.iter().map(|(both, k, properties)| (&both.judged[*k], properties.as_slice())).collect();
    let found = decides::decide(setup, &judged);
    let looked = found.iter().flatten().count();
    let n_properties = |world: usize| entries.iter().find(|(_, k, _)| *k == world).map_or(0, |(.., of)| of.len());
    let n_properties = [n_properties(0), n_properties(1)];
    let decided: Vec<(&Both, usize, Decided)> =
        entries.iter().zip(found).filter_map(|((both, k, _), found)| Some((*both, *k, found?))).collect();
    let count = |p: fn(&Decided) -> f64| decided.iter().filter(|(.., one)| p(one) <= tables::SIGNIFICANT).count();
    let [own, of_all] = [count(|one| one.p), count(|one| one.p_of_all)];
    let mut text = format!(
        "\n## What decides\n\nOf the claims that count, {looked}, still and moving water taken apart, hold in more than half of the campaigns of at \
         least three plants and fail so in at least three. For each, the property of the plants that goes with it most closely by rank correlation, out of {} in still and {} in moving water: the numbers that were free \
         in the calibration, there also by what the sides differ, and what the model is worth. p is the share of {} random orders of the plants that give a correlation as large with \
         any property of the same claim; then the share of orders in which any of these claims has a p as small. {own} reach {} for their own properties, {} would by chance; {of_all} for all \
         claims. Those {own} are shown, each claim in one row: property, rank correlation, p for its own properties, p for all claims; of the \
         others nothing goes with them closely enough.",
        n_properties[0],
        n_properties[1],
        decides::N_ORDERS,
        tables::SIGNIFICANT,
        crate::words::number(tables::SIGNIFICANT * looked as f64, 1),
    );
    if own == 0 {
        text += " Nothing stands out.\n";
    } else {
        text += "\n\n";
        text += &tables::decides(&decided).markdown();
    }
    text
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::calibration::Origin;

    fn kept(origin: Origin) -> Kept {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let setup = Setup::read_of(&root, origin).expect("plants");
        let store = Store::read(&root.join(origin.folder()), &setup.key).expect("campaigns");
        Kept { setup, store }
    }

    /// The page of the first plants alone, with one seed.
    fn page_of(n: usize) -> String {
        let mut near = kept(Origin::Near);
        near.setup.plants.truncate(n);
        (near.setup.campaigns.seeds, near.setup.campaigns.seeds_of_four) = (1, 1);
        let plants: Vec<u64> = near.setup.plants.iter().map(|plant| plant.number).collect();
        near.store.done.retain(|done| plants.contains(&done.unit.1));
        let [(_, page), ..] = texts(&Ensembles { near, beyond: kept(Origin::Beyond) });
        page
    }

    #[test]
    fn few_plants_are_counted_as_such_and_nothing_is_chosen_of_less_than_three() {
        let chosen = |page: &str| page.contains("## On the plants with the better models");
        let one = page_of(1);
        assert!(one.contains("- 1 plant, 1 seed, two worlds: ") && !chosen(&one), "{one}");
        assert!(one.contains("1 of 1 plant, "), "{one}");
        let two = page_of(2);
        assert!(two.contains("- 2 plants, 1 seed, two worlds: ") && !chosen(&two), "{two}");
        let three = page_of(3);
        assert!(chosen(&three) && three.contains("on 1 plant drawn at random"), "{three}");
        assert!(!three.contains("at least NaN"), "{three}");
    }
}
