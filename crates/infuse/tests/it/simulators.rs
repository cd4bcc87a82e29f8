//! Simulations of the pooled loop that answer for many designs at once.

use std::collections::BTreeSet;

use design_space::{Cell, Parameter, Region};
use infuse::Outcome;
use infuse::pooled::{Ask, Assessment, Loop, Responses, Settings, Simulate};

fn response(point: &[f64]) -> f64 {
    point.iter().map(|x| 0.8 * (x + 0.2).powi(2)).sum()
}

fn assessment(simulate: &mut dyn Simulate) -> Assessment {
    let parameter = |name: &str| Parameter::continuous(name, "mm", -1.0, 1.0)?.with_levels(21);
    let parameters = ["a", "b", "c"].map(parameter).into_iter().collect::<Result<_, _>>().expect("valid parameters");
    let mut settings = Settings::new(6);
    settings.max_batches = 2;
    let mut campaign = Loop::new(&Region::new(parameters).expect("distinct names"), settings).expect("valid settings");
    let mut experiment = |trial: &infuse::pooled::Trial| Ok(trial.point.iter().map(|x| (x - 0.4).powi(2)).sum::<f64>());
    campaign.run(simulate, &mut experiment).expect("a campaign that ends");
    campaign.assess(Some(simulate)).expect("responses that can be fitted").expect("there are responses")
}

/// Notes how many designs it was asked for at once.
#[derive(Default)]
struct Batches {
    sizes: Vec<usize>,
    seen: BTreeSet<Cell>,
    /// Responses that it leaves out at the end.
    short: usize,
}

impl Simulate for Batches {
    fn responses(&mut self, cells: &[Cell], points: &[Vec<f64>]) -> Vec<Result<Responses, String>> {
        self.sizes.push(cells.len());
        for &cell in cells {
            assert!(self.seen.insert(cell), "{cell} is simulated again");
        }
        points[..points.len().saturating_sub(self.short)].iter().map(|point| Ok(response(point).into())).collect()
    }
}

#[test]
fn answers_for_many_designs_are_those_for_one_after_the_other() {
    let mut batches = Batches::default();
    let together = assessment(&mut batches);
    assert_eq!(together, assessment(&mut |_: Cell, point: &[f64]| Ok(response(point))));
    assert!(batches.sizes.iter().all(|&size| size > 0), "nothing is asked for in vain");
    let largest = batches.sizes.iter().max().copied().unwrap_or(0);
    assert!(largest > 100 && batches.sizes.len() < 100, "{:?}", batches.sizes);
}

#[test]
fn designs_without_an_answer_have_failed() {
    let found = assessment(&mut Batches { short: 1, ..Batches::default() });
    assert!(found.recommended.mean.is_finite(), "{found:?}");
}

/// A campaign of three parameters whose simulation is displaced: what it asks for and, at the end, what it says. `meddle` is called after
/// each batch.
fn asked_and_said(displaced: bool, meddle: impl Fn(&mut Loop)) -> (Vec<Vec<Cell>>, Assessment, Loop) {
    let mut simulate = |_: Cell, point: &[f64]| Ok(response(point) + (5.0 * point[0]).sin());
    let measure = |point: &[f64]| {
        let there: Vec<f64> = point.iter().map(|x| x - 0.2).collect();
        response(&there) + (5.0 * there[0]).sin()
    };
    let parameter = |name: &str| Parameter::continuous(name, "mm", -1.0, 1.0)?.with_levels(21);
    let parameters = ["a", "b", "c"].map(parameter).into_iter().collect::<Result<_, _>>().expect("valid parameters");
    let mut settings = Settings::new(8);
    (settings.max_batches, settings.displaced) = (4, displaced);
    let mut campaign = Loop::new(&Region::new(parameters).expect("distinct names"), settings).expect("valid settings");
    let mut asked = Vec::new();
    while let Ask::Run { trials, .. } = campaign.ask(Some(&mut simulate)).expect("a batch") {
        asked.push(trials.iter().map(|trial| trial.cell).collect());
        for trial in trials {
            campaign.tell(trial.id, Outcome::Value(measure(&trial.point))).expect("an outstanding trial");
        }
        meddle(&mut campaign);
    }
    let said = campaign.assess(Some(&mut simulate)).expect("a fit").expect("responses");
    (asked, said, campaign)
}

/// What was simulated before is not simulated again, and that is all: asking for what is known, or telling what the simulation says of
/// some designs, changes nothing of what comes, and the same is said again.
#[test]
fn what_was_simulated_along_the_way_changes_nothing() {
    for displaced in [false, true] {
        let (asked, said, mut campaign) = asked_and_said(displaced, |_| {});
        let mut simulate = |_: Cell, point: &[f64]| Ok(response(point) + (5.0 * point[0]).sin());
        assert_eq!(said.registration.as_ref().is_some_and(|found| found.is_sure()), displaced, "{said:?}");
        let again = campaign.assess(Some(&mut simulate)).expect("a fit").expect("responses");
        assert_eq!(again, said, "assessed twice");
        let curious = |campaign: &mut Loop| {
            campaign.assess(Some(&mut simulate.clone())).expect("a fit");
            campaign.standings(&[Cell::new(4000)], Some(&mut simulate.clone())).expect("a fit");
            let cell = Cell::new(17);
            let point = campaign.grid().point(cell).expect("a cell of the grid");
            campaign.tell_simulation(cell, Ok(response(&point) + (5.0 * point[0]).sin())).expect("a cell of the grid");
        };
        let (asked_now, said_now, _) = asked_and_said(displaced, curious);
        assert_eq!((asked_now, said_now), (asked, said.clone()), "assessed along the way");
        // A new one that is told of the experiments alone.
        let mut revived = Loop::new(campaign.region(), campaign.settings().clone()).expect("valid settings");
        for batch in 1..=4 {
            let of_batch = || campaign.records().iter().filter(|record| record.trial.batch == batch);
            revived
                .hand_out(&of_batch().map(|record| record.trial.cell).collect::<Vec<_>>())
                .expect("cells of the grid");
            for record in of_batch() {
                revived
                    .tell(record.trial.id, record.outcome.clone().expect("an outcome"))
                    .expect("an outstanding trial");
            }
        }
        let found = revived.assess(Some(&mut simulate)).expect("a fit").expect("responses");
        assert_eq!(found, said, "revived");
    }
}
