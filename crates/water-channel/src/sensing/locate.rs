//! From sightings to a pose: nonlinear least squares over all pixels.

use core::fmt;

use bat_dynamics::{LANES, Lanes, Real};
use multiversion::multiversion;

use super::bundle::Bundle;
use super::normal_equations::NormalEquations;
use super::pose::{Attitude, Pose};
use super::triple::{Triple, abreast, add, times};

/// With fewer dots than this in all there is no pose.
pub(crate) const FEWEST_DOTS: usize = 4;
/// A step shorter than this, in m and rad, is the last: the next one would be of the order of its square.
const LAST_STEP: f64 = 3e-6;
const MOST_STEPS: usize = 40;
/// The damping that follows the first step that does not lessen the sum of squares.
const FIRST_DAMPING: f64 = 1e-3;

/// Why there is no new pose, so that the last one is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Three dots or fewer are seen by all cameras together.
    TooFewDots,
    /// The dots seen leave the pose open: all on a line, for example.
    Singular,
    /// No pose close to the last one fits: a dot would have to be behind its camera, or the steps do not end.
    NotConverged,
    /// Because of the delay no image has arrived yet; the pose is the one that the flight begins with.
    NoImageYet,
}

impl Hold {
    /// As the log has it: 1 to 4 in the order of the variants; 0 stands for a new pose.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::TooFewDots => 1,
            Self::Singular => 2,
            Self::NotConverged => 3,
            Self::NoImageYet => 4,
        }
    }
}

impl fmt::Display for Hold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewDots => "three dots or fewer are seen",
            Self::Singular => "the dots seen leave the pose open",
            Self::NotConverged => "no pose near the last one fits the dots seen",
            Self::NoImageYet => "no image has arrived yet",
        })
    }
}

/// The search for the pose that fits the sightings of one image best, from a guess on.
#[derive(Clone, Debug)]
pub(crate) struct Search<'a> {
    bundles: &'a [Bundle],
    /// The best pose so far, and its equations.
    best: Spot,
    equations: NormalEquations,
    /// The pose to look at.
    next: Spot,
    is_first: bool,
    damping: f64,
    outcome: Option<Result<Pose, Hold>>,
}

impl<'a> Search<'a> {
    #[inline(always)]
    pub(crate) fn new(bundles: &'a [Bundle], guess: &Pose) -> Self {
        let guess = Spot::of(guess);
        let equations = NormalEquations::NONE;
        Self { bundles, best: guess, equations, next: guess, is_first: true, damping: 0.0, outcome: None }
    }

    /// A search that has ended before it began.
    pub(crate) fn held(hold: Hold) -> Self {
        Self { outcome: Some(Err(hold)), ..Self::new(&[], &Pose::default()) }
    }

    /// What it came to.
    pub(crate) fn found(&self) -> Result<Pose, Hold> {
        self.outcome.unwrap_or(Err(Hold::NotConverged))
    }

    /// Looks at the next pose: it is the best so far if it lessens the sum of squares.
    #[inline(always)]
    fn look(&mut self) {
        match NormalEquations::new(self.bundles, self.next.position, &self.next.attitude.rows_gb()) {
            Some(after) if self.is_first || after.cost() <= self.equations.cost() => {
                (self.best, self.equations, self.is_first) = (self.next, after, false);
                self.damping = if self.damping > FIRST_DAMPING { 0.1 * self.damping } else { 0.0 };
            }
            None if self.is_first => self.outcome = Some(Err(Hold::NotConverged)),
            _ => self.damping = if self.damping > 0.0 { 10.0 * self.damping } else { FIRST_DAMPING },
        }
    }

    /// Ends with `next`, a step away from the best pose, or looks at it in the next round.
    #[inline(always)]
    fn take(&mut self, next: Spot, step: &[f64; 6], is_open: bool) {
        if is_open {
            self.outcome = Some(Err(Hold::Singular));
        } else if largest(step) < LAST_STEP && self.damping <= FIRST_DAMPING {
            self.outcome = Some(Ok(next.pose().usual()));
        } else {
            self.next = next;
        }
    }
}

