//! Evaluations of designs against numpy and statsmodels (`fixtures/doe/evaluation.json`), closed forms and invariances.

use doe::{
    Axis, Criterion, Design, Error, Evaluation, EvaluationSettings, Forbidden, FractionOfSpace, Model,
    PredictionVariance, Sampling, Space, Term, VarianceSlice, evaluate,
};
use proptest::prelude::*;
use serde::Deserialize;

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/doe/evaluation.json");

#[derive(Deserialize)]
struct Fixture {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    n_factors: usize,
    exponents: Vec<Vec<u8>>,
    runs: Vec<Vec<f64>>,
    leverages: Vec<f64>,
    standard_errors: Vec<f64>,
    variance_inflation: Vec<Option<f64>>,
    correlations: Vec<Vec<Option<f64>>>,
    degrees_of_freedom: [usize; 3],
    maximum: f64,
    minimum: f64,
    mean: f64,
    fractions: Vec<f64>,
    fraction_variances: Vec<f64>,
    d: f64,
    a: f64,
    e: f64,
    t: f64,
}

/// Algebra in double precision; the worst fixture has a condition number of 1e4.
const ALGEBRA: f64 = 1e-8;
/// The fixture's extremes are of local searches.
const EXTREME: f64 = 1e-6;
/// Both quantiles are of samples: 10,000 quasi-random points here, a million random ones there.
const QUANTILE: f64 = 0.02;

#[track_caller]
fn check(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(error <= tolerance * expected.abs().max(1.0), "{what}: {found} is not {expected}");
}

fn evaluated(model: &Model, design: &Design) -> Evaluation {
    let space = Space::cube(model.n_factors()).unwrap();
    evaluate(model, &space, design, &EvaluationSettings::default()).unwrap()
}

fn percent(evaluation: &Evaluation, criterion: Criterion) -> f64 {
    let precision = evaluation.precision.as_ref().unwrap();
    precision.efficiencies.iter().find(|efficiency| efficiency.criterion == criterion).unwrap().percent
}

#[test]
fn matches_numpy_and_statsmodels() {
    let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(FIXTURE).unwrap()).unwrap();
    assert!(fixture.cases.len() > 10);
    for case in &fixture.cases {
        let terms = case.exponents.iter().map(|exponents| Term::new(exponents.clone())).collect();
        let model = Model::new(case.n_factors, terms).unwrap();
        let evaluation = evaluated(&model, &Design::from_runs(&case.runs).unwrap());
        let precision = evaluation.precision.as_ref().unwrap();
        let of = |what: &str| format!("{}, {what}", case.name);
        for (&found, &expected) in precision.leverages.iter().zip(&case.leverages) {
            check(&of("leverage"), found, expected, ALGEBRA);
        }
        for (row, (&error, &inflation)) in
            precision.coefficients.iter().zip(case.standard_errors.iter().zip(&case.variance_inflation))
        {
            check(&of("standard error"), row.standard_error, error, ALGEBRA);
            match (row.variance_inflation, inflation) {
                (Some(found), Some(expected)) => check(&of("inflation"), found, expected, ALGEBRA),
                (found, expected) => assert_eq!(found, expected, "{}", of("inflation")),
            }
        }
        for (found, expected) in evaluation.correlations.values.iter().zip(case.correlations.iter().flatten()) {
            match (found, expected) {
                (Some(found), Some(expected)) => check(&of("correlation"), *found, *expected, ALGEBRA),
                _ => assert_eq!(found, expected, "{}", of("correlation")),
            }
        }
        let freedom = evaluation.degrees_of_freedom;
        assert_eq!([freedom.model, freedom.lack_of_fit, freedom.pure_error], case.degrees_of_freedom, "{}", case.name);
        check(&of("maximum"), precision.predictions.maximum, case.maximum, EXTREME);
        check(&of("minimum"), precision.predictions.minimum, case.minimum, EXTREME);
        check(&of("mean"), precision.predictions.mean, case.mean, ALGEBRA);
        let curve = &precision.fraction_of_space;
        for (&fraction, &expected) in case.fractions.iter().zip(&case.fraction_variances) {
            let found = curve.variance_at(fraction).unwrap();
            assert!((found - expected).abs() <= QUANTILE * expected.max(0.1), "{}: {found} {expected}", of("quantile"));
        }
        for (criterion, expected) in
            [(Criterion::D, case.d), (Criterion::A, case.a), (Criterion::E, case.e), (Criterion::T, case.t)]
        {
            check(&of("efficiency"), percent(&evaluation, criterion), expected, ALGEBRA);
        }
        let g = 100.0 * model.n_terms() as f64 / (case.runs.len() as f64 * case.maximum);
        check(&of("G"), percent(&evaluation, Criterion::G), g, EXTREME);
    }
}

