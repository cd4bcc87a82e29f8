//! The rules by which claims are judged: one meaning of each word, for the page over all chapters and for the ensemble alike.

use std::fmt;

#[cfg(feature = "ensemble")]
use page::palette;
use serde::{Deserialize, Serialize};

/// What comes out in at least so many per cent of the cases is reproduced in kind.
const MOST_PCT: usize = 90;
/// What comes out in fewer is not reproduced.
const FEW_PCT: usize = 10;
/// What a larger share of the designs that nobody chose meets says nothing of a loop.
const BY_CHANCE: f64 = 0.5;
/// What comes out less often than by chance by more than so many standard errors is not reproduced.
const STANDARD_ERRORS: f64 = 2.0;
/// Significantly, greatly, much: at most this part of what was there is left.
pub(crate) const MUCH: f64 = 0.5;
/// A printed design is reached within this part of the width of each parameter.
pub(crate) const NEAR: f64 = 0.1;
/// Rounding.
const SAME: f64 = 1e-12;

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Verdict {
    /// Theory that comes out in every case, and nothing was fitted to it.
    Reproduced,
    /// What it says comes out, on a stand-in instead of an experiment or with other numbers.
    InKind,
    /// It comes out in some cases and not in others.
    InPart,
    /// It does not come out.
    NotReproduced,
    /// A design that nobody chose would meet it, too.
    NotDiscriminating,
    /// It does not come out, and could not: no design that any method has tried meets it.
    OutOfReach,
    /// It comes out, but both ends of it were fitted: that the loop goes from one towards the other is all that it shows.
    PartlyCalibrated,
    /// It was fitted.
    Calibrated,
    /// It says what is put in, not what comes out.
    TakenOver,
    /// It follows from the equations whatever the numbers are: that it holds tests the program and not the dissertation.
    Check,
}

impl Verdict {
    /// In the order in which pages list them; the first four count.
    pub(crate) const ALL: [Self; 10] = [
        Self::Reproduced,
        Self::InKind,
        Self::InPart,
        Self::NotReproduced,
        Self::NotDiscriminating,
        Self::OutOfReach,
        Self::PartlyCalibrated,
        Self::Calibrated,
        Self::TakenOver,
        Self::Check,
    ];

    /// Whether it says something of the dissertation.
    pub(crate) fn counts(self) -> bool {
        matches!(self, Self::Reproduced | Self::InKind | Self::InPart | Self::NotReproduced)
    }

    /// In pictures; what does not count is gray.
    #[cfg(feature = "ensemble")]
    pub(crate) fn color(self) -> &'static str {
        match self {
            Self::Reproduced => palette::GREEN,
            Self::InKind => "#7fc8ae",
            Self::InPart => palette::ORANGE,
            Self::NotReproduced => palette::VERMILION,
            Self::NotDiscriminating => "#888888",
            Self::OutOfReach => "#555555",
            Self::PartlyCalibrated => "#999999",
            Self::Calibrated => "#bbbbbb",
            Self::TakenOver => "#cccccc",
            Self::Check => "#dddddd",
        }
    }

    /// In few words, where it is clear what is spoken of.
    pub(crate) fn short(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::InKind => "in kind",
            Self::InPart => "in part",
            Self::NotReproduced => "not",
            Self::NotDiscriminating => "not discriminating",
            Self::OutOfReach => "out of reach",
            Self::PartlyCalibrated => "partly calibrated",
            Self::Calibrated => "calibrated",
            Self::TakenOver => "taken over",
            Self::Check => "check",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::InKind => "reproduced in kind",
            Self::InPart => "reproduced in part",
            Self::NotReproduced => "not reproduced",
            other => other.short(),
        })
    }
}

/// In how many cases something holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Count {
    pub(crate) holding: usize,
    pub(crate) cases: usize,
}

impl Count {
    pub(crate) fn of(holds: impl IntoIterator<Item = bool>) -> Self {
        let start = Self { holding: 0, cases: 0 };
        holds.into_iter().fold(start, |Self { holding, cases }, holds| Self {
            holding: holding + usize::from(holds),
            cases: cases + 1,
        })
    }

    pub(crate) fn one(holds: bool) -> Self {
        Self::of([holds])
    }

    pub(crate) fn all(self) -> bool {
        self.cases > 0 && self.holding == self.cases
    }

    /// In at least nine of ten cases.
    pub(crate) fn most(self) -> bool {
        self.cases > 0 && 100 * self.holding >= MOST_PCT * self.cases
    }

