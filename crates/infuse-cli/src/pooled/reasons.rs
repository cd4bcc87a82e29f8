//! Why the loop asks for the experiments of a batch.

use infuse::pooled::Reason;
use page::Finding;

/// What they are for, the most frequent first.
pub(super) fn reasons(of_each: &[Reason], has_simulation: bool) -> Finding {
    let doubt = match has_simulation {
        true => "where least is known of what may be best, should the simulation be wrong",
        false => "where least is known of what may be best, should there be no trend",
    };
    let all: [(Reason, &str, &str); 8] = [
        (Reason::Again, "for again", "again where what was measured is far from what all others say"),
        (Reason::Around, "for around", "around a design that was measured to be far better than runs elsewhere say"),
        (
            Reason::Gain,
            "for gain",
            "where one more run is expected to improve the best response most, repeats included",
        ),
        (
            Reason::Little,
            "for little",
            "where one more run is expected to improve the best response most, which is next to nothing anywhere by now",
        ),
        (
            Reason::Noise,
            "for noise",
            "again where the best was measured, which puts the noise that was given to the test",
        ),
        (Reason::Doubt, "for doubt", doubt),
        (Reason::Coverage, "for coverage", "where most of what can be set is far from any run"),
        (Reason::Start, "for start", "spread over all that can be set"),
    ];
    let counted = all.map(|(reason, name, words)| {
        let n = of_each.iter().filter(|&&other| other == reason).count();
        (n, name, words)
    });
    let mut there: Vec<_> = counted.into_iter().filter(|(n, ..)| *n > 0).collect();
    there.sort_by_key(|(n, ..)| std::cmp::Reverse(*n));
    let words: Vec<String> = match &there[..] {
        [] => return Finding::new("Why the loop asked for these experiments was not written down."),
        [(_, _, words)] => vec![format!("All of it is {words}")],
        several => several.iter().map(|(n, _, words)| format!("{n} {words}")).collect(),
    };
    let finding = Finding::new(format!("{}.", words.join("; ")));
    there.iter().fold(finding, |finding, (n, name, _)| finding.with(name, *n as f64, "1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_counted_and_the_most_frequent_is_first() {
        use Reason::{Coverage, Doubt, Gain};
        let said = |of_each: &[Reason]| reasons(of_each, true).sentence().to_owned();
        let mixed = said(&[Gain, Coverage, Coverage, Doubt, Coverage, Gain]);
        assert_eq!(
            mixed,
            "3 where most of what can be set is far from any run; 2 where one more run is expected to improve the best response most, repeats included; 1 where least \
             is known of what may be best, should the simulation be wrong."
        );
        assert_eq!(said(&[Coverage; 4]), "All of it is where most of what can be set is far from any run.");
        assert!(said(&[]).contains("not written down"));
        assert!(!reasons(&[Doubt], false).sentence().contains("simulation"));
    }
}
