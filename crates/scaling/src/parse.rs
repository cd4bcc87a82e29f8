//! Products of powers as people write them: `kg*m^-3`, `m/(s*rad)`, `L_t^3*rho/M_a`, `1.225/1000`.
//!
//! One grammar serves units, dimensions, groups and ratios:
//!
//! ```text
//! product  = power { ("*" | "/" | nothing) power }     "nothing" (a space) multiplies, but not after a "/"
//! power    = primary [ ("^" | "**") exponent ] | primary superscripts
//! primary  = number | symbol | "(" product ")"
//! exponent = [sign] number | "(" [sign] number [ "/" number ] ")"
//! ```

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::error::Error;
use crate::number::decimal;

/// Largest numerator and denominator of an exponent in a text.
pub(crate) const EXPONENT_LIMIT: u32 = 1000;
const NESTING_LIMIT: usize = 64;

/// What is raised to a power.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Atom {
    Number(BigRational),
    /// A symbol and the position of its first character, counted from 1.
    Symbol {
        symbol: String,
        position: usize,
    },
}

/// One factor of a product.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Term {
    pub(crate) atom: Atom,
    pub(crate) exponent: BigRational,
}

/// Reads a product of powers.
///
/// `verbatim` tells how many bytes at the start of the rest of the text are a symbol that the grammar alone would
/// take apart, such as `% chord` or `k_p^z`.
pub(crate) fn parse(text: &str, verbatim: &dyn Fn(&str) -> Option<usize>) -> Result<Vec<Term>, Error> {
    let mut parser = Parser { text, at: 0, depth: 0, verbatim };
    parser.skip_space();
    if parser.rest().is_empty() {
        return Err(parser.expected("a symbol or a number, and a dimensionless 1 is written `1`"));
    }
    let terms = parser.product()?;
    if parser.rest().is_empty() { Ok(terms) } else { Err(parser.expected("an operator (`*`, `/`, `^`) or the end")) }
}

/// Whether a character may stand inside a symbol.
pub(crate) fn continues_symbol(c: char) -> bool {
    (c.is_alphanumeric() || c == '_') && superscript(c).is_none()
}

/// Whether a character may begin a symbol.
pub(crate) fn begins_symbol(c: char) -> bool {
    (c.is_alphabetic() && superscript(c).is_none()) || matches!(c, '_' | '%' | '‰' | '°' | '$' | '€' | '£' | '\'' | '"')
}

/// Whether a symbol is one that the grammar reads unaided.
pub(crate) fn is_plain(symbol: &str) -> bool {
    let mut characters = symbol.chars();
    match characters.next() {
        Some('%' | '‰') => characters.next().is_none(),
        Some(first) => begins_symbol(first) && characters.all(continues_symbol),
        None => false,
    }
}

/// Length of `symbol` at the start of `rest`, if it stands there as a whole.
pub(crate) fn matches_whole(symbol: &str, rest: &str) -> Option<usize> {
    let after = rest.strip_prefix(symbol)?;
    let ends = !symbol.chars().next_back().is_some_and(continues_symbol);
    (ends || !after.chars().next().is_some_and(continues_symbol)).then_some(symbol.len())
}

fn superscript(c: char) -> Option<char> {
    const SUPERSCRIPTS: [char; 12] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹', '⁻', '⁺'];
    const PLAIN: [char; 12] = ['0', '1', '2', '3', '4', '5', '6', '7', '8', '9', '-', '+'];
    SUPERSCRIPTS.iter().zip(PLAIN).find(|(s, _)| **s == c).map(|(_, plain)| plain)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    verbatim: &'a dyn Fn(&str) -> Option<usize>,
}

