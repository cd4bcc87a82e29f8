//! Simulations of the pooled loop that answer for many designs at once.

use std::collections::BTreeSet;

use design_space::{Cell, Parameter, Region};
use infuse::pooled::{Assessment, Loop, Responses, Settings, Simulate};

fn response(point: &[f64]) -> f64 {
    point.iter().map(|x| 0.8 * (x + 0.2).powi(2)).sum()
}

fn assessment(simulate: &mut dyn Simulate) -> Assessment {
    let parameter = |name: &str| Parameter::continuous(name, "mm", -1.0, 1.0)?.with_levels(21);
    let parameters = ["a", "b", "c"].map(parameter).into_iter().collect::<Result<_, _>>().expect("valid parameters");
    let mut settings = Settings::new(6);
    settings.max_batches = 2;
    let mut campaign = Loop::new(&Region::new(parameters).expect("distinct names"), settings).expect("valid settings");
    let mut experiment = |trial: &infuse::pooled::Trial| Ok(trial.point.iter().map(|x| (x - 0.4).powi(2)).sum());
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
