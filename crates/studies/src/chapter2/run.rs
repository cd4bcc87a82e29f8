//! The order of things in Chapter 2.

use super::file::Setup;
use super::findings::Findings;
use super::full_scale::FullScale;
use super::models::{self, Case, Releases};
use super::{claims, figures, page, tables};
use crate::handover::Handover;
use crate::reproduction::{self, Extent, Picture, Reproduction, Run, progress};
use ::page::{Column, write_columns_csv};
use anyhow::Result;
use rayon::prelude::*;
use scaling::{Remedies, Similarity};
use std::path::Path;
use std::time::Instant;

/// The study, and the committed copy of its results.
pub(crate) const CHAPTER: Reproduction = Reproduction {
    command: "reproduce-chapter2",
    name: "chapter2",
    title: "Chapter 2",
    has_claims: true,
    run: Run::Always(reproduce),
};

pub(crate) fn reproduce(root: &Path) -> Result<()> {
    let started = Instant::now();
    let setup = Setup::read(&root.join("fixtures/bat/chapter2.toml"))?;
    let out = CHAPTER.prepare(root, Extent::Default)?;
    eprintln!("{}: the stand-in for the water channel is a richer model, not an experiment.", setup.file.title);

    let bar = progress("groups, releases, full scale, pictures", 4);
    let similarity = Similarity::check(&setup.plant.groups, &setup.set_ups, setup.tolerance)?;
    let remedies = remedies(&setup, &similarity)?;
    bar.inc(1);
    let releases = Case::FLOWN.iter().map(|case| Releases::fly(&setup, *case)).collect::<Result<Vec<_>>>()?;
    let models = setup.file.model.iter();
    let in_similar_hulls = models.map(|model| models::in_a_similar_hull(&setup, model)).collect::<Result<Vec<_>>>()?;
    bar.inc(1);
    let full_scale = FullScale::of(&setup)?;
    bar.inc(1);
    let findings = Findings {
        setup: &setup,
        similarity,
        remedies,
        releases,
        in_similar_hulls,
        full_scale,
        seconds: started.elapsed().as_secs_f64(),
    };
    let shown: Vec<&Releases> = findings.releases.iter().filter(|releases| releases.case != Case::Rounded).collect();
    let pictures: Vec<Picture> = shown.par_iter().flat_map_iter(|releases| figures::of(&setup, releases)).collect();
    bar.inc(1);
    bar.finish();

    let claims = claims::claims(&findings)?;
    let first = page::first_screen(&findings, &pictures)?;
    let page = page::page(&findings, &claims, &pictures, &first)?;
    let results = page::markdown(&findings, &claims, &first.markdown(&CHAPTER.kept_picture()))?;
    reproduction::save_page(&out, &pictures, &page, &results, first.picture)?;
    Handover::new(claims, &pictures).save(&out)?;
    findings.full_scale.save(&setup, &out)?;
    tables::full_scale(&findings).write_csv(&out.join("full-scale.csv"))?;
    tables::laws(&findings)?.write_csv(&out.join("laws.csv"))?;
    for (number, releases) in findings.releases.iter().enumerate() {
        releases_csv(releases, &out.join(format!("releases-{}.csv", number + 1)))?;
    }
    page::print(&findings, &CHAPTER.out());
    Ok(())
}

/// What mass would match, by the printed tether length and by the chord.
pub(crate) fn remedies(setup: &Setup, by_tether: &Similarity) -> Result<[Remedies; 2]> {
    let groups = setup.plant.system.groups(&["L_c", "M_a", "V"])?;
    let by_chord = Similarity::check(&groups, &setup.set_ups, setup.tolerance)?;
    Ok([by_tether.remedy("M_a", setup.reference)?, by_chord.remedy("M_a", setup.reference)?])
}

