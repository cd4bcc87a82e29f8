//! Flights of the turbine, many at once.

use bat_dynamics::{Fidelity, Parameters};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use water_channel::{
    CostFile, CostWeights, Flight, FlightError, FlightRequest, FlightSettings, N_TERMS, ProfileFile, Rig, RigFile,
    TestProfile, fly_all,
};

use crate::arrays::{Matrix, matrix};
use crate::background::interruptible;
use crate::error::{Error, refusal};

const RIG: &str = include_str!("../../../fixtures/bat/rig.toml");
const PROFILE: &str = include_str!("../../../fixtures/bat/test-profile.toml");
const COST: &str = include_str!("../../../fixtures/bat/cost-chapter7.toml");

/// A rig, a test and the weights of its cost; without files those of Chapter 7.
#[pyclass(module = "infuse._native")]
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    rig: Rig,
    profile: TestProfile,
    weights: CostWeights,
}

#[pymethods]
impl Channel {
    #[new]
    fn new(rig: Option<String>, profile: Option<String>, cost: Option<String>) -> PyResult<Self> {
        let rig = rig.map_or_else(|| RigFile::parse(RIG), RigFile::read).map_err(refusal)?.rig;
        let profile = profile.map_or_else(|| ProfileFile::parse(PROFILE), ProfileFile::read).map_err(refusal)?.profile;
        let weights = cost.map_or_else(|| CostFile::parse(COST), CostFile::read).map_err(refusal)?.weights;
        Ok(Self { rig, profile, weights })
    }

    /// Flies every design, a row with one number per variable. A flight without a result has NaN, and its reason in `reasons`.
    fn fly<'py>(
        &self,
        py: Python<'py>,
        designs: PyReadonlyArray2<'py, f64>,
        variables: Vec<String>,
        fidelity: &str,
        steps_per_sample: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let designs = Matrix::of(&designs);
        if designs.n_columns != variables.len() {
            let (found, expected) = (designs.n_columns, variables.len());
            return Err(Error::new_err(format!("a design has {found} numbers, expected {expected}: one per variable")));
        }
        let fidelity = fidelity_named(fidelity)?;
        let places = variables.iter().map(|name| place(name)).collect::<PyResult<Vec<Place>>>()?;
        if let Some(number) = (0..places.len()).find(|&number| places[..number].contains(&places[number])) {
            let name = &variables[number];
            return Err(Error::new_err(format!("variable `{name}` is there by another name, too, expected each once")));
        }
        let request = |row: &[f64]| {
            let mut rig = self.rig.clone();
            places.iter().zip(row).for_each(|(place, &number)| place.set(&mut rig, number));
            FlightRequest { rig, fidelity }
        };
        let requests: Vec<FlightRequest> = designs.rows().map(request).collect();
        let settings = FlightSettings::with_steps(steps_per_sample);
        settings.validate().map_err(refusal)?;
        let profile = self.profile.clone();
        let (requests, flights) = interruptible(py, move || {
            let flights = fly_all(&requests, &profile, &settings, |_| {});
            (requests, flights)
        })?;
        self.results(py, &requests, &flights)
    }
}

impl Channel {
    fn results<'py>(
        &self,
        py: Python<'py>,
        requests: &[FlightRequest],
        flights: &[Result<Flight, FlightError>],
    ) -> PyResult<Bound<'py, PyDict>> {
        let (mut cost, mut terms, mut gram) = (Vec::new(), Vec::new(), Vec::new());
        let mut rest: [Vec<f64>; 3] = Default::default();
        let mut reasons: Vec<Option<String>> = Vec::new();
        for (request, flight) in requests.iter().zip(flights) {
            let integrals = flight.as_ref().ok().map(|flight| flight.integrals);
            let breakdown = integrals.map(|integrals| self.weights.cost(&integrals, request.rig.ballast_pct_chord()));
            cost.push(breakdown.map_or(f64::NAN, |breakdown| breakdown.total));
            terms.extend(breakdown.map_or([f64::NAN; N_TERMS + 1], |breakdown| breakdown.terms));
            gram.extend(
                integrals.map_or([[f64::NAN; N_TERMS]; N_TERMS], |integrals| integrals.gram).into_iter().flatten(),
            );
            let numbers = integrals.map_or([f64::NAN; 3], |i| [i.heading_squared, i.lateral_squared, i.duration_s]);
            rest.iter_mut().zip(numbers).for_each(|(column, number)| column.push(number));
            reasons.push(flight.as_ref().err().map(ToString::to_string));
        }
        let found = PyDict::new(py);
        let n = cost.len();
        found.set_item("cost", PyArray1::from_vec(py, cost))?;
        found.set_item("terms", matrix(py, N_TERMS + 1, terms)?)?;
        found.set_item("gram", PyArray1::from_vec(py, gram).reshape([n, N_TERMS, N_TERMS])?)?;
        for (name, column) in ["heading_squared", "lateral_squared", "duration_s"].into_iter().zip(rest) {
            found.set_item(name, PyArray1::from_vec(py, column))?;
        }
        found.set_item("reasons", reasons)?;
        Ok(found)
    }
}

fn fidelity_named(name: &str) -> PyResult<Fidelity> {
    match name {
        "numerical" => Ok(Fidelity::NUMERICAL),
        "stalled" => Ok(Fidelity::STALLED),
        "added mass" => Ok(Fidelity::ADDED_MASS),
        "stand-in" => Ok(Fidelity::STALLED_WITH_ADDED_MASS),
        _ => Err(Error::new_err(format!(
            "fidelity is `{name}`: it must be `numerical`, `stalled`, `added mass` or `stand-in`"
        ))),
    }
}

/// Where in a rig a number goes.
#[derive(Clone, Copy)]
enum Place {
    CenterOfMass,
    PitchSetPoint,
    Field(&'static bat_dynamics::Field),
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        self.path() == other.path()
    }
}

impl Place {
    /// Section and key in the rig's file.
    fn path(&self) -> (&'static str, &'static str) {
        match self {
            Self::CenterOfMass => ("body", "center_of_mass_x"),
            Self::PitchSetPoint => ("", "pitch_set_point"),
            Self::Field(field) => (field.section, field.name),
        }
    }

    fn set(&self, rig: &mut Rig, number: f64) {
        match self {
            Self::CenterOfMass => rig.plant.body.center_of_mass_x = number / 100.0,
            Self::PitchSetPoint => rig.set_points.pitch_rad = number.to_radians(),
            Self::Field(field) => (field.set)(&mut rig.plant, number),
        }
    }
}

/// The place of a variable: by its name in the studies, or a number of the plant as `section.key` in SI units and radians.
fn place(name: &str) -> PyResult<Place> {
    let path = match name {
        "center_of_mass" => return Ok(Place::CenterOfMass),
        "pitch_set_point" => return Ok(Place::PitchSetPoint),
        "horizontal_area" => "horizontal_stabilizer.area_factor",
        "vertical_area" => "vertical_stabilizer.area_factor",
        other => other,
    };
    let field = Parameters::fields().find(|field| path.split_once('.') == Some((field.section, field.name)));
    field.map(Place::Field).ok_or_else(|| {
        Error::new_err(format!(
            "variable `{name}`: it must be center_of_mass (% chord), pitch_set_point (deg), horizontal_area, vertical_area, or \
             a number of the plant as section.key"
        ))
    })
}
