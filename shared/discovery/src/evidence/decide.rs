//! The constants of a decision, each beside its derivation, and the verdict as a region of the
//! posterior.
//!
//! A model is a set of hypotheses; its weight is that of its evidence among all models that were
//! fitted. A hypothesis has the weight of all models that hold it. A law that leads has that of
//! larger laws at its site, too, which contain it as a limit: the simplest law that holds carries
//! the name, and what a larger one adds is bounded beside it.

use super::super::diagnose::Verdict;

/// Probability of a name and of any finding: a wrong name costs nine times a missed one.
pub(super) const LEVEL: f64 = 0.9;
/// Prior odds that something (more) is missing: a mismatch is suspected, neither is it known.
/// Every hypothesis has the m-th part of it, m the number of all hypotheses at all sites: the whole
/// correction for multiplicity.
pub(super) const PRIOR_ODDS: f64 = 1.0;
/// Standard deviation of the logarithm of a sensor's noise over its stated size: data sheets give
/// typical or largest values, ±35 %.
pub(super) const SENSOR_SPREAD: f64 = 0.3;
/// The same of a stated disturbance: a factor of two, since nobody measures it.
pub(super) const DISTURBANCE_SPREAD: f64 = 0.7;
/// Standard deviation of an amplitude, in amplitudes whose rms equals that of all that drives the
/// record. It enters by its logarithm: wrong by three, 1.1 nats.
pub(super) const AMPLITUDE_SCALE: f64 = 1.0;
/// Factor on the standard deviation of a number that conflicts with its file: one decade, which
/// costs it ln 10 = 2.3 nats.
pub(super) const CONFLICT_FACTOR: f64 = 10.0;
/// Prior odds π that a label of a channel is wrong. Odds of the data exceed k by chance with a
/// probability below 1/k (Markov), so a right label is corrected with one below π/9: six mistakes
/// asked of each of 300 right channels correct 0.2 of them, where none may be.
pub(super) const LABEL_ODDS: f64 = 1e-3;
/// Standard deviation of a positive number that is stated as exact and wrong, as a share of it: at
/// two of them it is off by itself.
pub(super) const EXACT_SHARE: f64 = 0.5;
/// Standard deviation of the damping ratio of a tank's mass or a mode that is stated without
/// damping: at two of them it has the tenth of the critical one that rings of baffles reach, which
/// joints of structures stay below.
pub(super) const DAMPING_RATIO: f64 = 0.05;
/// Squared distance of whitened innovations below which two laws are the same on a record: one nat
/// of likelihood, odds below e.
pub(super) const SAME: f64 = 2.0;
/// Standard errors of a loss on held-out data from which a set is rejected: one-sided 5 %.
pub(super) const HELD_OUT_SIGMA: f64 = 1.64;
/// Standard deviation of the shift of inputs [samples]: held against linear between stamps.
pub(super) const SHIFT_SIGMA: f64 = 0.5;
/// Probability of calling a model worse, or its misfit felt, by chance: one-sided 5 %, as
/// [`HELD_OUT_SIGMA`].
pub(super) const WORSE: f64 = 0.05;
/// Share of a signal below which a misfit is not seen in an overlay, and by which a misfit has to
/// be smaller to be seen to be: one part in twenty, what a line is wide on a page.
pub(super) const SEEN_SHARE: f64 = 0.05;
/// Share of the squares that noise cannot explain below which an effect is not worth adding: those
/// of a rms that is smaller by [`SEEN_SHARE`], 1 − (1 − s)² = 2 s.
pub(super) const RELEVANT_SHARE: f64 = 2.0 * SEEN_SHARE;
/// Share of a misfit that is not seen from which a law is what the plant lacks: no other law beside
/// it can have more than half of the squares, several can have less.
pub(super) const MAIN_SHARE: f64 = 0.5;
/// Standard deviation of the logarithm of a rate or distance over which a law unfolds about the
/// middle of its screening: a decade and a half of width, what a record resolves.
pub(super) const WIDTH_SPREAD: f64 = 1.5;
/// Mean and standard deviation of the pole of coloured noise: any memory from none to ten samples.
pub(super) const POLE_PRIOR: [f64; 2] = [0.5, 0.4];
/// Standard deviations of its prior beyond which noise is not as stated: 0.27 % of normal numbers.
pub(super) const NOISE_SIGMA: f64 = 3.0;

/// Share of the largest weight from which a weight is equal to it: a tenth of a nat, what two fits
/// of one law under two names may differ by. It orders names and decides no verdict.
const EQUAL: f64 = 0.9;

/// What a member of a model is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    Physics,
    Sensor,
    Noise,
    Conflict,
    Timing,
}

/// Classes that are something the plant lacks.
const FINDINGS: [Class; 2] = [Class::Physics, Class::Sensor];
/// Classes that are any way of being wrong.
const ALL: [Class; 5] = [Class::Physics, Class::Sensor, Class::Noise, Class::Conflict, Class::Timing];

