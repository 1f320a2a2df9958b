//! Which changes are adopted: one after another, then every rival is tested in the place of each.
//!
//! Stiffness and damping of a real plant are wrong together, so up to [`TERMS_MAX`] changes are
//! adopted, the best in turn, as long as it earns its BIC and its probability; all amplitudes are
//! fitted again. Then every other change is put in the place of every adopted one with the rest in
//! place: one that is better there takes it, one that is as good is a rival that these modes do not
//! separate.

use super::changes::Change;
use super::comparison::{Comparison, Fitted, Member};
use super::likelihood::Group;

/// Largest number of adopted changes.
const TERMS_MAX: usize = 3;
/// A change that reduces the residual by less than this (−2 ln L, linear in its amplitude) is not
/// fitted beside others: it neither earns its BIC nor is it a rival.
const GAIN_MIN: f64 = 2.0;

/// The adopted changes, and all others.
pub(super) struct Adopted {
    pub members: Vec<Member>,
    /// For each member the changes in its place, the best first, itself among them.
    pub places: Vec<Vec<Fitted>>,
    /// Every change on the plant as it is, the best first.
    pub alone: Vec<Fitted>,
    /// Changes in question.
    pub tried: usize,
}

/// Adopts changes by forward search at the level `alpha`, then exchanges each with better rivals.
///
/// Cost: changes × amplitudes (some 50) linearisations on the plant as it is; beside others, for
/// those changes whose direction fits.
pub(super) fn adopt(comparison: &Comparison<'_>, alpha: f64) -> Adopted {
    let all = Change::all(comparison.plant, comparison.evidence.has(Group::Damping));
    let tried = all.len();
    let fitted = all.into_iter().filter_map(|change| comparison.fitted(&[], 0, change, tried));
    let alone = sorted(fitted.collect());
    let mut adopted = Adopted { members: Vec::new(), places: Vec::new(), alone, tried };
    let mut next = adopted.alone.clone();
    while let Some(best) = next.first().filter(|best| best.p < alpha && best.bic < 0.0) {
        adopted.members.push(Member { change: best.change.clone(), amplitude: best.amplitude });
        fit_again(comparison, &mut adopted.members);
        if adopted.members.len() == TERMS_MAX {
            break;
        }
        next = adopted.beside(comparison, &adopted.members, adopted.members.len());
    }
    adopted.test_rivals(comparison);
    adopted
}

impl Adopted {
    /// Tests every change in the place of every member; a better one replaces it.
    fn test_rivals(&mut self, comparison: &Comparison<'_>) {
        self.places.clear();
        for place in 0..self.members.len() {
            let mut others = self.members.clone();
            others.remove(place);
            let list = if others.is_empty() { self.alone.clone() } else { self.beside(comparison, &others, place) };
            if let Some(best) = list.first().filter(|best| best.change != self.members[place].change) {
                self.members[place] = Member { change: best.change.clone(), amplitude: best.amplitude };
            }
            self.places.push(list);
        }
        fit_again(comparison, &mut self.members);
    }

    /// The set without one of its members.
    pub fn without(&mut self, comparison: &Comparison<'_>, place: usize) {
        self.members.remove(place);
        fit_again(comparison, &mut self.members);
        self.test_rivals(comparison);
    }

    /// Changes beside others, the best first.
    fn beside(&self, comparison: &Comparison<'_>, others: &[Member], place: usize) -> Vec<Fitted> {
        let new = self.alone.iter().filter(|fitted| others.iter().all(|member| member.change != fitted.change));
        let promising = new.filter(|fitted| gain(comparison, others, fitted) > GAIN_MIN);
        let fitted = promising.filter_map(|f| comparison.fitted(others, place, f.change.clone(), self.tried));
        sorted(fitted.collect())
    }
}

fn sorted(mut list: Vec<Fitted>) -> Vec<Fitted> {
    list.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    list
}

/// Reduction of the residual behind `others` by a change, in the direction in which it moves the
/// plant as it is.
fn gain(comparison: &Comparison<'_>, others: &[Member], fitted: &Fitted) -> f64 {
    let Some(left) = comparison.left(others, &comparison.all_rows()) else { return 0.0 };
    let factor = comparison.evidence.factor(&comparison.evidence.best(&left).tau);
    let along = factor.form(&fitted.moved, &left);
    along * along / factor.form(&fitted.moved, &fitted.moved).max(1e-300)
}

fn fit_again(comparison: &Comparison<'_>, members: &mut [Member]) {
    let places: Vec<usize> = (0..members.len()).collect();
    comparison.refit(members, &places, &comparison.evidence, &comparison.all_rows());
}
