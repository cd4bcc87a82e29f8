//! From the point an optimizer wants to the settings a rig has.

use std::error::Error;
use std::io::{Write as _, stdout};

use design_space::{Grid, Parameter, Region};

fn main() -> Result<(), Box<dyn Error>> {
    // Ballast holes every half per cent of chord from 45.65 %, pitch stops every half degree.
    let region = Region::new(vec![
        Parameter::continuous("center of mass", "% chord", 45.65, 51.15)?.with_levels(12)?,
        Parameter::continuous("pitch", "deg", 10.0, 22.0)?.with_levels(25)?,
    ])?;

    let asked = [47.13, 17.3];
    let possible = region.snap(&asked)?;
    let coded = region.coded(&possible)?;
    let hole = region.parameters()[0].nearest_level(asked[0])?;
    let stop = region.parameters()[1].nearest_level(asked[1])?;

    writeln!(stdout(), "asked     {:.3} % chord   {:.2} deg", asked[0], asked[1])?;
    writeln!(stdout(), "rig can   {:.3} % chord   {:.2} deg (hole {hole}, stop {stop})", possible[0], possible[1])?;
    writeln!(stdout(), "coded     {:.3}           {:.3}", coded[0], coded[1])?;
    writeln!(stdout(), "the grid of the rig has {} points", Grid::of(&region)?.n_cells())?;

    if let Err(error) = region.snap(&[47.13, 23.5]) {
        writeln!(stdout(), "23.5 deg? {error}")?;
    }
    Ok(())
}