    /// In fewer than one of ten cases.
    pub(crate) fn few(self) -> bool {
        self.cases == 0 || 100 * self.holding < FEW_PCT * self.cases
    }

    /// Whether the share is that of a rule to the digit.
    pub(crate) fn is_tie(self) -> bool {
        self.cases > 0 && [MOST_PCT, FEW_PCT].iter().any(|limit| 100 * self.holding == limit * self.cases)
    }

    pub(crate) fn share(self) -> f64 {
        self.holding as f64 / self.cases.max(1) as f64
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.holding, self.cases)
    }
}

/// What a claim is about, and with it the most that can become of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Standing {
    /// Theory: it can be reproduced.
    Theory,
    /// Experiments, in the place of which a stand-in flies: it can be reproduced in kind.
    StandIn,
    /// The same between two ends that were fitted: it cannot count.
    FittedEnds,
    /// What no plant of this structure and no draw could fail: it cannot count.
    Sure,
    /// What no design meets of all that were tried on any plant, by whatever method: that the loop does not says nothing of the loop.
    OutOfReach,
}

/// What a claim is judged by, and by nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Judged {
    pub(crate) count: Count,
    pub(crate) standing: Standing,
    /// Share of designs that nobody chose, or of blind draws of as many cells, that would meet it; none where none can.
    pub(crate) by_chance: Option<f64>,
}

impl Judged {
    pub(crate) fn of(count: Count, standing: Standing) -> Self {
        Self { count, standing, by_chance: None }
    }

    /// The same beside what chance would give.
    pub(crate) fn beside(self, by_chance: f64) -> Self {
        Self { by_chance: Some(by_chance), ..self }
    }

    /// The rule.
    pub(crate) fn verdict(&self) -> Verdict {
        let Self { count, standing, by_chance } = *self;
        match standing {
            Standing::Sure if count.all() => Verdict::Check,
            Standing::Sure => Verdict::NotReproduced,
            Standing::OutOfReach if count.few() => Verdict::OutOfReach,
            _ if count.few() || self.is_worse_than_chance() => Verdict::NotReproduced,
            _ if by_chance.is_some_and(|chance| chance > BY_CHANCE + SAME) => Verdict::NotDiscriminating,
            Standing::FittedEnds => Verdict::PartlyCalibrated,
            Standing::Theory if count.all() => Verdict::Reproduced,
            _ if count.most() => Verdict::InKind,
            _ => Verdict::InPart,
        }
    }

    /// Whether it comes out less often than by chance, and not by accident.
    fn is_worse_than_chance(&self) -> bool {
        self.by_chance.is_some_and(|chance| {
            let standard_error = (chance * (1.0 - chance) / self.count.cases.max(1) as f64).sqrt();
            self.count.share() < chance - STANDARD_ERRORS * standard_error - SAME && !self.count.most()
        })
    }

    /// Whether its word hangs on one case, and whether on one draw, because a share is that of a rule to the digit.
    pub(crate) fn ties(&self) -> [bool; 2] {
        let differs = |other: Self| other.verdict() != self.verdict();
        let one_less = Count { holding: self.count.holding.saturating_sub(1), ..self.count };
        let is_even = self.by_chance.is_some_and(|chance| (chance - BY_CHANCE).abs() <= SAME);
        [
            self.count.is_tie() && differs(Self { count: one_less, ..*self }),
            is_even && differs(self.beside(BY_CHANCE + 2.0 * SAME)),
        ]
    }

    /// The same in words to be added; most often nothing.
    pub(crate) fn tie_words(&self) -> &'static str {
        match self.ties() {
            [true, true] => " (both exactly at the limit)",
            [true, false] => " (count exactly at the limit)",
            [false, true] => " (chance exactly at the limit)",
            [false, false] => "",
        }
    }

    /// What chance gives, in words to be added.
    pub(crate) fn chance_words(&self) -> String {
        self.by_chance.filter(|chance| chance.is_finite()).map_or(String::new(), |chance| {
            let pct = 100.0 * chance;
            // Not 50 where the rule says another word than at 50.
            let digits = usize::from((pct - 50.0).abs() < 0.5 && (chance - BY_CHANCE).abs() > SAME);
            let is_more = self.verdict().counts() && !self.count.few() && chance > self.count.share();
            format!("; by chance {pct:.digits$} %{}", if is_more { ", which is more" } else { "" })
        })
    }
}

