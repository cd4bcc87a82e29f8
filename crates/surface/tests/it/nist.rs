//! The Longley data of the Statistical Reference Datasets of NIST: certified to 15 digits, condition 5e9.

use doe::Model;
use surface::{Data, Regression};

use crate::check_close;

const LONGLEY: [[f64; 7]; 16] = [
    [60323.0, 83.0, 234289.0, 2356.0, 1590.0, 107608.0, 1947.0],
    [61122.0, 88.5, 259426.0, 2325.0, 1456.0, 108632.0, 1948.0],
    [60171.0, 88.2, 258054.0, 3682.0, 1616.0, 109773.0, 1949.0],
    [61187.0, 89.5, 284599.0, 3351.0, 1650.0, 110929.0, 1950.0],
    [63221.0, 96.2, 328975.0, 2099.0, 3099.0, 112075.0, 1951.0],
    [63639.0, 98.1, 346999.0, 1932.0, 3594.0, 113270.0, 1952.0],
    [64989.0, 99.0, 365385.0, 1870.0, 3547.0, 115094.0, 1953.0],
    [63761.0, 100.0, 363112.0, 3578.0, 3350.0, 116219.0, 1954.0],
    [66019.0, 101.2, 397469.0, 2904.0, 3048.0, 117388.0, 1955.0],
    [67857.0, 104.6, 419180.0, 2822.0, 2857.0, 118734.0, 1956.0],
    [68169.0, 108.4, 442769.0, 2936.0, 2798.0, 120445.0, 1957.0],
    [66513.0, 110.8, 444546.0, 4681.0, 2637.0, 121950.0, 1958.0],
    [68655.0, 112.6, 482704.0, 3813.0, 2552.0, 123366.0, 1959.0],
    [69564.0, 114.2, 502601.0, 3931.0, 2514.0, 125368.0, 1960.0],
    [69331.0, 115.7, 518173.0, 4806.0, 2572.0, 127852.0, 1961.0],
    [70551.0, 116.9, 554894.0, 4007.0, 2827.0, 130081.0, 1962.0],
];

const COEFFICIENTS: [f64; 7] = [
    -3482258.63459582,
    15.0618722713733,
    -0.358191792925910e-1,
    -2.02022980381683,
    -1.03322686717359,
    -0.511041056535807e-1,
    1829.15146461355,
];
const STANDARD_ERRORS: [f64; 7] = [
    890420.383607373,
    84.9149257747669,
    0.334910077722432e-1,
    0.488399681651699,
    0.214274163161675,
    0.226073200069370,
    455.478499142212,
];
/// Eight digits: the condition with columns of unit length is 4e4, and 15 digits are certified.
const DIGITS: f64 = 1e-8;

fn longley() -> Regression {
    let points = LONGLEY.iter().flat_map(|row| row[1..].iter().copied()).collect();
    let data = Data::new(6, points, LONGLEY.iter().map(|row| row[0]).collect()).expect("valid data");
    Regression::fit(&Model::linear(6).expect("a valid model"), &data).expect("enough data")
}

#[test]
fn matches_the_certified_values_of_longley() {
    let fit = longley();
    let errors = fit.standard_errors().expect("nine degrees of freedom");
    for term in 0..7 {
        check_close(fit.coefficients()[term] / COEFFICIENTS[term], 1.0, DIGITS, "coefficient over certified");
        check_close(errors[term] / STANDARD_ERRORS[term], 1.0, DIGITS, "standard error over certified");
    }
    let sigma = fit.sigma_squared().expect("nine degrees of freedom").sqrt();
    check_close(sigma / 304.854073561965, 1.0, DIGITS, "residual standard deviation");
    check_close(fit.r_squared().expect("variation"), 0.995479004577296, DIGITS, "R^2");
}

/// scipy 1.17 of the certified numbers: t = b/s, `2*t.sf(abs(t), 9)`, b ∓ `t.ppf(0.975, 9)`·s.
#[test]
fn tests_of_longley_are_those_of_its_certified_numbers() {
    let t = [
        -3.910802918154339,
        0.17737602822999873,
        -1.0695163172210467,
        -4.136427355940727,
        -4.8219853104454575,
        -0.22605114466420403,
        4.015889812709781,
    ];
    let p = [
        0.00356040366372623,
        0.8631408328092144,
        0.3126810610927116,
        0.0025350917341112255,
        0.0009443667641617974,
        0.8262117957636468,
        0.0030368033416303102,
    ];
    let low = [
        -5496529.483274764,
        -177.02903529849357,
        -0.11158110241390132,
        -3.125066641973584,
        -1.5179487001723644,
        -0.5625172145072177,
        798.787515278419,
    ];
    let tests = longley().coefficient_tests(0.95).expect("nine degrees of freedom");
    for (term, test) in tests.iter().enumerate() {
        check_close(test.t / t[term], 1.0, DIGITS, "t over certified");
        check_close(test.p_value / p[term], 1.0, 1e-7, "p over certified");
        check_close(test.interval[0] / low[term], 1.0, DIGITS, "lower end over certified");
    }
}
