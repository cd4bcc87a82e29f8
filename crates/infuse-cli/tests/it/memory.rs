//! How much memory a campaign takes whose designs nobody could list.

use std::fs::File;
use std::process::Stdio;
use std::time::Duration;

use crate::rig::Rig;

/// 24^6 designs of a bowl whose simulation lies beside it, and experiments that are a command.
fn rig(method: &str, experiments: usize) -> Rig {
    let rig = Rig::empty();
    let parameter = |k: usize| {
        format!("[[parameter]]\nname = \"p{k}\"\nunit = \"mm\"\nlower = 0\nupper = 23\nstep = 1\nrole = \"plant\"\n")
    };
    let parameters: String = (1..=6).map(parameter).collect();
    let bowl = |at: f64| {
        let squares: Vec<String> = (1..=6).map(|k| format!("({{p{k}}} - {at}) ^ 2")).collect();
        format!("command = [\"awk\", \"BEGIN {{ print {} }}\"]", squares.join(" + "))
    };
    rig.write(
        "campaign.toml",
        &format!(
            "title = \"Six parameters\"\nseed = 1\n{parameters}[response]\nname = \"y\"\nunit = \"N\"\ngoal = \"minimize\"\n\
             [simulator]\n{}\n[experiment]\n{}\n[loop]\n{method}experiments = {experiments}\nsimulations = 36\nbatches = 2\n",
            bowl(14.0),
            bowl(12.0)
        ),
    );
    rig
}

/// The most memory that a call had at a time, in MB, as the kernel counts it; none where it does not say.
fn peak_mb(rig: &Rig, arguments: &[&str]) -> Option<f64> {
    let mut command = rig.command(arguments);
    let errors = rig.path("errors");
    command.stdout(Stdio::null()).stderr(File::create(&errors).unwrap());
    let mut child = command.spawn().unwrap();
    let path = format!("/proc/{}/status", child.id());
    let mut peak = None;
    loop {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kb = line.and_then(|rest| rest.trim().trim_end_matches(" kB").parse::<f64>().ok());
        peak = kb.map(|kb| kb / 1024.0).or(peak);
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{}", std::fs::read_to_string(errors).unwrap());
            return peak;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

const DISSERTATION: &str = "method = \"dissertation\"\n";

/// The most memory of two batches, in MB.
///
/// All designs as points would take 9 GB, a bit for each takes 24 MB.
fn peak_of_two_batches_mb(method: &str, experiments: usize) -> Option<f64> {
    let rig = rig(method, experiments);
    let peak = peak_mb(&rig, &["run", "--batches", "2"]);
    match peak {
        Some(peak) => assert!(peak < 300.0, "{peak} MB with `{method}`"),
        None => eprintln!("this system does not say how much memory a program had: nothing was tested"),
    }
    assert_eq!(rig.journal().iter().filter(|line| line["event"] == "told").count(), 2 * experiments);
    peak
}

#[test]
fn two_batches_over_two_hundred_million_designs_take_less_than_300_mb() {
    peak_of_two_batches_mb("", 18);
}

/// It goes through all designs, several times over, with the quadratic of six parameters, which has 28 terms.
#[test]
#[ignore = "a slow proof: `cargo xtask proofs`"]
fn the_loop_of_the_dissertation_takes_no_more() {
    let peak = peak_of_two_batches_mb(DISSERTATION, 34);
    if let (Some(peak), Ok(found)) = (peak, std::env::var("PROOF_FOUND")) {
        std::fs::write(found, format!("{peak:.0} MB")).unwrap();
    }
}