/// Each word with the rule that it stands for, as pages list them.
pub(crate) fn words() -> Vec<(&'static str, String)> {
    vec![
        ("Reproduced", "theory that comes out in every case, and nothing was fitted to it.".to_owned()),
        (
            "In kind",
            format!(
                "it comes out in at least {MOST_PCT} % of the cases, on a stand-in or with other numbers. A case is a campaign, or what a \
                 row says that it counts."
            ),
        ),
        ("In part", format!("in fewer, but in at least {FEW_PCT} %.")),
        (
            "Not",
            format!(
                "in fewer than {FEW_PCT} %, or less often than by chance by more than {STANDARD_ERRORS} standard errors and in fewer than {MOST_PCT} %. So \
                 with fewer than ten cases in kind means in all of them, not means in none; with a single case \
                 there is nothing between."
            ),
        ),
        (
            "Not discriminating",
            format!(
                "it would be in kind or in part, but a design that nobody chose meets it too, in more than {:.0} % of the cases; of the test \
                 that drops cells, a blind draw of as many cells.",
                100.0 * BY_CHANCE
            ),
        ),
        (
            "Out of reach",
            format!(
                "in fewer than {FEW_PCT} % of the campaigns over the ensemble, of what a design shows, and no design that any method tried on any plant \
                 shows it: no loop over these plants could. Not asked of one plant, where few designs are flown."
            ),
        ),
        (
            "Partly calibrated",
            "both ends were fitted, in still water; that the loop goes from the one towards the other is all that came out.".to_owned(),
        ),
        ("Calibrated", "it was fitted.".to_owned()),
        ("Taken over", "it says what is put in.".to_owned()),
        (
            "Check",
            "it follows from the equations whatever the numbers are, so that no plant of this structure could fail it, as an identity or the similarity of models in \
             equations without viscosity: it tests the program."
                .to_owned(),
        ),
        (
            "Exactly at the limit",
            "the share is that of a rule to the digit, and one case more or less changes the word.".to_owned(),
        ),
        (
            "Significantly, greatly, much",
            format!("at most {:.0} % of what was there before is left.", 100.0 * MUCH),
        ),
        ("At a printed row", format!("within {:.0} % of the width of each parameter.", 100.0 * NEAR)),
    ]
}

/// What stands before and after them.
pub(crate) const WORDS_HEAD: &str =
    "One rule for each word, here and over the ensemble. Only the first four count for or against the dissertation:";

