//! G-optimal designs on the 331,776 points of 24 levels in each of four factors, as a grid and as a list: eight searches of a quarter of a
//! second, or of as many seconds as the argument says.

use std::error::Error;
use std::io::{Write as _, stdout};
use std::time::Duration;

use doe::{Criterion, Model, Problem, Settings, Space, search};

fn main() -> Result<(), Box<dyn Error>> {
    let seconds = std::env::args().nth(1).map_or(Ok(0.25), |text| text.parse())?;
    let mut settings = Settings::default();
    settings.starts = u64::MAX;
    settings.time_limit = Some(Duration::try_from_secs_f64(seconds)?);

    let level = |i: usize| (2.0 * i as f64 - 23.0) / 23.0;
    let cells: Vec<f64> =
        (0..24_usize.pow(4)).flat_map(|cell| [1, 24, 576, 13_824].map(|stride| level(cell / stride % 24))).collect();
    for space in [Space::grid(&[24; 4])?, Space::list(4, cells)?] {
        for n_runs in [18, 36] {
            for (name, model) in [("quadratic", Model::quadratic(4)?), ("additive", Model::additive_quadratic(4)?)] {
                let problem = Problem::new(model, space.clone(), n_runs, Criterion::G)?;
                let found = search(&problem, &settings)?;
                let (report, efficiency) = (&found.report, &found.efficiency);
                writeln!(
                    stdout(),
                    "{n_runs} runs, {name}: {efficiency}; {} starts, {:.2?}",
                    report.starts,
                    report.elapsed
                )?;
            }
        }
    }
    Ok(())
}
