//! Invariants of dimensional analysis.

use proptest::prelude::*;
use scaling::{BigRational, Dimension, Factor, SetUp, System, Units, Variable};

use crate::ratio;

const BASES: [&str; 4] = ["M", "L", "T", "angle"];

fn exponent() -> impl Strategy<Value = BigRational> {
    (-4i64..5, 1i64..4).prop_map(|(n, d)| BigRational::new(n.into(), d.into()))
}

fn dimension() -> impl Strategy<Value = Dimension> {
    prop::collection::vec(prop_oneof![Just(BigRational::default()), exponent()], BASES.len()).prop_map(|exponents| {
        BASES.iter().zip(exponents).fold(Dimension::one(), |product, (base, exponent)| {
            &product * &Dimension::base(base).unwrap().pow(&exponent)
        })
    })
}

fn system() -> impl Strategy<Value = System> {
    prop::collection::vec(dimension(), 1..8).prop_map(|dimensions| {
        let variable = |(i, dimension)| Variable { name: format!("x_{i}"), dimension };
        System::new(dimensions.into_iter().enumerate().map(variable).collect()).unwrap()
    })
}

fn factor() -> impl Strategy<Value = Factor> {
    let base =
        prop::sample::select(vec![2u64, 3, 6, 10, 12, 100, 1225, 65537, 65537 * 3, 65537 * 1_000_003, 1_000_003]);
    prop::collection::vec((base, exponent()), 0..4).prop_map(|powers| {
        powers.into_iter().fold(Factor::one(), |product, (base, e)| {
            &product * &Factor::from_rational(&BigRational::from_integer(base.into())).unwrap().pow(&e)
        })
    })
}

