//! Models and terms, against hand counts.

use design_space::{Error, Model, Term};

#[test]
fn named_models_have_the_terms_of_the_source() {
    for k in 1..=7 {
        assert_eq!(Model::linear(k).unwrap().n_terms(), k + 1);
        assert_eq!(Model::additive_quadratic(k).unwrap().n_terms(), 2 * k + 1);
        assert_eq!(Model::quadratic(k).unwrap().n_terms(), (k + 1) * (k + 2) / 2);
    }
    let names = Model::quadratic(2).unwrap().term_names(&["a"]);
    assert_eq!(names, ["1", "a", "x2", "a x2", "a^2", "x2^2"]);
}

#[test]
fn a_regressor_is_the_value_of_every_term() {
    let model = Model::new(2, vec![Term::new([0, 0]), Term::new([3, 1]), Term::new([0, 2])]).unwrap();
    assert_eq!(model.regressor(&[2.0, -3.0]).unwrap(), [1.0, -24.0, 9.0]);
    assert_eq!(model.regressor(&[2.0]), Err(Error::PointLength { expected: 2, found: 1 }));
}

#[test]
fn refuses_terms_that_cannot_be() {
    let check = |terms: Vec<Term>, message: &str| {
        assert_eq!(Model::new(2, terms).unwrap_err().to_string(), message);
    };
    check(vec![], "number of terms of a model: 0, expected 1 to 256");
    check(vec![Term::new([1])], "exponents of term number 1 of the list: 1, expected one per factor: 2");
    check(vec![Term::new([9, 0])], "term `x1^9` has the exponent 9, expected 0 to 8");
    check(vec![Term::new([1, 0]), Term::new([1, 0])], "the term `x1` is given twice, expected distinct terms");
    assert_eq!(Model::quadratic(0).unwrap_err().to_string(), "number of factors of a model: 0, expected 1 to 12");
    assert_eq!(Model::quadratic(13).unwrap_err().to_string(), "number of factors of a model: 13, expected 1 to 12");
}

#[test]
fn dropping_terms_keeps_the_others_in_order() {
    let model = Model::quadratic(2).unwrap().without_terms(&[3, 5]).unwrap();
    assert_eq!(model.term_names(&[]), ["1", "x1", "x2", "x1^2"]);
    assert_eq!(model.without_terms(&[4]), Err(Error::NoSuchTerm { index: 4, n_terms: 4 }));
    assert!(model.is_affine_closed());
    assert!(!model.without_terms(&[1]).unwrap().is_affine_closed(), "x1^2 without x1");
}

#[test]
fn models_keep_through_files() {
    for model in [Model::quadratic(3).unwrap(), Model::linear(2).unwrap().without_terms(&[1]).unwrap()] {
        let text = serde_json::to_string(&model).unwrap();
        assert_eq!(serde_json::from_str::<Model>(&text).unwrap(), model, "{text}");
    }
    let error = serde_json::from_str::<Model>(r#"{"n_factors":2,"terms":"cubic"}"#).unwrap_err();
    assert!(error.to_string().contains("expected \"linear\", \"additive quadratic\", \"quadratic\""), "{error}");
}
