//! Constraints: responses within bounds, settings that do not go together, choices, designs that nobody can build.

use design_space::{Cell, Parameter, Region};
use infuse::pooled::{
    Ask, Assessment, Constraint, LinearConstraint, Loop, Needed, Responses, Settings, Simulate, StopReason, Trial,
};
use infuse::{Error, Outcome};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn square(levels: u32) -> Region {
    let parameter = |name: &str| Parameter::continuous(name, "", 0.0, 1.0).and_then(|p| p.with_levels(levels));
    Region::new(vec![parameter("a").expect("a parameter"), parameter("b").expect("a parameter")]).expect("a region")
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// The distance to (0.9, 0.9), squared; its simulation has the place wrong.
fn truth(point: &[f64]) -> f64 {
    (point[0] - 0.9).powi(2) + (point[1] - 0.9).powi(2)
}

fn rough(point: &[f64]) -> f64 {
    (point[0] - 0.7).powi(2) + (point[1] - 0.8).powi(2)
}

/// Travel, at most 1: less than what the simulation says, and curved.
fn travel(point: &[f64]) -> f64 {
    point[0] + point[1] + 0.3 * (point[0] - point[1]).powi(2)
}

fn rough_travel(point: &[f64]) -> f64 {
    0.8 * (point[0] + point[1])
}

/// The best of all designs that keep to the limit, by looking at each.
fn best(region: &Region, cells: u64, limit: f64) -> f64 {
    let grid = design_space::Grid::of(region).expect("a grid");
    let points = (0..cells).map(|index| grid.point(Cell::new(index)).expect("a cell"));
    points.filter(|point| travel(point) <= limit).map(|point| truth(&point)).fold(f64::INFINITY, f64::min)
}

fn given(is_given: bool, simulate: &mut dyn Simulate) -> Option<&mut dyn Simulate> {
    if is_given { Some(simulate) } else { None }
}

fn campaign(seed: u64, levels: u32, with_simulation: bool) -> Assessment {
    let mut settings = Settings::new(8);
    (settings.max_batches, settings.seed) = (4, seed);
    settings.constraints = vec![Constraint::at_most("travel", 1.0)];
    let mut campaign = Loop::new(&square(levels), settings).expect("a campaign");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut both =
        |_: Cell, point: &[f64]| Ok(Responses { cost: rough(point), constrained: vec![Some(rough_travel(point))] });
    while let Ask::Run { trials, .. } = campaign.ask(given(with_simulation, &mut both)).expect("a batch") {
        for trial in trials {
            let response = truth(&trial.point) + 0.02 * normal(&mut rng);
            campaign.tell(trial.id, Outcome::Value(response)).expect("a trial");
            let travel = travel(&trial.point) + 0.02 * normal(&mut rng);
            campaign.tell_constrained(trial.id, &[Some(travel)]).expect("a trial");
        }
    }
    campaign.assess(given(with_simulation, &mut both)).expect("a fit").expect("responses")
}

/// The lowest response lies where the travel is 1.8; of the designs that are allowed the best is at 0.38. How often this
/// holds over hundreds of campaigns is counted by `cargo xtask benchmark --constrained`.
#[test]
fn recommended_design_keeps_to_its_bounds_and_is_nearly_the_best_that_does() {
    let best = best(&square(16), 256, 1.0);
    assert!(best > 0.37);
    for (seed, with_simulation) in [(2, true), (1, false)] {
        let found = campaign(seed, 16, with_simulation);
        let point = &found.recommended.point;
        let (travel, regret) = (travel(point), truth(point) - best);
        assert!(travel <= 1.0 + 1e-9 && regret <= 0.08, "seed {seed}: {travel} {regret}");
        assert!(regret <= found.certificate.bound + 1e-9, "seed {seed}: {regret} {}", found.certificate.bound);
        assert!(found.recommended.suffices && found.recommended.constrained[0].within >= 0.9);
    }
}

/// A campaign that runs by itself is the one that is asked and told by hand, which the test above holds against the truth.
#[test]
fn a_campaign_that_runs_by_itself_tells_the_constrained_responses_too() {
    for with_simulation in [true, false] {
        let mut settings = Settings::new(8);
        (settings.max_batches, settings.seed) = (4, 2);
        settings.constraints = vec![Constraint::at_most("travel", 1.0)];
        let mut campaign = Loop::new(&square(11), settings).expect("a campaign");
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut both =
            |_: Cell, point: &[f64]| Ok(Responses { cost: rough(point), constrained: vec![Some(rough_travel(point))] });
        let mut rig = |trial: &Trial| {
            let cost = truth(&trial.point) + 0.02 * normal(&mut rng);
            Ok(Responses { cost, constrained: vec![Some(travel(&trial.point) + 0.02 * normal(&mut rng))] })
        };
        let stop = if with_simulation {
            campaign.run(&mut both, &mut rig).expect("it ends")
        } else {
            campaign.run_without_simulation(&mut rig).expect("it ends")
        };
        assert_eq!(stop, StopReason::BatchLimit);
        let found = campaign.assess(given(with_simulation, &mut both)).expect("a fit").expect("responses");
        assert_eq!(found, self::campaign(2, 11, with_simulation), "with a simulation: {with_simulation}");
    }
}

#[test]
fn constrained_responses_that_cannot_be_end_a_run() {
    let run = |constrained: Vec<Option<f64>>| {
        let mut settings = Settings::new(4);
        (settings.max_batches, settings.constraints) = (1, vec![Constraint::at_most("travel", 1.0)]);
        let mut campaign = Loop::new(&square(11), settings).expect("a campaign");
        let responses = Responses { cost: 1.0, constrained };
        let ended = campaign.run_without_simulation(&mut |_| Ok(responses.clone()));
        (ended.map_err(|error| error.to_string()), campaign.outstanding().len())
    };
    let (ended, outstanding) = run(vec![Some(0.5), None]);
    assert_eq!(ended, Err("2 constrained responses, expected at most 1: one per constraint".into()));
    assert_eq!(outstanding, 4, "nothing was told");
    let (ended, outstanding) = run(vec![Some(f64::NAN)]);
    let message = "trial 1: `travel` is NaN, expected a number of at most 1e100 in magnitude";
    assert_eq!((ended, outstanding), (Err(message.into()), 4), "no number");
    assert_eq!(run(vec![None]), (Ok(StopReason::BatchLimit), 0), "not measured");
    assert_eq!(run(Vec::new()), (Ok(StopReason::BatchLimit), 0), "left out");
}

#[test]
fn same_seed_gives_the_same_bits_whatever_the_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| campaign(3, 11, true))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn where_nothing_is_allowed_the_likeliest_design_is_recommended_and_said_not_to_suffice() {
    let mut settings = Settings::new(10);
    settings.constraints = vec![Constraint::at_most("travel", -1.0)];
    let mut campaign = Loop::new(&square(11), settings).expect("a campaign");
    let Ask::Run { trials, .. } = campaign.ask(None).expect("a batch") else { panic!("it stopped") };
    for trial in trials {
        campaign.tell(trial.id, Outcome::Value(truth(&trial.point))).expect("a trial");
        campaign.tell_constrained(trial.id, &[Some(travel(&trial.point))]).expect("a trial");
    }
    let found = campaign.assess(None).expect("a fit").expect("responses");
    assert!(!found.recommended.suffices, "{:?}", found.recommended);
    assert!(travel(&found.recommended.point) < 0.4, "{:?}", found.recommended.point);
}

