//! The search over a continuous box, replicates allowed.

use rand_pcg::Pcg64;

use super::attempt::{Attempt, Designer, Refinement};
use super::continuous::Continuous;
use super::ending::IsOver;
use super::frame::{Frame, judged_lattice};
use super::incumbents::Incumbents;
use super::problem::Problem;
use super::settings::Effort;
use super::smooth::MARGIN;
use super::starts::{Outcome, Runner};
use crate::shape::{BoxShape, Shape};
use crate::{Criterion, Design, Error, Information};

pub(crate) fn over_box(problem: &Problem, shape: &BoxShape, runner: Runner<'_>) -> Result<Outcome, Error> {
    let relaxed = shape.relaxed();
    let frame = Frame::of(problem, Some(&relaxed), runner.least_log_determinant, &<[f64]>::to_vec)?;
    let lattice = judged_lattice(problem, &relaxed, &frame.products);
    let (effort, judged) = (runner.settings.effort, problem.judged_grid().unwrap_or(&relaxed));
    Ok(runner.run(&Continuous { frame: &frame, shape: &relaxed, judged, lattice: &lattice, effort }))
}

/// A design taken to its local optimum by the criterion of a problem, as a thorough search does with its best: it is
/// never worse. Fixed runs must be its first and stay where they are. T alone would lead to designs that determine nothing:
/// det(M)^(1/p) stays what it is in the given design, to within a hundredth.
///
/// ```
/// use doe::{Criterion, Design, Model, Problem, Space, polished};
/// let problem = Problem::new(Model::quadratic(1)?, Space::cube(1)?, 4, Criterion::G)?;
/// let design = polished(&problem, &Design::new(1, vec![-1.0, -0.4, 0.5, 1.0])?)?;
/// let percent = Criterion::G.efficiency(problem.model(), problem.space(), &design)?.percent;
/// assert!((percent - 82.918).abs() < 5e-4);
/// # Ok::<(), doe::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::NotContinuous`] where runs cannot move, as on grids and lists, or must not meet; [`Error::Count`] for another
/// number of runs than the problem has; [`Error::RunOutside`]; [`Error::Singular`] if the design does not determine the
/// model; as [`Problem::validate`].
pub fn polished(problem: &Problem, design: &Design) -> Result<Design, Error> {
    problem.validate()?;
    let relaxed = match problem.space().shape() {
        Shape::Box(shape) if problem.is_continuous() => shape.relaxed(),
        _ => return Err(Error::NotContinuous { what: "a polish" }),
    };
    design.check_within(problem.space())?;
    let (found, n_runs) = (design.n_runs(), problem.n_runs());
    if found != n_runs {
        return Err(Error::Count { name: "runs of the design", found, least: n_runs, most: n_runs });
    }
    let value = |design: &Design| problem.criterion().efficiency(problem.model(), problem.judged(), design);
    let before = value(design)?.value;
    let least = match problem.criterion() {
        Criterion::T => log_determinant(problem, design)? - MARGIN,
        _ => f64::NEG_INFINITY,
    };
    let frame = Frame::of(problem, Some(&relaxed), least, &<[f64]>::to_vec)?;
    let lattice = judged_lattice(problem, &relaxed, &frame.products);
    let judged = problem.judged_grid().unwrap_or(&relaxed);
    let search = Continuous { frame: &frame, shape: &relaxed, judged, lattice: &lattice, effort: Effort::Thorough };
    let free = design.coordinates()[(n_runs - problem.n_free()) * design.n_factors()..].to_vec();
    let (x, _) = search.taken_down(free, &|| false).ok_or(Error::Singular)?;
    let polished = problem.design(&x)?;
    Ok(if value(&polished)?.value < before { polished } else { design.clone() })
}

/// log det(M) / p of a design.
fn log_determinant(problem: &Problem, design: &Design) -> Result<f64, Error> {
    let information = Information::of(problem.model(), design)?;
    Ok(information.log_determinant() / information.n_terms() as f64)
}

impl Designer for Continuous<'_> {
    fn start(&self, generator: &mut Pcg64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Attempt {
        self.start(generator, incumbents, is_over)
    }

    fn refine(&self, x: Vec<f64>, _value: f64, incumbents: &Incumbents, is_over: IsOver<'_>) -> Refinement {
        self.refine(x, incumbents, is_over)
    }
}
