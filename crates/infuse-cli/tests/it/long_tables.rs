//! A long table of simulations is read once; what was kept of it is never taken for what it is not.

use serde_json::Value;

use crate::rig::Rig;

const INDEX: &str = ".infuse-index";

/// A campaign with results whose table is long by a remark.
fn rig() -> Rig {
    let rig = Rig::pooled();
    rig.write("simulation.csv", &format!("# {}\n{}", "x".repeat(1 << 20), rig.read("simulation.csv")));
    rig.batch();
    rig
}

fn n_rows(rig: &Rig) -> Value {
    let said: Value = serde_json::from_str(&rig.infuse(&["check", "--json"]).ok()).unwrap();
    said["simulation"]["rows"].clone()
}

#[test]
fn a_long_table_gives_what_a_short_one_gives() {
    let (long, short) = (rig(), Rig::pooled());
    short.batch();
    assert!(long.path(INDEX).exists(), "a long table is indexed");
    assert!(!short.path(INDEX).exists(), "a short one is read as fast");
    assert_eq!(long.infuse(&["status"]).ok(), short.infuse(&["status"]).ok());
    let _ = (long.batch(), short.batch());
    assert_eq!(long.read("sheet-2.csv"), short.read("sheet-2.csv"), "the same designs next");
    std::fs::remove_file(long.path(INDEX)).unwrap();
    assert_eq!(long.infuse(&["status"]).ok(), short.infuse(&["status"]).ok(), "it can be removed");
}

#[test]
fn an_index_of_another_table_or_of_other_parameters_is_not_taken() {
    let rig = rig();
    let before = n_rows(&rig);
    let table = rig.read("simulation.csv");
    let (rest, _) = table.trim_end().rsplit_once('\n').unwrap();
    rig.write("simulation.csv", rest);
    assert_eq!(n_rows(&rig).as_u64(), before.as_u64().map(|n| n - 1), "a row was removed");
    // The same number of characters, and another number in one of them.
    let index = std::fs::read(rig.path(INDEX)).unwrap();
    rig.write("simulation.csv", &rest.replacen("12.8889", "12.8888", 1));
    rig.infuse(&["status"]).ok();
    assert_ne!(std::fs::read(rig.path(INDEX)).unwrap(), index);
    let fresh = Rig::pooled();
    fresh.write("simulation.csv", &table);
    fresh.infuse(&["check"]).ok();
    fresh.edit("upper = 34\n", "upper = 32\n");
    assert!(fresh.infuse(&["check"]).error().contains("column `spring [N/mm]`: is `34`"), "34 is above it now");
}

#[test]
fn a_broken_index_is_written_again() {
    let rig = rig();
    let (whole, status) = (std::fs::read(rig.path(INDEX)).unwrap(), rig.infuse(&["status"]).ok());
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        bytes
    };
    let n = whole.len();
    let broken = [flipped(0), flipped(35), flipped(n / 2), flipped(n - 1), whole[..n - 8].to_vec(), Vec::new()];
    for bytes in broken {
        std::fs::write(rig.path(INDEX), bytes).unwrap();
        assert_eq!(rig.infuse(&["status"]).ok(), status);
        assert_eq!(std::fs::read(rig.path(INDEX)).unwrap(), whole);
    }
    // Where it cannot be kept, all goes on without.
    std::fs::remove_file(rig.path(INDEX)).unwrap();
    std::fs::create_dir(rig.path(INDEX)).unwrap();
    assert_eq!(rig.infuse(&["status"]).ok(), status);
}
