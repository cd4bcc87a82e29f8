//! What can be wrong with units, systems, set-ups, ratios and documents.

/// Every fault of this crate, as a sentence that names the thing, what it is and what was allowed.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A text does not follow the grammar.
    #[error("\"{text}\", character {position}: found {found}, expected {expected}")]
    Syntax {
        /// The whole text.
        text: String,
        /// The character where reading stopped, counted from 1.
        position: usize,
        /// The character, or `the end`.
        found: String,
        /// What could have stood there.
        expected: &'static str,
    },
    /// A symbol stands for nothing.
    #[error("\"{text}\", character {position}: unknown {what} `{symbol}`{}", did_you_mean(near))]
    UnknownSymbol {
        /// `unit`, `variable` or `number`.
        what: &'static str,
        /// The symbol.
        symbol: String,
        /// Its first character, counted from 1.
        position: usize,
        /// The whole text.
        text: String,
        /// Known symbols that look alike.
        near: Vec<String>,
    },
    /// A unit with an offset, which is not a factor.
    #[error("\"{text}\", character {position}: `{symbol}` has an offset, so no factor converts it; {instead}")]
    AffineUnit {
        /// The symbol.
        symbol: String,
        /// Its first character, counted from 1.
        position: usize,
        /// The whole text.
        text: String,
        /// What to do.
        instead: &'static str,
    },
    /// An exponent is beyond any use.
    #[error("the exponent {exponent} in \"{place}\" is too large: numerator and denominator may be at most 1000")]
    ExponentTooLarge {
        /// The exponent.
        exponent: String,
        /// The text in which it stands.
        place: String,
    },
    /// A number where only symbols mean something.
    #[error("\"{text}\" contains the number {number}, but only 1 and symbols with exponents are allowed here")]
    NumberInText {
        /// The number.
        number: String,
        /// The whole text.
        text: String,
    },
    /// A factor or ratio that is zero, negative or not a number.
    #[error("{value} is no ratio: it must be positive and finite")]
    NotPositive {
        /// The value.
        value: String,
    },
    /// A name that could not be read back.
    #[error("`{name}` cannot be a name: {expected}")]
    BadName {
        /// The name.
        name: String,
        /// What a name may be.
        expected: &'static str,
    },
    /// A unit symbol that already means something.
    #[error("the unit `{symbol}` exists already: it means {meaning}")]
    UnitExists {
        /// The symbol.
        symbol: String,
        /// What it means, as factor and dimension.
        meaning: String,
    },
    /// A base whose dimension some unit has already.
    #[error(
        "the dimension `{dimension}` of the base `{symbol}` is not new, `{unit}` has it: give it another name with `base_as`"
    )]
    DimensionExists {
        /// The symbol of the base.
        symbol: String,
        /// The dimension.
        dimension: String,
        /// A unit that has it.
        unit: String,
    },
    /// A system without variables.
    #[error("there are no variables")]
    NoVariables,
    /// A name given twice.
    #[error("`{name}` is given twice as a {what}")]
    Duplicate {
        /// `variable`, `repeating variable`, `factor of the group`, `ratio` or `set-up`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A name that the system does not have.
    #[error("there is no variable `{name}`{}", did_you_mean(near))]
    UnknownVariable {
        /// The name.
        name: String,
        /// Variables that look alike.
        near: Vec<String>,
    },
    /// A repeating variable that is a product of other repeating variables.
    #[error("the repeating variables are not independent: {dependent} depends on {on}: {relation} is dimensionless")]
    DependentRepeating {
        /// The variable.
        dependent: String,
        /// Those that it depends on, as a list in words.
        on: String,
        /// The dimensionless group that they form.
        relation: String,
    },
    /// A dimensionless repeating variable.
    #[error("`{name}` is dimensionless and cannot be a repeating variable: it is a group of its own")]
    DimensionlessRepeating {
        /// The variable.
        name: String,
    },
    /// Too few repeating variables.
    #[error(
        "the repeating variables {repeating} do not span the dimension of {variable} ({dimension}): {}",
        add_one_of(candidates, variable)
    )]
    InsufficientRepeating {
        /// The repeating variables, as a list in words.
        repeating: String,
        /// The first variable that they do not reach.
        variable: String,
        /// Its dimension.
        dimension: String,
        /// Variables of which one more would help.
        candidates: Vec<String>,
    },
    /// A product that was claimed to be dimensionless.
    #[error("{group} is not dimensionless: it has the dimension {dimension}")]
    NotDimensionless {
        /// The product.
        group: String,
        /// Its dimension.
        dimension: String,
    },
    /// The exponent of a variable in a group that is read from a file.
    #[error("the exponent of `{name}` is {exponent}, expected a whole number or a fraction, other than 0")]
    BadExponent {
        /// The variable.
        name: String,
        /// The exponent as it stands there.
        exponent: String,
    },
    /// Groups that are read from a file, and are not those of their system.
    #[error("the groups are {}, expected {}, as {repeating} give them", in_words(found), in_words(expected))]
    OtherGroups {
        /// The repeating variables, as a list in words.
        repeating: String,
        /// The groups read.
        found: Vec<String>,
        /// The groups of the system, whose inverses would do as well.
        expected: Vec<String>,
    },
    /// The row of a group that is read from a file, with another number of values than there are set-ups.
    #[error("{group} has {found} values, expected {expected}, one per set-up")]
    ValueCount {
        /// The group.
        group: String,
        /// How many values it has.
        found: usize,
        /// How many set-ups there are.
        expected: usize,
    },
    /// A value is missing in a set-up.
    #[error("set-up \"{set_up}\" gives no value for {variable}, which {group} needs")]
    MissingValue {
        /// The set-up.
        set_up: String,
        /// The variable.
        variable: String,
        /// The group.
        group: String,
    },
    /// A value that its exponent makes impossible.
    #[error("set-up \"{set_up}\": {variable} is {value:?}, but {group} {reason}")]
    BadValue {
        /// The set-up.
        set_up: String,
        /// The variable.
        variable: String,
        /// The value.
        value: f64,
        /// The group.
        group: String,
        /// Why not.
        reason: &'static str,
    },
    /// The value of a group is beyond the range of f64.
    #[error("set-up \"{set_up}\": the value of {group} is beyond the range of f64")]
    GroupOutOfRange {
        /// The set-up.
        set_up: String,
        /// The group.
        group: String,
    },
    /// A value is given in a unit of another dimension.
    #[error("set-up \"{set_up}\": {variable} is given in {unit} ({found}), but has the dimension {expected}")]
    WrongDimension {
        /// The set-up.
        set_up: String,
        /// The variable.
        variable: String,
        /// The unit given.
        unit: String,
        /// Its dimension.
        found: String,
        /// The dimension of the variable.
        expected: String,
    },
    /// A value or a unit that a set-up cannot take.
    #[error("set-up \"{set_up}\", {variable}: {fault}")]
    InSetUp {
        /// The set-up.
        set_up: String,
        /// The variable.
        variable: String,
        /// What is wrong. Its words are in this error's words, so it is not its source.
        fault: Box<Error>,
    },
    /// Fewer than two set-ups.
    #[error("{count} set-up(s) given, but similarity needs at least 2")]
    TooFewSetUps {
        /// How many.
        count: usize,
    },
    /// A tolerance that is no tolerance.
    #[error("the tolerance is {tolerance:?}, but must be finite and at least 0")]
    BadTolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// A set-up that does not exist.
    #[error("there is no set-up {index}: there are {count}, counted from 0")]
    NoSuchSetUp {
        /// The index asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Adjusting this variable changes no mismatched group.
    #[error("{variable} occurs in none of the mismatched groups{}", list_after_colon(mismatched))]
    NoRemedy {
        /// The variable.
        variable: String,
        /// The mismatched groups.
        mismatched: Vec<String>,
    },
    /// No single value of the variable satisfies every group in which it stands.
    #[error("no single value of {variable} makes set-up \"{set_up}\" match: {}", wanted_values(wanted))]
    NoSingleValue {
        /// The variable.
        variable: String,
        /// The set-up.
        set_up: String,
        /// Each group with the value that it asks for.
        wanted: Vec<(String, f64)>,
    },
    /// The reference value of a group has another sign or is zero: no scaling of the variable reaches it.
    #[error("no positive multiple of {variable} takes {group} of set-up \"{set_up}\" from {from:?} to {to:?}")]
    Unreachable {
        /// The variable.
        variable: String,
        /// The group.
        group: String,
        /// The set-up.
        set_up: String,
        /// Its value there.
        from: f64,
        /// Its value at the reference.
        to: f64,
    },
    /// The given ratios leave something free.
    #[error("the given ratios ({given}) do not determine {what}: {} free, so {}", stays(free), give_one_of(candidates))]
    FreeRatio {
        /// The given ratios, as a list in words.
        given: String,
        /// The variable with its dimension in parentheses, or the dimension that is not determined.
        what: String,
        /// The base dimensions in it that stay free.
        free: Vec<String>,
        /// Variables of which one more ratio would help.
        candidates: Vec<String>,
    },
    /// The given ratios contradict each other.
    #[error(
        "the given ratios contradict each other: {group} is dimensionless and must keep its value, \
         but {name} changes by {given}, where the other ratios require {required}"
    )]
    ContradictoryRatio {
        /// The dimensionless group that would change.
        group: String,
        /// The ratio that does not fit.
        name: String,
        /// Its given value.
        given: String,
        /// The value that the others require.
        required: String,
    },
    /// Text that is not TOML.
    #[error("not a TOML document: {message}")]
    Toml {
        /// What the parser says.
        message: String,
    },
    /// Something wrong at a key of a document.
    #[error("{path}: {fault}")]
    AtKey {
        /// The key as a dotted path, or the name of a ratio.
        path: String,
        /// What is wrong. Its words are in this error's words, so it is not its source.
        fault: Box<Error>,
    },
    /// A value in a document that is not a number or a list of numbers.
    #[error("the value is {found}, expected a finite number or a list of them")]
    NotANumber {
        /// What stands there.
        found: String,
    },
    /// A converted value beyond the range of f64.
    #[error("{value:?} times {factor} is beyond the range of f64")]
    ValueOutOfRange {
        /// The value.
        value: f64,
        /// The factor.
        factor: String,
    },
}

