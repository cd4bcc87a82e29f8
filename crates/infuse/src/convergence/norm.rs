//! Norms of functions over the cells of a region.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::checks::{check_cells, check_count, check_each, check_finite};

/// The order q of a norm, at least 1. In files `{ finite = 2.0 }` or `"infinity"`.
///
/// The dissertation calls it p, as it does a design.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedOrder", into = "UncheckedOrder")]
pub struct NormOrder(UncheckedOrder);

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum UncheckedOrder {
    Finite(f64),
    Infinity,
}

impl NormOrder {
    /// The largest magnitude, the only norm that says something about each single design.
    pub const INFINITY: Self = Self(UncheckedOrder::Infinity);

    /// A finite order q ≥ 1, not necessarily an integer.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`]; below 1 the triangle inequality fails, and every bound with it.
    pub fn finite(q: f64) -> Result<Self, Error> {
        if q >= 1.0 && q.is_finite() {
            Ok(Self(UncheckedOrder::Finite(q)))
        } else {
            Err(Error::Setting { name: "order", value: q, expected: "a finite q of at least 1, or infinity by name" })
        }
    }
}

impl TryFrom<UncheckedOrder> for NormOrder {
    type Error = Error;

    fn try_from(unchecked: UncheckedOrder) -> Result<Self, Error> {
        match unchecked {
            UncheckedOrder::Finite(q) => Self::finite(q),
            UncheckedOrder::Infinity => Ok(Self::INFINITY),
        }
    }
}

impl From<NormOrder> for UncheckedOrder {
    fn from(order: NormOrder) -> Self {
        order.0
    }
}

/// Whether a norm of finite order depends on the size of the region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NormScaling {
    /// The integral of (42) as it stands: it shrinks with the region, whatever the function does.
    Integral,
    /// The integral divided by the region's measure: a typical magnitude. It may grow when the region
    /// shrinks to where the function is large.
    Mean,
}

/// The norm (42) over the retained cells M of a region, each with its measure m:
///
/// ```text
/// ‖J‖ = (Σ_{p in M} m(p) |J(p)|^q)^(1/q)        Mean: divided by (Σ_{p in M} m(p))^(1/q)
/// ```
///
/// and max |J(p)| for q = ∞. The unit is that of J if measures are dimensionless, so they are taken in
/// coordinates coded to −1..1 over the original box, see [`coded_cell_measure`].
///
/// Source: (42).
///
/// ```
/// use infuse::convergence::{Norm, NormOrder, NormScaling};
///
/// let integral = Norm { order: NormOrder::finite(2.0)?, scaling: NormScaling::Integral };
/// assert_eq!(integral.over(&[3.0, -4.0], &[1.0, 1.0])?, 5.0);
/// assert_eq!(Norm::SUP.over(&[3.0, -4.0], &[1.0, 1.0])?, 4.0);
/// # Ok::<(), infuse::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Norm {
    /// The order q.
    pub order: NormOrder,
    /// Integral or mean; the same for q = ∞.
    pub scaling: NormScaling,
}

impl Norm {
    /// The largest magnitude.
    pub const SUP: Self = Self { order: NormOrder::INFINITY, scaling: NormScaling::Integral };

    /// The norm of a function with these values on cells with these measures, without overflow or
    /// underflow on the way.
    ///
    /// # Errors
    ///
    /// [`Error::EmptyRegion`]; [`Error::WrongCount`]; [`Error::Entry`] for a value that is not finite
    /// or a measure that is not positive; [`Error::Setting`] if the norm itself is too large for a double.
    pub fn over(&self, values: &[f64], measures: &[f64]) -> Result<f64, Error> {
        check_cells(values.len())?;
        check_count("measures", values.len(), measures.len(), "cell")?;
        check_finite("values", values)?;
        check_each("measures", measures, "a finite positive number", |m| m > 0.0 && m.is_finite())?;
        let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let UncheckedOrder::Finite(q) = self.order.0 else {
            return Ok(largest);
        };
        if largest <= 0.0 {
            return Ok(0.0);
        }
        // Every number in the sums is at most 1, and the largest of each kind is 1.
        let largest_measure = measures.iter().copied().fold(0.0, f64::max);
        let (mut sum, mut total) = (0.0, 0.0);
        for (value, measure) in values.iter().zip(measures) {
            let share = measure / largest_measure;
            sum += share * raised(value.abs() / largest, q);
            total += share;
        }
        let norm = match self.scaling {
            NormScaling::Mean => largest * root(sum / total, q),
            NormScaling::Integral => largest * root(sum, q) * root(largest_measure, q),
        };
        let expected = "a norm below the largest double";
        if norm.is_finite() { Ok(norm) } else { Err(Error::Setting { name: "norm", value: norm, expected }) }
    }

    /// (|J|/largest)^q, a share of at most 1; 0 for q = ∞ and where everything is 0.
    #[cfg(feature = "global")]
    pub(crate) fn share(&self, value: f64, largest: f64) -> f64 {
        match self.order.0 {
            UncheckedOrder::Finite(q) if largest > 0.0 => raised(value.abs() / largest, q),
            UncheckedOrder::Finite(_) | UncheckedOrder::Infinity => 0.0,
        }
    }

    /// The norm over cells of one measure from the largest magnitude and the sum of the [shares](Self::share).
    #[cfg(feature = "global")]
    pub(crate) fn of_shares(&self, largest: f64, sum: f64, n_cells: u64, measure: f64) -> Result<f64, Error> {
        if n_cells == 0 {
            return Err(Error::EmptyRegion);
        }
        let norm = match (self.order.0, self.scaling) {
            (UncheckedOrder::Infinity, _) => largest,
            (UncheckedOrder::Finite(q), NormScaling::Mean) => largest * root(sum / n_cells as f64, q),
            (UncheckedOrder::Finite(q), NormScaling::Integral) => largest * root(sum, q) * root(measure, q),
        };
        let expected = "a norm below the largest double";
        if norm.is_finite() { Ok(norm) } else { Err(Error::Setting { name: "norm", value: norm, expected }) }
    }
}

/// The measure of one of `n_cells` equal cells of the whole original box, in coordinates coded to
/// −1..1 per parameter: 2^n / `n_cells`, dimensionless. A cell keeps it when the region shrinks.
///
/// # Errors
///
/// [`Error::EmptyRegion`] without cells; [`Error::SettingCount`] without parameters or with more than
/// 1000.
pub fn coded_cell_measure(n_parameters: usize, n_cells: usize) -> Result<f64, Error> {
    check_cells(n_cells)?;
    match i32::try_from(n_parameters) {
        Ok(n @ 1..=1000) => Ok(2.0_f64.powi(n) / n_cells as f64),
        _ => Err(Error::SettingCount { name: "n_parameters", value: n_parameters, expected: "1 to 1000" }),
    }
}

/// The usual orders go without the platform's power function, and so are the same everywhere.
#[expect(clippy::float_cmp, reason = "an order is given, not computed")]
fn raised(value: f64, q: f64) -> f64 {
    if q == 1.0 {
        value
    } else if q == 2.0 {
        value * value
    } else {
        value.powf(q)
    }
}

#[expect(clippy::float_cmp, reason = "an order is given, not computed")]
fn root(value: f64, q: f64) -> f64 {
    if q == 1.0 {
        value
    } else if q == 2.0 {
        value.sqrt()
    } else {
        value.powf(1.0 / q)
    }
}