/// A model as the decision sees it: its members (class and place in the list of all names), and
/// its posterior weight.
pub(super) struct Weighted {
    pub members: Vec<(Class, usize)>,
    /// Names of simpler laws that its members contain as limits.
    pub contains: Vec<usize>,
    pub weight: f64,
    /// Place in the catalogue: of models of equal weight the first leads.
    pub rank: usize,
    /// Models of one class are the same on the record.
    pub class: usize,
}

/// The decision.
pub(super) struct Decision {
    pub verdict: Verdict,
    /// Place of the model that leads.
    pub leader: usize,
    /// Of every name: weight of all models that hold it.
    pub inclusion: Vec<f64>,
    /// Weight of all models with physics or an error of a sensor.
    pub found: f64,
    /// Weight of all models with anything of the leader's classes; of all that find nothing where
    /// the leader does.
    pub of_kind: f64,
}

/// The verdict on models whose weights add to one; `names` is how many names there are,
/// `noise_is_off` that fitted noise lies beyond [`NOISE_SIGMA`] of its prior.
pub(super) fn decide(models: &[Weighted], names: usize, noise_is_off: bool) -> Decision {
    let holds = |model: &Weighted, classes: &[Class]| model.members.iter().any(|(class, _)| classes.contains(class));
    let weight = |classes: &[Class]| -> f64 {
        models.iter().filter(|model| holds(model, classes)).map(|model| model.weight).sum()
    };
    let of = |name: usize| {
        models.iter().filter(|model| model.members.iter().any(|(_, own)| *own == name)).map(|model| model.weight).sum()
    };
    let mut inclusion: Vec<f64> = (0..names).map(of).collect();
    let found = weight(&FINDINGS);
    let is_found = found >= LEVEL;
    let other = match () {
        () if is_found => None,
        () if weight(&[Class::Timing]) >= LEVEL => Some(Verdict::InputTiming),
        () if weight(&[Class::Conflict]) >= LEVEL => Some(Verdict::ParameterConflict),
        () if weight(&[Class::Noise, Class::Conflict, Class::Timing]) >= LEVEL || noise_is_off => {
            Some(Verdict::NoiseModel)
        }
        () => None,
    };
    // what is wrong beyond doubt leads where it is open which kind it is
    let is_wrong = !is_found && other.is_none() && weight(&ALL) >= LEVEL;
    let allowed = |model: &&(usize, &Weighted)| match is_wrong {
        true => holds(model.1, &ALL),
        false => holds(model.1, &FINDINGS) == is_found,
    };
    let candidates: Vec<(usize, &Weighted)> = models.iter().enumerate().filter(|entry| allowed(&entry)).collect();
    let whole = |class: usize| -> f64 {
        candidates.iter().filter(|(_, model)| model.class == class).map(|(_, model)| model.weight).sum()
    };
    let class = candidates.iter().map(|(_, model)| model.class).max_by(|a, b| whole(*a).total_cmp(&whole(*b)));
    let own = candidates.iter().filter(|(_, model)| Some(model.class) == class);
    let most = own.clone().map(|(_, model)| model.weight).fold(0.0, f64::max);
    let equal = own.filter(|(_, model)| model.weight >= EQUAL * most);
    let leader = equal.min_by_key(|(place, model)| (model.rank, *place)).map_or(0, |(place, _)| *place);
    let members = models.get(leader).map_or(&[][..], |model| &model.members);
    for (_, name) in members {
        let holds =
            |model: &&Weighted| model.members.iter().any(|(_, own)| own == name) || model.contains.contains(name);
        inclusion[*name] = models.iter().filter(holds).map(|model| model.weight).sum();
    }
    let leads = |classes: &[Class]| members.iter().any(|(class, _)| classes.contains(class));
    let verdict = if is_found {
        found_verdict(members, &inclusion)
    } else if let Some(other) = other {
        other
    } else if !is_wrong {
        Verdict::None
    } else if leads(&FINDINGS) {
        match weight(&[Class::Physics, Class::Sensor, Class::Conflict]) >= LEVEL {
            true => Verdict::NotSeparable,
            false => Verdict::CannotDecide,
        }
    } else if leads(&[Class::Conflict]) {
        Verdict::ParameterConflict
    } else if leads(&[Class::Timing]) {
        Verdict::InputTiming
    } else {
        Verdict::NoiseModel
    };
    let of_kind = match members.iter().map(|(class, _)| *class).collect::<Vec<Class>>() {
        own if own.is_empty() => 1.0 - weight(&ALL),
        own => weight(&own),
    };
    Decision { verdict, leader, inclusion, found, of_kind }
}

