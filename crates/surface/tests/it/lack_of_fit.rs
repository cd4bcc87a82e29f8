//! Lack of fit against pure error.

use doe::{Criterion, Model, Problem, Settings, Space, search};
use surface::{Data, Regression};

use crate::check_close;

fn line(points: &[f64], values: &[f64]) -> Regression {
    let data = Data::new(1, points.to_vec(), values.to_vec()).expect("valid data");
    Regression::fit(&Model::linear(1).expect("a valid model"), &data).expect("enough data")
}

#[test]
fn lack_of_fit_by_hand() {
    // Means 1, 4, 1 at -1, 0, 1, each of two points ±1: the line is 2, the means miss it by -1, 2, -1.
    let test =
        line(&[-1.0, -1.0, 0.0, 0.0, 1.0, 1.0], &[0.0, 2.0, 3.0, 5.0, 0.0, 2.0]).lack_of_fit().expect("replicates");
    assert_eq!((test.lack_of_fit_degrees, test.pure_error_degrees), (1, 3));
    check_close(test.lack_of_fit, 12.0, 1e-13, "2 (1 + 4 + 1)");
    check_close(test.pure_error, 6.0, 1e-13, "six times 1");
    check_close(test.f, 6.0, 1e-12, "12/(6/3)");
    // F with 1 and 3 degrees of freedom is t² with 3: P(|t| > √6), closed form of Student's distribution for 3.
    let s = 2.0_f64.sqrt();
    let p = 1.0 - 2.0 / std::f64::consts::PI * (s.atan() + s / (1.0 + s * s));
    check_close(test.p_value, p, 1e-12, "p value");
}

#[test]
fn replicates_that_agree_make_any_lack_of_fit_certain() {
    let test = line(&[-1.0, -1.0, 0.0, 1.0], &[2.0, 2.0, 5.0, 2.0]).lack_of_fit().expect("replicates");
    assert!(test.f > 1e20 && test.p_value < 1e-10, "{test:?}");
    let test = line(&[-1.0, -1.0, 0.0, 1.0], &[0.0; 4]).lack_of_fit().expect("replicates");
    assert_eq!((test.f, test.p_value), (0.0, 1.0), "nothing is missed");
}

/// The best four runs of a line for the mean prediction have the middle twice, which a search finds but for its last bits.
#[test]
fn a_repeat_that_a_search_chose_gives_pure_error() {
    let model = Model::quadratic(1).expect("a valid model");
    let problem = Problem::new(model, Space::cube(1).expect("a line"), 4, Criterion::I).expect("a problem");
    let design = search(&problem, &Settings::default()).expect("a design").design;
    let values: Vec<f64> = design.coordinates().iter().map(|x| 1.0 + x).collect();
    let test = line(design.coordinates(), &values).lack_of_fit().expect("replicates");
    assert_eq!((test.lack_of_fit_degrees, test.pure_error_degrees), (1, 1), "{design:?}");
}