/// `a, b and c`.
pub(crate) fn in_words<S: AsRef<str>>(names: &[S]) -> String {
    match names {
        [] => "none".to_owned(),
        [only] => only.as_ref().to_owned(),
        [first @ .., last] => {
            let first: Vec<_> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}

fn did_you_mean(near: &[String]) -> String {
    match near {
        [] => String::new(),
        near => format!("; did you mean {}?", near.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(" or ")),
    }
}

fn add_one_of(candidates: &[String], only: &str) -> String {
    match candidates {
        [] => format!("no variable of the system would help, so leave {only} out or add a variable of its kind"),
        [one] if one == only => format!("add {only} (no other variable of the system helps) or leave it out"),
        several => format!("add one of {}", several.join(", ")),
    }
}

fn stays(free: &[String]) -> String {
    format!("{} {}", in_words(free), if free.len() == 1 { "stays" } else { "stay" })
}

fn give_one_of(candidates: &[String]) -> String {
    match candidates {
        [] => "add a variable of such a dimension to the system, and its ratio".to_owned(),
        [one] => format!("give the ratio of {one} as well"),
        several => format!("give the ratio of one of {} as well", several.join(", ")),
    }
}

fn list_after_colon(groups: &[String]) -> String {
    if groups.is_empty() { ": there are none".to_owned() } else { format!(": {}", groups.join(", ")) }
}

fn wanted_values(wanted: &[(String, f64)]) -> String {
    wanted
        .iter()
        .map(|(group, value)| format!("{group} asks for {}", crate::number::significant(*value)))
        .collect::<Vec<_>>()
        .join(", ")
}
