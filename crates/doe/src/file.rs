//! Designs in CSV files, in natural units.

use std::io::{Read, Write};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::{Design, Error, FileFault, Levels, Parameter, Region, Space};

/// A design as a file gave it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignFile {
    /// The runs, in the order of the file.
    pub design: Design,
    /// Columns that are no parameter of the region and not written beside them by [`Design::write_csv`], such as notes and
    /// responses: not read.
    pub ignored: Vec<String>,
}

/// In which order runs are written, and to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RunOrder {
    /// As they are in the design.
    #[default]
    Standard,
    /// Shuffled, so that drifts of the rig do not pass for effects of the factors; the same for the same seed.
    Random {
        /// The order follows from it.
        seed: u64,
    },
}

/// Columns beside the settings.
const LABELS: [&str; 4] = ["run", "standard", "point", "replicate"];
/// One more where runs are settled.
const KIND: &str = "kind";

impl Design {
    /// Reads the runs of a CSV file in natural units: a header with the names of the region's parameters, in any order,
    /// with or without the unit in brackets (`pitch` or `pitch [deg]`), and one line per run. Empty lines, lines that
    /// begin with `#` and other columns are passed over; values between levels are read as they are.
    ///
    /// ```
    /// use doe::{Design, Parameter, Region};
    /// let region = Region::new(vec![Parameter::continuous("pitch", "deg", 10.0, 22.0)?])?;
    /// let file = Design::read_csv(&region, "note,pitch [deg]\nlow,10\nmiddle,16\n".as_bytes())?;
    /// assert_eq!(file.design.coordinates(), [-1.0, 0.0]);
    /// assert_eq!(file.ignored, ["note"]);
    /// let error = Design::read_csv(&region, "pitch\n1O\n25\n".as_bytes()).unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "line 2, column `pitch`: \"1O\", expected a finite number; \
    ///      line 3, column `pitch`: 25.0, expected 10.0 to 22.0 deg"
    /// );
    /// # Ok::<(), doe::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::File`] with every fault there is: of the header, or else of the fields.
    pub fn read_csv(region: &Region, mut reader: impl Read) -> Result<DesignFile, Error> {
        let mut text = String::new();
        reader.read_to_string(&mut text).map_err(|error| unreadable(error.into()))?;
        let text = text.trim_start_matches('\u{feff}');
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .flexible(true)
            .from_reader(text.as_bytes());
        let header: Vec<String> = reader.headers().map_err(unreadable)?.iter().map(str::to_owned).collect();
        if header.iter().all(String::is_empty) {
            return Err(Error::File { faults: vec![FileFault::Empty] });
        }
        if let Some(found) = separator(region, &header) {
            return Err(Error::File { faults: vec![FileFault::Separator { found }] });
        }
        let columns = columns(region, &header)?;
        let mut coordinates = Vec::new();
        let mut faults = Vec::new();
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            let line = record.position().map_or(0, |position| line_of_record(text, position));
            if record.len() != header.len() {
                faults.push(FileFault::FieldCount { line, found: record.len(), expected: header.len() });
                continue;
            }
            for (parameter, &column) in region.parameters().iter().zip(&columns) {
                match field(parameter, record.get(column).unwrap_or_default(), line) {
                    Ok(value) => coordinates.push(parameter.coded(value)),
                    Err(fault) => faults.push(fault),
                }
            }
        }
        if coordinates.is_empty() && faults.is_empty() {
            faults.push(FileFault::NoRuns);
        }
        if !faults.is_empty() {
            return Err(Error::File { faults });
        }
        let design = Self::new(region.n_parameters(), coordinates)?;
        let is_ours = |text: &String| LABELS.contains(&text.as_str()) || text == KIND;
        let unused = (0..header.len()).filter(|column| !columns.contains(column) && !is_ours(&header[*column]));
        Ok(DesignFile { design, ignored: unused.map(|column| header[column].clone()).collect() })
    }

    /// Writes the runs as CSV in natural units, in a form that [`read_csv`](Self::read_csv) reads.
    ///
    /// The columns are `run` (1, 2, … in the order to be made), `standard` (the run's number in the design), `point`
    /// (number of the distinct point) and `replicate` (how often the point has been in the design up to this run),
    /// then the settings with their units. Levels are written with all their digits, other settings are rounded to
    /// within 1e-10 of the width of their range.
    ///
    /// # Errors
    ///
    /// [`DesignSpaceError::WrongDimension`](crate::DesignSpaceError::WrongDimension); [`Error::File`] if it cannot be written, or a parameter bears the name of one of the
    /// other columns, or one that the header of a file cannot tell from another.
    pub fn write_csv(&self, region: &Region, order: RunOrder, writer: impl Write) -> Result<(), Error> {
        self.write(region, order, None, writer)
    }

    /// As [`write_csv`](Self::write_csv), of a design whose first `n_fixed` runs were settled before the others were
    /// chosen: one more column, `kind`, says `fixed`, `new` or `replicate of` and a run's number in the design.
    ///
    /// # Errors
    ///
    /// As [`write_csv`](Self::write_csv).
    pub fn write_csv_with_kinds(
        &self,
        region: &Region,
        order: RunOrder,
        n_fixed: usize,
        writer: impl Write,
    ) -> Result<(), Error> {
        let kind = |(run, twins): (usize, Option<(usize, usize)>)| match twins {
            _ if run < n_fixed => "fixed".to_owned(),
            Some((first, _)) => format!("replicate of {}", first + 1),
            None => "new".to_owned(),
        };
        let kinds = self.twins().into_iter().enumerate().map(kind);
        self.write(region, order, Some(kinds.collect()), writer)
    }

    fn write(
        &self,
        region: &Region,
        order: RunOrder,
        kinds: Option<Vec<String>>,
        writer: impl Write,
    ) -> Result<(), Error> {
        let labels: Vec<&'static str> = LABELS.into_iter().chain(kinds.as_ref().map(|_| KIND)).collect();
        if let Some(&name) = labels.iter().find(|name| region.index_of(name).is_some()) {
            return Err(Error::File { faults: vec![FileFault::ReservedName { name }] });
        }
        check_header(region, &labels)?;
        let settings = self.natural(region)?;
        let visits = self.visits();
        let mut sequence: Vec<usize> = (0..self.n_runs()).collect();
        if let RunOrder::Random { seed } = order {
            let mut generator = Pcg64::seed_from_u64(seed);
            for last in (1..sequence.len()).rev() {
                sequence.swap(last, generator.random_range(0..=last));
            }
        }
        let mut writer = csv::Writer::from_writer(writer);
        let names = region.parameters().iter().map(heading);
        writer.write_record(labels.into_iter().map(str::to_owned).chain(names)).map_err(unreadable)?;
        for (position, &run) in sequence.iter().enumerate() {
            let (point, replicate) = visits[run];
            let numbers = [position + 1, run + 1, point, replicate].map(|number| number.to_string());
            let settings = region.parameters().iter().zip(&settings[run]);
            let settings = settings.map(|(parameter, &value)| shortened(parameter, value, LAST_BITS).to_string());
            let kind = kinds.as_ref().map(|kinds| kinds[run].clone());
            writer.write_record(numbers.into_iter().chain(kind).chain(settings)).map_err(unreadable)?;
        }
        writer.flush().map_err(|error| unreadable(error.into()))
    }

    /// The same runs at settings rounded to within 1e-8 of the width of their range, which nobody minds to read, as long as they
    /// stay in the space and what was a replicate stays one, to the last bit. Levels and the first `n_fixed` runs stay as they
    /// are. [`write_csv`](Self::write_csv) rounds by the same rule, and finer: it writes these settings as they are, but for
    /// last bits where they lie more than a thousand widths from zero.
    ///
    /// ```
    /// use doe::{Design, Parameter, Region, Space};
    /// let region = Region::new(vec![Parameter::continuous("pitch", "deg", 10.0, 22.0)?])?;
    /// let design = Design::new(1, vec![1.0 / 3.0])?.rounded(&region, &Space::of_region(&region)?, 0)?;
    /// assert_eq!(design.natural(&region)?, [[18.0]]);
    /// # Ok::<(), doe::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`DesignSpaceError::WrongDimension`](crate::DesignSpaceError::WrongDimension).
    pub fn rounded(&self, region: &Region, space: &Space, n_fixed: usize) -> Result<Self, Error> {
        let mut runs = Vec::with_capacity(self.coordinates().len());
        let united = self.clone().with_equal_replicates(n_fixed);
        for (index, (run, settings)) in united.runs().zip(united.natural(region)?).enumerate() {
            let parameters = region.parameters().iter().zip(settings);
            let short = parameters.map(|(parameter, value)| shortened(parameter, value, READABLE));
            let short = region.coded(&short.collect::<Vec<_>>())?;
            runs.extend(if index >= n_fixed && space.contains(&short) { short } else { run.to_vec() });
        }
        Ok(Self::new(self.n_factors(), runs)?.with_equal_replicates(n_fixed))
    }

    /// Number of the distinct point, from 1 in order of appearance, and number of the visit, of each run.
    fn visits(&self) -> Vec<(usize, usize)> {
        let mut labels: Vec<(usize, usize)> = Vec::with_capacity(self.n_runs());
        let mut n_points = 0;
        for twins in self.twins() {
            match twins {
                Some((_, last)) => labels.push((labels[last].0, labels[last].1 + 1)),
                None => {
                    n_points += 1;
                    labels.push((n_points, 1));
                }
            }
        }
        labels
    }
}