impl Parser<'_> {
    fn product(&mut self) -> Result<Vec<Term>, Error> {
        let mut terms = self.power()?;
        let mut divided = false;
        loop {
            let spaced = self.skip_space();
            let Some(c) = self.peek() else { return Ok(terms) };
            let divide = match c {
                '*' | '·' | '×' | '⋅' => {
                    self.at += c.len_utf8();
                    divided = false;
                    false
                }
                '/' => {
                    self.at += 1;
                    divided = true;
                    true
                }
                ')' => return Ok(terms),
                _ if (spaced || c == '(') && self.begins_primary(c) => {
                    if divided {
                        let wanted =
                            "`*`, or parentheses around the denominator, because it is unclear what the `/` divides";
                        return Err(self.expected(wanted));
                    }
                    false
                }
                _ => return Ok(terms),
            };
            self.skip_space();
            let mut next = self.power()?;
            if divide {
                next.iter_mut().for_each(|term| term.exponent = -term.exponent.clone());
            }
            terms.append(&mut next);
        }
    }

    fn power(&mut self) -> Result<Vec<Term>, Error> {
        let mut terms = self.primary()?;
        let Some(exponent) = self.exponent_if_any()? else { return Ok(terms) };
        for term in &mut terms {
            term.exponent = &term.exponent * &exponent;
            self.check_exponent(&term.exponent)?;
        }
        let rest = self.rest().trim_start();
        if rest.starts_with('^') || rest.starts_with("**") {
            return Err(self.expected("parentheses, because a power of a power reads in two ways"));
        }
        Ok(terms)
    }

    fn primary(&mut self) -> Result<Vec<Term>, Error> {
        let position = self.position();
        if let Some(length) = (self.verbatim)(self.rest()) {
            let symbol = self.take(length);
            return Ok(vec![Term { atom: Atom::Symbol { symbol, position }, exponent: BigRational::one() }]);
        }
        let Some(c) = self.peek() else { return Err(self.expected("a symbol, a number or `(`")) };
        if c == '(' {
            return self.parenthesis();
        }
        let atom = if c.is_ascii_digit() || c == '.' {
            Atom::Number(self.number()?)
        } else if begins_symbol(c) {
            let rest = self.rest();
            let alone = matches!(c, '%' | '‰');
            let tail = rest.char_indices().skip(1).find(|(_, c)| alone || !continues_symbol(*c));
            let symbol = self.take(tail.map_or(rest.len(), |(end, _)| end));
            Atom::Symbol { symbol, position }
        } else {
            return Err(self.expected("a symbol, a number or `(`"));
        };
        Ok(vec![Term { atom, exponent: BigRational::one() }])
    }

    fn parenthesis(&mut self) -> Result<Vec<Term>, Error> {
        if self.depth == NESTING_LIMIT {
            return Err(self.expected("at most 64 parentheses inside each other"));
        }
        self.depth += 1;
        self.at += 1;
        self.skip_space();
        let terms = self.product()?;
        self.close()?;
        self.depth -= 1;
        Ok(terms)
    }

    fn close(&mut self) -> Result<(), Error> {
        self.skip_space();
        if self.peek() != Some(')') {
            return Err(self.expected("`)`"));
        }
        self.at += 1;
        Ok(())
    }

    fn exponent_if_any(&mut self) -> Result<Option<BigRational>, Error> {
        if let Some(plain) = self.superscripts() {
            let exponent = decimal(&plain).ok_or_else(|| self.expected("digits in the superscript"))?;
            self.check_exponent(&exponent)?;
            return Ok(Some(exponent));
        }
        let before = self.at;
        self.skip_space();
        let rest = self.rest();
        let operator = if rest.starts_with("**") {
            2
        } else if rest.starts_with('^') {
            1
        } else {
            self.at = before;
            return Ok(None);
        };
        self.at += operator;
        self.skip_space();
        let exponent = if self.peek() == Some('(') {
            self.at += 1;
            let mut value = self.signed_number()?;
            self.skip_space();
            if self.peek() == Some('/') {
                self.at += 1;
                self.skip_space();
                let denominator = self.number()?;
                if denominator.is_zero() {
                    return Err(self.expected("a denominator other than 0"));
                }
                value /= denominator;
            }
            self.close()?;
            value
        } else {
            let value = self.signed_number()?;
            if self.rest().starts_with('/') && self.rest()[1..].starts_with(|c: char| c.is_ascii_digit()) {
                return Err(self.expected("parentheses around a fractional exponent, as in `m^(1/2)`"));
            }
            value
        };
        self.check_exponent(&exponent)?;
        Ok(Some(exponent))
    }

    fn superscripts(&mut self) -> Option<String> {
        let plain: String = self.rest().chars().map_while(superscript).collect();
        let length: usize = self.rest().chars().take(plain.len()).map(char::len_utf8).sum();
        self.at += length;
        (!plain.is_empty()).then_some(plain)
    }

    fn signed_number(&mut self) -> Result<BigRational, Error> {
        self.skip_space();
        let negative = match self.peek() {
            Some('-' | '\u{2212}') => true,
            Some('+') => false,
            _ => return self.number(),
        };
        self.at += self.peek().map_or(0, char::len_utf8);
        self.skip_space();
        let value = self.number()?;
        Ok(if negative { -value } else { value })
    }

    /// Digits with an optional point and an optional power of ten; a lone `e` belongs to what follows.
    fn number(&mut self) -> Result<BigRational, Error> {
        let bytes = self.rest().as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end += 1 + digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let power = digits((end + 1 + sign).min(bytes.len()));
            if power > 0 {
                end += 1 + sign + power;
            }
        }
        let value = decimal(&self.rest()[..end]);
        let value = value.ok_or_else(|| self.expected("a number, at most 400 digits long and below 1e400"))?;
        self.at += end;
        Ok(value)
    }

    fn check_exponent(&self, exponent: &BigRational) -> Result<(), Error> {
        let limit = EXPONENT_LIMIT.into();
        if exponent.numer().abs() > limit || *exponent.denom() > limit {
            return Err(Error::ExponentTooLarge { exponent: exponent.to_string(), place: self.text.into() });
        }
        Ok(())
    }

    fn begins_primary(&self, c: char) -> bool {
        c == '(' || c == '.' || c.is_ascii_digit() || begins_symbol(c) || (self.verbatim)(self.rest()).is_some()
    }

    fn skip_space(&mut self) -> bool {
        let rest = self.rest();
        let space = rest.len() - rest.trim_start().len();
        self.at += space;
        space > 0
    }

    fn take(&mut self, length: usize) -> String {
        let taken = self.rest()[..length].to_owned();
        self.at += length;
        taken
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn position(&self) -> usize {
        self.text[..self.at].chars().count() + 1
    }

    fn expected(&self, expected: &'static str) -> Error {
        let found = self.rest().chars().next().map_or("the end".to_owned(), |c| format!("`{c}`"));
        Error::Syntax { text: self.text.into(), position: self.position(), found, expected }
    }
}
