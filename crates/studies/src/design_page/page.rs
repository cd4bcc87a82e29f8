//! The page of an evaluated design.

use super::evaluation::{Alias, DegreesOfFreedom, Evaluation, Predictions};
use super::{figures, tables};
use page::Page;

pub(super) fn page(evaluation: &Evaluation) -> Page {
    let names: Vec<&str> = evaluation.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let (n, p) = (evaluation.runs.len(), evaluation.terms.len());
    let mut page = Page::new(&format!("A design of {n} runs for {p} terms of {}", names.join(", ")));
    warn(&mut page, evaluation);
    let DegreesOfFreedom { model, lack_of_fit, pure_error } = evaluation.degrees_of_freedom;
    page.paragraph(&format!(
        "Predictions are asked for over the {}. Of the {n} degrees of freedom {model} go to the model, {lack_of_fit} tell \
         lack of fit, {pure_error} pure error. All variances are for unit variance of a run; terms are those of coded \
         parameters, from -1 at the lower bound to 1 at the upper.",
        evaluation.over
    ));
    if let Some(precision) = &evaluation.precision {
        let Predictions { maximum, maximum_at, minimum, mean } = &precision.predictions;
        page.heading("Predictions");
        page.paragraph(&format!(
            "The prediction variance is {mean:.4} in the mean, from {minimum:.4} to {maximum:.4}, the latter at {}.",
            evaluation.place(maximum_at)
        ));
        if let Some(slice) = &evaluation.variance_slice {
            page.figure(&figures::plane(evaluation, slice), &figures::plane_caption(evaluation, slice));
        }
        page.figure(
            &figures::fractions(precision),
            "Fraction of design space: the prediction variance that a share of the space does not exceed, and the mean.",
        );
        page.table(&tables::efficiencies(precision), "Efficiencies by every criterion.");
        page.heading("Terms and runs");
        page.table(
            &tables::coefficients(precision),
            "What the runs say about each coefficient, for unit noise of a run.",
        );
        page.figure(
            &figures::leverages(precision),
            "Above, the leverage of each run: at 1 the model goes through the run, whatever was measured. Below, the \
             variance inflation of each term without the constant, numbered as in the map of correlations: 1 is a term \
             unrelated to all others.",
        );
    } else {
        page.heading("Terms and runs");
    }
    if evaluation.correlations.terms.len() >= 2 {
        page.figure(
            &figures::correlations(&evaluation.correlations),
            &figures::correlations_caption(&evaluation.correlations),
        );
    }
    page.table(&tables::runs(evaluation), "The runs.");
    page
}

/// What is likely to be a mistake comes first.
fn warn(page: &mut Page, evaluation: &Evaluation) {
    let numbers = |runs: &[usize]| {
        let noun = if runs.len() == 1 { "run" } else { "runs" };
        format!("{noun} {}", runs.iter().map(|run| (run + 1).to_string()).collect::<Vec<_>>().join(", "))
    };
    let elsewhere: Vec<usize> =
        evaluation.outside.iter().copied().filter(|run| !evaluation.forbidden.contains(run)).collect();
    if !evaluation.forbidden.is_empty() {
        page.note(&format!("In a forbidden box: {}.", numbers(&evaluation.forbidden)));
    }
    if !elsewhere.is_empty() {
        page.note(&format!("Outside of the space, or off its levels: {}.", numbers(&elsewhere)));
    }
    if evaluation.precision.is_none() {
        page.note(
            "The runs do not determine the model: no prediction and no coefficient has a finite variance. On them:",
        );
        let parts = |alias: &Alias| alias.equals.iter().map(|(term, by)| format!("{by:.4} ({term})")).collect();
        let right = |parts: Vec<String>| if parts.is_empty() { "0".to_owned() } else { parts.join(" + ") };
        let items = evaluation.aliases.iter().map(|alias| format!("{} = {}", alias.term, right(parts(alias))));
        page.list(&items.collect::<Vec<String>>());
    }
}
