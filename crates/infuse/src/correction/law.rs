//! The correction laws, as linear combinations of the surfaces seen so far.

use serde::{Deserialize, Serialize};

use crate::correction::{Coefficients, Gain};

/// How the surfaces of batch n change the correction. In files `proof_recursion`,
/// `current_simulation`, `as_printed_36`.
///
/// Ĵexp,n and Ĵsim,n are the surfaces fitted to the experiments and to the simulations of batch n
/// from 1; Ĵcor,0 = 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// The recursion of the dissertation's proof:
    ///
    /// ```text
    /// Ĵcor,n = Ĵcor,n−1 + k_n (Ĵexp,n − Ĵnum,n−1)        Ĵnum,n = Ĵsim,n + Ĵcor,n        Ĵnum,0 = Ĵsim,1
    /// ```
    ///
    /// The experiment is compared with the model of the batch before, so the simulation's error enters twice.
    ///
    /// Source: (45), (46).
    #[default]
    ProofRecursion,
    /// The same, but against the simulation surface of the same batch:
    ///
    /// ```text
    /// Ĵcor,n = Ĵcor,n−1 + k_n (Ĵexp,n − Ĵsim,n − Ĵcor,n−1)
    /// ```
    ///
    /// Source: beyond the text. For 0 < k ≤ 1 the limit of its bound is smaller by 2 k E1 than that
    /// of the proof's law.
    CurrentSimulation,
    /// (36) as printed: all corrections so far are added up, and the next difference to them.
    ///
    /// ```text
    /// Ĵcor,n = k_n (Ĵexp,n − Ĵsim,n) + Σ_{j<n} Ĵcor,j
    /// ```
    ///
    /// Do not use it on a rig. It adds up corrections that are sums already, so a constant gap is
    /// corrected k, 2k, 4k, 8k, ... times. In the dissertation's loop its numbers pass what a surface
    /// takes, 1e100, after some 330 batches for a gap of 1, and `tell` then answers with an error; on their own they
    /// overflow after a thousand. It is offered so that one can watch it fail.
    ///
    /// Source: (36).
    #[serde(rename = "as_printed_36")]
    AsPrinted36,
}

/// Which simulation surface carries the correction learned from n batches of experiments.
///
/// The experiments of a batch must not correct the model with which their own validation
/// points are compared, so batch n + 1 works with [`Onset`](Self::Onset); the proposition speaks of
/// [`Corrected`](Self::Corrected).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelStage {
    /// Ĵsim,n+1 + Ĵcor,n: the model at the onset of batch n + 1, of which its combined surface is
    /// made.
    Onset,
    /// Ĵnum,n = Ĵsim,n + Ĵcor,n of (35). With n = 0 it is Ĵsim,1.
    Corrected,
}

/// A correction law with its gain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// What is compared with what.
    #[serde(default)]
    pub law: Law,
    /// How much of the difference is believed.
    pub gain: Gain,
}

impl Rule {
    /// This law with this gain.
    #[must_use]
    pub fn new(law: Law, gain: Gain) -> Self {
        Self { law, gain }
    }

    /// Ĵcor,n as a combination of Ĵexp,1..n and Ĵsim,1..n.
    ///
    /// With w_j = k_j Π_{i=j+1}^{n} (1 − k_i) and Ĵsim,0 = Ĵsim,1:
    ///
    /// ```text
    /// ProofRecursion      Σ_{j=1}^{n} w_j (Ĵexp,j − Ĵsim,j−1)
    /// CurrentSimulation   Σ_{j=1}^{n} w_j (Ĵexp,j − Ĵsim,j)
    /// AsPrinted36         k_n (Ĵexp,n − Ĵsim,n) + Σ_{j<n} 2^(n−1−j) k_j (Ĵexp,j − Ĵsim,j)
    /// ```
    ///
    /// The first is (47) with a constant gain; the others follow by unrolling.
    ///
    /// Source: (47).
    #[must_use]
    pub fn correction(&self, n: usize) -> Coefficients {
        let experiment = self.weights(n).of_difference;
        let mut simulation = vec![0.0; n];
        for (index, weight) in experiment.iter().enumerate() {
            let compared = match self.law {
                Law::ProofRecursion => index.saturating_sub(1),
                Law::CurrentSimulation | Law::AsPrinted36 => index,
            };
            simulation[compared] -= weight;
        }
        Coefficients { experiment, simulation }
    }

    /// The model after n batches of experiments as a combination of n experiment surfaces and of n
    /// simulation surfaces, n + 1 at the onset of the next batch.
    #[must_use]
    pub fn model(&self, stage: ModelStage, n: usize) -> Coefficients {
        let mut coefficients = self.correction(n);
        if n == 0 || stage == ModelStage::Onset {
            coefficients.simulation.push(0.0);
        }
        if let Some(carrier) = coefficients.simulation.last_mut() {
            *carrier += 1.0;
        }
        coefficients
    }

    pub(crate) fn weights(&self, n: usize) -> Weights {
        let mut of_difference = vec![0.0; n];
        let mut rest = 1.0;
        if self.law == Law::AsPrinted36 {
            // The sum of the corrections doubles, but only from the batch before last on.
            let mut doubled = 1.0;
            for j in (1..=n).rev() {
                of_difference[j - 1] = self.gain.at(j) * doubled;
                rest -= of_difference[j - 1];
                if j < n {
                    doubled *= 2.0;
                }
            }
        } else {
            for j in (1..=n).rev() {
                of_difference[j - 1] = self.gain.at(j) * rest;
                rest *= 1.0 - self.gain.at(j);
            }
        }
        Weights { of_difference, of_gap: rest }
    }
}

/// What the correction of batch n makes of the past.
#[derive(Debug)]
pub(crate) struct Weights {
    /// Weight of the difference observed in each batch.
    pub(crate) of_difference: Vec<f64>,
    /// What is left of the gap J_true − J_sim: one less the sum of the weights.
    pub(crate) of_gap: f64,
}
