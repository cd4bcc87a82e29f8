//! What Student's t says of a regression: tests and intervals of its coefficients, intervals of the response.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::{Error, Regression, Surface};

/// One coefficient of a regression, whether it is other than zero, and where it may be.
///
/// All of it holds for normal errors with the variances that the weights say, and a model that is right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CoefficientTest {
    /// b, in the unit of the response by that of the term.
    pub coefficient: f64,
    /// Its standard error, in the same unit.
    pub standard_error: f64,
    /// b over its standard error, without a unit: infinite if the model meets the data exactly, 0 for a b of 0.
    pub t: f64,
    /// Probability of a t at least as far from zero if the coefficient is zero.
    pub p_value: f64,
    /// Both ends of the interval that holds the coefficient with the probability asked for, in the unit of b.
    pub interval: [f64; 2],
}

impl Regression {
    /// The test against zero and the interval of each coefficient, in the order of [`coefficients`](Self::coefficients). The
    /// probability is that of each interval by itself, not that of all together.
    ///
    /// ```
    /// use doe::Model;
    /// use surface::{Data, Regression};
    /// let data = Data::new(1, vec![-1.0, 0.0, 0.0, 1.0], vec![1.0, 2.0, 3.0, 6.0])?;
    /// let line = Regression::fit(&Model::linear(1)?, &data)?;
    /// // b = (3, 2.5), residuals 0.5, -1, 0, 0.5: σ² = 1.5/2, and the slope has the variance σ²/2.
    /// let slope = line.coefficient_tests(0.95)?[1];
    /// assert!((slope.t - 2.5 / 0.375_f64.sqrt()).abs() < 1e-12);
    /// // Student's t with 2 degrees of freedom: P(|T| > t) = 1 - t/√(2 + t²).
    /// assert!((slope.p_value - (1.0 - slope.t / (2.0 + slope.t * slope.t).sqrt())).abs() < 1e-12);
    /// let [low, high] = slope.interval;
    /// assert!(low < 0.0 && 5.0 < high, "four points leave open whether there is a slope: {low} to {high}");
    /// # Ok::<(), surface::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a probability that is not between 0 and 1, [`Error::NoDegreesOfFreedom`].
    pub fn coefficient_tests(&self, probability: f64) -> Result<Vec<CoefficientTest>, Error> {
        let student = Student::of(self)?;
        let quantile = student.quantile(probability)?;
        let errors = self.standard_errors().ok_or_else(|| no_degrees(self))?;
        let test = |(&coefficient, standard_error): (&f64, f64)| {
            // 0/0 is nothing against zero.
            let t = if coefficient == 0.0 { 0.0 } else { coefficient / standard_error };
            let interval = about(coefficient, quantile * standard_error);
            CoefficientTest { coefficient, standard_error, t, p_value: student.beyond(t), interval }
        };
        Ok(self.coefficients().iter().zip(errors).map(test).collect())
    }

    /// Both ends of the interval that holds the mean response at a point with this probability, in the unit of the response: that
    /// of the error of the fit alone.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a probability that is not between 0 and 1, [`Error::NoDegreesOfFreedom`], [`Error::Length`] and
    /// [`Error::Coordinate`] for a point that is none.
    pub fn mean_interval(&self, point: &[f64], probability: f64) -> Result<[f64; 2], Error> {
        self.interval(point, 0.0, probability)
    }

    /// Both ends of the interval that holds one new observation of this weight at a point with this probability, in the unit of
    /// the response: its own error, of the variance σ²/weight, comes to that of the fit. A mean of several new observations has
    /// the sum of their weights.
    ///
    /// # Errors
    ///
    /// Those of [`mean_interval`](Self::mean_interval), [`Error::Parameter`] for a weight that is not a number above zero.
    pub fn observation_interval(&self, point: &[f64], weight: f64, probability: f64) -> Result<[f64; 2], Error> {
        if !(weight > 0.0 && weight.is_finite()) {
            return Err(Error::Parameter { name: "weight", value: weight, expected: "a finite number above 0" });
        }
        self.interval(point, weight.recip(), probability)
    }

    /// With this multiple of σ² beside the variance of the estimate.
    fn interval(&self, point: &[f64], multiple: f64, probability: f64) -> Result<[f64; 2], Error> {
        let estimate = self.try_predict(point)?;
        let quantile = Student::of(self)?.quantile(probability)?;
        let both = self.variance(point).zip(self.sigma_squared());
        let (variance, sigma_squared) = both.ok_or_else(|| no_degrees(self))?;
        Ok(about(estimate, quantile * (variance + multiple * sigma_squared).sqrt()))
    }
}

/// Student's t with the degrees of freedom of a regression.
struct Student(StudentsT);

impl Student {
    fn of(regression: &Regression) -> Result<Self, Error> {
        let degrees = regression.degrees_of_freedom() as f64;
        StudentsT::new(0.0, 1.0, degrees).map(Self).map_err(|_| no_degrees(regression))
    }

    /// P(|T| > |t|).
    fn beyond(&self, t: f64) -> f64 {
        2.0 * self.0.sf(t.abs())
    }

    /// How far from zero T is at most with this probability.
    fn quantile(&self, probability: f64) -> Result<f64, Error> {
        if !(probability > 0.0 && probability < 1.0) {
            return Err(Error::Parameter { name: "probability", value: probability, expected: "between 0 and 1" });
        }
        let tail = (1.0 - probability) / 2.0;
        Ok(-self.0.inverse_cdf(tail))
    }
}

fn about(center: f64, half: f64) -> [f64; 2] {
    [center - half, center + half]
}

fn no_degrees(regression: &Regression) -> Error {
    Error::NoDegreesOfFreedom { n_points: regression.data().n_used(), n_terms: regression.model().n_terms() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With 1 and 2 degrees of freedom in closed form; with more, how far is what is beyond it.
    #[test]
    fn quantiles_are_those_of_closed_forms() {
        let student = |degrees: f64| Student(StudentsT::new(0.0, 1.0, degrees).expect("degrees of freedom"));
        for p in [0.1, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0 - 1e-6] {
            let near = |found: f64, expected: f64, what: &str| {
                assert!((found / expected - 1.0).abs() < 1e-9, "{what} at {p}: {found}, expected {expected}");
            };
            near(student(1.0).quantile(p).expect("within"), (std::f64::consts::FRAC_PI_2 * p).tan(), "1");
            near(student(2.0).quantile(p).expect("within"), p * (2.0 / (1.0 - p * p)).sqrt(), "2");
            for degrees in [3.0, 7.0, 40.0, 1000.0] {
                let student = student(degrees);
                near(student.beyond(student.quantile(p).expect("within")), 1.0 - p, "beyond");
            }
        }
        let extremes = [f64::MIN_POSITIVE, 1.0 - f64::EPSILON].map(|p| student(3.0).quantile(p).expect("within"));
        assert!(extremes[0].abs() < 1e-6 && extremes[1] > 1e4, "{extremes:?}");
    }
}
