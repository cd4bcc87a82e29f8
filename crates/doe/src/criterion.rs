//! What makes one design better than another.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::measure::Measure;
use crate::products::Products;
use crate::shape::Shape;
use crate::{Design, Error, Information, Model, Over, PredictionVariance, Space};

/// An optimality criterion: a number to be made small, and an efficiency to be made large.
///
/// With p terms, N runs, M = R'R, and v(x) = r(x)' M⁻¹ r(x):
///
/// | | value, made small | efficiency | change with run i, ∂/∂rᵢ |
/// |---|---|---|---|
/// | D | −log det(M) / p | det(M)^(1/p) / N | −2 M⁻¹ rᵢ / p |
/// | A | tr M⁻¹ | p / (N tr M⁻¹) | −2 M⁻² rᵢ |
/// | G | max v(x) over the space | p / (N max v) | −2 (r(x)' M⁻¹ rᵢ) M⁻¹ r(x) at the maximum |
/// | E | 1 / λmin(M) | λmin(M) / N | −2 (u' rᵢ) u / λmin², u its unit eigenvector |
/// | T | −tr M / p | tr M / (p N) | −2 rᵢ / p |
/// | I | mean v(x) over the space | p / (N mean v) | −2 M⁻¹ B M⁻¹ rᵢ, B the mean of r r' |
///
/// At most 1 are G, by the equivalence theorem, and on the cube, where no term exceeds 1, D, A, E and T. The mean of v
/// is smaller than its maximum, so I can exceed 1: use it to compare designs of one model and one space.
/// D, A, E and T depend on the coding and are those of the coded factors; D only by a constant factor.
///
/// T alone is best at designs that determine nothing: a search for T keeps to designs of at least
/// [`T_LEAST_D`](Self::T_LEAST_D) of the determinant efficiency of the best D design it knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Criterion {
    /// Volume of the confidence ellipsoid of the coefficients.
    D,
    /// Mean variance of the coefficients.
    A,
    /// Largest prediction variance over the space.
    ///
    /// Source: (29)
    ///
    /// The source minimizes a variance over the point where it is taken, which picks the point that is predicted best.
    G,
    /// Largest variance of a unit combination of the coefficients.
    E,
    /// Trace of the information.
    T,
    /// Mean prediction variance.
    I,
}

impl Criterion {
    /// All criteria.
    pub const ALL: [Self; 6] = [Self::D, Self::A, Self::G, Self::E, Self::T, Self::I];
    /// Least D-efficiency, as a fraction of the best D design found first, that a search for T accepts.
    pub const T_LEAST_D: f64 = 0.5;

    /// Value and efficiency of a design.
    ///
    /// ```
    /// use doe::{Criterion, Design, Model, Space};
    /// let design = Design::new(1, vec![-1.0, 0.0, 1.0])?;
    /// let g = Criterion::G.efficiency(&Model::quadratic(1)?, &Space::cube(1)?, &design)?;
    /// assert!((g.percent - 100.0).abs() < 1e-9);
    /// assert_eq!(g.to_string(), "G-efficiency 100.000 % over the cube [-1, 1]^1");
    /// # Ok::<(), doe::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Information::of`], and [`Error::FactorMismatch`] for a space of another number of factors. Runs outside
    /// the space are allowed here: the space says where one predicts.
    pub fn efficiency(self, model: &Model, space: &Space, design: &Design) -> Result<Efficiency, Error> {
        let (expected, found) = (model.n_factors(), space.n_factors());
        if expected != found {
            return Err(Error::FactorMismatch { what: "the space", expected, found });
        }
        let information = Information::of(model, design)?;
        let (n, p) = (information.n_runs() as f64, information.n_terms() as f64);
        let diagonal = |matrix: &[f64]| matrix.iter().step_by(information.n_terms() + 1).sum::<f64>();
        let (value, fraction) = match self {
            Self::D => (-information.log_determinant() / p, (information.log_determinant() / p).exp() / n),
            Self::A => {
                let value = diagonal(information.inverse());
                (value, p / (n * value))
            }
            Self::E => {
                let least = information.eigenvalues()?[0];
                (1.0 / least, least / n)
            }
            Self::T => {
                let trace = diagonal(information.matrix());
                (-trace / p, trace / (p * n))
            }
            Self::G => {
                let value = PredictionVariance::from_information(model, &information)?.maximum(space)?.value;
                (value, p / (n * value))
            }
            Self::I => {
                let moments = moment_matrix(model, space)?;
                let value: f64 = moments.iter().zip(information.inverse()).map(|(a, b)| a * b).sum();
                (value, p / (n * value))
            }
        };
        let over = matches!(self, Self::G | Self::I).then(|| space.over());
        Ok(Efficiency { criterion: self, value, percent: 100.0 * fraction, over })
    }
}

impl fmt::Display for Criterion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, formatter)
    }
}

/// How good a design is by one criterion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Efficiency {
    /// Which criterion.
    pub criterion: Criterion,
    /// Its value, the smaller the better; see the table of [`Criterion`].
    pub value: f64,
    /// Its efficiency in per cent.
    pub percent: f64,
    /// The set of points, for the criteria that look at predictions.
    pub over: Option<Over>,
}

impl fmt::Display for Efficiency {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}-efficiency {:.3} %", self.criterion, self.percent)?;
        match &self.over {
            Some(over) => write!(formatter, " over the {over}"),
            None => Ok(()),
        }
    }
}

/// Mean of r(x) r(x)' over a space, p × p, row by row: exact for boxes, also less forbidden boxes.
///
/// # Errors
///
/// [`Error::FactorMismatch`].
pub fn moment_matrix(model: &Model, space: &Space) -> Result<Vec<f64>, Error> {
    let (expected, found) = (model.n_factors(), space.n_factors());
    if expected != found {
        return Err(Error::FactorMismatch { what: "the space", expected, found });
    }
    let products = Products::of(model);
    let moments: Vec<f64> = match space.shape() {
        Shape::Box(shape) => {
            let measure = Measure::of(shape);
            let total = measure.total();
            let moment =
                |exponents: &[u8]| measure.moment(&exponents.iter().map(|&e| u32::from(e)).collect::<Vec<_>>()) / total;
            products.monomials().map(moment).collect()
        }
        Shape::List(list) => {
            let mut sums = vec![0.0; products.n_monomials()];
            let mut values = sums.clone();
            for point in list.points() {
                products.fill(point, &mut values);
                sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
            }
            sums.iter().map(|sum| sum / list.n_points() as f64).collect()
        }
    };
    let mut matrix = vec![0.0; model.n_terms() * model.n_terms()];
    products.spread(&moments, &mut matrix);
    Ok(matrix)
}
