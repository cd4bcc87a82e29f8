//! The groups of random systems against null spaces computed by sympy (`fixtures/scaling/null_spaces.json`).

use std::collections::BTreeMap;

use ::serde::Deserialize;
use scaling::{BigRational, Dimension, Group, System, Variable};

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/scaling/null_spaces.json");

#[derive(Deserialize)]
struct Fixture {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    bases: Vec<String>,
    dimensions: Vec<Vec<String>>,
    rank: usize,
    null_space: Vec<Vec<String>>,
}

impl Case {
    fn system(&self) -> System {
        let dimension = |exponents: &Vec<String>| {
            self.bases.iter().zip(exponents).fold(Dimension::one(), |product, (base, exponent)| {
                &product * &Dimension::base(base).unwrap().pow(&exponent.parse().unwrap())
            })
        };
        let variable = |(i, exponents)| Variable { name: format!("x{i}"), dimension: dimension(exponents) };
        System::new(self.dimensions.iter().enumerate().map(variable).collect()).unwrap()
    }

    fn group(&self, exponents: &[BigRational]) -> Group {
        let pairs = exponents.iter().enumerate().filter(|(_, e)| **e != BigRational::default());
        let pairs: Vec<_> = pairs.map(|(i, e)| (format!("x{i}"), e.to_string())).collect();
        Group::try_from(pairs).unwrap()
    }

    fn null_space(&self) -> Vec<Vec<BigRational>> {
        self.null_space.iter().map(|row| row.iter().map(|e| e.parse().unwrap()).collect()).collect()
    }
}

fn cases() -> Vec<Case> {
    serde_json::from_str::<Fixture>(&std::fs::read_to_string(FIXTURE).unwrap()).unwrap().cases
}

/// The coordinates of a vector in a basis in reduced echelon form are its entries at the pivots.
fn is_combination(basis: &[Vec<BigRational>], vector: &[BigRational]) -> bool {
    let zero = BigRational::default();
    let mut rest = vector.to_vec();
    for row in basis {
        let pivot = row.iter().position(|e| *e != zero).unwrap();
        let coordinate = vector[pivot].clone();
        rest.iter_mut().zip(row).for_each(|(r, e)| *r -= &coordinate * e);
    }
    rest.iter().all(|e| *e == zero)
}

#[test]
fn ranks_and_counts_are_those_of_sympy() {
    let cases = cases();
    assert!(cases.len() >= 300);
    for (number, case) in cases.iter().enumerate() {
        let system = case.system();
        assert_eq!(system.rank(), case.rank, "case {number}");
        assert_eq!(system.n_groups(), case.null_space.len(), "case {number}");
        assert_eq!(system.n_groups(), system.variables().len() - case.rank, "case {number}");
    }
}

#[test]
fn every_group_lies_in_the_null_space_of_sympy() {
    for (number, case) in cases().iter().enumerate() {
        let system = case.system();
        let basis = case.null_space();
        let groups = system.groups(&system.propose_repeating()).unwrap();
        assert_eq!(groups.len(), basis.len(), "case {number}");
        for group in &groups {
            let exponents: Vec<_> = system.variables().iter().map(|v| group.exponent(&v.name)).collect();
            assert!(exponents.iter().all(BigRational::is_integer), "case {number}: {group}");
            assert!(is_combination(&basis, &exponents), "case {number}: {group}");
        }
    }
}

#[test]
fn groups_span_the_null_space_of_sympy_for_several_repeating_sets() {
    for (number, case) in cases().iter().enumerate() {
        let system = case.system();
        let listed: Vec<_> = case.null_space().iter().map(|row| case.group(row)).collect();
        for repeating in system.repeating_sets().take(3) {
            let groups = system.groups(&repeating).unwrap();
            assert!(groups.span_same_space(&listed), "case {number}");
            if listed.len() > 1 {
                assert!(!groups.span_same_space(&listed[1..]), "case {number}");
            }
        }
    }
}

#[test]
fn variables_in_no_group_are_the_zero_columns_of_sympy() {
    for (number, case) in cases().iter().enumerate() {
        let used: BTreeMap<usize, ()> = case
            .null_space()
            .iter()
            .flat_map(|row| {
                row.iter()
                    .enumerate()
                    .filter(|(_, e)| **e != BigRational::default())
                    .map(|(i, _)| (i, ()))
                    .collect::<Vec<_>>()
            })
            .collect();
        let system = case.system();
        let expected: Vec<_> =
            (0..system.variables().len()).filter(|i| !used.contains_key(i)).map(|i| format!("x{i}")).collect();
        assert_eq!(system.in_no_group(), expected, "case {number}");
    }
}