/// Corners −1, 1 of K factors.
fn factorial(k: u32) -> Design {
    let sign = |run: u32, j: u32| if run >> j & 1 == 1 { 1.0 } else { -1.0 };
    Design::new(k as usize, (0..1 << k).flat_map(|run| (0..k).map(move |j| sign(run, j))).collect()).unwrap()
}

#[test]
fn a_factorial_is_all_hundreds_for_the_linear_model() {
    for k in 1..=6 {
        let evaluation = evaluated(&Model::linear(k as usize).unwrap(), &factorial(k));
        for criterion in [Criterion::D, Criterion::A, Criterion::G, Criterion::E, Criterion::T] {
            check("efficiency", percent(&evaluation, criterion), 100.0, 1e-9);
        }
        let precision = evaluation.precision.unwrap();
        let (n, p) = (f64::from(1_u32 << k), f64::from(k + 1));
        precision.leverages.iter().for_each(|&leverage| check("leverage", leverage, p / n, 1e-12));
        precision
            .coefficients
            .iter()
            .skip(1)
            .for_each(|row| check("inflation", row.variance_inflation.unwrap(), 1.0, 1e-12));
        // v = (1 + |x|^2) / N: 1/N at the center, p/N at the corners, (1 + K/3)/N on average.
        check("smallest", precision.predictions.minimum, 1.0 / n, 1e-9);
        check("largest", precision.predictions.maximum, p / n, 1e-9);
        check("mean", precision.predictions.mean, (1.0 + f64::from(k) / 3.0) / n, 1e-12);
        let largest = evaluation.correlations.largest().map_or(0.0, |(.., value)| value);
        check("correlation", largest, 0.0, 1e-12);
    }
}

#[test]
fn the_curve_of_a_linear_model_in_one_factor_is_a_parabola() {
    // v = (1 + x^2)/2, and |x| is at most f on the fraction f.
    let evaluation = evaluated(&Model::linear(1).unwrap(), &factorial(1));
    let curve = evaluation.precision.unwrap().fraction_of_space;
    assert_eq!(curve.fractions.len(), FractionOfSpace::N_POINTS);
    for (&fraction, &variance) in curve.fractions.iter().zip(&curve.variances) {
        check("curve", variance, 0.5 * (1.0 + fraction * fraction), 1e-3);
    }
    assert!(curve.variance_at(-0.1).is_none() && curve.variance_at(f64::NAN).is_none());
}

#[test]
fn confounded_designs_say_which_terms() {
    let evaluation = evaluated(&Model::quadratic(2).unwrap(), &factorial(2));
    assert_eq!(evaluation.precision, None);
    let aliases: Vec<String> = evaluation.aliases.iter().map(ToString::to_string).collect();
    assert_eq!(aliases, ["`x1^2` = 1", "`x2^2` = 1"]);
    let freedom = evaluation.degrees_of_freedom;
    assert_eq!((freedom.model, freedom.lack_of_fit, freedom.pure_error), (4, 0, 0));
    assert!(evaluation.to_string().contains("`x1^2` = 1"));

    // The half fraction x3 = x1 x2 confounds each product with the third factor.
    let half = Design::from_runs(&[[-1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [1.0, 1.0, 1.0]]).unwrap();
    let terms = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]];
    let model = Model::new(3, terms.into_iter().map(Term::new).collect()).unwrap();
    let mut settings = EvaluationSettings::default();
    settings.factors = vec!["mass".into(), "pitch".into(), "speed".into()];
    let evaluation = evaluate(&model, &Space::cube(3).unwrap(), &half, &settings).unwrap();
    let aliases: Vec<String> = evaluation.aliases.iter().map(ToString::to_string).collect();
    assert_eq!(aliases, ["`mass pitch` = `speed`", "`mass speed` = `pitch`", "`pitch speed` = `mass`"]);
    // The first of the three pairs is speed with mass pitch.
    assert_eq!(evaluation.correlations.largest().map(|(.., value)| value), Some(1.0));
}