/// Number of variables minus rank, by determinants modulo a prime: independent of the crate's elimination.
fn rank_modulo_prime(system: &System) -> usize {
    const P: i128 = 1_000_000_007;
    let inverse = |a: i128| {
        let (mut result, mut base, mut power) = (1, a.rem_euclid(P), P - 2);
        while power > 0 {
            if power % 2 == 1 {
                result = result * base % P;
            }
            base = base * base % P;
            power /= 2;
        }
        result
    };
    let entry = |e: &BigRational| {
        let part = |n: &num_bigint::BigInt| i128::try_from(n).unwrap();
        (part(e.numer()) * inverse(part(e.denom()))).rem_euclid(P)
    };
    let mut rows: Vec<Vec<i128>> =
        system.variables().iter().map(|v| BASES.iter().map(|b| entry(&v.dimension.exponent(b))).collect()).collect();
    let mut rank = 0;
    for column in 0..BASES.len() {
        let Some(pivot) = (rank..rows.len()).find(|r| rows[*r][column] != 0) else { continue };
        rows.swap(rank, pivot);
        let pivot_row = rows[rank].clone();
        for row in &mut rows[rank + 1..] {
            let multiple = row[column] * inverse(pivot_row[column]) % P;
            row.iter_mut().zip(&pivot_row).for_each(|(a, b)| *a = (*a - multiple * b).rem_euclid(P));
        }
        rank += 1;
    }
    rank
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn rank_theorem_holds(system in system()) {
        let rank = rank_modulo_prime(&system);
        prop_assert_eq!(system.rank(), rank);
        let groups = system.groups(&system.propose_repeating()).unwrap();
        prop_assert_eq!(groups.len(), system.variables().len() - rank);
    }

    #[test]
    fn groups_are_dimensionless_coprime_and_read_back(system in system()) {
        for group in &system.groups(&system.propose_repeating()).unwrap() {
            let dimension = group.factors().fold(Dimension::one(), |product, (name, e)| {
                &product * &system.variable(name).unwrap().dimension.pow(e)
            });
            prop_assert!(dimension.is_one());
            prop_assert!(group.factors().all(|(_, e)| e.is_integer()));
            let too_large = group.factors().any(|(_, e)| e.numer() > &1000.into() || e.numer() < &(-1000).into());
            if !too_large {
                prop_assert_eq!(&system.group(&group.to_string()).unwrap(), group);
            }
        }
    }

    #[test]
    fn values_do_not_depend_on_the_units(
        system in system(),
        values in prop::collection::vec(0.01f64..100.0, 8),
        scales in prop::collection::vec(1u64..50, 4),
        numerators in prop::collection::vec(1u64..50, 4),
    ) {
        let at = |scaled: bool| {
            system.variables().iter().zip(&values).fold(SetUp::new("s"), |set_up, (variable, value)| {
                let factor = BASES.iter().enumerate().fold(Factor::one(), |product, (i, base)| {
                    let ratio = BigRational::new(numerators[i].into(), scales[i].into());
                    &product * &Factor::from_rational(&ratio).unwrap().pow(&variable.dimension.exponent(base))
                });
                set_up.with(variable.name.clone(), if scaled { factor.apply(*value) } else { *value })
            })
        };
        let (before, after) = (at(false), at(true));
        for group in &system.groups(&system.propose_repeating()).unwrap() {
            // Each scaled value is off by half a unit in the last place, and a power multiplies that.
            let powers: f64 = group.factors().map(|(_, e)| e.to_string().parse::<f64>().unwrap().abs()).sum();
            if let (Ok(before), Ok(after)) = (group.value(&before), group.value(&after)) {
                prop_assert!((after / before).ln().abs() <= (2.0 * powers + 4.0) * f64::EPSILON, "{} {} {}", group, before, after);
            }
        }
    }

    #[test]
    fn rank_does_not_depend_on_the_bases(system in system(), k in 1i64..5, l in -3i64..4) {
        // Force, length and time, with a twist, in place of mass, length and time: an invertible change.
        let changed = system.variables().iter().map(|v| {
            let e = |base: &str| v.dimension.exponent(base);
            let (k, l) = (BigRational::from_integer(k.into()), BigRational::from_integer(l.into()));
            let new = [("F", &e("M") * &k), ("L", &e("L") - &e("M")), ("T", &e("T") + &e("M") * &l), ("angle", e("angle"))];
            let dimension = new.iter().fold(Dimension::one(), |p, (base, e)| &p * &Dimension::base(base).unwrap().pow(e));
            Variable { name: v.name.clone(), dimension }
        });
        let changed = System::new(changed.collect()).unwrap();
        prop_assert_eq!(changed.rank(), system.rank());
        let groups = system.groups(&system.propose_repeating()).unwrap();
        let theirs = changed.groups(&changed.propose_repeating()).unwrap();
        prop_assert!(groups.span_same_space(&theirs));
    }

    #[test]
    fn every_repeating_set_spans_the_same_space(system in system()) {
        let first = system.groups(&system.propose_repeating()).unwrap();
        let mut count = 0;
        for repeating in system.repeating_sets() {
            prop_assert!(system.groups(&repeating).unwrap().span_same_space(&first));
            count += 1;
        }
        prop_assert!(count > 0);
        // All subsets of the right size that work, found by trying them.
        let names: Vec<&str> = system.variables().iter().map(|v| v.name.as_str()).collect();
        let rank = system.rank();
        let tried = (0u32..1 << names.len())
            .filter(|set| set.count_ones() as usize == rank)
            .filter(|set| {
                let chosen: Vec<_> = names.iter().enumerate().filter(|(i, _)| set & (1 << i) != 0).map(|(_, n)| *n).collect();
                system.groups(&chosen).is_ok()
            })
            .count();
        prop_assert_eq!(count, tried);
    }

    #[test]
    fn dimensions_read_back(dimension in dimension()) {
        prop_assert_eq!(dimension.to_string().parse::<Dimension>().unwrap(), dimension);
    }

    #[test]
    fn units_read_back_from_their_parts(dimension in dimension(), prefix in prop::sample::select(vec!["", "k", "m", "µ", "c"])) {
        let mut units = Units::none();
        for base in BASES {
            units.base(base).unwrap();
        }
        prop_assert_eq!(units.parse(&dimension.to_string()).unwrap().dimension, dimension);
        let si = Units::si();
        let unit = format!("{prefix}N^(3/2)/({prefix}m^2*s)");
        let product = &si.parse(&format!("{prefix}N")).unwrap().factor.pow(&ratio("3/2"))
            * &si.parse(&format!("{prefix}m")).unwrap().factor.pow(&ratio("-2"));
        prop_assert_eq!(si.parse(&unit).unwrap().factor, product);
    }

    #[test]
    fn factors_are_a_group_and_read_back(a in factor(), b in factor(), e in exponent()) {
        prop_assert!((&(&a * &b) / &b) == a);
        prop_assert_eq!(&a * &b, &b * &a);
        prop_assert_eq!((&a * &b).pow(&e), &a.pow(&e) * &b.pow(&e));
        prop_assert_eq!(a.to_string().parse::<Factor>().unwrap(), a.clone());
        prop_assert_eq!(a.inverse().inverse(), a.clone());
        prop_assert_eq!(a == b, (a.log10() - b.log10()).abs() < 1e-11);
        let product = (&a * &b).to_f64();
        prop_assert!((product / (a.to_f64() * b.to_f64()) - 1.0).abs() < 1e-15 * 4.0);
    }

    #[test]
    fn law_leaves_every_group_unchanged(system in system(), numbers in prop::collection::vec((1u64..100, 1u64..100), 4)) {
        let factors: Vec<_> = system.propose_repeating().into_iter().zip(&numbers).map(|(name, (n, d))| {
            (name.to_owned(), Factor::from_rational(&BigRational::new((*n).into(), (*d).into())).unwrap())
        }).collect();
        let law = system.law_from_factors(&factors).unwrap();
        for group in &system.groups(&system.propose_repeating()).unwrap() {
            let change = group.factors().fold(Factor::one(), |product, (name, e)| {
                &product * &law.rule(name).unwrap().factor.pow(e)
            });
            prop_assert!(change.is_one(), "{} changes by {}", group, change);
        }
        // All ratios that the law gives are redundant and agree.
        let all: Vec<_> = law.rules().map(|rule| (rule.quantity, rule.factor)).collect();
        prop_assert!(system.law_from_factors(&all).is_ok());
    }

    #[test]
    fn no_text_makes_a_reader_panic(text in "[-a-zA-Z0-9µ°%²⁻ ()*/^._·+]{0,24}") {
        let _ = Units::si().parse(&text);
        let _ = text.parse::<Factor>();
        let _ = text.parse::<Dimension>();
        let _ = System::parse(&Units::si(), &[("L_t", "m"), ("k_p^z", "1/s")]).unwrap().group(&text);
    }
}
