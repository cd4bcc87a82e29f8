//! A straight line: everything has a closed form. And what a line cannot tell.

use infuse::identification::{Answer, Identification, Noise, RangeEnd, Settings, identify};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::{each, readings, unknowns};

const XS: [f64; 6] = [0.0, 1.0, 2.0, 4.0, 5.0, 6.0];

fn line(theta: &[f64], x: &[f64]) -> Answer {
    Ok(vec![theta[0] + theta[1] * x[0]])
}

fn estimated() -> Settings {
    let mut settings = Settings::default();
    settings.noise = Noise::Estimated;
    settings
}

#[test]
fn standard_errors_and_correlation_of_a_line_are_those_of_the_textbook() {
    let ys = [1.1, 2.9, 5.2, 8.8, 11.3, 12.9];
    let pairs: Vec<(f64, f64)> = XS.into_iter().zip(ys).collect();
    let found = identify(
        &unknowns(&[(-50.0, 50.0, 3.0), (-50.0, 50.0, -4.0)]),
        &readings(&pairs, 0.7),
        &estimated(),
        &mut each(line),
    )
    .unwrap();
    let mean = XS.iter().sum::<f64>() / 6.0;
    let spread: f64 = XS.iter().map(|x| (x - mean).powi(2)).sum();
    let slope: f64 = pairs.iter().map(|(x, y)| (x - mean) * y).sum::<f64>() / spread;
    let intercept = ys.iter().sum::<f64>() / 6.0 - slope * mean;
    let squares: f64 = pairs.iter().map(|(x, y)| (y - intercept - slope * x).powi(2)).sum();
    let s = (squares / 4.0).sqrt();
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-7, "{found} is not {expected}");
    close(found.estimates[0].value, intercept);
    close(found.estimates[1].value, slope);
    close(found.estimates[1].standard_error.unwrap(), s / spread.sqrt());
    close(found.estimates[0].standard_error.unwrap(), s * (1.0 / 6.0 + mean * mean / spread).sqrt());
    let mean_square = XS.iter().map(|x| x * x).sum::<f64>() / 6.0;
    close(found.correlation(0, 1).unwrap(), -mean / mean_square.sqrt());
    close(found.sigma * 0.7, s);
    // Student's 97.5 % quantile for four degrees of freedom, from a table.
    let [lower, upper] = found.estimates[1].interval(0.95).unwrap().unwrap();
    assert!((0.5 * (upper - lower) / (s / spread.sqrt()) - 2.776_445).abs() < 1e-5);
    assert_eq!((found.degrees_of_freedom, found.misfit()), (4, None));
}

#[test]
fn of_a_product_only_the_product_is_determined_and_the_start_decides_the_rest() {
    let pairs: Vec<(f64, f64)> = XS.iter().map(|x| (*x, 6.0 * x)).collect();
    let mut model = each(|t: &[f64], x: &[f64]| Ok(vec![(t[0] + t[1]) * x[0]]));
    let theta = unknowns(&[(0.0, 10.0, 1.0), (0.0, 10.0, 2.0), (0.0, 4.0, 3.0)]);
    let found = identify(&theta, &readings(&pairs, 0.1), &Settings::default(), &mut model).unwrap();
    // The nearest to the start with the sum of 6: each goes up by 1.5.
    for (estimate, expected) in found.estimates.iter().zip([2.5, 3.5, 3.0]) {
        assert!((estimate.value - expected).abs() < 1e-5, "{found:?}");
        assert_eq!((estimate.standard_error, estimate.is_determined()), (None, false));
    }
    let words: Vec<&str> = found.undetermined.iter().map(|direction| direction.words.as_str()).collect();
    assert_eq!(
        words,
        [
            "`a` and `b` are determined only together: a rise of `a` by 1.00 and a fall of `b` by 1.00 together change \
             nothing of what was measured",
            "`c` has no effect on what was measured"
        ]
    );
    assert_eq!(found.correlation(0, 1), None);
}