/// The same in Markdown.
pub(crate) fn words_markdown() -> String {
    let items: String = words().iter().map(|(word, meaning)| format!("- **{word}**: {meaning}\n")).collect();
    format!("{WORDS_HEAD}\n\n{items}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(holding: usize, cases: usize, standing: Standing, by_chance: Option<f64>) -> Verdict {
        Judged { count: Count { holding, cases }, standing, by_chance }.verdict()
    }

    #[test]
    fn every_word_at_its_limits() {
        use Verdict::{InKind, InPart, NotReproduced, Reproduced};
        let of = |holding, cases| verdict(holding, cases, Standing::StandIn, None);
        assert_eq!([of(135, 150), of(134, 150)], [InKind, InPart], "nine in ten");
        assert_eq!([of(15, 150), of(14, 150)], [InPart, NotReproduced], "one in ten");
        assert_eq!([of(1, 20), of(2, 20), of(1, 21)], [NotReproduced, InPart, NotReproduced], "not one of twenty");
        assert_eq!([of(18, 20), of(17, 20)], [InKind, InPart]);
        let theory = |holding, cases| verdict(holding, cases, Standing::Theory, None);
        assert_eq!([theory(14, 14), theory(13, 14), theory(12, 14)], [Reproduced, InKind, InPart]);
    }

    #[test]
    fn few_cases_know_all_some_and_none() {
        use Verdict::{InKind, InPart, NotReproduced};
        let of = |holding, cases| verdict(holding, cases, Standing::StandIn, None);
        for cases in 2..10 {
            assert_eq!([of(0, cases), of(cases, cases)], [NotReproduced, InKind]);
            assert!((1..cases).all(|holding| of(holding, cases) == InPart), "{cases}");
        }
        assert_eq!([of(0, 1), of(1, 1), of(0, 0)], [NotReproduced, InKind, NotReproduced], "nothing is no evidence");
    }

    #[test]
    fn what_chance_meets_more_often_than_not_says_nothing() {
        let of = |chance| verdict(95, 100, Standing::StandIn, Some(chance));
        assert_eq!(of(0.5), Verdict::InKind, "a tie is not more");
        assert_eq!(of(960.0 / 1920.0), Verdict::InKind);
        assert_eq!(of(961.0 / 1920.0), Verdict::NotDiscriminating);
        assert_eq!(of(f64::NAN), Verdict::InKind, "no designs were drawn");
    }

    #[test]
    fn what_comes_out_less_often_than_by_chance_is_not_reproduced() {
        use Verdict::{InKind, InPart, NotDiscriminating, NotReproduced};
        let of = |holding, cases, chance| verdict(holding, cases, Standing::StandIn, Some(chance));
        // A test that drops the best cell sooner than others.
        assert_eq!([of(48, 150, 0.51), of(39, 150, 0.496)], [NotReproduced, NotReproduced]);
        // Of 100 draws with a chance of 0.4, two standard errors are 9.8.
        assert_eq!([of(31, 100, 0.4), of(30, 100, 0.4)], [InPart, NotReproduced]);
        assert_eq!([of(93, 100, 0.99), of(60, 100, 0.62)], [NotDiscriminating; 2]);
        assert_eq!(of(1, 2, 0.34), InPart, "few cases tell little");
        assert_eq!(of(95, 100, 0.3), InKind);
    }

    #[test]
    fn any_standing_can_come_out_as_not() {
        for standing in [Standing::Theory, Standing::StandIn, Standing::FittedEnds, Standing::Sure] {
            for chance in [None, Some(0.2), Some(0.9)] {
                assert_eq!(verdict(9, 100, standing, chance), Verdict::NotReproduced, "{standing:?}, {chance:?}");
            }
        }
    }

    #[test]
    fn fitted_ends_and_checks_never_count() {
        for holding in 0..=20 {
            for chance in [None, Some(0.2), Some(0.9)] {
                let fitted = verdict(holding, 20, Standing::FittedEnds, chance);
                let sure = verdict(holding, 20, Standing::Sure, chance);
                assert!(!fitted.counts() || fitted == Verdict::NotReproduced, "{holding}: {fitted}");
                assert_eq!(
                    sure,
                    if holding == 20 { Verdict::Check } else { Verdict::NotReproduced },
                    "one failure tells"
                );
            }
        }
    }

    /// One design that meets it after all, and the word is that of the others.
    #[test]
    fn what_is_out_of_reach_does_not_count() {
        assert_eq!(verdict(0, 150, Standing::OutOfReach, Some(0.0)), Verdict::OutOfReach);
        assert_eq!(verdict(0, 150, Standing::StandIn, Some(0.0)), Verdict::NotReproduced);
        assert_eq!(
            verdict(140, 150, Standing::OutOfReach, Some(0.1)),
            Verdict::InKind,
            "nobody is told that it cannot be"
        );
    }

    #[test]
    fn ties_are_said_where_a_word_hangs_on_them() {
        let judged = |holding, cases, chance| Judged {
            count: Count { holding, cases },
            standing: Standing::StandIn,
            by_chance: chance,
        };
        let words = |holding, cases, chance| judged(holding, cases, chance).tie_words();
        assert_eq!(words(135, 150, Some(960.0 / 1920.0)), " (both exactly at the limit)");
        assert_eq!(words(135, 150, Some(0.3)), " (count exactly at the limit)");
        assert_eq!(words(15, 150, None), " (count exactly at the limit)");
        assert_eq!(words(140, 150, Some(0.5)), " (chance exactly at the limit)");
        assert_eq!(words(135, 150, Some(0.51)), "", "it does not count either way");
        assert_eq!(words(15, 150, Some(0.51)), "", "it is not either way: chance is far above");
        assert_eq!(words(136, 150, Some(0.499)), "");
        assert_eq!(judged(140, 150, Some(0.503)).chance_words(), "; by chance 50.3 %");
        assert_eq!(judged(140, 150, Some(0.5)).chance_words(), "; by chance 50 %");
        assert_eq!(judged(140, 150, None).chance_words(), "");
        assert_eq!(judged(39, 150, Some(0.496)).chance_words(), "; by chance 49.6 %, which is more");
    }

    #[test]
    fn the_first_four_words_count() {
        let counting: Vec<bool> = Verdict::ALL.iter().map(|verdict| verdict.counts()).collect();
        assert_eq!(counting, [true, true, true, true, false, false, false, false, false, false]);
    }
}
