//! The undisturbed flow: uniform in space, with speed and direction as functions of time.

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::real::Real;

/// A uniform flow at one instant.
///
/// Its velocity in G is `−V [cos psi_flow, sin psi_flow, 0]`: a nose with the heading `psi_flow` looks
/// straight upstream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow<T = f64> {
    /// V, in m/s.
    pub speed_m_s: T,
    /// psi_flow, in rad.
    pub direction_rad: T,
}

impl Flow {
    /// A flow of `speed_m_s` along the x axis of G (nose direction `psi_flow = 0`).
    #[must_use]
    pub fn straight(speed_m_s: f64) -> Self {
        Self { speed_m_s, direction_rad: 0.0 }
    }

    /// The same flow in every lane, or with zero derivative.
    #[must_use]
    #[inline(always)]
    pub fn cast<T: Real>(&self) -> Flow<T> {
        Flow { speed_m_s: T::constant(self.speed_m_s), direction_rad: T::constant(self.direction_rad) }
    }

    /// # Errors
    /// [`Error::Argument`] for a negative or non-finite speed or a non-finite direction.
    pub fn validate(&self) -> Result<(), Error> {
        if !(self.speed_m_s.is_finite() && self.speed_m_s >= 0.0) {
            return Err(Error::Argument {
                name: "flow speed in m/s",
                value: self.speed_m_s,
                expected: "finite and zero or more",
            });
        }
        if !self.direction_rad.is_finite() {
            return Err(Error::Argument {
                name: "flow direction in rad",
                value: self.direction_rad,
                expected: "finite",
            });
        }
        Ok(())
    }
}

/// How the flow goes from one knot of a [`FlowHistory`] to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transition {
    /// The knot's flow holds until the next knot, where it steps.
    #[default]
    Step,
    /// Speed and direction go linearly to those of the next knot.
    Linear,
}

/// The flow from one instant on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowKnot {
    /// Time from which the flow applies, in s.
    pub from_s: f64,
    /// The flow at that time.
    pub flow: Flow,
    /// How it goes on.
    pub transition: Transition,
}

/// Speed and direction of the flow as functions of time.
///
/// The equations of motion treat the flow as steady at each instant: the inertia of an accelerating flow is left out,
/// which with added mass would push by `(rho Vol + M_a) ΔV` where the speed steps.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowHistory {
    knots: Vec<FlowKnot>,
}

impl FlowHistory {
    /// A history from its knots, the first of which is at t = 0.
    ///
    /// # Errors
    /// [`Error::Argument`] when there is no knot, the first is not at 0, times do not increase, or a flow is
    /// not finite.
    pub fn new(knots: Vec<FlowKnot>) -> Result<Self, Error> {
        let Some(first) = knots.first() else {
            return Err(Error::Argument { name: "number of flow knots", value: 0.0, expected: "at least one" });
        };
        if first.from_s != 0.0 {
            return Err(Error::Argument {
                name: "time of the first flow knot in s",
                value: first.from_s,
                expected: "0",
            });
        }
        for knot in &knots {
            knot.flow.validate()?;
        }
        for pair in knots.windows(2) {
            if !(pair[1].from_s.is_finite() && pair[1].from_s > pair[0].from_s) {
                return Err(Error::Argument {
                    name: "time of a flow knot in s",
                    value: pair[1].from_s,
                    expected: "finite and later than the knot before",
                });
            }
        }
        Ok(Self { knots })
    }

    /// The same flow at all times.
    ///
    /// # Errors
    /// [`Error::Argument`], see [`Flow::validate`].
    pub fn constant(flow: Flow) -> Result<Self, Error> {
        Self::new(vec![FlowKnot { from_s: 0.0, flow, transition: Transition::Step }])
    }

    /// The flow at `time_s`; at a step, the flow after it.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Flow {
        self.within(self.piece(time_s), time_s)
    }

    /// The index of the piece that covers `time_s`; at a knot, the piece that begins there.
    #[must_use]
    pub fn piece(&self, time_s: f64) -> usize {
        self.knots.partition_point(|knot| knot.from_s <= time_s).saturating_sub(1)
    }

    /// The flow at `time_s` by the formula of piece `piece_idx`, also at the end of the piece.
    #[must_use]
    #[inline]
    pub fn within(&self, piece_idx: usize, time_s: f64) -> Flow {
        let knot = &self.knots[piece_idx.min(self.knots.len() - 1)];
        match (knot.transition, self.knots.get(piece_idx + 1)) {
            (Transition::Linear, Some(next)) => {
                let share = ((time_s - knot.from_s) / (next.from_s - knot.from_s)).clamp(0.0, 1.0);
                Flow {
                    speed_m_s: knot.flow.speed_m_s + share * (next.flow.speed_m_s - knot.flow.speed_m_s),
                    direction_rad: knot.flow.direction_rad
                        + share * (next.flow.direction_rad - knot.flow.direction_rad),
                }
            }
            _ => knot.flow,
        }
    }

    /// The knots, in the order of time.
    #[must_use]
    pub fn knots(&self) -> &[FlowKnot] {
        &self.knots
    }
}