/// `name [unit]`, or the name alone.
fn heading(parameter: &Parameter) -> String {
    if parameter.unit().is_empty() {
        parameter.name().to_owned()
    } else {
        format!("{} [{}]", parameter.name(), parameter.unit())
    }
}

/// Whether [`columns`] finds every parameter in its own column of the header to be written.
fn check_header(region: &Region, labels: &[&str]) -> Result<(), Error> {
    let headings = region.parameters().iter().map(|parameter| heading(parameter).trim().to_owned());
    let header: Vec<String> = labels.iter().map(|&label| label.to_owned()).chain(headings).collect();
    for (index, parameter) in region.parameters().iter().enumerate() {
        if column_of(parameter, &header).ok() != Some(labels.len() + index) {
            return Err(Error::File { faults: vec![FileFault::AmbiguousName { name: parameter.name().to_owned() }] });
        }
    }
    Ok(())
}

/// How much of the width of a parameter's range a setting may be changed by to be short.
#[derive(Clone, Copy)]
struct Share {
    /// Its decimal logarithm, less the sign.
    digits: f64,
    share: f64,
}

/// What a search's last bits are, so that they do not fill a file.
const LAST_BITS: Share = Share { digits: 10.0, share: 1e-10 };
/// What nobody minds: a hundred million steps of the range.
const READABLE: Share = Share { digits: 8.0, share: 1e-8 };

