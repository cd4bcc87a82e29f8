//! What can be wrong with a parameter, a region, a grid or a model.

/// Every fault of this crate, each naming the field, the value and what was allowed.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter has no name.
    #[error("a parameter has an empty name (unit \"{unit}\", bounds {lower:?} to {upper:?})")]
    EmptyName {
        /// Unit of the nameless parameter.
        unit: String,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// A bound is NaN, infinite or beyond [`Parameter::LARGEST_BOUND`](crate::Parameter::LARGEST_BOUND).
    #[error(
        "parameter `{parameter}`: the {bound} bound is {value:?}, expected a finite number of magnitude at most 1e290"
    )]
    BoundNotUsable {
        /// Name of the parameter.
        parameter: String,
        /// `"lower"` or `"upper"`.
        bound: &'static str,
        /// The bound given.
        value: f64,
    },
    /// The lower bound is above the upper bound.
    #[error(
        "parameter `{parameter}`: the lower bound {lower:?} is above the upper bound {upper:?}, expected lower < upper"
    )]
    InvertedBounds {
        /// Name of the parameter.
        parameter: String,
        /// The lower bound given.
        lower: f64,
        /// The upper bound given.
        upper: f64,
    },
    /// Both bounds are the same number.
    #[error("parameter `{parameter}`: both bounds are {value:?}, expected lower < upper")]
    ZeroWidth {
        /// Name of the parameter.
        parameter: String,
        /// The value of both bounds.
        value: f64,
    },
    /// Fewer than two levels.
    #[error("parameter `{parameter}`: number of levels {count}, expected at least 2, or continuous levels")]
    TooFewLevels {
        /// Name of the parameter.
        parameter: String,
        /// The count given.
        count: u32,
    },
    /// So many levels between these bounds that neighbors round to the same number.
    #[error(
        "parameter `{parameter}`: {count} levels from {lower:?} to {upper:?} cannot be told apart in double precision"
    )]
    IndistinctLevels {
        /// Name of the parameter.
        parameter: String,
        /// The count given.
        count: u32,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A level was asked of a parameter that has none.
    #[error("parameter `{parameter}` is continuous, expected a count of levels")]
    Continuous {
        /// Name of the parameter.
        parameter: String,
    },
    /// A level index past the last level.
    #[error("parameter `{parameter}`: level index {index}, expected 0 to {last}")]
    NoSuchLevel {
        /// Name of the parameter.
        parameter: String,
        /// The index given.
        index: u64,
        /// The largest index there is.
        last: u64,
    },
    /// A coordinate is NaN.
    #[error("parameter `{parameter}`: the value is NaN, expected {lower:?} to {upper:?} {unit}")]
    NotANumber {
        /// Name of the parameter.
        parameter: String,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
        /// Unit of the bounds.
        unit: String,
    },
    /// A coordinate outside the bounds.
    #[error("parameter `{parameter}`: the value is {value:?}, expected {lower:?} to {upper:?} {unit}")]
    OutOfBounds {
        /// Name of the parameter.
        parameter: String,
        /// The value given.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
        /// Unit of the bounds.
        unit: String,
    },
    /// A number within the bounds of a choice that is the place of none.
    #[error("parameter `{parameter}`: the value is {value:?}, expected the place of a choice: {expected}")]
    NotAChoice {
        /// Name of the parameter.
        parameter: String,
        /// The value given.
        value: f64,
        /// The places there are, with the names of their choices.
        expected: String,
    },
    /// A region without parameters.
    #[error("a region has no parameters, expected at least one")]
    NoParameters,
    /// Two parameters of one region share a name.
    #[error("the name `{name}` stands for parameters number {} and {} of the list, expected unique names", first + 1, second + 1)]
    DuplicateName {
        /// The shared name.
        name: String,
        /// Index of its first bearer, from 0; the message counts from 1.
        first: usize,
        /// Index of its second bearer.
        second: usize,
    },
    /// A point with another number of coordinates than the region has parameters.
    #[error("coordinates of a point: {found}, expected {expected} ({names})")]
    WrongDimension {
        /// Number of parameters of the region.
        expected: usize,
        /// Number of coordinates given.
        found: usize,
        /// Names of the parameters, in order, separated by commas.
        names: String,
    },
    /// A grid with more cells than a 64-bit index can count.
    #[error("the grid of {n_parameters} parameters has more than 2^64 - 1 cells, expected fewer levels")]
    GridTooLarge {
        /// Number of parameters of the region.
        n_parameters: usize,
    },
    /// A cell that the grid does not have.
    #[error("cell {index}, expected less than {n_cells}")]
    NoSuchCell {
        /// The index given.
        index: u64,
        /// Number of cells of the grid.
        n_cells: u64,
    },
    /// A model is asked for by a name that no model has.
    #[error("model \"{name}\": expected {} or a list of exponents", quoted(expected))]
    NoSuchModel {
        /// The name given.
        name: String,
        /// The names there are.
        expected: &'static [&'static str],
    },
    /// A term with another number of exponents than the model has factors.
    #[error("exponents of term number {number} of the list: {found}, expected one per factor: {expected}", number = term + 1)]
    WrongTermLength {
        /// Index of the term.
        term: usize,
        /// Number of factors of the model.
        expected: usize,
        /// Number of exponents given.
        found: usize,
    },
    /// An exponent beyond what the model supports.
    #[error("term `{name}` has the exponent {exponent}, expected 0 to {largest}")]
    ExponentTooLarge {
        /// Index of the term.
        term: usize,
        /// Its name.
        name: String,
        /// The exponent given.
        exponent: u8,
        /// The largest exponent allowed.
        largest: u8,
    },
    /// The same term twice.
    #[error("the term `{name}` is given twice, expected distinct terms")]
    DuplicateTerm {
        /// Its name.
        name: String,
        /// Index of the first.
        first: usize,
        /// Index of the second.
        second: usize,
    },
    /// A term index past the last term.
    #[error("term index {index}, expected less than {n_terms}")]
    NoSuchTerm {
        /// The index given.
        index: usize,
        /// Number of terms.
        n_terms: usize,
    },
    /// Choices that cannot be told apart, or are too few.
    #[error("parameter `{parameter}`: the choice `{choice}` is not usable, expected {expected}")]
    Choices {
        /// The parameter.
        parameter: String,
        /// The choice at fault, empty if it is their number.
        choice: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// A choice where only numbers will do.
    #[error("parameter `{parameter}` is a choice, expected a number with bounds")]
    Categorical {
        /// The parameter.
        parameter: String,
    },
    /// Too few or too many of something.
    #[error("number of {name}: {found}, expected {least} to {most}")]
    Count {
        /// Of what.
        name: &'static str,
        /// The number given.
        found: usize,
        /// The smallest number allowed.
        least: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// A coded point with another number of coordinates than there are factors.
    #[error("coordinates of a point: {found}, expected {expected}")]
    PointLength {
        /// Number of factors.
        expected: usize,
        /// Number of coordinates given.
        found: usize,
    },
}

/// `"a", "b", "c"`.
fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

impl Error {
    /// What may help a person who typed the numbers into a file or a shell, and would mislead who handed over an array: no
    /// part of the message.
    #[must_use]
    pub fn hint(&self) -> Option<&'static str> {
        match *self {
            // Two numbers for each that was expected are what decimal commas make of a point.
            Self::WrongDimension { expected, found, .. } | Self::PointLength { expected, found } => {
                (expected > 0 && found > expected && found <= 2 * expected)
                    .then_some("a decimal comma separates numbers, write 20.5 and not 20,5")
            }
            _ => None,
        }
    }
}
