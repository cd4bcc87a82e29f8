//! What the symbols in a unit string mean.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;

use crate::dimension::Dimension;
use crate::error::Error;
use crate::factor::Factor;
use crate::near::near_misses;
use crate::parse::{Atom, is_plain, matches_whole, parse};

/// A unit: how many coherent units it is, and of which dimension.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// Multiplies a number in this unit to give the number in the coherent unit; exact, also for degrees.
    pub factor: Factor,
    /// What the unit measures.
    pub dimension: Dimension,
}

/// The units that a reader of unit strings knows.
///
/// ```
/// use scaling::Units;
///
/// let mut units = Units::si();
/// units.define("% chord", "0.01")?;
/// units.base("USD")?;
/// assert_eq!(units.parse("cm^2")?.factor.to_string(), "1/10000");
/// assert_eq!(units.parse("1/(% chord)^2")?.factor.to_string(), "10000");
/// assert_eq!(units.parse("USD/(kW*h)")?.dimension.to_string(), "T^2*USD/(M*L^2)");
/// # Ok::<(), scaling::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Units {
    known: BTreeMap<String, Known>,
    /// Symbols that the grammar alone would take apart, the longest first.
    verbatim: Vec<String>,
}

#[derive(Debug, Clone)]
struct Known {
    unit: Unit,
    prefixes: bool,
}

/// SI prefixes with their power of ten.
const PREFIXES: [(&str, i32); 26] = [
    ("da", 1),
    ("Q", 30),
    ("R", 27),
    ("Y", 24),
    ("Z", 21),
    ("E", 18),
    ("P", 15),
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("d", -1),
    ("c", -2),
    ("m", -3),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("n", -9),
    ("p", -12),
    ("f", -15),
    ("a", -18),
    ("z", -21),
    ("y", -24),
    ("r", -27),
    ("q", -30),
];

/// Base units: symbol, factor, dimension. The gram takes the prefixes, the kilogram is coherent.
const BASES: [(&str, &str, &str); 7] = [
    ("m", "1", "L"),
    ("g", "1/1000", "M"),
    ("s", "1", "T"),
    ("A", "1", "I"),
    ("K", "1", "Theta"),
    ("mol", "1", "N"),
    ("cd", "1", "J"),
];

/// Derived units that take prefixes.
const PREFIXED: [(&str, &str); 26] = [
    ("Hz", "1/s"),
    ("N", "kg*m/s^2"),
    ("Pa", "N/m^2"),
    ("J", "N*m"),
    ("W", "J/s"),
    ("C", "A*s"),
    ("V", "W/A"),
    ("F", "C/V"),
    ("ohm", "V/A"),
    ("Ω", "V/A"),
    ("S", "A/V"),
    ("Wb", "V*s"),
    ("T", "Wb/m^2"),
    ("H", "Wb/A"),
    ("lm", "cd*sr"),
    ("lx", "lm/m^2"),
    ("Bq", "1/s"),
    ("Gy", "J/kg"),
    ("Sv", "J/kg"),
    ("kat", "mol/s"),
    ("L", "dm^3"),
    ("l", "dm^3"),
    ("eV", "1.602176634e-19*J"),
    ("bar", "1e5*Pa"),
    ("Wh", "3600*J"),
    ("Ah", "3600*C"),
];

/// Other units, without prefixes.
const PLAIN: [(&str, &str); 41] = [
    ("%", "0.01"),
    ("‰", "0.001"),
    ("ppm", "1e-6"),
    ("deg", "pi/180*rad"),
    ("°", "deg"),
    ("arcmin", "deg/60"),
    ("arcsec", "deg/3600"),
    ("rev", "2*pi*rad"),
    ("min", "60*s"),
    ("rpm", "rev/min"),
    ("h", "3600*s"),
    ("hr", "3600*s"),
    ("d", "86400*s"),
    ("day", "86400*s"),
    ("t", "1000*kg"),
    ("ha", "1e4*m^2"),
    ("au", "149597870700*m"),
    ("atm", "101325*Pa"),
    ("Torr", "atm/760"),
    // The conventional one: a column of 13595.1 kg/m^3 in standard gravity.
    ("mmHg", "133.322387415*Pa"),
    ("inHg", "25.4*mmHg"),
    ("cal", "4.184*J"),
    ("kcal", "1000*cal"),
    ("St", "1e-4*m^2/s"),
    ("cSt", "St/100"),
    ("P", "0.1*Pa*s"),
    ("cP", "P/100"),
    ("in", "0.0254*m"),
    ("ft", "0.3048*m"),
    ("yd", "0.9144*m"),
    ("mi", "1609.344*m"),
    ("nmi", "1852*m"),
    ("knot", "nmi/h"),
    ("mph", "mi/h"),
    ("lb", "0.45359237*kg"),
    ("oz", "lb/16"),
    ("lbf", "lb*9.80665*m/s^2"),
    ("slug", "lbf*s^2/ft"),
    ("kgf", "kg*9.80665*m/s^2"),
    ("psi", "lbf/in^2"),
    ("hp", "550*ft*lbf/s"),
];