/// The curves of all models of one case, one below the other.
pub(crate) fn releases_csv(releases: &Releases, path: &Path) -> Result<()> {
    let mut columns: [Vec<f64>; 6] = Default::default();
    for (number, release) in releases.models.iter().enumerate() {
        columns[0].extend(std::iter::repeat_n(number as f64 + 1.0, release.time_s.len()));
        columns[1].extend(&release.time_s);
        columns[2].extend(release.normalized_time());
        columns[3].extend(&release.heading_rad);
        columns[4].extend(&release.lateral_m);
        columns[5].extend(release.normalized_lateral());
    }
    let heads = [
        ("model", "1"),
        ("time", "s"),
        ("normalized time", "s"),
        ("heading", "rad"),
        ("lateral position", "m"),
        ("lateral position over L_t", "1"),
    ];
    let columns: Vec<(Column, &[f64])> =
        heads.iter().zip(&columns).map(|((name, unit), values)| (Column::new(name, unit), values.as_slice())).collect();
    Ok(write_columns_csv(path, &columns)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup() -> Setup {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        Setup::read(&root.join("fixtures/bat/chapter2.toml")).expect("the study file")
    }

    /// Check 34, and the rig's files there and back.
    #[test]
    fn flight_at_full_scale_is_that_of_the_laboratory_in_dimensionless_form() {
        let full = FullScale::of(&setup()).expect("both scales fly");
        assert_eq!(full.changed_on_return, 0, "of {} numbers", full.n_numbers);
        assert!(full.n_numbers > 90, "all three files were converted: {}", full.n_numbers);
        for flight in &full.flights {
            assert!(flight.largest_difference < 1e-9, "{flight:?}");
            assert!(flight.cost_difference < 1e-9, "{flight:?}");
            assert!((flight.duration_s[1] / flight.duration_s[0] - 10.0).abs() < 1e-12, "{flight:?}");
        }
    }

    /// Checks 34 and 35: similar models collapse, the printed masses do not.
    #[test]
    fn similar_models_collapse_and_the_printed_masses_do_not() {
        let setup = setup();
        let similar = Releases::fly(&setup, Case::Similar).expect("flies").apart_when_normalized();
        assert!(similar.heading < 1e-10 && similar.lateral < 1e-10, "{similar:?}");
        let printed = Releases::fly(&setup, Case::PrintedMasses).expect("flies").apart_when_normalized();
        assert!(printed.heading > 0.05 && printed.lateral > 0.05, "{printed:?}");
        let apart = Releases::fly(&setup, Case::Similar).expect("flies").apart();
        assert!(apart.heading > 0.05, "against time they differ: {apart:?}");
    }

    /// The period by the modes is that by the zeros of the heading, half a period apart each, in every case.
    #[test]
    fn period_is_that_of_the_zeros_of_the_heading() {
        let setup = setup();
        for case in Case::FLOWN {
            for release in Releases::fly(&setup, case).expect("flies").models {
                let zeros: Vec<f64> = (1..release.time_s.len())
                    .filter(|k| (release.heading_rad[*k] > 0.0) != (release.heading_rad[k - 1] > 0.0))
                    .map(|k| release.time_s[k])
                    .collect();
                assert!(zeros.len() >= 4, "{case:?}, {}: {zeros:?}", release.model);
                let period_s = zeros[3] - zeros[1];
                assert!((release.period_s / period_s - 1.0).abs() < 0.03, "{case:?}, {}: {period_s}", release.model);
            }
        }
    }

    #[test]
    fn table_2_has_one_mismatch_and_the_masses_that_repair_it() {
        let setup = setup();
        let similarity = Similarity::check(&setup.plant.groups, &setup.set_ups, setup.tolerance).expect("a check");
        let mismatches: Vec<String> = similarity.mismatches().map(|row| row.group.to_string()).collect();
        assert_eq!(mismatches, ["L_t^3*rho/M_a"]);
        for (remedies, grams) in
            remedies(&setup, &similarity).expect("remedies").iter().zip([[75.7, 180.0, 348.1], [75.9, 180.0, 351.6]])
        {
            for (remedy, grams) in remedies.values.iter().zip(grams) {
                assert!((1000.0 * remedy.required - grams).abs() < 0.051, "{remedy:?}: {grams} g");
            }
        }
    }

    #[test]
    fn computed_groups_and_listed_groups_say_the_same() {
        let setup = setup();
        for (analysis, count) in [(&setup.plant, 11), (&setup.normalized_time, 12), (&setup.controller, 8)] {
            assert_eq!((analysis.groups.len(), analysis.listed.len()), (count, count), "groups");
            assert!(analysis.groups.span_same_space(&analysis.listed), "{:?}", analysis.listed);
            assert!(!analysis.groups.span_same_space(&analysis.listed[1..]), "one less is not enough");
        }
    }
}