/// The shortest decimal within a share of the width, as it is where there is none: for settings that may be any number.
fn shortened(parameter: &Parameter, value: f64, Share { digits, share }: Share) -> f64 {
    if parameter.levels() != Levels::Continuous {
        return value;
    }
    let is_close = |short: f64| (short - value).abs() <= share * parameter.width() && parameter.contains(short);
    let digits = (digits - parameter.width().log10()).ceil();
    let scale = 10.0_f64.powf(digits.clamp(0.0, 300.0));
    let by_width = (value * scale).round() / scale;
    // Beyond what a double can scale, and past a bound, the digits are those of the number itself.
    [by_width + 0.0, to_nine_digits(value)].into_iter().find(|&short| is_close(short)).unwrap_or(value)
}

/// A number to nine significant digits.
fn to_nine_digits(value: f64) -> f64 {
    format!("{value:.8e}").parse().ok().filter(|short: &f64| short.is_finite()).unwrap_or(value)
}

/// What separates the columns, if it is not commas: a header of one column whose parts are names of parameters.
fn separator(region: &Region, header: &[String]) -> Option<char> {
    let [only] = header else {
        return None;
    };
    let is_name = |part: &str| {
        let name = part.split('[').next().unwrap_or_default().trim();
        region.index_of(name).is_some() || LABELS.contains(&name)
    };
    [';', '\t'].into_iter().find(|&found| only.contains(found) && only.split(found).any(is_name))
}

/// The column of each parameter.
fn columns(region: &Region, header: &[String]) -> Result<Vec<usize>, Error> {
    let (mut faults, mut columns) = (Vec::new(), Vec::new());
    for parameter in region.parameters() {
        match column_of(parameter, header) {
            Ok(column) => columns.push(column),
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(columns) } else { Err(Error::File { faults }) }
}

/// The column of a parameter; spaces around its name do not count, because a reader does not see them.
fn column_of(parameter: &Parameter, header: &[String]) -> Result<usize, FileFault> {
    let name = parameter.name().trim();
    // The text in the brackets behind the name, or none if the name stands alone.
    let unit_of = |text: &str| match text.strip_prefix(name)?.trim() {
        "" => Some(None),
        rest => rest.strip_prefix('[')?.strip_suffix(']').map(|unit| Some(unit.trim().to_owned())),
    };
    let found: Vec<(usize, Option<String>)> =
        header.iter().enumerate().filter_map(|(column, text)| Some((column, unit_of(text)?))).collect();
    let name = parameter.name().to_owned();
    match &found[..] {
        [] => Err(FileFault::MissingColumn { name, header: header.to_vec() }),
        [(_, Some(unit))] if unit != parameter.unit().trim() => Err(FileFault::WrongUnit {
            name,
            found: unit.clone(),
            expected: if parameter.unit().is_empty() { "no unit".to_owned() } else { parameter.unit().to_owned() },
        }),
        [(column, _)] => Ok(*column),
        _ => Err(FileFault::DuplicateColumn { name }),
    }
}

/// The line that a record begins in: its position is where the one before it ended, ahead of comments and empty lines.
fn line_of_record(text: &str, position: &csv::Position) -> u64 {
    let rest = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or_default();
    let passed = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count();
    position.line() + passed as u64
}

fn field(parameter: &Parameter, text: &str, line: u64) -> Result<f64, FileFault> {
    let name = parameter.name().to_owned();
    if text.is_empty() {
        return Err(FileFault::Missing { line, name });
    }
    match text.parse::<f64>() {
        Ok(value) if !value.is_finite() => Err(FileFault::NotANumber { line, name, text: text.to_owned() }),
        Err(_) => Err(FileFault::NotANumber { line, name, text: text.to_owned() }),
        Ok(value) => parameter.check(value).map_err(|error| match error {
            design_space::Error::NotAChoice { expected, .. } => FileFault::NotAChoice { line, name, value, expected },
            _ => FileFault::OutOfBounds {
                line,
                name,
                value,
                lower: parameter.lower(),
                upper: parameter.upper(),
                unit: parameter.unit().to_owned(),
            },
        }),
    }
}

fn unreadable(error: csv::Error) -> Error {
    Error::File { faults: vec![FileFault::Unreadable { reason: error.to_string() }] }
}