#[test]
fn before_the_first_reading_of_a_constraint_nothing_suffices() {
    let mut settings = Settings::new(10);
    settings.constraints = vec![Constraint::at_most("travel", 1.0)];
    let mut campaign = Loop::new(&square(11), settings).expect("a campaign");
    let Ask::Run { trials, .. } = campaign.ask(None).expect("a batch") else { panic!("it stopped") };
    for trial in &trials {
        campaign.tell(trial.id, Outcome::Value(truth(&trial.point))).expect("a trial");
    }
    let found = campaign.assess(None).expect("a fit").expect("responses");
    assert!(!found.recommended.suffices && found.recommended.constrained[0].expected.is_none());
    assert!(campaign.tell_constrained(trials[0].id, &[Some(1.0), None]).is_err(), "there is but one constraint");
    let refused = campaign.tell_constrained(trials[0].id, &[Some(f64::NAN)]).expect_err("not a number").to_string();
    assert!(refused.contains("`travel` is NaN"), "{refused}");
}

/// a + b + c + d ≤ 1 and ≥ 0.9 leaves one design in 34; the best of them is known.
#[test]
fn thin_set_of_settings_is_kept_to() {
    let parameter = |name: &str| Parameter::continuous(name, "", 0.0, 1.0).and_then(|p| p.with_levels(21));
    let region = ["a", "b", "c", "d"].map(|name| parameter(name).expect("a parameter")).to_vec();
    let region = Region::new(region).expect("a region");
    let mut settings = Settings::new(12);
    settings.max_batches = 3;
    settings.linear_constraints =
        vec![LinearConstraint::at_most(vec![1.0; 4], 1.0), LinearConstraint::at_least(&[1.0; 4], 0.9)];
    let mut campaign = Loop::new(&region, settings).expect("a campaign");
    let goal = [0.4, 0.3, 0.15, 0.15];
    let distance = |p: &[f64]| p.iter().zip(goal).map(|(x, goal)| (x - goal).powi(2)).sum::<f64>();
    let kept = |p: &[f64]| (0.9 - 1e-9..=1.0 + 1e-9).contains(&p.iter().sum::<f64>());
    let mut simulate = |_: Cell, p: &[f64]| {
        assert!(kept(p), "nothing else is simulated");
        Ok(p.iter().map(|x| x * x).sum::<f64>())
    };
    campaign
        .run(&mut simulate, &mut |trial| {
            assert!(kept(&trial.point), "{:?}", trial.point);
            Ok(distance(&trial.point))
        })
        .expect("it ends");
    let found = campaign.assess(Some(&mut simulate)).expect("a fit").expect("responses");
    assert!(kept(&found.recommended.point) && distance(&found.recommended.point) < 0.02, "{:?}", found.recommended);
}

