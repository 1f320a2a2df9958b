//! The posterior of all messages, and how each of them tests the others.

use crate::message::Received;
use crate::parameters::Parameters;
use estimation::identifiability::Identifiability;
use identification::joint::{Agreement, Knowledge, Message};
use identification::statistics::chi_squared_tail;
use nalgebra::DVector;
use telemetry::{BLOCKS, JointVerdict, ParameterBlock};

/// What all messages say together.
#[derive(Clone, Debug)]
pub struct Folded {
    pub knowledge: Knowledge,
    /// Mean, in the parameters' own units.
    pub theta: Vec<f64>,
    pub sigma: Vec<f64>,
    pub identifiability: Vec<Identifiability>,
    /// From the point of linearisation to the mean, rms over the parameters in posterior standard
    /// deviations; `None` where the messages have no common point.
    pub step_sigma: Option<f64>,
    /// One of each message, in the order of the arcs.
    pub arcs: Vec<ArcTest>,
}

/// How an arc tests the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcTest {
    pub arc: usize,
    pub chi2_per_row: f64,
    /// How often white noise of the stated size is as far off, on either side.
    pub p_noise: f64,
    /// By code of [`ParameterBlock`]: how often arcs of one craft differ as much; `None` without
    /// another arc.
    pub p_between: [Option<f64>; BLOCKS],
}

/// A held-out arc, predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    pub chi2_per_row: f64,
    /// How often a prediction by a true model is off as much, on either side; what the posterior
    /// leaves open is taken into account.
    pub p: f64,
}

/// How often a true model is rejected: half of it by the tests at the end, half by those of an arc
/// that no step explains ([`crate::refusal`]), each over all its tests.
pub(crate) const FALSE_REFUSALS: f64 = 1e-3;

/// What priors and messages say together: `Λ = 1 + Σ N` about the messages' own points of
/// linearisation, in the order of the arcs whatever the order of arrival. `None` where the sum is
/// not positive.
#[must_use]
pub fn fold(parameters: &Parameters, received: &[Received]) -> Option<Knowledge> {
    let mut known = Knowledge::of_priors(parameters.len());
    for one in in_order(received) {
        known = known.with([&one.message], &parameters.deviations(&one.theta))?;
    }
    Some(known)
}

fn in_order(received: &[Received]) -> Vec<&Received> {
    let mut order: Vec<&Received> = received.iter().collect();
    order.sort_by_key(|one| one.arc);
    order
}

impl Folded {
    /// The posterior of `received`, with its tests; `None` where it is not positive.
    #[must_use]
    pub fn of(parameters: &Parameters, received: &[Received]) -> Option<Self> {
        let knowledge = fold(parameters, received)?;
        let covariance = knowledge.covariance()?;
        let n = parameters.len();
        let relative: Vec<f64> = (0..n).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
        let order = in_order(received);
        let common = order.first().map(|one| &one.theta).filter(|theta| order.iter().all(|one| one.theta == **theta));
        let step_sigma = common.map(|theta| {
            let step = &knowledge.mean - parameters.deviations(theta);
            (step.dot(&(&knowledge.information * &step)).max(0.0) / n as f64).sqrt()
        });
        let arcs = order.iter().map(|one| arc_test(parameters, &order, one)).collect();
        Some(Self {
            theta: parameters.values(&knowledge.mean),
            sigma: relative.iter().zip(&parameters.unknowns).map(|(s, unknown)| s * unknown.sigma).collect(),
            identifiability: relative.iter().map(|s| Identifiability::of(*s, 1.0)).collect(),
            knowledge,
            step_sigma,
            arcs,
        })
    }

