//! What holds in every campaign.

use infuse::codesign::{
    self,
    Strategy::{Nested, Simultaneous},
};
use infuse::{Outcome, TrialId, gradient};
use proptest::prelude::*;

use crate::problems::{failed, json, measured, optimizer, pair, pair_loop, simulated, trials};

fn campaign(steps: [f64; 2], policy: gradient::BoundPolicy, strategy: codesign::Strategy) -> gradient::Loop {
    let mut settings = gradient::Settings::new(vec![0.6, 0.6], steps.to_vec());
    settings.bound_policy = policy;
    settings.optimizer = optimizer(strategy);
    settings.max_iterations = 5;
    gradient::Loop::new(pair(-1.0, 1.0), settings).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn nothing_is_asked_outside_the_region_and_ids_count_up(
        steps in [0.01..0.9, 0.01..0.9],
        rig_optimum in [-2.0_f64..2.0, -2.0..2.0],
        lost in 0_u64..20,
    ) {
        let mut campaign = campaign(steps, gradient::BoundPolicy::StayInside, Simultaneous);
        let mut next = 1;
        let mut simulation = |p: &[f64]| {
            assert!(p.iter().all(|p| p.abs() <= 1.0), "simulated at {p:?}");
            simulated(p)
        };
        campaign.run(&mut simulation, &mut |trial| {
            assert_eq!(trial.id, TrialId::new(next), "one more each time");
            next += 1;
            assert!(trial.point.iter().all(|p| p.abs() <= 1.0), "asked at {:?}", trial.point);
            if trial.id.number() == lost {
                return Err("lost".to_owned());
            }
            let squares = (0..2).map(|j| (trial.point[j] - rig_optimum[j]) * (trial.point[j] - rig_optimum[j]));
            Ok(squares.sum())
        }).unwrap();
        let n_experiments: usize =
            campaign.reports().iter().map(|report| report.n_experiments()).sum();
        prop_assert_eq!(u64::try_from(n_experiments).unwrap() + 1, next);
    }

    #[test]
    fn the_order_of_telling_does_not_matter(
        order in Just([0, 1, 2, 3, 4]).prop_shuffle(),
        failing in 0_usize..6,
    ) {
        let tell = |order: &[usize]| {
            let mut campaign = pair_loop();
            let asked = trials(campaign.ask(&mut simulated).unwrap());
            for &index in order {
                let outcome = if index == failing {
                    failed("wind")
                } else {
                    measured(&asked[index].point).into()
                };
                campaign.tell(asked[index].id, outcome).unwrap();
            }
            campaign.ask(&mut simulated).unwrap();
            json(&campaign)
        };
        prop_assert_eq!(tell(&order), tell(&[0, 1, 2, 3, 4]));
    }
}

#[test]
fn asking_again_changes_nothing_and_runs_no_simulation() {
    let mut campaign = pair_loop();
    let asked = trials(campaign.ask(&mut simulated).unwrap());
    assert_eq!(asked.len(), 5, "2 n + 1");
    campaign.tell(asked[3].id, Outcome::Value(2.0)).unwrap();
    let before = campaign.clone();
    let again = trials(campaign.ask(&mut |_| panic!("no simulation is needed")).unwrap());
    assert_eq!(again.len(), 4, "those not yet told");
    assert_eq!(campaign, before, "nothing has changed");
}

#[test]
fn a_stopped_campaign_stays_stopped() {
    let mut campaign = pair_loop();
    let reason = campaign.run(&mut simulated, &mut |trial| measured(&trial.point)).unwrap();
    let again = campaign.ask(&mut |_| panic!("no simulation is needed")).unwrap();
    assert_eq!(again, gradient::Ask::Stopped(reason));
}

#[test]
fn stepping_outside_keeps_both_sides_at_a_bound() {
    for (policy, n_trials) in [(gradient::BoundPolicy::StayInside, 3), (gradient::BoundPolicy::StepOutside, 5)] {
        let mut campaign = campaign([0.1, 0.1], policy, Nested);
        let asked = trials(campaign.ask(&mut |p| Ok(-p[0] - p[1])).unwrap());
        assert_eq!(asked[0].point, [1.0, 1.0], "the corner");
        assert_eq!(asked.len(), n_trials, "{policy:?}");
    }
}