/// Seeks the poses that fit the sightings of four images best, by Gauss-Newton steps, damped (Levenberg-Marquardt) where one does not lessen
/// the sum of squares.
///
/// Sums are made for one image after the other, steps for four side by side; a pose depends on its own image alone. Compiled for
/// several instruction sets, none of which contracts a product and a sum: all give the same bits.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn locate(searches: &mut [Search<'_>; LANES]) {
    for _ in 0..MOST_STEPS {
        let mut is_over = true;
        for search in searches.iter_mut() {
            if search.outcome.is_none() {
                search.look();
                is_over &= search.outcome.is_some();
            }
        }
        if is_over {
            break;
        }
        let [a, b, c, d] = &*searches;
        let raised = Lanes([1.0 + a.damping, 1.0 + b.damping, 1.0 + c.damping, 1.0 + d.damping]);
        let equations = NormalEquations::abreast([&a.equations, &b.equations, &c.equations, &d.equations]);
        let best = Spot::abreast([&a.best, &b.best, &c.best, &d.best]);
        let (step, is_regular) = equations.step(raised);
        let (next, has_angles) = (best.moved(step), best.attitude.has_angles());
        for (lane, search) in searches.iter_mut().enumerate() {
            if search.outcome.is_none() {
                let is_open = is_regular.0[lane] * has_angles.0[lane] <= 0.0;
                search.take(next.lane(lane), &step_of(&step, lane), is_open);
            }
        }
    }
}

#[inline(always)]
fn step_of(&[a, b, c, d, e, f]: &[Lanes; 6], lane: usize) -> [f64; 6] {
    [a.0[lane], b.0[lane], c.0[lane], d.0[lane], e.0[lane], f.0[lane]]
}

#[inline(always)]
fn largest(&[a, b, c, d, e, f]: &[f64; 6]) -> f64 {
    a.abs().max(b.abs()).max(c.abs()).max(d.abs()).max(e.abs()).max(f.abs())
}

/// A pose with its attitude, or several side by side.
#[derive(Clone, Copy, Debug)]
struct Spot<T = f64> {
    position: Triple<T>,
    angles: Triple<T>,
    attitude: Attitude<T>,
}

impl<T: Real> Spot<T> {
    #[inline(always)]
    fn new(position: Triple<T>, angles: Triple<T>) -> Self {
        Self { position, angles, attitude: Attitude::of_angles(angles) }
    }

    /// After a step of shifts and turns along G.
    #[inline(always)]
    fn moved(&self, [x, y, z, a, b, c]: [T; 6]) -> Self {
        let angles = times(&self.attitude.angles_of_turn(), [a, b, c]);
        Self::new(add(self.position, [x, y, z]), add(self.angles, angles))
    }
}

impl Spot<Lanes> {
    #[inline(always)]
    fn abreast([a, b, c, d]: [&Spot; LANES]) -> Self {
        let (e, f, g, h) = (&a.attitude, &b.attitude, &c.attitude, &d.attitude);
        Self {
            position: abreast(&a.position, &b.position, &c.position, &d.position),
            angles: abreast(&a.angles, &b.angles, &c.angles, &d.angles),
            attitude: Attitude {
                sines: abreast(&e.sines, &f.sines, &g.sines, &h.sines),
                cosines: abreast(&e.cosines, &f.cosines, &g.cosines, &h.cosines),
            },
        }
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Spot {
        let of = |[a, b, c]: Triple<Lanes>| [a.0[lane], b.0[lane], c.0[lane]];
        let attitude = Attitude { sines: of(self.attitude.sines), cosines: of(self.attitude.cosines) };
        Spot { position: of(self.position), angles: of(self.angles), attitude }
    }
}

impl Spot {
    #[inline(always)]
    fn of(pose: &Pose) -> Self {
        let angles = [pose.roll_rad, pose.pitch_rad, pose.heading_rad];
        Self { position: pose.position_m, angles, attitude: pose.attitude() }
    }

    #[inline(always)]
    fn pose(&self) -> Pose {
        let [roll_rad, pitch_rad, heading_rad] = self.angles;
        Pose { position_m: self.position, roll_rad, pitch_rad, heading_rad }
    }
}