    /// A held-out arc at this posterior, `χ²` and `N` as its message has them at `theta`. Of
    /// innovations r with sensitivities H and unit variance, what the posterior leaves open widens
    /// the covariance to `1 + H Λ⁻¹ H'`, so that `χ² = r'r − b'(Λ + N)⁻¹b`, `b = H'r`.
    #[must_use]
    pub fn predicts(&self, parameters: &Parameters, held_out: &Received) -> Option<Predicted> {
        let Message { information, gradient, chi2, rows, .. } = &held_out.message;
        let step = &self.knowledge.mean - parameters.deviations(&held_out.theta);
        let turned = information * &step;
        let at_mean = chi2 - 2.0 * gradient.dot(&step) + step.dot(&turned);
        let b: DVector<f64> = gradient - turned;
        let both = nalgebra::Cholesky::new(&self.knowledge.information + information)?;
        let p = two_sided(at_mean - b.dot(&both.solve(&b)), *rows);
        Some(Predicted { chi2_per_row: at_mean / (*rows).max(1) as f64, p })
    }

    /// Whether the arcs speak for the model, and the arc that does not. With a held-out arc that is
    /// `None` where there is none to come.
    #[must_use]
    pub fn verdict(&self, predicted: Option<Predicted>) -> (JointVerdict, Option<usize>) {
        let between = |arc: &ArcTest| arc.p_between.iter().flatten().count();
        let tests = self.arcs.iter().map(|arc| 1 + between(arc)).sum::<usize>() + usize::from(predicted.is_some());
        let level = 0.5 * FALSE_REFUSALS / tests.max(1) as f64;
        let least = |arc: &ArcTest| arc.p_between.iter().flatten().copied().fold(1.0, f64::min);
        let off = |p: &dyn Fn(&ArcTest) -> f64| {
            // of arcs that are both impossible, the one that is further off
            let order =
                |a: &&ArcTest, b: &&ArcTest| p(a).total_cmp(&p(b)).then(b.chi2_per_row.total_cmp(&a.chi2_per_row));
            let worst = self.arcs.iter().min_by(order);
            worst.filter(|arc| p(arc) < level).map(|arc| arc.arc)
        };
        if self.arcs.is_empty() {
            (JointVerdict::NoMessage, None)
        } else if let Some(arc) = off(&|arc| arc.p_noise) {
            (JointVerdict::ArcNotExplained, Some(arc))
        } else if let Some(arc) = off(&least) {
            (JointVerdict::ArcsContradict, Some(arc))
        } else {
            match predicted {
                Some(predicted) if predicted.p < level => (JointVerdict::HeldOutMissed, None),
                Some(_) => (JointVerdict::Accepted, None),
                None => (JointVerdict::NoHeldOut, None),
            }
        }
    }
}

fn arc_test(parameters: &Parameters, all: &[&Received], one: &Received) -> ArcTest {
    let others: Vec<Received> = all.iter().filter(|other| other.arc != one.arc).map(|other| (*other).clone()).collect();
    let known = (!others.is_empty()).then(|| fold(parameters, &others)).flatten();
    let d = parameters.deviations(&one.theta);
    let between = |block: &ParameterBlock| match (block, &known) {
        (_, None) => None,
        (ParameterBlock::Whole, Some(known)) => Agreement::of(&one.message, known, &d),
        (_, Some(known)) => {
            let places = parameters.of_block(*block);
            (!places.is_empty()).then(|| Agreement::of_block(&one.message, known, &d, &places)).flatten()
        }
    };
    let mut p_between = [None; BLOCKS];
    for block in ParameterBlock::ALL {
        p_between[usize::from(block.code())] = between(block).map(|agreement| agreement.p);
    }
    let rows = one.message.rows;
    ArcTest {
        arc: one.arc,
        chi2_per_row: one.message.chi2 / rows.max(1) as f64,
        p_noise: two_sided(one.message.chi2, rows),
        p_between,
    }
}

