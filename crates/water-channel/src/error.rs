//! What can be wrong with a file, a rig or a flight.

use std::path::PathBuf;

use thiserror::Error;

/// An error in a parameter, profile or cost file: which file, which key, what was found, what was allowed.
#[non_exhaustive]
#[derive(Debug, Error)]
pub enum FileError {
    /// The file could not be read.
    #[error("{path}: {cause}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: std::io::Error,
    },
    /// The file is not TOML.
    #[error("not a TOML file: {0}")]
    Syntax(#[from] toml::de::Error),
    /// A key that nothing reads, most often a typo.
    #[error("unknown key `{key}`{}; known here: {known}", .similar.as_ref().map_or(String::new(), |s| format!(" (is it `{s}`?)")))]
    UnknownKey {
        /// The key with its sections.
        key: String,
        /// The keys that are known in its section.
        known: String,
        /// The known key of which it looks like a slip.
        similar: Option<String>,
    },
    /// A key that is needed.
    #[error("missing key `{key}`: {expected}")]
    MissingKey {
        /// The key with its sections.
        key: String,
        /// What should stand there.
        expected: String,
    },
    /// A value of the wrong kind, in the wrong unit or out of range.
    #[error("`{key}` is {found}: it must be {expected}")]
    Value {
        /// The key with its sections.
        key: String,
        /// What stands there.
        found: String,
        /// What is allowed.
        expected: String,
    },
    /// Numbers that are allowed one by one and impossible together.
    #[error("{0}")]
    Inconsistent(Error),
    /// An error in a named file.
    #[error("{path}: {error}")]
    In {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        error: Box<FileError>,
    },
}

/// An error in a rig, a profile or settings.
#[non_exhaustive]
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// The plant's own error.
    #[error(transparent)]
    Plant(#[from] bat_dynamics::Error),
    /// The controller's own error.
    #[error("controller: {0}")]
    Controller(#[from] tether_control::Error),
    /// A number that a caller gave.
    #[error("{name} = {value}: it must be {expected}")]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// What was allowed.
        expected: &'static str,
    },
    /// Something about cameras or dots.
    #[error("sensing.{field} = {value}: it must be {expected}")]
    Sensing {
        /// What it is about, with its place: `camera[0].focal_length` for example.
        field: String,
        /// The value that was given, with its unit.
        value: String,
        /// What was allowed.
        expected: &'static str,
    },
    /// Cameras and dots that, even without noise, give no pose of the body where a flight begins.
    #[error(
        "sensing: no pose can be had where the flight begins: {reason} ({dots_seen} of {dots} dots; of them {}); cameras or dots must stand otherwise",
        by_camera(.seen_by)
    )]
    NoFirstPose {
        /// Why not.
        reason: String,
        /// Dots that at least one camera sees.
        dots_seen: usize,
        /// All dots.
        dots: usize,
        /// Every camera by its name, with the number of dots that it sees in the first image.
        seen_by: Vec<(String, usize)>,
    },
}

fn by_camera(seen_by: &[(String, usize)]) -> String {
    let each = seen_by.iter().map(|(camera, dots)| format!("{dots} by camera `{camera}`"));
    each.collect::<Vec<_>>().join(", ")
}

/// Why a flight has no result. The trial failed, and says why; no cost stands for it.
#[non_exhaustive]
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FlightError {
    /// The rig, the profile or the settings are wrong, or there is no trim to start from.
    #[error("cannot start: {0}")]
    Start(#[from] Error),
    /// The state left the model.
    #[error("left the model: {0}")]
    LeftTheModel(bat_dynamics::Error),
    /// A line went slack, where the settings make that an error.
    #[error("line {line} went slack at t = {time_s} s: its tension would be {tension_n:.4} N, allowed: zero or more")]
    Slack {
        /// `center`, `starboard` or `port`.
        line: &'static str,
        /// Sample at which it was found.
        time_s: f64,
        /// The tension.
        tension_n: f64,
    },
}