#[test]
fn linear_constraints_that_cannot_be_are_refused() {
    let with = |constraint| {
        let mut settings = Settings::new(4);
        settings.linear_constraints = vec![constraint];
        Loop::new(&square(11), settings).map(|_| ()).expect_err("it cannot be").to_string()
    };
    assert!(with(LinearConstraint::at_most(vec![1.0, 1.0], -0.1)).contains("no design"), "none is below 0");
    assert!(with(LinearConstraint::at_most(vec![1.0], 1.0)).contains("one per parameter"));
    assert!(with(LinearConstraint::at_most(vec![0.0, 0.0], 1.0)).contains("not zero"));
    assert!(with(LinearConstraint::at_most(vec![f64::NAN, 0.0], 1.0)).contains("NaN"));
    let mut settings = Settings::new(4);
    let mut both = Constraint::at_most("travel", 1.0);
    both.lower = Some(2.0);
    settings.constraints = vec![both];
    let refused = settings.validate(&square(11)).expect_err("upside down").to_string();
    assert!(refused.contains("`travel`") && refused.contains("above the lower one"), "{refused}");
    settings.constraints = ["force", "travel", "force"].map(|name| Constraint::at_most(name, 1.0)).to_vec();
    let refused = Loop::new(&square(11), settings).map(|_| ()).expect_err("nobody can tell them apart").to_string();
    assert_eq!(refused, "constraint `force` is there 2 times, expected each name once");
}

