//! What Chapter 4 of the dissertation says, and whether it holds here.

use super::findings::Findings;
use super::rows::{ERRORS, Row};
use super::seeds::falls_pct;
use crate::bat::STAND_IN;
use crate::blind::Blind;
use crate::claims::{Claim, Place, Verdict};
use crate::logged::Logged;
use crate::rules::{Count, Judged, Standing};
use page::Summary;

/// What a claim says first when there was nothing to find at either end.
const FITTED: &str = "Both ends of the path and their costs were calibrated; that the loop goes from the one towards the other is what came out.";

/// How a design flies in the stand-in.
struct Design {
    point: Vec<f64>,
    cost: f64,
    /// Mean squares of [`ERRORS`], in deg².
    errors: [f64; ERRORS.len()],
}

impl Design {
    fn of(row: &Row) -> Self {
        let errors = ERRORS.map(|(.., error)| row.mean_squared_deg2(error));
        Self { point: row.point.to_vec(), cost: row.cost(), errors }
    }
}

/// What designs show that nobody chose.
fn blind(findings: &Findings<'_>) -> Blind<Design> {
    let setup = findings.material.setup;
    let read = |point: &[f64], logged: Logged| {
        let errors = ERRORS.map(|(.., error)| logged.mean(|row| error(row).to_degrees().powi(2)));
        Design { point: point.to_vec(), cost: logged.cost.total, errors }
    };
    Blind::read(setup.problem.region(), |points| setup.bat.read_logged(points, STAND_IN, read))
}

/// Point and cost of the first and the last design of each campaign: that without noise, then seed by seed.
fn ends(findings: &Findings<'_>) -> Vec<[(Vec<f64>, f64); 2]> {
    let rows = findings.printed();
    let quiet = [rows.first(), rows.last()].map(|row| (row.point.to_vec(), row.cost()));
    let seeded = findings.material.seeded.first().into_iter().flat_map(|seeded| &seeded.campaigns);
    let noisy = seeded.filter_map(|(_, campaign)| {
        let end = |report: &infuse::gradient::Report| {
            let point = report.numerical.point.clone();
            let cost = findings.material.setup.bat.cost(&point, STAND_IN).unwrap_or(f64::NAN);
            (point, cost)
        };
        Some([end(campaign.reports.first()?), end(campaign.reports.last()?)])
    });
    std::iter::once(quiet).chain(noisy).collect()
}

/// What the dissertation claims in this chapter, and what of it came out.
pub(crate) fn claims(findings: &Findings<'_>) -> Vec<Claim> {
    let (blind, start) = (blind(findings), Design::of(findings.printed().first()));
    let mut claims = of_the_path(findings, &blind, &start);
    claims.push(test_profile());
    claims.extend(of_the_errors(findings, &blind, &start));
    claims
}

/// That the loop goes from one end of the path to the other, and what it costs there.
fn of_the_path(findings: &Findings<'_>, blind: &Blind<Design>, start: &Design) -> Vec<Claim> {
    let published = findings.published();
    let direction = |k: usize| published[published.len() - 1].point()[k] - published[0].point()[k];
    let moves = |from: &[f64], to: &[f64]| (0..2).all(|k| direction(k) * (to[k] - from[k]) > 0.0);
    let ends = ends(findings);
    let cheaper = Judged::of(Count::of(ends.iter().map(|[(_, from), (_, to)]| to < from)), Standing::FittedEnds)
        .beside(blind.share(|one| one.cost < start.cost));
    let moved = Count::of(ends.iter().map(|[from, to]| to.1 < from.1 && moves(&from.0, &to.0)));
    let moved = Judged::of(moved, Standing::FittedEnds)
        .beside(blind.share(|one| one.cost < start.cost && moves(&start.point, &one.point)));
    let (fall, short) = (fall(findings), fall_in_short(findings));
    vec![
        Claim::new(
            Place::Contribution(1),
            "An iterative co-design framework that fuses experiments and simulations by gradients",
            cheaper,
            format!("`infuse::gradient::Loop` with the sign of (27) repaired. {FITTED} {fall}"),
        )
        .in_short(&*short),
        Claim::new(
            Place::Contribution(5),
            "It is validated on two parameters in the water channel",
            cheaper,
            format!("Against a stand-in, not in water. {FITTED} {fall}"),
        )
        .in_short(&*short),
        optimum_moves(findings, moved, &fall),
    ]
}

/// How the cost falls, beside the dissertation and over the seeds.
fn fall(findings: &Findings<'_>) -> String {
    let (rows, theirs) = (findings.printed(), findings.published_fall_pct());
    let seeds = findings
        .material
        .seeded
        .first()
        .and_then(|seeded| Summary::of(&falls_pct(findings.material.setup, seeded)))
        .map_or_else(String::new, |s| {
            format!(" Over {} noise seeds: median {:.1} %, worst {:.1} %.", s.count, s.median, s.minimum)
        });
    format!(
        "The experimental cost falls by {:.1} %, in the dissertation by {theirs:.1} %, with {} experiments each.{seeds}",
        rows.fall_pct(),
        rows.n_experiments(),
    )
}

fn fall_in_short(findings: &Findings<'_>) -> String {
    let (ours, theirs) = (findings.printed().fall_pct(), findings.published_fall_pct());
    format!("the experimental cost falls by {ours:.1} %, in the dissertation by {theirs:.1} %")
}

fn optimum_moves(findings: &Findings<'_>, judged: Judged, fall: &str) -> Claim {
    let (rows, published) = (findings.printed(), findings.published());
    let (last, printed) = (rows.last(), &published[published.len() - 1]);
    Claim::new(
        Place::Table(3),
        "In three iterations the optimum moves aft and to a higher pitch, and the experimental cost falls",
        judged,
        format!(
            "{FITTED} Last row: {}, in the dissertation {} and {}. {fall}",
            findings.material.setup.sentence(&last.point),
            printed.center_of_mass,
            printed.pitch_set_point
        ),
    )
    .in_short(format!(
        "to {:.2} % chord and {:.2} deg, {:.1} % less; in the dissertation {} and {}, {:.1} % less",
        last.point[0],
        last.point[1],
        rows.fall_pct(),
        printed.center_of_mass,
        printed.pitch_set_point,
        findings.published_fall_pct()
    ))
    .shown_in(&["landscape-stand-in"])
}

fn test_profile() -> Claim {
    Claim::given(
        Place::Figure(15),
        "The test: three speeds, three pulls at the port line",
        Verdict::TakenOver,
        "As printed in Section 3.2 and (22)-(26).".to_owned(),
    )
    .shown_in(&["figure-15-test-profile"])
}

/// That what the controller misses is smaller at the end, quantity by quantity.
fn of_the_errors(findings: &Findings<'_>, blind: &Blind<Design>, start: &Design) -> Vec<Claim> {
    let end = Design::of(findings.printed().last());
    let claim = |(k, (what, number, _)): (usize, &(&str, u32, _))| {
        let (before, after) = (start.errors[k], end.errors[k]);
        Claim::new(
            Place::Figure(*number as u8),
            &format!("The {what} error squared is smaller after infusion"),
            Judged::of(Count::one(after < before), Standing::FittedEnds)
                .beside(blind.share(|one| one.errors[k] < before)),
            format!("Its mean is {before:.2} deg² before and {after:.2} deg² after, without noise."),
        )
        .in_short(format!("mean {before:.2} → {after:.2} deg²"))
        .shown_in(&[&format!("figure-{number}-{what}")])
    };
    ERRORS.iter().enumerate().map(claim).collect()
}
