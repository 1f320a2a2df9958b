//! How much of a diagnosis is done, from the work that is counted; no clock.

use discovery::diagnose::Phase;

/// What is being done, in the order of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The channel metadata are checked.
    Labels,
    /// The recordings are examined.
    Examine,
    /// The search itself.
    Search(Phase),
}

impl Stage {
    /// `look at the labels`.
    pub fn words(self) -> &'static str {
        match self {
            Stage::Labels => "look at the labels",
            Stage::Examine => "examine the recordings",
            Stage::Search(phase) => phase.words(),
        }
    }
}

/// The work at which each stage began.
pub struct Forecast {
    begun: Vec<(Stage, f64)>,
    /// The most that the search costs.
    most: f64,
}

/// Scores of the catalogue, in works of the fits before them (the nominal plant and its noise), and
/// their most as a share of all work; measured on four cases of `deploy/plants`, like all below.
const SCORE: f64 = 5.0;
const SCORE_MOST: f64 = 0.055;
/// What follows the scores of a round, in their work: a comparison, and the end of the diagnosis.
/// The comparison is 0.1 where nothing is missing and up to 7 where many sets are near.
const COMPARE: f64 = 0.4;
const END: f64 = 0.2;
/// A stage that takes longer than expected is at this share of its own.
const OVERDUE: f64 = 0.67;
/// The fits before any are known, and the least of them.
const FITS_LEAST: f64 = 3e8;
/// The share of all that the look at the labels comes near to.
const LABELS: f64 = 0.2;

impl Forecast {
    pub fn new(most: f64) -> Self {
        Self { begun: Vec::new(), most }
    }

    /// `stage` begins when `work` is done.
    pub fn begin(&mut self, stage: Stage, work: f64) {
        self.begun.push((stage, work));
    }

    /// What is being done now.
    pub fn words(&self) -> &'static str {
        self.begun.last().map_or("begin", |(stage, _)| stage.words())
    }

    /// Share of all work that is done with `work`, in [0, 1].
    pub fn share(&self, work: f64) -> f64 {
        let rest = self.rest(work);
        if work + rest > 0.0 { (work / (work + rest)).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The work at which the first of `stage` began.
    fn began(&self, stage: Phase) -> Option<f64> {
        self.begun.iter().find(|(begun, _)| *begun == Stage::Search(stage)).map(|(_, work)| *work)
    }

    /// Work of the scores of the first round: measured once they are, else expected.
    fn scores(&self, work: f64) -> f64 {
        let (Some(fit), score) = (self.began(Phase::Fit), self.began(Phase::Score)) else { return FITS_LEAST };
        if let (Some(score), Some(compare)) = (score, self.began(Phase::Compare)) {
            return compare - score;
        }
        (SCORE * (score.unwrap_or(work) - fit).max(FITS_LEAST)).min(SCORE_MOST * self.most)
    }

    /// The work that is still expected.
    fn rest(&self, work: f64) -> f64 {
        let Some((stage, since)) = self.begun.last() else { return FITS_LEAST };
        let done = work - since;
        let left = |expected: f64| (expected - done).max(done * (1.0 / OVERDUE - 1.0));
        let scores = self.scores(work);
        let rest = match stage {
            Stage::Labels | Stage::Examine => (1.0 / LABELS - 1.0) * work + FITS_LEAST,
            Stage::Search(Phase::Fit | Phase::Noise) => left(FITS_LEAST) + (1.0 + COMPARE + END) * scores,
            Stage::Search(Phase::Score) => left(scores) + (COMPARE + END) * scores,
            Stage::Search(Phase::Compare | Phase::SearchAgain) => left(COMPARE * scores) + END * scores,
            Stage::Search(Phase::Report) => left(0.1 * END * scores),
            Stage::Search(_) => left(END * scores),
        };
        rest.min((self.most - work).max(0.0) + END * scores)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stages of a diagnosis of `hub_appendage`, and the work at which each began.
    const HUB: [(Stage, f64); 8] = [
        (Stage::Labels, 0.0),
        (Stage::Examine, 0.333e9),
        (Stage::Search(Phase::Fit), 0.333e9),
        (Stage::Search(Phase::Noise), 1.45e9),
        (Stage::Search(Phase::Score), 2.251e9),
        (Stage::Search(Phase::Compare), 8.998e9),
        (Stage::Search(Phase::HeldOut), 9.666e9),
        (Stage::Search(Phase::Report), 12.512e9),
    ];

    #[test]
    fn from_a_fifth_of_a_diagnosis_on_what_is_left_is_right_within_a_factor_of_two_and_a_half() {
        let (mut forecast, all) = (Forecast::new(1e11), 12.534e9);
        let mut stages = HUB.iter().peekable();
        for step in 0..96 {
            let work = all * f64::from(step) / 100.0;
            while let Some((stage, begun)) = stages.next_if(|(_, begun)| *begun <= work) {
                forecast.begin(*stage, *begun);
            }
            let ratio = forecast.rest(work) / (all - work);
            assert!((0.0..=1.0).contains(&forecast.share(work)));
            assert!(step < 20 || step > 70 || (0.4..2.5).contains(&ratio), "{step} %: {ratio}");
        }
    }

    #[test]
    fn the_share_moves_within_a_stage_that_takes_much_longer_than_expected() {
        let mut forecast = Forecast::new(1e12);
        HUB[..6].iter().for_each(|(stage, work)| forecast.begin(*stage, *work));
        let shares: Vec<f64> = (1..9).map(|k| forecast.share(1e10 * f64::from(k))).collect();
        assert!(shares.iter().all(|share| (0.3..1.0).contains(share)), "{shares:?}");
    }
}