/// The verdict on findings: of members of the leading model, with the weights of all names.
pub(super) fn found_verdict(members: &[(Class, usize)], inclusion: &[f64]) -> Verdict {
    let own = |class: &[Class]| members.iter().filter(|(own, _)| class.contains(own)).collect::<Vec<_>>();
    match own(&[Class::Physics, Class::Sensor]).iter().all(|(_, name)| inclusion[*name] >= LEVEL) {
        false => Verdict::NotSeparable,
        true if own(&[Class::Physics]).is_empty() => Verdict::Sensor,
        true => Verdict::Named,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(members: &[(Class, usize)], weight: f64) -> Weighted {
        Weighted { members: members.to_vec(), contains: Vec::new(), weight, rank: 0, class: 0 }
    }

    #[test]
    fn a_law_that_leads_a_larger_one_which_contains_it_carries_the_name_and_a_larger_one_that_leads_does_not() {
        let of = |simple: f64| {
            let larger = Weighted { contains: vec![0], ..model(&[(Class::Physics, 1)], 1.0 - simple) };
            decide(&[model(&[(Class::Physics, 0)], simple), larger], 2, false)
        };
        let (simple, larger) = (of(0.6), of(0.4));
        assert!(simple.verdict == Verdict::Named && (simple.inclusion[0] - 1.0).abs() < 1e-12);
        assert!(larger.verdict == Verdict::NotSeparable && larger.leader == 1);
        assert_eq!(larger.inclusion, [0.4, 0.6]);
    }

    #[test]
    fn a_law_under_three_names_leads_by_the_sum_of_its_weights() {
        let of =
            |name: usize, weight: f64, class: usize| Weighted { class, ..model(&[(Class::Physics, name)], weight) };
        let models = [of(0, 0.4, 0), of(1, 0.2, 1), of(2, 0.2, 1), of(3, 0.2, 1)];
        let found = decide(&models, 4, false);
        assert!(found.leader == 1 && found.verdict == Verdict::NotSeparable);
    }

    #[test]
    fn nothing_is_named_below_nine_to_one_and_one_name_of_nine_to_one_is() {
        let (none, one) = (model(&[], 0.11), model(&[(Class::Physics, 0)], 0.89));
        assert_eq!(decide(&[none, one], 1, false).verdict, Verdict::None);
        let (none, one) = (model(&[], 0.09), model(&[(Class::Physics, 0)], 0.91));
        let found = decide(&[none, one], 1, false);
        assert!(found.verdict == Verdict::Named && found.leader == 1 && (found.inclusion[0] - 0.91).abs() < 1e-12);
    }

    #[test]
    fn two_rivals_are_found_and_not_separated_and_a_name_in_both_of_two_sets_is_sure() {
        let rivals = [model(&[(Class::Physics, 0)], 0.6), model(&[(Class::Sensor, 1)], 0.4)];
        assert_eq!(decide(&rivals, 2, false).verdict, Verdict::NotSeparable);
        let sets = [model(&[(Class::Physics, 0)], 0.6), model(&[(Class::Physics, 0), (Class::Noise, 1)], 0.4)];
        assert_eq!(decide(&sets, 2, false).verdict, Verdict::Named);
    }

    #[test]
    fn what_is_wrong_beyond_doubt_is_never_none_where_its_kind_is_open() {
        let shared = |a: Class, b: Class| {
            let models = [model(&[], 0.01), model(&[(a, 0)], 0.6), model(&[(b, 1)], 0.39)];
            let found = decide(&models, 2, false);
            assert_eq!(found.leader, 1);
            found.verdict
        };
        assert_eq!(shared(Class::Conflict, Class::Physics), Verdict::ParameterConflict);
        assert_eq!(shared(Class::Physics, Class::Conflict), Verdict::NotSeparable);
        assert_eq!(shared(Class::Physics, Class::Noise), Verdict::CannotDecide);
        assert_eq!(shared(Class::Noise, Class::Physics), Verdict::NoiseModel);
        assert_eq!(shared(Class::Timing, Class::Physics), Verdict::InputTiming);
    }

    #[test]
    fn a_model_with_a_law_never_leads_a_verdict_without_one() {
        for (class, verdict) in [(Class::Noise, Verdict::NoiseModel), (Class::Conflict, Verdict::ParameterConflict)] {
            let both = model(&[(Class::Physics, 0), (class, 1)], 0.85);
            let found = decide(&[model(&[], 0.02), model(&[(class, 1)], 0.13), both], 2, false);
            assert_eq!((found.verdict, found.leader), (verdict, 1));
        }
    }

    #[test]
    fn noise_and_conflicts_have_words_of_their_own() {
        let noise = [model(&[], 0.05), model(&[(Class::Noise, 0)], 0.95)];
        assert_eq!(decide(&noise, 1, false).verdict, Verdict::NoiseModel);
        assert_eq!(decide(&[model(&[], 1.0)], 0, true).verdict, Verdict::NoiseModel);
        let conflict = [model(&[], 0.05), model(&[(Class::Conflict, 0)], 0.95)];
        assert_eq!(decide(&conflict, 1, false).verdict, Verdict::ParameterConflict);
        let timing = [model(&[], 0.05), model(&[(Class::Timing, 0)], 0.95)];
        assert_eq!(decide(&timing, 1, false).verdict, Verdict::InputTiming);
        let sensor = [model(&[(Class::Sensor, 0)], 1.0)];
        assert_eq!(decide(&sensor, 1, false).verdict, Verdict::Sensor);
    }
}