#[test]
fn saturated_designs_have_full_leverage_and_nothing_to_check_with() {
    let saturated = Design::new(1, vec![-1.0, 0.2, 1.0]).unwrap();
    let evaluation = evaluated(&Model::quadratic(1).unwrap(), &saturated);
    let freedom = evaluation.degrees_of_freedom;
    assert_eq!((freedom.model, freedom.lack_of_fit, freedom.pure_error), (3, 0, 0));
    evaluation.precision.unwrap().leverages.iter().for_each(|&leverage| check("leverage", leverage, 1.0, 1e-10));
}

#[test]
fn replicates_and_runs_outside_are_named() {
    let design = Design::new(1, vec![-1.0, 0.0, 1.0, 0.0, 1.5, 0.0]).unwrap();
    let evaluation = evaluated(&Model::quadratic(1).unwrap(), &design);
    assert_eq!(evaluation.replicates, [vec![1, 3, 5]]);
    assert_eq!(evaluation.outside, [4]);
    let freedom = evaluation.degrees_of_freedom;
    assert_eq!((freedom.model, freedom.lack_of_fit, freedom.pure_error), (3, 1, 2));
    let text = evaluation.to_string();
    assert!(
        text.contains("replicates: runs 2, 4, 6") && text.starts_with("WARNING: run 5 is not in the space"),
        "{text}"
    );
}

/// The corners of the square in turn: in closed form every leverage of the linear model is 3/N, and every corner has N/4 runs.
#[test]
fn of_many_thousands_of_runs_the_report_is_short_and_its_numbers_can_be_read() {
    const N: usize = 200_000;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let runs: Vec<[f64; 2]> = corners.iter().copied().cycle().take(N).collect();
    let evaluation = evaluated(&Model::linear(2).unwrap(), &Design::from_runs(&runs).unwrap());
    assert_eq!(evaluation.degrees_of_freedom.pure_error, N - 4);
    for (corner, group) in evaluation.replicates.iter().enumerate() {
        assert!(group.iter().copied().eq((corner..N).step_by(4)), "corner {corner}");
    }
    let text = evaluation.to_string();
    assert!(text.len() < 4000, "{} bytes", text.len());
    let leverage = text.lines().find(|line| line.starts_with("leverage: 1.500e-5 (run ")).unwrap_or_default();
    assert!(leverage.contains(") to 1.500e-5 (run ") && leverage.ends_with(", 1.500e-5 in the mean"), "{text}");
    assert!(text.contains("193, 197 and 49950 more"), "{text}");
    assert!(text.contains("largest  1.500e-5 at"), "{text}");
}

#[test]
fn forbidden_runs_are_warned_of_first() {
    let design =
        Design::from_runs(&[[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [0.9, 0.8], [1.0, 1.0], [2.0, 0.0]]).unwrap();
    let corner = Forbidden::new(vec![Some([0.5, 1.0]), Some([0.5, 1.0])]).unwrap();
    let space = Space::cube(2).unwrap().forbid(vec![corner]).unwrap();
    let evaluation = evaluate(&Model::linear(2).unwrap(), &space, &design, &EvaluationSettings::default()).unwrap();
    assert_eq!((evaluation.outside.as_slice(), evaluation.forbidden.as_slice()), (&[3, 4, 5][..], &[3, 4][..]));
    let text = evaluation.to_string();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("WARNING: runs 4, 5 lie in a forbidden box"));
    let second = lines.next().unwrap_or_default();
    assert!(second.starts_with("WARNING: run 6 is not in the space"), "{second}");
    let third = lines.next().unwrap_or_default();
    assert_eq!(third, "6 runs, 3 terms of x1, x2, predictions over the cube [-1, 1]^2 less a forbidden box");
}

