//! What the dissertation says of Figures 14 and 21, as tests of a plant.

use super::kept::{ITERATIONS, LARGEST, cases_of_figure21, of_iteration, of_place, places_in_table4};
use crate::chapter3::MATTERS;
use crate::claims::Place;
use crate::ensemble::claims::{Claim, Test};
use crate::ensemble::file::Setup;
use crate::ensemble::kept::Case;
use crate::ensemble::row::Study;

/// Of open-loop flights and of the corrected model, in still water.
pub(in crate::ensemble) fn claims(setup: &Setup) -> Vec<Claim> {
    let mut claims = vec![
        Claim::new(
            Place::Figure(14),
            "In each of four configurations the open-loop cost depends on trim pitch and center of mass",
            Study::Chapter3,
            "of the lowest costs at each center of mass within Table 4 the highest is more than 1.5 times the lowest, in each configuration",
            Test::Plant(depends(setup)),
        )
        .still(),
    ];
    for truth in 0..setup.chapter6.n_truths() {
        let says = "Low noise and a good fit bring the corrected model close to the truth";
        let rule = "2 parameters: after all iterations the largest error is less than without correction at each noise, and higher at the highest noise than at none";
        let test = Test::Plant(comes_close(setup, truth));
        let claim = Claim::new(Place::Figure(21), says, Study::Chapter6, rule, test).still();
        claims.push(if setup.chapter6.truth(truth).is_ours() { claim } else { claim.of_printed_truth() });
    }
    claims
}

type OfPlant = Box<dyn Fn(&Case<'_>) -> Option<bool>>;

fn depends(setup: &Setup) -> OfPlant {
    let study = &setup.chapter3;
    let places = places_in_table4(study);
    let n_panels = study.configurations.len();
    Box::new(move |case| {
        let spans = (0..n_panels).map(|panel| {
            let costs: Vec<f64> = places.iter().filter_map(|(place, _)| case.fact(&of_place(panel, *place))).collect();
            let [low, high] = [costs.iter().copied().reduce(f64::min)?, costs.iter().copied().reduce(f64::max)?];
            Some(high / low)
        });
        Some(spans.collect::<Option<Vec<f64>>>()?.iter().all(|span| *span > MATTERS))
    })
}

fn comes_close(setup: &Setup, truth: usize) -> OfPlant {
    let study = &setup.chapter6;
    let last = ITERATIONS[ITERATIONS.len() - 1];
    let mut mine: Vec<_> = cases_of_figure21(study).filter(|case| case.truth == truth).collect();
    mine.sort_by(|a, b| a.noise.total_cmp(&b.noise));
    let names: Vec<String> = mine.into_iter().map(|case| of_iteration(study, case, last, LARGEST)).collect();
    Box::new(move |case| {
        let errors = names.iter().map(|name| case.fact(name)).collect::<Option<Vec<f64>>>()?;
        Some(errors.iter().all(|error| *error < 1.0) && errors.first()? < errors.last()?)
    })
}