/// Sixteen pairs of choices, each run once: a quadratic has as many terms, and what they differ by may be noise. Of six runs of one design
/// none tells what another is like.
#[test]
fn nothing_is_promised_where_nothing_tells_noise_from_designs() {
    let names = ["a", "b", "c", "d"];
    let choice = |name| Parameter::categorical(name, names).expect("a choice");
    let region = Region::new(vec![choice("first"), choice("second")]).expect("a region");
    let mut settings = Settings::new(8);
    (settings.max_batches, settings.worth) = (9, Some(1e9));
    let mut campaign = Loop::new(&region, settings.clone()).expect("a campaign");
    for cell in 0..16 {
        let point = campaign.grid().point(Cell::new(cell)).expect("a cell");
        let once = (cell * 7 % 16) as f64;
        campaign.add_earlier(&point, once, "before").expect("a valid experiment");
        let found = campaign.assess(None).expect("a fit").expect("responses");
        let needed = if cell < 11 { Needed::Readings(12) } else { Needed::Repeat };
        assert_eq!((found.needed, found.bound()), (Some(needed), None), "{cell}");
    }
    assert!(matches!(campaign.ask(None).expect("a batch"), Ask::Run { .. }), "whatever another batch is worth");
    let mut known = settings.clone();
    known.noise = Some(0.1);
    campaign.set_settings(known).expect("valid settings");
    assert_eq!(campaign.assess(None).expect("a fit").expect("responses").needed, None, "the noise is given");

    let mut one_design = Loop::new(&square(11), settings).expect("a campaign");
    for run in 0..8 {
        one_design.add_earlier(&[0.5, 0.5], 5.0 + 0.1 * f64::from(run % 3), "before").expect("a valid experiment");
        let found = one_design.assess(None).expect("a fit").expect("responses");
        let needed = if run < 5 { Needed::Readings(6) } else { Needed::Designs(4) };
        assert_eq!((found.needed, found.bound()), (Some(needed), None), "{run}");
    }
    assert!(matches!(one_design.ask(None).expect("a batch"), Ask::Run { .. }), "whatever another batch is worth");
}

/// One reading of a constrained response, or the same one again, says nothing of other designs.
#[test]
fn one_reading_of_a_bound_tells_of_no_other_design() {
    let mut settings = Settings::new(8);
    settings.constraints = vec![Constraint::at_most("travel", 10.0)];
    let mut campaign = Loop::new(&square(11), settings).expect("a campaign");
    let at = |number: usize| [0.1 * (number % 4) as f64, 0.3 * (number / 4) as f64];
    for number in 0..10 {
        campaign.add_earlier(&at(number), 1.0 + number as f64, "before").expect("a valid experiment");
    }
    let far = [campaign.grid().nearest(&[1.0, 1.0]).expect("a cell")];
    let within = |campaign: &mut Loop| {
        let found = campaign.expectations(&far, None).expect("a fit").expect("responses");
        (found[0].constrained[0].within, found[0].constrained[0].expected)
    };
    for travel in [4.0, 4.0] {
        let responses = Responses { cost: 3.0, constrained: vec![Some(travel)] };
        campaign.add_earlier(&at(0), responses, "before").expect("a valid experiment");
        assert_eq!(within(&mut campaign), (0.5, None));
        assert_eq!(
            campaign.assess(None).expect("a fit").expect("responses").bound(),
            None,
            "none is known to keep to it"
        );
    }
    let responses = Responses { cost: 3.0, constrained: vec![Some(5.0)] };
    campaign.add_earlier(&at(1), responses, "before").expect("a valid experiment");
    let (probability, expected) = within(&mut campaign);
    assert!(probability > 0.5 && expected.is_some_and(|(_, deviation)| deviation > 0.01), "{probability} {expected:?}");
}

/// Three materials, each with its own offset; the shape over `a` is the same. What one teaches holds for the others.
#[test]
fn choices_share_what_they_have_in_common() {
    let region = Region::new(vec![
        Parameter::categorical("material", ["foam", "film", "wood"]).expect("a choice"),
        Parameter::continuous("a", "", 0.0, 1.0).and_then(|p| p.with_levels(21)).expect("a parameter"),
    ]);
    let region = region.expect("a region");
    let truth = |p: &[f64]| [0.5, 0.0, 0.8][p[0] as usize] + 2.0 * (p[1] - 0.65).powi(2);
    let (mut found_it, mut expected_well) = (0, 0);
    for seed in 1..=6 {
        let mut settings = Settings::new(6);
        (settings.max_batches, settings.seed) = (3, seed);
        let mut campaign = Loop::new(&region, settings).expect("a campaign");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        while let Ask::Run { trials, .. } = campaign.ask(None).expect("a batch") {
            for trial in trials {
                let response = truth(&trial.point) + 0.02 * normal(&mut rng);
                campaign.tell(trial.id, Outcome::Value(response)).expect("a trial");
            }
        }
        let found = campaign.assess(None).expect("a fit").expect("responses");
        found_it += usize::from(truth(&found.recommended.point) < 0.02);
        // At 0.65, in the material of which least is known.
        let wood = campaign.grid().nearest(&[2.0, 0.65]).expect("a cell");
        let expected = campaign.expectations(&[wood], None).expect("a fit").expect("responses")[0].mean;
        expected_well += usize::from((expected - 0.8).abs() < 0.2);
    }
    assert!(found_it >= 5 && expected_well >= 5, "{found_it} {expected_well} of 6");
}

