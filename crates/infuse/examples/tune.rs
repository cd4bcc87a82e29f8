//! Development only.
#![allow(warnings)]
#[path = "../../studies/src/benchmark/families.rs"]
mod families;
use design_space::*;
use infuse::pooled::*;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let names: Vec<&str> = args[1].split(',').collect();
    let seeds: u64 = args[2].parse().unwrap();
    let first: u64 = args.get(3).map_or(1, |s| s.parse().unwrap());
    let nosim = args.get(4).is_some_and(|s| s.contains("nosim"));
    for family in families::FAMILIES.iter().filter(|f| names.contains(&f.name) || names[0] == "all") {
        let n_batch = match family.n_factors { 2 => 12, 3 => 14, 4 => 18, _ => 24 };
        let mut rows: Vec<Vec<[f64; 5]>> = vec![vec![]; 5];
        let start = Instant::now();
        let (mut t_ask, mut t_assess) = (0.0, 0.0);
        for seed in first..first + seeds {
            let pair = family.pair(seed);
            let k = family.n_factors;
            let region = Region::new((0..k).map(|j| Parameter::continuous(format!("u{j}"), "1", 0.0, 1.0).unwrap().with_levels(24).unwrap()).collect()).unwrap();
            let grid = Grid::of(&region).unwrap();
            let best = best_of(&grid, &*pair.truth);
            let mut settings = Settings::new(n_batch);
            settings.seed = seed;
            settings.max_batches = 5;
            if let Ok(mask) = std::env::var("STRUCT") {
                // Digits: simulation (i, s, c) and residual (n, s, r), as "in,is".
                let parse = |word: &str| surface::process::Structure {
                    simulation: match &word[..1] { "i" => surface::process::SimulationUse::Ignored, "s" => surface::process::SimulationUse::Subtracted, _ => surface::process::SimulationUse::Scaled },
                    residual: match &word[1..] { "n" => surface::process::Residual::None, "s" => surface::process::Residual::Smooth, _ => surface::process::Residual::Rough },
                };
                settings.structures = mask.split(',').map(parse).collect();
            }
            if let Ok(n) = std::env::var("PARTICLES") { settings.particles = n.parse().unwrap(); }
            if let Ok(n) = std::env::var("DEAR") { settings.simulations = Some(n.parse().unwrap()); }
            if let Ok(n) = std::env::var("NOISE") { settings.noise = Some(n.parse().unwrap()); }
            if let Some(p) = args.get(4) { if let Ok(p) = p.parse() { settings.particles = p } }
            let mut campaign = Loop::new(&region, settings).unwrap();
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed + 1000);
            let mut simulate = |_: Cell, u: &[f64]| Ok((pair.simulation)(u));
            for batch in 0..5 {
                let t = Instant::now();
                let sim: Option<&mut (dyn FnMut(Cell, &[f64]) -> Result<f64, String>)> = if nosim { None } else { Some(&mut simulate) };
                let Ask::Run { trials, simulations } = campaign.ask(sim).unwrap() else { panic!() };
                let trials = if trials.is_empty() {
                    for cell in simulations { let s = (pair.simulation)(&grid.point(cell).unwrap()); campaign.tell_simulation(cell, &infuse::Outcome::Value(s)).unwrap(); }
                    let Ask::Run { trials, simulations } = campaign.ask(None).unwrap() else { panic!() };
                    for cell in simulations { let s = (pair.simulation)(&grid.point(cell).unwrap()); campaign.tell_simulation(cell, &infuse::Outcome::Value(s)).unwrap(); }
                    trials
                } else {
                    for cell in simulations { let s = (pair.simulation)(&grid.point(cell).unwrap()); campaign.tell_simulation(cell, &infuse::Outcome::Value(s)).unwrap(); }
                    trials };
                t_ask += t.elapsed().as_secs_f64();
                for trial in trials {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    let y = (pair.truth)(&trial.point) + pair.noise * z;
                    campaign.tell(trial.id, infuse::Outcome::Value(y)).unwrap();
                }
                let t = Instant::now();
                let sim: Option<&mut (dyn FnMut(Cell, &[f64]) -> Result<f64, String>)> = if nosim { None } else { Some(&mut simulate) };
                let a = campaign.assess(sim).unwrap().unwrap();
                t_assess += t.elapsed().as_secs_f64();
                let regret = (pair.truth)(&a.recommended.point) - best;
                if let Ok(path) = std::env::var("RAW") {
                    use std::io::Write;
                    let mut file = std::fs::OpenOptions::new().create(true).append(true).open(path).unwrap();
                    writeln!(file, "{},{seed},{},{regret},{},{},{},{},{}", family.name, batch + 1, a.certificate.bound / 1.5, a.certificate.quantile, a.certificate.band, a.left, a.recommended.deviation).unwrap();
                }
                rows[batch].push([regret, a.certificate.bound, a.certificate.quantile, a.certificate.band, a.noise]);
            }
        }
        print!("{:14}", family.name);
        let n = seeds as usize;
        for rows in &rows {
            let mut r: Vec<f64> = rows.iter().map(|r| r[0]).collect();
            r.sort_by(f64::total_cmp);
            print!(" {:.3}/{:.3}", r[n / 2], r[((n as f64 * 0.9) as usize).min(n - 1)]);
        }
        let med = |b: usize, i: usize| { let mut r: Vec<f64> = rows[b].iter().map(|r| r[i]).collect(); r.sort_by(f64::total_cmp); r[n / 2] };
        let breach = |b: usize, i: usize| rows[b].iter().filter(|r| r[0] > r[i] + 1e-12).count();
        print!(" | q");
        for b in 0..5 { print!(" {:.3}:{}", med(b, 2), breach(b, 2)); }
        print!(" | b");
        for b in 0..5 { print!(" {:.3}:{}", med(b, 1), breach(b, 1)); }
        println!(" noise {:.3} ask {:.2} assess {:.2} s", med(4, 4), t_ask / (5.0 * n as f64), t_assess / (5.0 * n as f64));
    }
}

fn best_of(grid: &Grid, f: &dyn Fn(&[f64]) -> f64) -> f64 {
    if grid.n_cells() < 400_000 {
        return grid.cells().map(|c| f(&grid.point(c).unwrap())).fold(f64::INFINITY, f64::min);
    }
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut best = f64::INFINITY;
    let mut v: Vec<(f64, Cell)> = (0..20000).map(|_| { let c = Cell::new(rng.random_range(0..grid.n_cells())); (f(&grid.point(c).unwrap()), c) }).collect();
    v.sort_by(|a, b| a.0.total_cmp(&b.0));
    for &(mut value, mut cell) in &v[..50] {
        loop {
            let next = grid.neighbours(cell).unwrap().into_iter().map(|c| (f(&grid.point(c).unwrap()), c)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            if next.0 < value { (value, cell) = next } else { break }
        }
        best = best.min(value);
    }
    best
}