/// How often a sum of so many squares is as far off its expectation, on either side.
fn two_sided(chi2: f64, rows: usize) -> f64 {
    let above = chi_squared_tail(chi2.max(0.0), rows.max(1) as f64);
    (2.0 * above.min(1.0 - above)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial;

    const ROWS: usize = 400;

    fn parameters() -> Parameters {
        Parameters::of_plant(&trial::plant("oscillator")).unwrap()
    }

    fn arc(parameters: &Parameters, arc: usize, offset: f64, chi2: f64) -> Received {
        trial::arc(parameters, arc, [offset, chi2], ROWS)
    }

    #[test]
    fn arcs_that_agree_give_one_model_and_the_prior_counts_once() {
        let parameters = parameters();
        let folded = Folded::of(&parameters, &[arc(&parameters, 0, 0.5, 1.0), arc(&parameters, 1, 0.5, 1.0)]).unwrap();
        for i in 0..parameters.len() {
            assert!((folded.knowledge.mean[i] - 0.5 * 200.0 / 201.0).abs() < 1e-12);
            assert!((folded.sigma[i] - parameters.unknowns[i].sigma / 201.0_f64.sqrt()).abs() < 1e-12);
            assert_eq!(folded.identifiability[i], Identifiability::Identified);
        }
        assert_eq!(folded.verdict(None).0, JointVerdict::NoHeldOut);
        assert!(folded.step_sigma.unwrap() > 1.0, "the mean is far from the common point");
    }

    #[test]
    fn a_lost_arc_leaves_the_estimate_wider_and_where_it_was() {
        let parameters = parameters();
        let both = [arc(&parameters, 0, 0.1, 1.0), arc(&parameters, 1, 0.1, 1.0)];
        let (whole, part) = (Folded::of(&parameters, &both).unwrap(), Folded::of(&parameters, &both[..1]).unwrap());
        for i in 0..parameters.len() {
            assert!(part.sigma[i] > 1.4 * whole.sigma[i] && part.sigma[i] < 1.42 * whole.sigma[i]);
            assert!((part.theta[i] - whole.theta[i]).abs() < part.sigma[i]);
        }
        assert_eq!(part.arcs[0].p_between, [None; BLOCKS], "there is nothing to compare it with");
    }

    #[test]
    fn a_residual_that_is_no_noise_and_an_arc_that_contradicts_are_refused_by_name() {
        let parameters = parameters();
        let of = |second: Received| {
            let arcs = [arc(&parameters, 0, 0.0, 1.0), second, arc(&parameters, 2, 0.0, 1.0)];
            Folded::of(&parameters, &arcs).unwrap().verdict(None)
        };
        assert_eq!(of(arc(&parameters, 1, 0.0, 1.5)), (JointVerdict::ArcNotExplained, Some(1)));
        // far too small is no noise of the stated size either
        assert_eq!(of(arc(&parameters, 1, 0.0, 0.6)), (JointVerdict::ArcNotExplained, Some(1)));
        assert_eq!(of(arc(&parameters, 1, 1.0, 1.0)), (JointVerdict::ArcsContradict, Some(1)));
    }

    #[test]
    fn a_prediction_may_be_off_by_what_the_posterior_leaves_open_and_not_by_more() {
        let parameters = parameters();
        let folded = Folded::of(&parameters, &[arc(&parameters, 0, 0.0, 1.0)]).unwrap();
        let n = parameters.len() as f64;
        // innovations that all parameters at one posterior sigma explain: b'Λ⁻¹b = n of them
        let off = |sigmas: f64| {
            let mut held_out = arc(&parameters, 3, sigmas / 101.0_f64.sqrt(), 1.0);
            held_out.message.chi2 += 100.0 * n * sigmas * sigmas / 101.0;
            folded.predicts(&parameters, &held_out).unwrap()
        };
        let (near, far) = (off(1.0), off(60.0));
        assert!(near.p > 0.5 && near.chi2_per_row > 1.0, "{near:?}");
        assert_eq!(folded.verdict(Some(near)).0, JointVerdict::Accepted);
        assert_eq!(folded.verdict(Some(far)).0, JointVerdict::HeldOutMissed, "{far:?}");
    }
}
