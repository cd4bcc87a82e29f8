//! A saved campaign of the pooled loop goes on bit for bit, or is refused.

use design_space::{Cell, Parameter, Region};
use infuse::Outcome;
use infuse::pooled::{Ask, Constraint, Loop, Responses, Settings, Trial};
use proptest::prelude::*;
use serde_json::{Value, json};

fn load(text: &str) -> Loop {
    serde_json::from_str(text).unwrap()
}

fn save(campaign: &Loop) -> String {
    serde_json::to_string_pretty(campaign).unwrap()
}

/// A number and a choice of three, a second response that is held, dear simulations if there is a budget.
fn small(seed: u64, simulations: Option<usize>) -> Loop {
    let region = Region::new(vec![
        Parameter::continuous("force", "N", 0.0, 10.0).unwrap().with_levels(21).unwrap(),
        Parameter::categorical("material", ["foam", "film", "wood"]).unwrap(),
    ]);
    let mut settings = Settings::new(5);
    (settings.max_batches, settings.seed, settings.simulations) = (3, seed, simulations);
    (settings.particles, settings.constraints) = (4, vec![Constraint::at_most("travel", 8.0)]);
    Loop::new(&region.unwrap(), settings).unwrap()
}

fn simulation(cell: Cell, point: &[f64]) -> Result<Responses, String> {
    if cell.index() % 11 == 3 {
        return Err("it did not converge".to_owned());
    }
    Ok(Responses { cost: (point[0] - 4.0).powi(2) / 7.0 + point[1], constrained: vec![Some(point[0])] })
}

/// An awkward rig: some trials fail, one is set elsewhere, of one the second response is not known.
fn answer(campaign: &mut Loop, trial: &Trial) {
    let [force, material] = [trial.point[0], trial.point[1]];
    let value = Outcome::Value((force - 5.0).powi(2) / 3.0 + [0.0, 0.7, 0.2][material as usize]);
    if trial.id.number() != 5 {
        campaign.tell_constrained(trial.id, &[Some(force / 1.1)]).unwrap();
    }
    match trial.id.number() {
        2 => campaign.tell(trial.id, Outcome::Failed { reason: "it slipped".to_owned() }),
        3 => campaign.tell_at(trial.id, &[force - 0.123, material], value),
        _ => campaign.tell(trial.id, value),
    }
    .unwrap();
}

/// What is asked for now: with dear simulations these first, which are told.
fn trials(campaign: &mut Loop) -> Vec<Trial> {
    loop {
        let is_dear = campaign.settings().simulations.is_some();
        let asked = if is_dear { campaign.ask(None) } else { campaign.ask(Some(&mut simulation)) };
        let Ask::Run { trials, simulations } = asked.unwrap() else { return Vec::new() };
        for cell in simulations {
            let point = campaign.grid().point(cell).unwrap();
            campaign.tell_simulation(cell, simulation(cell, &point)).unwrap();
        }
        if !trials.is_empty() {
            return trials;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn saving_and_loading_at_every_point_changes_no_bit(seed in any::<u64>(), is_dear in any::<bool>()) {
        let mut kept = small(seed, is_dear.then_some(6));
        kept.add_earlier(&[9.0, 1.0], 4.5, "last year").unwrap();
        kept.add_earlier_failure(&[10.0, 0.0], "it broke", "last year").unwrap();
        kept.refuse(Cell::new(7)).unwrap();
        let mut restored = load(&save(&kept));
        loop {
            restored = load(&save(&restored));
            let asked = trials(&mut kept);
            prop_assert_eq!(&trials(&mut restored), &asked);
            if asked.is_empty() {
                break;
            }
            for trial in &asked {
                prop_assert_eq!(kept.reason(trial.id), restored.reason(trial.id));
                restored = load(&save(&restored));
                answer(&mut kept, trial);
                answer(&mut restored, trial);
                prop_assert_eq!(save(&restored), save(&kept));
            }
            let assessed = |campaign: &mut Loop| {
                let found = if is_dear { campaign.assess(None) } else { campaign.assess(Some(&mut simulation)) };
                serde_json::to_string(&found.unwrap()).unwrap()
            };
            prop_assert_eq!(assessed(&mut restored), assessed(&mut kept));
        }
        prop_assert_eq!(kept.batch(), 3);
    }
}

/// Simulations that were handed out are still due.
#[test]
fn simulations_that_are_due_stay_so_until_they_are_told_or_cheap() {
    let mut campaign = small(3, Some(6));
    campaign.ask(None).unwrap();
    let due = campaign.due().to_vec();
    assert_eq!(due.len(), 6, "the first ones");
    let mut restored = load(&save(&campaign));
    assert_eq!(restored.due(), due);
    restored.tell_simulation(due[0], Ok(1.0)).unwrap();
    assert_eq!(restored.due(), &due[1..]);
    let mut cheap = restored.settings().clone();
    cheap.simulations = None;
    restored.set_settings(cheap).unwrap();
    assert!(restored.due().is_empty(), "a cheap simulation is called, and waited for no longer");
    assert!(matches!(restored.ask(Some(&mut simulation)), Ok(Ask::Run { trials, .. }) if trials.len() == 5));
}

#[test]
fn a_file_that_no_campaign_can_have_written_is_refused() {
    let mut campaign = small(4, Some(6));
    for trial in trials(&mut campaign) {
        answer(&mut campaign, &trial);
    }
    campaign.ask(None).unwrap();
    let whole: Value = serde_json::from_str(&save(&campaign)).unwrap();
    let refused = |pointer: &str, value: Value, message: &str| {
        let mut changed = whole.clone();
        *changed.pointer_mut(pointer).unwrap() = value;
        let error = serde_json::from_value::<Loop>(changed).unwrap_err().to_string();
        assert!(error.contains(message), "{pointer}: {error}");
    };
    refused("/format", json!(2), "format 2, expected 1");
    refused("/trials/0/trial/id", json!(9), "`trials` of turn 1, expected the numbers, the batch and the settings");
    refused("/trials/0/trial/cell", json!(1), "`trials` of turn 1");
    refused("/trials/0/trial/cell", json!(100), "cell 100");
    refused("/trials/0/outcome", json!({ "value": 1e300 }), "trial 1");
    refused("/trials/0/constrained", json!([1.0, 2.0]), "2 constrained");
    refused("/trials/2/actual", json!([3.0, 0.5]), "the place of one of its choices, from 0");
    refused("/trials/2/outcome", Value::Null, "`trials.actual` of turn 1, expected none before there is an outcome");
    refused("/due", json!([5, 4]), "`due` of turn 2, expected cells that were not simulated, ascending");
    refused("/due", json!([100]), "`due` of turn 2");
    refused("/settings/confidence", json!(2.0), "`confidence` is 2");
    let mut changed = whole.clone();
    changed["batches"] = json!(1);
    let error = serde_json::from_value::<Loop>(changed).unwrap_err().to_string();
    assert!(error.contains("unknown field `batches`"), "{error}");
}
