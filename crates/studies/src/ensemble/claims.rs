//! What the dissertation says, as tests of a campaign, a design or a plant.

use super::file::Setup;
use super::kept::{Case, value_of};
use super::row::{Fact, Method, Reading, Row, Study, World};
use crate::claims::{Place, Truth};
use crate::rules::{MUCH, NEAR, Standing};

/// Of a design beside the one before.
type OfTwo = Box<dyn Fn(&Row, &Row) -> bool>;
/// Of a campaign, step by step, in its case.
type OfPath = Box<dyn Fn(&Case<'_>, &[&Row]) -> bool>;
/// Of a campaign by the number of its seed; none where nothing is known.
type OfSeed = Box<dyn Fn(&Case<'_>, u64) -> Option<bool>>;
/// Of a search for a design of experiments by its seed, in the facts of all; none where nothing is known.
type OfSearch = Box<dyn Fn(&[&Fact], u64) -> Option<bool>>;
/// Of a plant; none where nothing is known.
type OfPlant = Box<dyn Fn(&Case<'_>) -> Option<bool>>;

/// What is looked at.
pub(super) enum Test {
    /// The last design of a campaign beside the optimum of the model: designs that nobody chose can be held against it, too.
    End(OfTwo),
    /// The same beside the first design of the campaign.
    SinceFirst(OfTwo),
    /// A campaign step by step, in its case.
    Path(OfPath),
    /// A campaign by whether the best design known is among what is left: a blind draw of as many cells can be held against it.
    Kept,
    /// A campaign by the number of its seed; none where nothing is known.
    Seed(OfSeed),
    /// A search for a design of experiments by its seed: it knows no plant.
    Search(OfSearch),
    /// The plant itself: each counts as one campaign.
    Plant(OfPlant),
}

/// A claim with what counts as holding.
pub(super) struct Claim {
    pub(super) place: Place,
    /// Without the truth; people read [`Self::words`].
    pub(super) says: String,
    /// Named where it is not our stand-in.
    pub(super) truth: Truth,
    pub(super) study: Study,
    /// What counts.
    pub(super) rule: &'static str,
    /// What it is about, and what can become of it; ends that were fitted were so in still water.
    pub(super) standing: Standing,
    /// Whether it is judged in still water alone.
    pub(super) still_alone: bool,
    /// Whether it is about where a design lies: somebody could choose one that lies there, so that it is within reach.
    pub(super) of_a_place: bool,
    /// Whether it is about flights that cameras saw: then in moving water alone.
    pub(super) by_cameras: bool,
    pub(super) test: Test,
}

/// A design misses the best that is known by more than this share of its cost.
const MISSED: f64 = 0.02;
/// A strategy fails that ends so much above the best of all strategies, as a share.
const FAILED: f64 = 0.01;
/// An error that stays is no larger, in deg.
const STEADY_DEG: f64 = 0.1;
/// A cost is not sensitive that changes by no more than this share.
const INSENSITIVE: f64 = 0.05;

fn lower(reading: Reading, factor: f64) -> OfTwo {
    Box::new(move |before, after| after.of(reading) < factor * before.of(reading))
}

impl Claim {
    pub(super) fn new(place: Place, says: impl Into<String>, study: Study, rule: &'static str, test: Test) -> Self {
        Self {
            place,
            says: says.into(),
            truth: Truth::Unnamed,
            study,
            rule,
            test,
            standing: Standing::StandIn,
            still_alone: false,
            by_cameras: false,
            of_a_place: false,
        }
    }

    /// The same of the truth of the dissertation.
    pub(super) fn of_printed_truth(self) -> Self {
        Self { truth: Truth::Printed, ..self }
    }

    /// What it says, with the truth.
    pub(super) fn words(&self) -> String {
        self.truth.after(&self.says)
    }

    fn fitted(self) -> Self {
        Self { standing: Standing::FittedEnds, ..self }
    }

    /// Of what no plant of this structure could fail.
    fn sure(self) -> Self {
        Self { standing: Standing::Sure, ..self }
    }

    fn of_a_place(self) -> Self {
        Self { of_a_place: true, ..self }
    }

    pub(super) fn still(self) -> Self {
        Self { still_alone: true, ..self }
    }

    /// What can become of it in a world: nothing was fitted in moving water.
    pub(super) fn standing_in(&self, world: World) -> Standing {
        match (self.standing, world) {
            (Standing::FittedEnds, World::Moving) => Standing::StandIn,
            (standing, _) => standing,
        }
    }

    /// The world whose cases decide it in a world of campaigns.
    pub(super) fn judged_by(&self, world: World) -> Option<World> {
        match world {
            World::Still => (!self.by_cameras).then_some(World::Still),
            World::Moving if self.by_cameras => Some(World::Cameras),
            World::Moving => (!self.still_alone).then_some(World::Moving),
            World::Cameras => None,
        }
    }
}

fn section(number: &str) -> Place {
    Place::Section(number.to_owned())
}

pub(super) fn all(setup: &Setup) -> Vec<Claim> {
    let mut claims = of_chapter4();
    claims.extend(of_plants());
    claims.extend(of_surfaces());
    claims.extend(steps_of_two());
    claims.extend(ends_of_two(setup));
    claims.extend(of_four(setup));
    claims.extend(figures_of_four());
    claims.extend(of_convergence());
    claims.sort_by(|a, b| a.place.cmp(&b.place));
    claims
}

const COST_LOWER: &str = "true cost lower than at the model's optimum";

fn of_chapter4() -> Vec<Claim> {
    let claim = |place, says, rule, test| Claim::new(place, says, Study::Chapter4, rule, test).fitted();
    let cheaper = || Test::End(lower(Reading::Cost, 1.0));
    let figure = |number, says, reading| {
        claim(
            Place::Figure(number),
            says,
            "lower at the end than at the model's optimum",
            Test::End(lower(reading, 1.0)),
        )
    };
    let moved =
        |before: &Row, after: &Row| (0..2).all(|k| after.point[k] > before.point[k]) && after.cost() < before.cost();
    vec![
        claim(
            Place::Contribution(1),
            "An iterative co-design framework that fuses experiments and simulations by gradients",
            COST_LOWER,
            cheaper(),
        ),
        claim(Place::Contribution(5), "It is validated on two parameters in the water channel", COST_LOWER, cheaper()),
        claim(
            Place::Table(3),
            "In three iterations the optimum moves aft and to a higher pitch, and the experimental cost falls",
            "all three, from the model's optimum to the last design",
            Test::End(Box::new(moved)),
        ),
        figure(16, "The yaw error squared is smaller after infusion", Reading::Heading),
        figure(17, "The roll error squared is smaller after infusion", Reading::Roll),
        figure(18, "The pitch error squared is smaller after infusion", Reading::Pitch),
    ]
}

/// Whether a strategy of co-design ends above the others.
fn fails(name: &'static str) -> Test {
    Test::Plant(Box::new(move |case: &Case<'_>| {
        let cost = |name: &str| case.fact(&format!("{name}_cost_s"));
        let least = cost("nested")?.min(cost("simultaneous")?);
        Some(cost(name)? > (1.0 + FAILED) * least)
    }))
}

/// Whether the nested strategy takes fewer simulations to the same cost.
fn nested(case: &Case<'_>) -> Option<bool> {
    let of = |name: &str| Some((case.fact(&format!("{name}_simulations"))?, case.fact(&format!("{name}_cost_s"))?));
    let ((n, cost), (m, other)) = (of("nested")?, of("simultaneous")?);
    Some(n < m && cost <= (1.0 + FAILED) * other)
}

/// Whether the pulls do all that is said of them.
fn pulls(case: &Case<'_>) -> Option<bool> {
    let (roll, pitch) = (case.fact("pull_roll_deg")?, case.fact("pull_pitch_up_deg")?);
    let (lower, heading) = (case.fact("pull_lower_cm")?, case.fact("pull_heading_deg")?);
    Some(roll > 1.0 && pitch > 0.1 && lower > 0.1 && heading > 1.0 && case.fact("pull_left")? < 0.1)
}

/// Statements of the text about the plant and about strategies.
fn of_plants() -> Vec<Claim> {
    let claim = |number: &str, says, study, rule, test| Claim::new(section(number), says, study, rule, test);
    let steady = |case: &Case<'_>| Some(case.center()?.of(Reading::SteadyPitch) < STEADY_DEG);
    let strategy = |says, name| claim("1.1", says, Study::Chapter4, FAILS, fails(name)).still();
    vec![
        claim(
            "1.1",
            "Nested optimization is more efficient than simultaneous",
            Study::Chapter4,
            "fewer simulations of the model to a cost no more than 1 % higher",
            Test::Plant(Box::new(nested)),
        )
        .still(),
        strategy("Sequential optimization may fail where plant and controller are coupled", "sequential"),
        strategy("Iterative optimization may fail where plant and controller are coupled", "iterative"),
        claim(
            "2.3",
            "No integral action is needed for steady tracking",
            Study::Two,
            "pitch error at the center of the box at most 0.1 deg in the mean over the last 10 s; no plant of this structure could fail: its winches \
             integrate",
            Test::Plant(Box::new(steady)),
        )
        .sure(),
        claim(
            "2.4.1",
            "Flight is not always sensitive to the mass of the lines",
            Study::Two,
            "cost at the center of the box within 5 % without it and with twice of it",
            Test::Plant(Box::new(|case| Some(case.fact("line_mass_effect")? <= INSENSITIVE))),
        )
        .still(),
        claim(
            "3.2",
            "A pull rolls, pitches up, lowers and turns the body until the controller brings it back",
            Study::Chapter4,
            "each of three: roll, heading by 1 deg, pitch by 0.1, 1 mm; a tenth of the heading left after 70 s",
            Test::Plant(Box::new(pulls)),
        )
        .still(),
    ]
}

/// A claim about designs of experiments: by how many runs there are, how many differ by the criteria G and D, and how far the farthest cell
/// is from a run by either.
fn searches(says: &'static str, rule: &'static str, holds: fn(f64, [f64; 2], [f64; 2]) -> bool) -> Claim {
    let test = move |facts: &[&Fact], seed: u64| {
        let of = |name: &str| value_of(facts, &format!("{name}/{seed}"));
        let distinct = [of("g_distinct")?, of("d_distinct")?];
        Some(holds(value_of(facts, "runs")?, distinct, [of("g_farthest")?, of("d_farthest")?]))
    };
    Claim::new(section("5.1"), says, Study::Two, rule, Test::Search(Box::new(test))).still()
}

/// Statements of the text about experiments and surfaces.
fn of_surfaces() -> Vec<Claim> {
    let claim = |number: &str, says, study, rule, test| Claim::new(section(number), says, study, rule, test);
    vec![
        claim(
            "5",
            "Experiments near the optimum alone may miss the global optimum",
            Study::Chapter4,
            "the last design costs more than 2 % above the best known",
            Test::Path(Box::new(|case, path| path.last().is_some_and(|end| case.regret(end) > MISSED))),
        ),
        searches(
            "D-optimal designs repeat experiments, G-optimal ones do not",
            "five searches for a first batch, no plant: all runs by G differ, not all by D",
            |runs, [g, d], _| g >= runs && d < runs,
        ),
        searches(
            "G-optimal designs fill the space",
            "the same searches: no cell is as far from a run by G as some are by D",
            |_, _, [g, d]| g < d,
        ),
        claim(
            "5.3.2",
            "Distance-weighted surfaces are more realistic than a regressor that is not known",
            Study::Two,
            "(32) through the first batch is closer to designs that nobody chose than (61), root mean square",
            Test::Seed(Box::new(|case, seed| {
                let of = |name: &str| case.fact(&format!("{name}/{seed}"));
                Some(of("error_of_inverse_distance")? < of("error_of_61")?)
            })),
        ),
    ]
}

const FAILS: &str = "ends more than 1 % above the cost that nested or simultaneous optimization finds";

/// Space left before the first and after each step.
fn shares(path: &[&Row]) -> Vec<f64> {
    std::iter::once(1.0).chain(path.iter().map(|row| row.share)).collect()
}

fn drops(path: &[&Row], iteration: usize) -> f64 {
    let shares = shares(path);
    shares.get(iteration).map_or(f64::NAN, |after| shares[iteration - 1] - after)
}

fn shrinks(_: &Case<'_>, path: &[&Row]) -> bool {
    shares(path).windows(2).all(|pair| pair[1] < pair[0])
}

/// Whether a design is near a printed one.
fn near(setup: &Setup, case: usize, printed: Option<Vec<f64>>) -> impl Fn(&Row) -> bool + use<> {
    let widths: Vec<f64> = setup.chapter7.cases.get(case).map_or(Vec::new(), |case| {
        case.space.region().parameters().iter().map(design_space::Parameter::width).collect()
    });
    move |row: &Row| {
        let printed = printed.iter().flatten();
        row.point.iter().zip(printed).zip(&widths).all(|((x, printed), width)| (x - printed).abs() <= NEAR * width)
    }
}

fn last_row(setup: &Setup, case: usize) -> Option<Vec<f64>> {
    Some(setup.chapter7.cases.get(case)?.published.last()?.point.clone())
}

const SHRINKS: &str = "every iteration drops cells";
const AFT: &str = "the last design's center of mass lies behind that of the model's optimum";
const REACHED: &str = "within a tenth of the width of each parameter";
const HALVED: &str = "at most half of that at the model's optimum";
const KEPT: &str = "the best design known is among what is left at the end";
const KEPT_OF_FOUR: &str = "the cheapest design that any compared method chose is among what is left at the end";

fn aft(before: &Row, after: &Row) -> bool {
    after.point[0] > before.point[0]
}

/// Of a campaign with two parameters, step by step.
fn steps_of_two() -> Vec<Claim> {
    let claim = |place, says, rule, test: fn(&Case<'_>, &[&Row]) -> bool| {
        Claim::new(place, says, Study::Two, rule, Test::Path(Box::new(test)))
    };
    vec![
        claim(
            section("7.1"),
            "2 parameters: the first iteration shrinks the space less than the second, because the model is not corrected yet",
            "the first drops fewer cells than the second",
            |_, path| drops(path, 1) < drops(path, 2),
        ),
        claim(
            section("7.1"),
            "2 parameters: from the third iteration on noise limits further reduction",
            "the third drops less than half of what the second does",
            |_, path| drops(path, 3) < 0.5 * drops(path, 2),
        ),
        claim(
            section("7.1"),
            "2 parameters: the corrected model gives a better fit at the second iteration",
            "S of (39) smaller than at the first",
            |_, path| path.get(1).is_some_and(|second| second.spread < path[0].spread),
        ),
        Claim::new(
            section("5.5"),
            "The z-test at 90 % keeps what may be the optimum, with the settings of Chapter 7",
            Study::Two,
            KEPT,
            Test::Kept,
        ),
        claim(Place::Table(5), "2 parameters: the design space shrinks at every iteration", SHRINKS, shrinks),
        claim(
            Place::Figure(23),
            "2 parameters: the runs of every iteration are G-optimal in a space that has shrunk since the iteration before",
            "the first two iterations drop cells",
            |_, path| path.len() >= 2 && shares(path).windows(2).take(2).all(|pair| pair[1] < pair[0]),
        ),
    ]
}

/// Of the last design of a campaign with two parameters.
fn ends_of_two(setup: &Setup) -> Vec<Claim> {
    let claim = |place, says, rule, test| Claim::new(place, says, Study::Two, rule, Test::End(test)).fitted();
    let is_near = near(setup, 0, last_row(setup, 0));
    let figure_24 = |says, reading| claim(Place::Figure(24), says, HALVED, lower(reading, MUCH));
    vec![
        claim(
            Place::Contribution(6),
            "2 parameters: infusion gives a better system than the numerical model alone",
            COST_LOWER,
            lower(Reading::Cost, 1.0),
        ),
        claim(Place::Table(5), "2 parameters: infusion moves the center of mass aft", AFT, Box::new(aft)),
        claim(
            Place::Table(5),
            "2 parameters: the loop ends at the last printed row",
            REACHED,
            Box::new(move |_, after| is_near(after)),
        )
        .of_a_place(),
        figure_24("2 parameters: heading squared improves significantly", Reading::Heading),
        figure_24("2 parameters: pitch error squared improves significantly", Reading::Pitch),
    ]
}

fn of_four(setup: &Setup) -> Vec<Claim> {
    let claim = |place, says, rule, test| Claim::new(place, says, Study::Four, rule, test);
    let path = |of: fn(&Case<'_>, &[&Row]) -> bool| Test::Path(Box::new(of));
    let end = |reading, factor| Test::End(lower(reading, factor));
    let is_near = near(setup, 1, last_row(setup, 1));
    let first = setup.chapter7.cases.get(1).and_then(|case| Some(case.published.first()?.point.clone()));
    let is_first = near(setup, 1, first);
    vec![
        claim(
            Place::Contribution(2),
            "A global framework of optimal designs, response surfaces and hypothesis tests",
            COST_LOWER,
            end(Reading::Cost, 1.0),
        ),
        claim(
            Place::Contribution(6),
            "4 parameters: infusion gives a better system than the numerical model alone",
            COST_LOWER,
            end(Reading::Cost, 1.0),
        ),
        claim(
            section("7.2.4"),
            "4 parameters: the space is reduced significantly over five iterations",
            "at most half of it is left",
            path(|_, path| path.last().is_some_and(|row| row.share <= MUCH)),
        ),
        claim(
            section("5.5"),
            "4 parameters: the z-test at 90 % keeps what may be the optimum",
            KEPT_OF_FOUR,
            Test::Kept,
        ),
        claim(Place::Table(6), "4 parameters: the design space shrinks at every iteration", SHRINKS, path(shrinks)),
        claim(Place::Table(6), "4 parameters: infusion moves the center of mass aft", AFT, Test::End(Box::new(aft))),
        claim(
            Place::Table(6),
            "4 parameters: the numerical optimum is row 0",
            REACHED,
            Test::Plant(Box::new(move |case| case.numerical().map(&is_first))),
        )
        .still(),
        claim(
            Place::Table(6),
            "4 parameters: the loop ends at the last printed row",
            REACHED,
            Test::End(Box::new(move |_, after| is_near(after))),
        )
        .of_a_place(),
    ]
}

/// Of what the last design of a campaign with four parameters shows in its flights.
fn figures_of_four() -> Vec<Claim> {
    let claim = |place, says, rule, test| Claim::new(place, says, Study::Four, rule, test);
    let end = |reading, factor| Test::End(lower(reading, factor));
    let better = "lower than at the model's optimum";
    vec![
        Claim {
            by_cameras: true,
            ..claim(
                section("7.2.4"),
                "4 parameters: at the numerical optimum dots leave the view for moments, at the infused one they do not",
                "where the pose is held at times at the model's optimum, less than half as often at a last design; not judged where it \
                 never is",
                Test::Plant(Box::new(|case| {
                    let end = case.ends(JUDGED).first()?.of(Reading::Held);
                    let before = case.numerical()?.of(Reading::Held);
                    (before > 0.0 && end.is_finite()).then_some(end < MUCH * before)
                })),
            )
        },
        claim(
            Place::Figure(26),
            "4 parameters: the heading is significantly improved",
            HALVED,
            end(Reading::Heading, MUCH),
        ),
        claim(
            Place::Figure(27),
            "4 parameters: the roll offset is greatly reduced",
            HALVED,
            end(Reading::RollOffset, MUCH),
        ),
        claim(Place::Figure(27), "4 parameters: the zenith angle is slightly lower", better, end(Reading::Zenith, 1.0)),
        claim(Place::Figure(28), "4 parameters: altitude tracking improves", better, end(Reading::Altitude, 1.0)),
        claim(Place::Figure(28), "4 parameters: pitch tracking improves", better, end(Reading::Pitch, 1.0)),
    ]
}

/// Of Chapter 6, on the campaigns of Chapter 7.
fn of_convergence() -> Vec<Claim> {
    let claim = |place, says, rule, test| Claim::new(place, says, Study::Four, rule, test);
    vec![
        claim(
            Place::Figure(20),
            "The design space shrinks monotonically, and much",
            "each of five iterations of Chapter 7 drops cells, and at most half is left",
            Test::Path(Box::new(|case, path| shrinks(case, path) && path.last().is_some_and(|row| row.share <= MUCH))),
        ),
        claim(
            Place::Figure(22),
            "The heading is significantly better at the last optimum than at the first",
            "at most half of that after the first iteration of Chapter 7",
            Test::SinceFirst(lower(Reading::Heading, MUCH)),
        ),
        claim(
            section("6.2.2"),
            "The footprint on the ground is slightly reduced",
            "lower than after the first iteration of Chapter 7",
            Test::SinceFirst(lower(Reading::Footprint, 1.0)),
        ),
    ]
}

/// The method whose campaigns are judged.
pub(super) const JUDGED: Method = Method::Dissertation;