#[test]
fn the_sample_beside_forbidden_boxes_covers_what_is_left_evenly() {
    // v = (1 + x^2)/2 over [-1, 0] and [1/2, 1]: the exact curve.
    let middle = Forbidden::new(vec![Some([0.0, 0.5])]).unwrap();
    let space = Space::cube(1).unwrap().forbid(vec![middle]).unwrap();
    let evaluation =
        evaluate(&Model::linear(1).unwrap(), &space, &factorial(1), &EvaluationSettings::default()).unwrap();
    let curve = evaluation.precision.unwrap().fraction_of_space;
    for (&fraction, &variance) in curve.fractions.iter().zip(&curve.variances) {
        // |x| below 1/2 on the left only, above it on both sides.
        let size = if fraction <= 1.0 / 3.0 { 1.5 * fraction } else { 0.5 + 0.75 * (fraction - 1.0 / 3.0) };
        check("curve", variance, 0.5 * (1.0 + size * size), 1e-3);
    }
}

#[test]
fn every_set_is_sampled_as_it_is() {
    let model = Model::quadratic(2).unwrap();
    let design = Design::from_runs(&[
        [-1.0, -1.0],
        [1.0, -1.0],
        [-1.0, 1.0],
        [1.0, 1.0],
        [0.0, 0.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [1.0, 0.0],
    ])
    .unwrap();
    let sampled = |space: Space| {
        let evaluation = evaluate(&model, &space, &design, &EvaluationSettings::default()).unwrap();
        let text = evaluation.to_string();
        assert!(text.contains(&format!(
            "G-efficiency {:.3} % over the {}",
            percent(&evaluation, Criterion::G),
            space.over()
        )));
        let precision = evaluation.precision.unwrap();
        let curve = &precision.fraction_of_space;
        let (first, last) = (curve.variances[0], curve.variances[FractionOfSpace::N_POINTS - 1]);
        assert!(precision.predictions.minimum <= first);
        assert_eq!(last.to_bits(), precision.predictions.maximum.to_bits(), "the curve ends at what G is about");
        (curve.sampling, precision)
    };
    // Nine known points of the list, all of which the curve passes through: its ends are exact.
    let grid = Space::grid(&[3, 3]).unwrap();
    let (sampling, on_grid) = sampled(grid);
    assert_eq!(sampling, Sampling::All { n_points: 9 });
    let points: Vec<f64> = (0..9).flat_map(|i| [f64::from(i / 3) - 1.0, f64::from(i % 3) - 1.0]).collect();
    let (sampling, on_list) = sampled(Space::list(2, points).unwrap());
    assert_eq!(sampling, Sampling::All { n_points: 9 });
    assert_eq!(on_list.fraction_of_space, on_grid.fraction_of_space);
    check("mean", on_list.predictions.mean, on_grid.predictions.mean, 1e-12);
    check("minimum", on_list.predictions.minimum, on_grid.predictions.minimum, 1e-12);
    let corner = Forbidden::new(vec![Some([0.5, 1.0]), Some([0.5, 1.0])]).unwrap();
    let (sampling, _) = sampled(Space::grid(&[3, 3]).unwrap().forbid(vec![corner.clone()]).unwrap());
    assert_eq!(sampling, Sampling::All { n_points: 8 });
    let (sampling, _) = sampled(Space::cube(2).unwrap().forbid(vec![corner]).unwrap());
    assert_eq!(sampling, Sampling::QuasiRandom { n_points: 10_000, seed: 1 });
    let most = Forbidden::new(vec![Some([-0.99, 1.0]), None]).unwrap();
    let (sampling, _) = sampled(Space::cube(2).unwrap().forbid(vec![most]).unwrap());
    assert_eq!(sampling, Sampling::Random { n_points: 10_000, seed: 1 });
    let (sampling, _) = sampled(Space::of_axes(vec![Axis::Continuous, Axis::equally_spaced(24).unwrap()]).unwrap());
    assert_eq!(sampling, Sampling::QuasiRandom { n_points: 10_000, seed: 1 });
    let (sampling, _) = sampled(Space::grid(&[200, 200]).unwrap());
    assert_eq!(sampling, Sampling::QuasiRandom { n_points: 10_000, seed: 1 });
}

#[test]
fn the_sample_covers_the_space_in_any_dimension() {
    // The mean of the quantile curve against the exact mean: a sample that misses a part would not meet it.
    for k in 1..=7 {
        let runs = [factorial(k as u32).coordinates(), &vec![0.0; k]].concat();
        let mut settings = EvaluationSettings::default();
        settings.n_samples = 20_000;
        settings.seed = 3;
        let design = Design::new(k, runs).unwrap();
        let model = Model::linear(k).unwrap();
        let precision = evaluate(&model, &Space::cube(k).unwrap(), &design, &settings).unwrap().precision.unwrap();
        let variances = &precision.fraction_of_space.variances;
        let trapezoids: f64 = variances.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
        let mean = trapezoids / (variances.len() - 1) as f64;
        assert!((mean / precision.predictions.mean - 1.0).abs() < 5e-3, "{k}: {mean} {}", precision.predictions.mean);
    }
}

#[test]
fn slices_are_the_variance_itself() {
    let model = Model::quadratic(3).unwrap();
    let design = Design::new(3, (0..42).map(|i| (f64::from(i * i) * 0.7).sin()).collect()).unwrap();
    let variance = PredictionVariance::of(&model, &design).unwrap();
    let slice = VarianceSlice::of(&variance, [2, 0], &[0.9, 0.3, -0.2], 5).unwrap();
    assert_eq!(slice.levels, [-1.0, -0.5, 0.0, 0.5, 1.0]);
    // Third row: first factor at 0; second column: third factor at −0.5.
    check("slice", slice.variances[2 * 5 + 1], variance.at(&[0.0, 0.3, -0.5]).unwrap(), 1e-12);
    let refused = |factors, through: &[f64], n| VarianceSlice::of(&variance, factors, through, n).unwrap_err();
    assert_eq!(refused([0, 3], &[0.0; 3], 5), Error::NoSuchFactor { index: 3, n_factors: 3 });
    assert_eq!(
        refused([0, 1], &[0.0; 2], 5),
        Error::DesignSpace(doe::DesignSpaceError::PointLength { expected: 3, found: 2 })
    );
    assert!(matches!(refused([1, 1], &[0.0; 3], 5), Error::Count { found: 1, .. }));
    assert!(matches!(refused([0, 1], &[0.0; 3], 1), Error::Count { found: 1, least: 2, .. }));
}

#[test]
fn an_evaluation_serializes_with_its_set() {
    let evaluation = evaluated(&Model::linear(2).unwrap(), &factorial(2));
    let json = serde_json::to_value(&evaluation).unwrap();
    assert_eq!(json["over"], "cube [-1, 1]^2");
    assert_eq!(json["precision"]["efficiencies"][2]["criterion"], "G");
    assert_eq!(json["precision"]["efficiencies"][2]["over"], "cube [-1, 1]^2");
    assert_eq!(json["precision"]["fraction_of_space"]["fractions"].as_array().unwrap().len(), 201);
    assert_eq!(json["precision"]["fraction_of_space"]["sampling"]["quasi_random"]["seed"], 1);
    let efficiencies = &evaluation.precision.as_ref().unwrap().efficiencies;
    assert_eq!(serde_json::to_value(efficiencies).unwrap(), json["precision"]["efficiencies"], "each by itself");
}

#[test]
fn refuses_what_does_not_fit() {
    let (model, space) = (Model::linear(2).unwrap(), Space::cube(2).unwrap());
    let settings = EvaluationSettings::default();
    let error = evaluate(&model, &Space::cube(3).unwrap(), &factorial(2), &settings).unwrap_err();
    assert_eq!(error, Error::FactorMismatch { what: "the space", expected: 2, found: 3 });
    let error = evaluate(&model, &space, &factorial(3), &settings).unwrap_err();
    assert_eq!(error, Error::FactorMismatch { what: "the design", expected: 2, found: 3 });
    let mut none = settings;
    none.n_samples = 0;
    let error = evaluate(&model, &space, &factorial(2), &none).unwrap_err();
    assert_eq!(error.to_string(), "sample points: 0, expected 1 to 10000000");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn runs_in_another_order_say_the_same(flat in prop::collection::vec(-1.0..1.0, 20), shift in 0_usize..10) {
        let model = Model::quadratic(2).unwrap();
        let mut turned = flat.clone();
        turned.rotate_left(2 * shift);
        let (a, b) = (Design::new(2, flat).unwrap(), Design::new(2, turned).unwrap());
        let (a, b) = (evaluated(&model, &a), evaluated(&model, &b));
        prop_assert_eq!(a.degrees_of_freedom, b.degrees_of_freedom);
        let (a, b) = (a.precision.unwrap(), b.precision.unwrap());
        for (x, y) in a.efficiencies.iter().zip(&b.efficiencies) {
            prop_assert!((x.percent / y.percent - 1.0).abs() < 1e-6);
        }
        for (run, leverage) in a.leverages.iter().enumerate() {
            prop_assert!((leverage - b.leverages[(run + 10 - shift) % 10]).abs() < 1e-6);
        }
        prop_assert!((a.leverages.iter().sum::<f64>() - 6.0).abs() < 1e-6, "leverages sum to p");
    }

    #[test]
    fn factors_in_another_order_or_direction_say_the_same(flat in prop::collection::vec(-1.0..1.0, 24)) {
        let model = Model::quadratic(2).unwrap();
        let mirrored: Vec<f64> = flat.chunks(2).flat_map(|run: &[f64]| [run[1], -run[0]]).collect();
        let a = evaluated(&model, &Design::new(2, flat).unwrap()).precision.unwrap();
        let b = evaluated(&model, &Design::new(2, mirrored).unwrap()).precision.unwrap();
        for (x, y) in a.efficiencies.iter().zip(&b.efficiencies) {
            prop_assert!((x.percent / y.percent - 1.0).abs() < 1e-6, "{} {}", x, y);
        }
        // 1, x1, x2, x1 x2, x1^2, x2^2: the first and second factor change places.
        for (i, j) in [(1, 2), (2, 1), (3, 3), (4, 5), (5, 4)] {
            let (x, y) = (a.coefficients[i].variance_inflation.unwrap(), b.coefficients[j].variance_inflation.unwrap());
            prop_assert!((x / y - 1.0).abs() < 1e-6);
        }
        // The sample is not mirrored: of two valleys equally deep to 1e-3 it may lead into either.
        prop_assert!((a.predictions.minimum / b.predictions.minimum - 1.0).abs() < 1e-3);
    }

    #[test]
    fn inflation_is_at_least_one_and_leverage_at_most_one(flat in prop::collection::vec(-1.0..1.0, 36)) {
        let design = Design::new(3, flat).unwrap();
        let evaluation = evaluated(&Model::quadratic(3).unwrap(), &design);
        let precision = evaluation.precision.unwrap();
        for inflation in precision.coefficients.iter().filter_map(|row| row.variance_inflation) {
            prop_assert!(inflation > 1.0 - 1e-9);
        }
        let predictions = &precision.predictions;
        for &leverage in &precision.leverages {
            prop_assert!((0.0..1.0 + 1e-9).contains(&leverage));
            prop_assert!(leverage >= 0.999 * predictions.minimum && leverage <= 1.000_001 * predictions.maximum);
        }
        prop_assert!(predictions.minimum < predictions.mean && predictions.mean < predictions.maximum);
        let variances = &precision.fraction_of_space.variances;
        prop_assert!(variances.windows(2).all(|pair| pair[0] <= pair[1]));
    }

    #[test]
    fn linear_coefficients_inflate_alike_in_any_unit(
        flat in prop::collection::vec(-1.0..1.0, 16), scale in 0.1..0.9, shift in -0.1..0.1,
    ) {
        let model = Model::linear(2).unwrap();
        let moved: Vec<f64> = flat.iter().map(|x| scale * x + shift).collect();
        let a = evaluated(&model, &Design::new(2, flat).unwrap()).precision.unwrap();
        let b = evaluated(&model, &Design::new(2, moved).unwrap()).precision.unwrap();
        for (x, y) in a.coefficients.iter().zip(&b.coefficients).skip(1) {
            let ratio = x.variance_inflation.unwrap() / y.variance_inflation.unwrap();
            prop_assert!((ratio - 1.0).abs() < 1e-6);
        }
    }
}

/// The second factor is zero in all runs: its term does not vary, and goes with nothing.
#[test]
fn what_does_not_vary_has_no_correlation() {
    let design = Design::from_runs(&[[-1.0, 0.0], [0.5, 0.0], [1.0, 0.0]]).unwrap();
    let found = evaluated(&Model::linear(2).unwrap(), &design).correlations;
    assert_eq!(found.values, [Some(1.0), None, None, None]);
}
