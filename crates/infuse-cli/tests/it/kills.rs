//! Kills at any moment, of a call that waits for a queue and of the page beside the rig.
//!
//! A few in every run of the tests; `KILLS=1000 cargo test --release -p infuse-cli --test it kills_` makes a thousand of each,
//! those of `interruptions.rs` included.

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::Duration;

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

#[cfg(unix)]
use crate::queues::{KEYS, check_each_once, local, queued};
use crate::rig::{Rig, told};
use crate::serve::row_of;
use crate::served::{Served, send};

/// How many kills: so many, unless somebody asks for more.
pub(crate) fn n_kills(otherwise: usize) -> usize {
    std::env::var("KILLS").map_or(otherwise, |number| number.parse().expect("KILLS is a number"))
}

/// A call that submits, waits, and takes what came: the campaign goes on as one that nobody disturbed, and nothing was
/// simulated twice.
#[cfg(unix)]
#[test]
fn kills_of_calls_that_wait_for_a_queue_lose_nothing_and_repeat_nothing() {
    let mut random = Pcg64::seed_from_u64(11);
    let reference = local();
    assert!(reference.batch() && reference.batch());
    let (kills, mut n) = (n_kills(25), 0);
    while n < kills {
        let rig = queued(KEYS);
        rig.write("slow", "");
        for _ in 0..2 {
            loop {
                let mut child = rig.command(&["ask"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
                std::thread::sleep(Duration::from_millis(160).mul_f64(random.random::<f64>()));
                if let Some(ended) = child.try_wait().unwrap() {
                    let said = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
                    assert!(ended.success(), "{said}");
                    break;
                }
                child.kill().unwrap();
                child.wait().unwrap();
                n += 1;
                if n >= kills {
                    break;
                }
            }
            assert!(rig.batch(), "what is left of the batch");
        }
        check_each_once(&rig);
        assert_eq!(rig.status()["best"], reference.status()["best"]);
        assert_eq!(rig.status()["bound"], reference.status()["bound"]);
    }
}

/// Whatever the page has acknowledged is in the journal, and what it has not may be there once.
#[test]
fn kills_of_the_page_lose_nothing_that_it_has_acknowledged() {
    let mut random = Pcg64::seed_from_u64(12);
    let (kills, mut n) = (n_kills(40), 0);
    while n < kills {
        let rig = Rig::pooled();
        rig.infuse(&["ask"]).ok();
        let mut acknowledged: BTreeMap<u64, f64> = BTreeMap::new();
        for id in (1..=10).cycle() {
            if n >= kills || acknowledged.len() == 10 {
                break;
            }
            if acknowledged.contains_key(&id) {
                continue;
            }
            let value = 7.0 + id as f64 / 8.0;
            let mut served = Served::new(&rig);
            let page = served.get("/").body;
            if told(&rig.journal()).contains_key(&id) {
                // It was written down before the kill that kept the page from saying so.
                acknowledged.insert(id, value);
                continue;
            }
            let fields = row_of(&page, id, (&value.to_string(), "", ""));
            let fields: Vec<(&str, &str)> = fields.iter().map(|(name, value)| (&**name, &**value)).collect();
            let origin = format!("Origin: http://127.0.0.1:{}\r\n", served.port);
            let (port, form) = (served.port, served.form("/tell", &fields, &origin));
            let client = std::thread::spawn(move || send(port, &form));
            std::thread::sleep(Duration::from_millis(8).mul_f64(random.random::<f64>()));
            served.kill();
            let is_acknowledged = client.join().unwrap() == 303;
            n += 1;
            let journal = told(&rig.journal());
            if is_acknowledged {
                acknowledged.insert(id, value);
            }
            for (id, value) in &acknowledged {
                assert_eq!(journal.get(id), Some(value), "experiment {id} was acknowledged");
            }
        }
        for (id, value) in told(&rig.journal()) {
            assert!((value - 7.0 - id as f64 / 8.0).abs() < 1e-12, "experiment {id} is {value}");
        }
        rig.infuse(&["status"]).ok();
    }
}