#[test]
fn choices_are_refused_where_only_numbers_will_do() {
    let choice = || Parameter::categorical("material", ["foam", "film"]).expect("a choice");
    let region = Region::new(vec![choice()]).expect("a region");
    let model = design_space::Model::linear(1).expect("a model");
    let settings = infuse::global::Settings::new(model, 4, 8);
    let refused = infuse::global::Loop::new(&region, settings).map(|_| ()).expect_err("a choice").to_string();
    assert!(refused.contains("`material` is a choice"), "{refused}");
}

#[test]
fn what_is_no_choice_was_not_made() {
    let region = Region::new(vec![
        Parameter::categorical("material", ["foam", "film", "wood"]).expect("a choice"),
        Parameter::continuous("a", "", 0.0, 1.0).expect("a parameter"),
    ]);
    let mut campaign = Loop::new(&region.expect("a region"), Settings::new(4)).expect("a campaign");
    for place in [3.0, 0.5, -1.0, f64::NAN] {
        let refused = campaign.add_earlier(&[place, 0.5], 1.0, "before").map(|()| place);
        assert!(matches!(refused, Err(Error::EarlierSetting { .. } | Error::DesignSpace(_))), "{refused:?}");
    }
    campaign.add_earlier(&[2.0, 1.4], 1.0, "before").expect("wood, and somewhat outside");
    let Ask::Run { trials, .. } = campaign.ask(None).expect("a batch") else { panic!("it has just begun") };
    let refused = campaign.tell_at(trials[0].id, &[2.9, 0.5], Outcome::Value(1.0)).map_err(|error| error.to_string());
    let expected =
        "the actual setting of parameter `material` is 2.9, expected the place of one of its choices, from 0";
    assert!(refused.as_ref().is_err_and(|error| error.contains(expected)), "{refused:?}");
}

/// Of three designs two can be built: these are run again. Where none is left, that is said.
#[test]
fn of_few_designs_none_that_was_refused_is_asked_for() {
    let line = Parameter::continuous("a", "", 0.0, 1.0).and_then(|p| p.with_levels(3)).expect("a parameter");
    let region = Region::new(vec![line]).expect("a region");
    for seed in 1..=20 {
        let mut settings = Settings::new(5);
        settings.seed = seed;
        let mut campaign = Loop::new(&region, settings).expect("a campaign");
        campaign.refuse(Cell::new(1)).expect("a cell");
        let Ask::Run { trials, .. } = campaign.ask(None).expect("a batch") else { panic!("it has just begun") };
        let cells: Vec<u64> = trials.iter().map(|trial| trial.cell.index()).collect();
        assert!(cells.len() == 5 && !cells.contains(&1) && cells.contains(&0) && cells.contains(&2), "{cells:?}");
    }
    let mut campaign = Loop::new(&region, Settings::new(5)).expect("a campaign");
    (0..3).for_each(|cell| campaign.refuse(Cell::new(cell)).expect("a cell"));
    assert_eq!(campaign.ask(None), Err(Error::EveryDesignRefused { n_refused: 3 }));
}

