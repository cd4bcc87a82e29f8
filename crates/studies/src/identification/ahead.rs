//! Designs that a campaign is going to ask the model for, flown before it asks.
//!
//! A search asks for one design after the other, and a flight alone takes nearly four times as long as one of four side by side. What
//! a campaign asked for when it was run before it asks for again, unless something has changed; so all of that is flown at
//! once. It is a guess: every cost is flown in the run that uses it, and what nobody foresaw is flown when it is asked for.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context as _, Result};
use infuse::gradient::UncertainModel;
use infuse::identification::Answer;

use super::file::Study;
use super::plant::Doubted;
use crate::costs::Cost;
use crate::kept;

/// The model of a campaign, which knows what will be asked of it.
pub(super) struct Ahead<'a> {
    model: Doubted<'a>,
    /// The designs, for one vector of unknowns after the other.
    foreseen: Vec<Vec<Vec<f64>>>,
    asked: Vec<Asked>,
    n_missed: usize,
}

/// What was asked for with the same unknowns.
struct Asked {
    unknowns: Vec<f64>,
    designs: Vec<Vec<f64>>,
    /// By the bits of a design.
    costs: HashMap<Vec<u64>, Cost>,
}

fn bits(design: &[f64]) -> Vec<u64> {
    design.iter().map(|x| x.to_bits()).collect()
}

impl<'a> Ahead<'a> {
    /// With the designs that a file lists; none where there is no file.
    pub(super) fn read(study: &'a Study, path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let mut foreseen: Vec<Vec<Vec<f64>>> = Vec::new();
        for (number, design) in text.lines().filter_map(read_line) {
            foreseen.resize(foreseen.len().max(number + 1), Vec::new());
            foreseen[number].push(design);
        }
        Self { model: Doubted(study), foreseen, asked: Vec::new(), n_missed: 0 }
    }

    /// Lists what was asked for.
    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let lines = self.asked.iter().enumerate().flat_map(|(number, asked)| {
            asked.designs.iter().map(move |design| {
                let numbers: String = design.iter().map(|x| format!(" {x}")).collect();
                format!("{number}{numbers}\n")
            })
        });
        kept::replace(path, lines.collect::<String>().as_bytes()).with_context(|| path.display().to_string())
    }

    /// How many designs were flown alone, and how many there were.
    pub(super) fn n_missed(&self) -> (usize, usize) {
        (self.n_missed, self.asked.iter().map(|asked| asked.designs.len()).sum())
    }

    /// What is known with these unknowns; with new ones all that is foreseen of them is flown.
    fn with(&mut self, unknowns: &[f64]) -> usize {
        let known = self.asked.iter().position(|asked| asked.unknowns == unknowns);
        known.unwrap_or_else(|| {
            let designs = self.foreseen.get(self.asked.len()).map_or(&[][..], Vec::as_slice);
            let costs = self.model.costs(unknowns, designs);
            let costs = designs.iter().map(|design| bits(design)).zip(costs).collect();
            self.asked.push(Asked { unknowns: unknowns.to_vec(), designs: Vec::new(), costs });
            self.asked.len() - 1
        })
    }
}

/// The number of the unknowns and a design.
fn read_line(line: &str) -> Option<(usize, Vec<f64>)> {
    // No campaign has more turns than this; a line that makes no sense foresees nothing.
    const MOST_TURNS: usize = 1000;
    let (number, design) = line.split_once(' ')?;
    let number = number.parse().ok().filter(|number| *number < MOST_TURNS)?;
    let design = design.split(' ').map(|x| x.parse().ok()).collect::<Option<Vec<f64>>>()?;
    Some((number, design))
}

impl UncertainModel for Ahead<'_> {
    fn cost(&mut self, unknowns: &[f64], design: &[f64]) -> Cost {
        let number = self.with(unknowns);
        let Self { model, asked, n_missed, .. } = self;
        let Asked { designs, costs, .. } = &mut asked[number];
        if !designs.iter().any(|known| bits(known) == bits(design)) {
            designs.push(design.to_vec());
        }
        let fly = || {
            *n_missed += 1;
            model.cost(unknowns, design)
        };
        costs.entry(bits(design)).or_insert_with(fly).clone()
    }

    fn responses(&mut self, unknowns: &[Vec<f64>], designs: &[Vec<f64>]) -> Vec<Vec<Answer>> {
        self.model.responses(unknowns, designs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_the_same_whatever_was_foreseen() {
        let study = Study::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).expect("a study");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("asked.txt");
        let mut other = study.unknowns.start().to_vec();
        other[0] *= 1.1;
        // The second has a center of mass at which nothing flies.
        let designs = [[48.0, 12.0], [90.0, 12.0], [49.0, 0.1 + 0.2], [48.0, 12.0]];
        let ask = |model: &mut Ahead<'_>| -> Vec<Cost> {
            let both = [study.unknowns.start(), &other];
            both.iter().flat_map(|unknowns| designs.map(|design| model.cost(unknowns, &design))).collect()
        };
        let mut alone = Ahead::read(&study, &path);
        let costs = ask(&mut alone);
        assert_eq!(alone.n_missed(), (6, 6), "nothing was foreseen");
        assert!(costs[0].is_ok() && costs[1].is_err() && costs[0] != costs[4], "{costs:?}");
        alone.write(&path).expect("written");
        let mut ahead = Ahead::read(&study, &path);
        assert_eq!(ask(&mut ahead), costs);
        assert_eq!(ahead.n_missed(), (0, 6), "all was foreseen");
        std::fs::write(&path, "0 48 12.5\n1 nonsense\n1 48\n\n99999999999 48 12\n1 48 12\n").expect("written");
        let mut wrong = Ahead::read(&study, &path);
        assert_eq!(ask(&mut wrong), costs);
        assert_eq!(wrong.n_missed(), (5, 6), "one was foreseen");
    }
}
