//! Three scale models, as their experimenter would write them down: are they similar, and if not, what would help?

use std::error::Error;

use scaling::{SetUp, Similarity, System, Units};

#[expect(clippy::print_stdout, reason = "an example shows what it computes")]
fn main() -> Result<(), Box<dyn Error>> {
    let units = Units::si();
    let system = System::parse(
        &units,
        &[("L_t", "m"), ("L_c", "m"), ("M_a", "kg"), ("rho", "kg*m^-3"), ("V", "m/s"), ("g", "m/s^2")],
    )?;

    println!("{} variables, rank {}: {} groups", system.variables().len(), system.rank(), system.n_groups());
    let groups = system.groups(&["L_t", "M_a", "V"])?;
    for group in &groups {
        println!("  {group}");
    }
    println!("repeating sets that would do as well: {}", system.repeating_sets().count() - 1);

    // Chord and tether in cm, mass in g, speed in cm/s, each known to half a unit of its last digit.
    let models = [
        ("model 1", "5.625", "45.7", "135", "26"),
        ("model 2", "7.5", "61", "180", "30"),
        ("model 3", "9.375", "76", "225", "33.5"),
    ];
    let mut set_ups = Vec::new();
    for (name, chord, tether, mass, speed) in models {
        let set_up = SetUp::new(name)
            .printed(&units, "L_c", chord, "cm")?
            .printed(&units, "L_t", tether, "cm")?
            .printed(&units, "M_a", mass, "g")?
            .printed(&units, "V", speed, "cm/s")?
            .with("rho", 1000.0)
            .with("g", 9.81);
        set_ups.push(set_up);
    }

    let check = Similarity::check(&groups, &set_ups, 0.005)?;
    println!("\n{check}");
    for row in check.mismatches() {
        println!("{} does not match; to match model 2:", row.group);
    }
    print!("{}", check.remedy("M_a", 1)?);

    // With the chord as the length of the mass group.
    let by_chord = system.groups(&["L_c", "M_a", "V"])?;
    println!("\nby the chord:");
    print!("{}", Similarity::check(&by_chord, &set_ups, 0.005)?.remedy("M_a", 1)?);

    println!("\nfrom the 1/100 model in water to the full scale in air:");
    print!("{}", system.law(&[("L_t", "100"), ("rho", "1.225/1000"), ("g", "1")])?);
    Ok(())
}