#[test]
fn design_that_nobody_can_build_is_neither_asked_for_nor_recommended() {
    let mut settings = Settings::new(8);
    settings.max_batches = 3;
    let mut campaign = Loop::new(&square(11), settings).expect("a campaign");
    // All with a above 0.75 cannot be built.
    let refused: Vec<Cell> =
        campaign.grid().cells().filter(|&cell| campaign.grid().point(cell).expect("a cell")[0] > 0.75).collect();
    for &cell in &refused {
        campaign.refuse(cell).expect("a cell");
    }
    campaign
        .run(&mut |_: Cell, point: &[f64]| Ok(rough(point)), &mut |trial| Ok(truth(&trial.point)))
        .expect("it ends");
    let asked_later = campaign.records().iter().filter(|record| record.trial.batch > 1);
    assert!(
        asked_later.clone().count() == 16 && asked_later.clone().all(|record| !refused.contains(&record.trial.cell))
    );
    let found =
        campaign.assess(Some(&mut |_: Cell, point: &[f64]| Ok(rough(point)))).expect("a fit").expect("responses");
    assert!(!refused.contains(&found.recommended.cell), "{:?}", found.recommended);
}

/// A batch that is planned and of which nothing was told is no news.
#[test]
fn what_is_only_planned_changes_nothing_of_what_is_said() {
    let mut settings = Settings::new(8);
    settings.max_batches = 2;
    let mut campaign = Loop::new(&square(40), settings).expect("a campaign");
    let simulate = &mut |_: Cell, point: &[f64]| Ok(rough(point));
    let mut noise = (0..).map(|index: u32| 0.02 * f64::from(index * 7 % 5) - 0.04);
    let reading = &mut |trial: &infuse::pooled::Trial| Ok(truth(&trial.point) + noise.next().unwrap_or(0.0));
    campaign.run(simulate, reading).expect("it ends");
    let before = campaign.assess(Some(simulate)).expect("a fit").expect("responses");
    let cells = [before.recommended.cell; 3];
    campaign.hand_out(&cells).expect("a batch to confirm it");
    let after = campaign.assess(Some(simulate)).expect("a fit").expect("responses");
    assert_eq!(after.certificate, before.certificate);
    assert_eq!(after.recommended, before.recommended);
}

/// What was built and measured once may be gone: its measurements stay, and it is not asked for again.
#[test]
fn design_that_was_measured_and_cannot_be_built_any_more_is_left_alone() {
    let mut settings = Settings::new(8);
    settings.max_batches = 3;
    let mut campaign = Loop::new(&square(11), settings.clone()).expect("a campaign");
    let simulate = &mut |_: Cell, point: &[f64]| Ok(rough(point));
    campaign.run(simulate, &mut |trial| Ok(truth(&trial.point))).expect("it ends");
    let before = campaign.assess(Some(simulate)).expect("a fit").expect("responses");
    let measured: Vec<Cell> = campaign.records().iter().map(|record| record.trial.cell).collect();
    for &cell in &measured {
        campaign.refuse(cell).expect("a cell");
    }
    settings.max_batches = 4;
    campaign.set_settings(settings).expect("valid settings");
    let found = campaign.assess(Some(simulate)).expect("a fit").expect("responses");
    assert!(measured.contains(&before.recommended.cell) && !measured.contains(&found.recommended.cell));
    assert!(found.contradiction.is_none(), "what is gone speaks against nothing: {:?}", found.contradiction);
    let Ask::Run { trials, .. } = campaign.ask(Some(simulate)).expect("a batch") else { panic!("it goes on") };
    assert!(trials.len() == 8 && trials.iter().all(|trial| !measured.contains(&trial.cell)), "{trials:?}");
}

/// a + b at most 1 on a square of 11 by 11 levels, and one design that nobody can build.
#[test]
fn designs_that_break_a_bound_or_were_refused_are_not_allowed() {
    let mut settings = Settings::new(4);
    settings.linear_constraints = vec![LinearConstraint::at_most(vec![1.0, 1.0], 1.0)];
    let mut campaign = Loop::new(&square(11), settings).expect("valid settings");
    let n_allowed = campaign.grid().cells().filter(|&cell| campaign.allows(cell)).count();
    assert_eq!(n_allowed, 66, "the triangle with its diagonal");
    let cell = campaign.grid().nearest(&[0.2, 0.3]).expect("a design");
    assert!(campaign.allows(cell), "its sum is half");
    campaign.refuse(cell).expect("a design");
    assert!(!campaign.allows(cell), "refused");
}
