//! From sightings to a pose: nonlinear least squares over all pixels.

use core::fmt;

use bat_dynamics::{LANES, Lanes, Real};
use multiversion::multiversion;

use super::bundle::Bundle;
use super::normal_equations::{Factor, MisfitShares, Shares};
use super::pose::{Attitude, Pose};
use super::triple::{Triple, abreast, add, times};

/// With fewer dots than this in all there is no pose.
pub(crate) const FEWEST_DOTS: usize = 4;
/// A step shorter than this, in m and rad, is the last: the next one would be of the order of its square.
const LAST_STEP: f64 = 3e-6;
/// Steps that lead no farther than this from the pose where `Jᵀ J` was made, in m and rad, go by it: the look after them is for the
/// misfit alone.
const SHORT_WAY: f64 = 1e-2;
/// Such steps end where the way from that pose times the last step is less than this, in m², m rad and rad²: the next step would be a
/// small multiple of that product.
const LAST_PRODUCT: f64 = 1e-11;
/// More of it for each px that the pose leaves, as the root of the sum of squares.
///
/// At a pixel noise of 0.1 px a search ends within 2e-7 rad and 5e-9 m of where it would come to rest, 1.5 ten-thousandths of a
/// standard deviation of the pose; from 0.03 to 1 px within 3 ten-thousandths (the largest of 2000 poses each, test
/// `what_a_search_leaves_is_far_below_the_noise`).
const LAST_PRODUCT_PER_PX: f64 = 1.5e-8;
/// Such steps that shrink by less than this are not the last, wherever they lead, and ask for a matrix of their own.
const SLOW: f64 = 0.1;
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
    equations: Shares,
    /// The pose to look at, and how long the step to it is, in m and rad.
    next: Spot,
    step: f64,
    /// The length of all steps since the matrix was made.
    way: f64,
    /// Whether the next look is for the misfit alone, by the matrix of an earlier one.
    is_chord: bool,
    is_first: bool,
    damping: f64,
    outcome: Option<Result<Pose, Hold>>,
}

impl<'a> Search<'a> {
    #[inline(always)]
    pub(crate) fn new(bundles: &'a [Bundle], guess: &Pose) -> Self {
        let guess = Spot::of(guess);
        let equations = Shares::NONE;
        Self {
            bundles,
            best: guess,
            equations,
            next: guess,
            step: f64::INFINITY,
            way: 0.0,
            is_chord: false,
            is_first: true,
            damping: 0.0,
            outcome: None,
        }
    }

    /// A search that has ended before it began.
    pub(crate) fn held(hold: Hold) -> Self {
        Self { outcome: Some(Err(hold)), ..Self::new(&[], &Pose::default()) }
    }

    /// What it came to.
    pub(crate) fn found(&self) -> Result<Pose, Hold> {
        self.outcome.unwrap_or(Err(Hold::NotConverged))
    }

    /// Looks at the next pose: it is the best so far if it lessens the sum of squares. Whether the matrix or the damping is another
    /// than before.
    #[inline(always)]
    fn look(&mut self) -> bool {
        let (position, rows) = (self.next.position, self.next.attitude.rows_gb());
        if self.is_chord {
            match MisfitShares::new(self.bundles, position, &rows) {
                Some(after) if after.cost() <= self.equations.cost() => {
                    self.best = self.next;
                    self.equations.misfit = after;
                    return false;
                }
                _ => (self.damping, self.is_chord) = (FIRST_DAMPING, false),
            }
        } else {
            match Shares::new(self.bundles, position, &rows) {
                Some(after) if self.is_first || after.cost() <= self.equations.cost() => {
                    (self.best, self.equations, self.is_first) = (self.next, after, false);
                    self.damping = if self.damping > FIRST_DAMPING { 0.1 * self.damping } else { 0.0 };
                }
                None if self.is_first => self.outcome = Some(Err(Hold::NotConverged)),
                _ => self.damping = if self.damping > 0.0 { 10.0 * self.damping } else { FIRST_DAMPING },
            }
        }
        true
    }

    /// Ends with `next`, a step away from the best pose, or looks at it in the next round.
    #[inline(always)]
    fn take(&mut self, next: Spot, step: &[f64; 6], is_open: bool) {
        let now = largest(step);
        let is_slow = self.is_chord && now > SLOW * self.step;
        let is_last = if self.is_chord {
            !is_slow && now * self.way < LAST_PRODUCT + LAST_PRODUCT_PER_PX * self.equations.cost().sqrt()
        } else {
            now < LAST_STEP && self.damping <= FIRST_DAMPING
        };
        if is_open {
            self.outcome = Some(Err(Hold::Singular));
        } else if is_last {
            self.outcome = Some(Ok(next.pose().usual()));
        } else {
            let way = if self.is_chord { self.way + now } else { now };
            self.is_chord = self.damping <= 0.0 && way < SHORT_WAY && !is_slow;
            (self.next, self.step, self.way) = (next, now, way);
        }
    }
}

/// Seeks the poses that fit the sightings of four images best, by Gauss-Newton steps, damped (Levenberg-Marquardt) where one does not lessen
/// the sum of squares.
///
/// After a short step `Jᵀ J` is what it was but for a share of the order of that step, and stays: the next look is for `Jᵀ e`, which
/// alone decides where the search comes to rest, and takes less than half the time. Most images of a flight take one look for all and one
/// for `Jᵀ e`.
///
/// Sums are made for one image after the other, steps for four side by side; a pose depends on its own image alone. Compiled for
/// several instruction sets, none of which contracts a product and a sum: all give the same bits.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(crate) fn locate(searches: &mut [Search<'_>; LANES]) {
    let mut factor = Factor::NONE;
    for _ in 0..MOST_STEPS {
        let (mut is_over, mut is_new) = (true, false);
        for search in searches.iter_mut() {
            if search.outcome.is_none() {
                is_new |= search.look();
                is_over &= search.outcome.is_some();
            }
        }
        if is_over {
            break;
        }
        let [a, b, c, d] = &*searches;
        let (e, f, g, h) = (&a.equations, &b.equations, &c.equations, &d.equations);
        if is_new {
            let raised = Lanes([1.0 + a.damping, 1.0 + b.damping, 1.0 + c.damping, 1.0 + d.damping]);
            factor = Factor::new(&Shares::abreast([e, f, g, h]), raised);
        }
        let step = factor.step(&MisfitShares::abreast([&e.misfit, &f.misfit, &g.misfit, &h.misfit]));
        let best = Spot::abreast([&a.best, &b.best, &c.best, &d.best]);
        let (next, is_regular, has_angles) = (best.moved(step), factor.is_regular(), best.attitude.has_angles());
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