/// Two readings determine a line, and leave nothing that could tell of a misfit.
#[test]
fn as_many_readings_as_unknowns_say_nothing_of_the_model() {
    let theta = unknowns(&[(-10.0, 10.0, 0.0), (-10.0, 10.0, 0.0)]);
    let of =
        |pairs: &[(f64, f64)]| identify(&theta, &readings(pairs, 0.1), &Settings::default(), &mut each(line)).unwrap();
    let found = of(&[(0.0, 1.0), (2.0, 5.0)]);
    assert_eq!((found.degrees_of_freedom, found.misfit(), found.p_of_misfit()), (0, None, None));
    // A third, 0.3 off the line of the others: its distance from the best line is a closed form.
    let found = of(&[(0.0, 1.0), (1.0, 3.3), (2.0, 5.0)]);
    assert!((found.misfit().unwrap() - 3.0 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-6, "{:?}", found.misfit());
}

/// A model that fails less than a step above the bound at which an unknown starts: nothing is asked beyond it to get around
/// that.
#[test]
fn a_model_that_fails_beside_a_bound_is_not_asked_beyond_it() {
    let theta = unknowns(&[(0.0, 1.0, 0.0), (-10.0, 10.0, 0.0)]);
    let pairs = [(0.0, 1.0), (1.0, 1.0)];
    let (mut least, mut n_failed) = (0.0_f64, 0);
    let found =
        identify(&theta, &readings(&pairs, 0.1), &Settings::default(), &mut |all: &[Vec<f64>], _: &[Vec<f64>]| {
            let answer = |theta: &Vec<f64>| -> Vec<Answer> {
                least = least.min(theta[0]);
                n_failed += usize::from(theta[0] > 5e-6);
                let answer = if theta[0] > 5e-6 { Err("it breaks".to_owned()) } else { Ok(vec![theta[1]]) };
                vec![answer; pairs.len()]
            };
            all.iter().map(answer).collect()
        })
        .unwrap();
    assert!(least >= 0.0, "asked at {least}");
    assert!(n_failed > 1 && found.n_failed_simulations == n_failed, "{n_failed} {found:?}");
    assert!((found.estimates[1].value - 1.0).abs() < 1e-7, "{found:?}");
}

/// Where readings lie close together, an intercept far away is hardly told from the slope.
#[test]
fn what_noise_drowns_stays_at_its_start() {
    let pairs: Vec<(f64, f64)> = [9.9, 10.0, 10.1].into_iter().map(|x| (x, 1.0 + 2.0 * x)).collect();
    let theta = unknowns(&[(-10.0, 10.0, 3.0), (0.0, 4.0, 1.5)]);
    let found = identify(&theta, &readings(&pairs, 0.5), &Settings::default(), &mut each(line)).unwrap();
    let [intercept, slope] = [found.estimates[0].value, found.estimates[1].value];
    assert!((intercept + 10.0 * slope - 21.0).abs() < 1e-3, "what is determined is met: {found:?}");
    assert_eq!(found.undetermined.len(), 1);
    assert!(found.undetermined[0].words.contains("can hardly be told from none"), "{:?}", found.undetermined);
    // The same readings, a thousand times as precise: all is determined.
    let found = identify(&theta, &readings(&pairs, 5e-4), &Settings::default(), &mut each(line)).unwrap();
    assert!(found.undetermined.is_empty() && (found.estimates[0].value - 1.0).abs() < 1e-5, "{found:?}");
}

#[test]
fn an_optimum_outside_ends_at_the_bound_and_says_so() {
    let pairs: Vec<(f64, f64)> = XS.iter().map(|x| (*x, 1.0 + 2.0 * x)).collect();
    let theta = unknowns(&[(1.5, 9.0, 2.0), (-9.0, 9.0, 0.0)]);
    let found = identify(&theta, &readings(&pairs, 0.1), &Settings::default(), &mut each(line)).unwrap();
    assert_eq!(found.estimates[0].bound, Some(RangeEnd::Lower));
    assert!((found.estimates[0].value - 1.5).abs() < 1e-300, "the bound itself");
    // With the intercept known the slope is Σ x (y − 1.5) / Σ x².
    let squares: f64 = XS.iter().map(|x| x * x).sum();
    let slope: f64 = pairs.iter().map(|(x, y)| x * (y - 1.5)).sum::<f64>() / squares;
    assert!((found.estimates[1].value - slope).abs() < 1e-7);
    assert!((found.estimates[1].standard_error.unwrap() - 0.1 / squares.sqrt()).abs() < 1e-7);
    assert!(found.warnings().iter().any(|w| w == "`a` has run to its lower bound of 1.5"), "{:?}", found.warnings());
    assert!(found.warnings().iter().any(|w| w.contains("times as large as the noise")), "{:?}", found.warnings());
}

/// Fewer readings than unknowns: the line through one point that is nearest to the start in shares of the ranges.
#[test]
fn one_reading_of_two_unknowns_moves_them_no_farther_than_it_must() {
    let theta = unknowns(&[(-10.0, 10.0, 0.0), (-10.0, 10.0, 0.0)]);
    let found = identify(&theta, &readings(&[(2.0, 5.0)], 0.1), &Settings::default(), &mut each(line)).unwrap();
    assert!(
        (found.estimates[0].value - 1.0).abs() < 1e-5 && (found.estimates[1].value - 2.0).abs() < 1e-5,
        "{found:?}"
    );
    assert_eq!((found.undetermined.len(), found.degrees_of_freedom), (1, 0));
}

/// An interval of 90 % contains the truth in 90 % of draws: 1800 of 2000 within four standard deviations of a binomial, 54.
#[test]
fn intervals_contain_the_truth_as_often_as_they_say() {
    for settings in [Settings::default(), estimated()] {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let normal = Normal::new(0.0, 0.4).unwrap();
        let mut n_inside = [0_i32; 2];
        for _ in 0..2000 {
            let pairs: Vec<(f64, f64)> =
                XS.iter().map(|x| (*x, curve(1.0, 0.3, *x) + normal.sample(&mut rng))).collect();
            let theta = unknowns(&[(-50.0, 50.0, 0.0), (-1.0, 1.0, 0.1)]);
            let mut model = each(|t: &[f64], x: &[f64]| Ok(vec![curve(t[0], t[1], x[0])]));
            let found: Identification = identify(&theta, &readings(&pairs, 0.4), &settings, &mut model).unwrap();
            for ((estimate, truth), n_inside) in found.estimates.iter().zip([1.0, 0.3]).zip(&mut n_inside) {
                let [lower, upper] = estimate.interval(0.9).unwrap().expect("all is determined");
                *n_inside += i32::from((lower..=upper).contains(&truth));
            }
        }
        assert!(n_inside.iter().all(|n| (n - 1800).abs() <= 54), "{n_inside:?} of 2000, {:?}", settings.noise);
    }
}

fn curve(a: f64, b: f64, x: f64) -> f64 {
    a + (b * x).exp()
}