/// Units with an offset, and what to use instead.
const AFFINE: [(&str, &str); 6] =
    [("degC", KELVIN), ("°C", KELVIN), ("celsius", KELVIN), ("degF", KELVIN), ("°F", KELVIN), ("fahrenheit", KELVIN)];
const KELVIN: &str = "give temperatures and their differences in K";

/// Names in full, for the near misses only.
const SPELLED: [(&str, &str); 22] = [
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("metres", "m"),
    ("gram", "g"),
    ("grams", "g"),
    ("kilogram", "kg"),
    ("sec", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("minute", "min"),
    ("hour", "h"),
    ("liter", "L"),
    ("litre", "L"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("newton", "N"),
    ("pascal", "Pa"),
    ("kelvin", "K"),
    ("percent", "%"),
];

const UNIT_NAME: &str = "a unit begins with a letter or one of _ % ‰ ° $ € £, holds none of * / ^ ( ) · × and no number \
                         after a space, and has no space at its ends";

impl Units {
    /// Nothing but `1`.
    #[must_use]
    pub fn none() -> Self {
        let mut units = Self { known: BTreeMap::new(), verbatim: Vec::new() };
        for (symbol, _) in AFFINE {
            units.remember_verbatim(symbol);
        }
        units
    }

    /// The SI with its prefixes, `rad` and `sr` being 1, and common units beside it (`deg`, `%`, `min`, `rpm`, `L`, `kWh`, `mmHg`,
    /// `cP`, `ft`, …).
    #[must_use]
    pub fn si() -> Self {
        Self::with_radian(&Dimension::one())
    }

    /// As [`si`](Self::si), but angles are a base dimension `angle`: degrees, radians and `sr` (rad²) count.
    #[must_use]
    pub fn si_with_angle() -> Self {
        Self::with_radian(&Dimension::from_exponents(
            [("angle".to_owned(), BigRational::from_integer(1.into()))].into(),
        ))
    }

    #[expect(clippy::expect_used, reason = "the tables of this file, all read by a test")]
    fn with_radian(angle: &Dimension) -> Self {
        let mut units = Self::none();
        for (symbol, factor, dimension) in BASES {
            let factor = factor.parse().expect("a factor");
            units.insert(symbol, Unit { factor, dimension: dimension.parse().expect("a dimension") }, true);
        }
        units.insert("rad", Unit { factor: Factor::one(), dimension: angle.clone() }, true);
        let solid = angle.pow(&BigRational::from_integer(2.into()));
        units.insert("sr", Unit { factor: Factor::one(), dimension: solid }, true);
        for (symbol, definition) in PREFIXED {
            let unit = units.parse(definition).expect("a definition");
            units.insert(symbol, unit, true);
        }
        for (symbol, definition) in PLAIN {
            let unit = units.parse(definition).expect("a definition");
            units.insert(symbol, unit, false);
        }
        units
    }

    /// Adds a unit or a label by its definition: `("% chord", "0.01")`, `("furlong", "660 ft")`.
    ///
    /// The symbol may contain spaces; it is then read as a whole wherever it stands. It takes no SI prefixes.
    ///
    /// # Errors
    /// [`Error::BadName`], [`Error::UnitExists`], or what is wrong with the definition.
    pub fn define(&mut self, symbol: &str, definition: &str) -> Result<&mut Self, Error> {
        let unit = self.parse(definition)?;
        self.add(symbol, unit)
    }

    /// Adds a base: a unit that is the coherent unit of a new dimension of the same name.
    ///
    /// # Errors
    /// [`Error::BadName`], [`Error::UnitExists`], or [`Error::DimensionExists`]: the SI has a dimension `M` already.
    pub fn base(&mut self, symbol: &str) -> Result<&mut Self, Error> {
        self.base_as(symbol, symbol)
    }

    /// Adds a base whose dimension has another name than its unit: `("bit", "information")`.
    ///
    /// # Errors
    /// Those of [`base`](Self::base).
    pub fn base_as(&mut self, symbol: &str, dimension: &str) -> Result<&mut Self, Error> {
        let unit = Unit { factor: Factor::one(), dimension: Dimension::base(dimension)? };
        if self.find(symbol).is_none()
            && let Some(known) = self.unit_of(&unit.dimension)
        {
            let (symbol, unit) = (symbol.to_owned(), known.to_owned());
            return Err(Error::DimensionExists { symbol, dimension: dimension.to_owned(), unit });
        }
        self.add(symbol, unit)
    }

    /// A known unit in whose dimension this one stands, if there is one: that which has it alone and takes prefixes goes first.
    fn unit_of(&self, dimension: &Dimension) -> Option<&str> {
        let holds =
            |known: &Known| dimension.bases().all(|base| known.unit.dimension.bases().any(|other| other == base));
        let rank = |known: &Known| (known.unit.dimension != *dimension, !known.prefixes);
        let known = self.known.iter().filter(|(_, known)| holds(known));
        known.min_by_key(|(_, known)| rank(known)).map(|(symbol, _)| symbol.as_str())
    }

    /// Reads a unit string.
    ///
    /// # Errors
    /// [`Error::UnknownSymbol`] with near misses, [`Error::AffineUnit`], [`Error::Syntax`] with position and
    /// expectation, [`Error::ExponentTooLarge`], [`Error::NotPositive`] for the number 0.
    pub fn parse(&self, text: &str) -> Result<Unit, Error> {
        let verbatim = |rest: &str| self.verbatim.iter().find_map(|symbol| matches_whole(symbol, rest));
        let mut product = Unit { factor: Factor::one(), dimension: Dimension::one() };
        for term in parse(text, &verbatim)? {
            let unit = match term.atom {
                Atom::Number(number) => Unit { factor: Factor::from_rational(&number)?, dimension: Dimension::one() },
                Atom::Symbol { symbol, position } => {
                    self.find(&symbol).ok_or_else(|| self.unknown(symbol, position, text))?
                }
            };
            product.factor = &product.factor * &unit.factor.pow(&term.exponent);
            product.dimension.multiply(&unit.dimension, &term.exponent);
        }
        Ok(product)
    }

    fn find(&self, symbol: &str) -> Option<Unit> {
        if let Some(known) = self.known.get(symbol) {
            return Some(known.unit.clone());
        }
        if symbol == "pi" || symbol == "π" {
            return Some(Unit { factor: Factor::pi(), dimension: Dimension::one() });
        }
        PREFIXES.iter().find_map(|(prefix, power)| {
            let known = self.known.get(symbol.strip_prefix(prefix)?).filter(|known| known.prefixes)?;
            Some(Unit { factor: &known.unit.factor * &power_of_ten(*power), dimension: known.unit.dimension.clone() })
        })
    }

    fn unknown(&self, symbol: String, position: usize, text: &str) -> Error {
        let text = text.to_owned();
        if let Some((_, instead)) = AFFINE.iter().find(|(affine, _)| *affine == symbol) {
            return Error::AffineUnit { symbol, position, text, instead };
        }
        // `m2` is a slip for `m^2`.
        let stem = symbol.trim_end_matches(|c: char| c.is_ascii_digit());
        if stem.len() < symbol.len() && self.find(stem).is_some() {
            let near = vec![format!("{stem}^{}", &symbol[stem.len()..])];
            return Error::UnknownSymbol { what: "unit", symbol, position, text, near };
        }
        let spelled = near_misses(&symbol, SPELLED.iter().map(|(name, _)| (*name).to_owned()));
        let meant = SPELLED.iter().filter(|(name, _)| spelled.iter().any(|near| near == name));
        let mut near: Vec<_> = meant.map(|(_, unit)| (*unit).to_owned()).filter(|u| self.find(u).is_some()).collect();
        near.dedup();
        let plain = self.known.keys().cloned();
        let prefixed = self.known.iter().filter(|(_, known)| known.prefixes);
        let prefixed = prefixed.flat_map(|(unit, _)| PREFIXES.iter().map(move |(prefix, _)| format!("{prefix}{unit}")));
        if near.is_empty() {
            near = near_misses(&symbol, plain.clone().chain(prefixed));
            // Unless the case alone is wrong, whole symbols are likelier than prefixed ones.
            let without_prefix = near_misses(&symbol, plain);
            if !near.first().is_some_and(|near| near.eq_ignore_ascii_case(&symbol)) && !without_prefix.is_empty() {
                near = without_prefix;
            }
        }
        Error::UnknownSymbol { what: "unit", symbol, position, text, near }
    }

    fn add(&mut self, symbol: &str, unit: Unit) -> Result<&mut Self, Error> {
        let forbidden = |c: char| matches!(c, '*' | '/' | '^' | '(' | ')' | '·' | '×' | '⋅');
        let begins = symbol.chars().next().is_some_and(crate::parse::begins_symbol);
        let number = symbol.split_whitespace().any(|word| word.starts_with(|c: char| c.is_ascii_digit()));
        if !begins || number || symbol.trim() != symbol || symbol.contains(forbidden) {
            return Err(Error::BadName { name: symbol.into(), expected: UNIT_NAME });
        }
        let old = self.find(symbol);
        if let Some(old) = old {
            let meaning = format!("{} of dimension {}", old.factor, old.dimension);
            return Err(Error::UnitExists { symbol: symbol.into(), meaning });
        }
        self.insert(symbol, unit, false);
        Ok(self)
    }

    fn insert(&mut self, symbol: &str, unit: Unit, prefixes: bool) {
        self.remember_verbatim(symbol);
        self.known.insert(symbol.to_owned(), Known { unit, prefixes });
    }

    fn remember_verbatim(&mut self, symbol: &str) {
        if !is_plain(symbol) {
            self.verbatim.push(symbol.to_owned());
            self.verbatim.sort_by_key(|symbol| std::cmp::Reverse(symbol.len()));
        }
    }
}

fn power_of_ten(power: i32) -> Factor {
    let ten = BigRational::from_integer(BigInt::from(10u8));
    Factor::from_rational(&ten).unwrap_or_default().pow(&BigRational::from_integer(power.into()))
}
