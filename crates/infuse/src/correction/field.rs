//! The correction as a recursion over values at points.

use crate::Error;
use crate::checks::{check_cells, check_count, check_finite};
use crate::correction::{Law, Rule};

/// Ĵcor,n and Ĵnum,n at the cells of a region, one batch of experiments after the other.
///
/// The same as [`Rule::correction`] to rounding, without keeping past surfaces.
///
/// ```
/// use infuse::correction::{Field, Gain, Law, Rule};
///
/// // The simulation says 1 where the truth is 3. With k = 0.5 half of the gap is left each time.
/// let rule = Rule::new(Law::ProofRecursion, Gain::constant(0.5)?);
/// let mut field = Field::new(rule, 1)?;
/// for expected in [2.0, 2.5, 2.75] {
///     field.update(&[3.0], &[1.0])?;
///     assert_eq!(field.model(), Some(&[expected][..]));
/// }
/// # Ok::<(), infuse::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    rule: Rule,
    n_batches: usize,
    correction: Vec<f64>,
    /// Ĵnum,n; empty before the first batch.
    model: Vec<f64>,
    /// Σ_j Ĵcor,j, which only (36) as printed asks for.
    sum_of_corrections: Vec<f64>,
}

impl Field {
    /// No correction yet, at this many cells.
    ///
    /// # Errors
    ///
    /// [`Error::EmptyRegion`].
    pub fn new(rule: Rule, n_cells: usize) -> Result<Self, Error> {
        check_cells(n_cells)?;
        let zeros = vec![0.0; n_cells];
        Ok(Self { rule, n_batches: 0, correction: zeros.clone(), model: Vec::new(), sum_of_corrections: zeros })
    }

    /// Rounds of experiments digested so far.
    #[must_use]
    pub fn n_batches(&self) -> usize {
        self.n_batches
    }

    /// Ĵcor,n per cell.
    #[must_use]
    pub fn correction(&self) -> &[f64] {
        &self.correction
    }

    /// Ĵnum,n = Ĵsim,n + Ĵcor,n per cell, (35); nothing before the first batch.
    #[must_use]
    pub fn model(&self) -> Option<&[f64]> {
        (self.n_batches > 0).then_some(&self.model)
    }

    /// Ĵsim,n+1 + Ĵcor,n per cell: the model at the onset of the next batch, from that
    /// batch's simulation surface.
    ///
    /// # Errors
    ///
    /// [`Error::WrongCount`], [`Error::Entry`].
    pub fn onset_model(&self, simulation: &[f64]) -> Result<Vec<f64>, Error> {
        check_count("simulation", self.correction.len(), simulation.len(), "cell")?;
        check_finite("simulation", simulation)?;
        let model = add(simulation, &self.correction);
        check_finite("model", &model)?;
        Ok(model)
    }

    /// Learns from the surfaces Ĵexp and Ĵsim of the next batch, given per cell.
    ///
    /// # Errors
    ///
    /// [`Error::WrongCount`], and [`Error::Entry`] for a value that is not finite, in the surfaces or in
    /// what becomes of them; the field is then as before.
    pub fn update(&mut self, experiment: &[f64], simulation: &[f64]) -> Result<(), Error> {
        let n_cells = self.correction.len();
        check_count("experiment", n_cells, experiment.len(), "cell")?;
        check_count("simulation", n_cells, simulation.len(), "cell")?;
        check_finite("experiment", experiment)?;
        check_finite("simulation", simulation)?;
        let gain = self.rule.gain.at(self.n_batches + 1);
        // Ĵnum,0 = Ĵsim,1 (45).
        let last_model = self.model().unwrap_or(simulation);
        let correction: Vec<f64> = (0..n_cells)
            .map(|cell| {
                let last = self.correction[cell];
                let measured = experiment[cell];
                match self.rule.law {
                    Law::ProofRecursion => last + gain * (measured - last_model[cell]),
                    Law::CurrentSimulation => last + gain * (measured - simulation[cell] - last),
                    Law::AsPrinted36 => gain * (measured - simulation[cell]) + self.sum_of_corrections[cell],
                }
            })
            .collect();
        let model = add(simulation, &correction);
        check_finite("correction", &correction)?;
        check_finite("model", &model)?;
        if self.rule.law == Law::AsPrinted36 {
            let sum = add(&self.sum_of_corrections, &correction);
            check_finite("sum of corrections", &sum)?;
            self.sum_of_corrections = sum;
        }
        (self.correction, self.model) = (correction, model);
        self.n_batches += 1;
        Ok(())
    }

    /// Keeps the cells marked `true`, in their order: a region that shrinks.
    ///
    /// # Errors
    ///
    /// [`Error::WrongCount`], and [`Error::EmptyRegion`] if none is kept; the field is then as before.
    pub fn retain(&mut self, keep: &[bool]) -> Result<(), Error> {
        check_count("keep", self.correction.len(), keep.len(), "cell")?;
        check_cells(keep.iter().filter(|kept| **kept).count())?;
        for values in [&mut self.correction, &mut self.model, &mut self.sum_of_corrections] {
            let mut kept = keep.iter();
            values.retain(|_| kept.next().copied().unwrap_or(false));
        }
        Ok(())
    }
}

fn add(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}
