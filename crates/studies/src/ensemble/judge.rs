//! One rule for all claims: what became of each over all plants, in a world.

use std::fmt;

use super::claims::{Claim, JUDGED, Test};
use super::kept::Case;
use super::row::{Row, World};

/// What comes out in so large a share of the campaigns is reproduced in kind.
pub(super) const MOST: f64 = 0.9;
/// What comes out in less is not reproduced.
pub(super) const FEW: f64 = 0.1;
/// What a larger share of the designs that nobody chose meets says nothing of a loop.
pub(super) const BY_CHANCE: f64 = 0.5;

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    InKind,
    InPart,
    Not,
    /// A design that nobody chose would meet it, too.
    NotDiscriminating,
    /// Both ends were fitted.
    PartlyCalibrated,
    /// No campaign of it is kept, or it is not asked in this world.
    NotJudged,
}

impl Verdict {
    pub(super) const COUNTED: [Self; 5] =
        [Self::InKind, Self::InPart, Self::Not, Self::NotDiscriminating, Self::PartlyCalibrated];
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::InKind => "in kind",
            Self::InPart => "in part",
            Self::Not => "not",
            Self::NotDiscriminating => "not discriminating",
            Self::PartlyCalibrated => "partly calibrated",
            Self::NotJudged => "not judged",
        })
    }
}

/// A plant by its number, and in how many of its campaigns a claim holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    pub(super) plant: u64,
    pub(super) holding: usize,
    pub(super) campaigns: usize,
}

impl Share {
    pub(super) fn value(&self) -> f64 {
        self.holding as f64 / self.campaigns.max(1) as f64
    }
}

/// What became of a claim in a world.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// Plants with at least one campaign.
    pub(super) shares: Vec<Share>,
    /// Share of the designs that nobody chose that would meet it, mean over plants; none where no single design can.
    pub(super) by_chance: Option<f64>,
    pub(super) verdict: Verdict,
}

impl Judged {
    /// Plants with a claim in more than half of their campaigns.
    pub(super) fn n_holding(&self) -> usize {
        self.shares.iter().filter(|share| share.value() > 0.5).count()
    }

    pub(super) fn campaigns(&self) -> [usize; 2] {
        let sum = |of: fn(&Share) -> usize| self.shares.iter().map(of).sum();
        [sum(|share| share.holding), sum(|share| share.campaigns)]
    }

    /// In words; none where it is not judged.
    pub(super) fn words(&self) -> Option<String> {
        if self.verdict == Verdict::NotJudged {
            return None;
        }
        let [holding, campaigns] = self.campaigns();
        let plants = format!("{} of {} plants", self.n_holding(), self.shares.len());
        Some(if self.shares.len() == 1 {
            format!("{holding} of {campaigns} cases")
        } else if campaigns == self.shares.len() {
            plants
        } else {
            format!("{plants}, {holding} of {campaigns} campaigns")
        })
    }
}

/// The rule: by the share of all campaigns, by what chance would give, and by what was fitted.
pub(super) fn verdict(share: f64, by_chance: Option<f64>, is_fitted: bool) -> Verdict {
    if share < FEW {
        Verdict::Not
    } else if by_chance.is_some_and(|chance| chance > BY_CHANCE) {
        Verdict::NotDiscriminating
    } else if is_fitted {
        Verdict::PartlyCalibrated
    } else if share >= MOST {
        Verdict::InKind
    } else {
        Verdict::InPart
    }
}

/// What became of a claim in a world.
pub(super) fn judge(claim: &Claim, world: World, cases: &[Case<'_>]) -> Judged {
    let by = claim.judged_by(world);
    let mine = cases.iter().filter(|case| case.study == claim.study && Some(case.world) == by);
    let (mut shares, mut chances) = (Vec::new(), Vec::new());
    for case in mine {
        let (outcomes, chance) = outcomes(claim, case);
        if !outcomes.is_empty() {
            let holding = outcomes.iter().filter(|holds| **holds).count();
            shares.push(Share { plant: case.plant, holding, campaigns: outcomes.len() });
            chances.extend(chance);
        }
    }
    let by_chance = (!chances.is_empty()).then(|| chances.iter().sum::<f64>() / chances.len() as f64);
    let mut judged = Judged { shares, by_chance, verdict: Verdict::NotJudged };
    let [holding, campaigns] = judged.campaigns();
    if campaigns > 0 {
        let is_fitted = claim.is_fitted && world == World::Still;
        judged.verdict = verdict(holding as f64 / campaigns as f64, by_chance, is_fitted);
    }
    judged
}

/// Campaign by campaign whether a claim holds, and for how many of the designs that nobody chose it would.
fn outcomes(claim: &Claim, case: &Case<'_>) -> (Vec<bool>, Option<f64>) {
    let paths: Vec<Vec<&Row>> = case.seeds(JUDGED).into_iter().map(|seed| case.path(JUDGED, seed)).collect();
    let random = case.random();
    let chance = |before: &Row, test: &dyn Fn(&Row, &Row) -> bool| {
        random.iter().filter(|row| test(before, row)).count() as f64 / random.len().max(1) as f64
    };
    match &claim.test {
        Test::End(test) => {
            let Some(before) = case.numerical() else { return (Vec::new(), None) };
            let ends = paths.iter().filter_map(|path| path.last());
            (ends.map(|after| test(before, after)).collect(), Some(chance(before, test)))
        }
        Test::SinceFirst(test) => {
            let pairs: Vec<(&Row, &Row)> =
                paths.iter().filter_map(|path| Some((*path.first()?, *path.last()?))).collect();
            let chances: Vec<f64> = pairs.iter().map(|(before, _)| chance(before, test)).collect();
            let mean = (!chances.is_empty()).then(|| chances.iter().sum::<f64>() / chances.len() as f64);
            (pairs.into_iter().map(|(before, after)| test(before, after)).collect(), mean)
        }
        Test::Path(test) => (paths.iter().map(|path| test(case, path)).collect(), None),
        Test::Seed(test) => (case.seeds(JUDGED).into_iter().filter_map(|seed| test(case, seed)).collect(), None),
        Test::Plant(test) => (test(case).into_iter().collect(), None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rule_for_every_claim() {
        assert_eq!(verdict(0.95, Some(0.2), false), Verdict::InKind);
        assert_eq!(verdict(0.90, None, false), Verdict::InKind);
        assert_eq!(verdict(0.89, Some(0.5), false), Verdict::InPart);
        assert_eq!(verdict(0.95, Some(0.51), false), Verdict::NotDiscriminating);
        assert_eq!(verdict(0.95, Some(0.2), true), Verdict::PartlyCalibrated);
        // Nothing keeps a claim from coming out as not reproduced.
        for (chance, fitted) in [(None, true), (Some(0.9), true), (Some(0.9), false), (None, false)] {
            assert_eq!(verdict(0.09, chance, fitted), Verdict::Not);
        }
    }
}
