//! The joint estimate as a sample.

use craft::fold::{Folded, Predicted};
use craft::parameters::Parameters;
use runtime::Frame;
use telemetry::{ARCS_MAX, BLOCKS, JointEstimate, JointVerdict, Sample};

/// `JointEstimate::verdict_arc`: none.
const NO_ARC: u16 = u16::MAX;

/// The sample of a fold, undecided; of none, with nothing but its parameters.
pub fn sample(parameters: &Parameters, generation: u16, folded: Option<&Folded>, frame: &Frame<'_>) -> JointEstimate {
    let mut sample = JointEstimate::zeroed_at(frame.t_ns);
    (sample.frame, sample.generation) = (frame.number, generation);
    (sample.parameter_hash, sample.verdict_arc) = (parameters.hash, NO_ARC);
    sample.chi2_per_row = [f64::NAN; ARCS_MAX];
    sample.p_between = [[f64::NAN; BLOCKS]; ARCS_MAX];
    (sample.step_sigma, sample.held_out_chi2_per_row, sample.held_out_p) = (f64::NAN, f64::NAN, f64::NAN);
    let Some(folded) = folded else { return sample };
    let n = parameters.len();
    (sample.count, sample.messages) = (n as u16, folded.arcs.len() as u16);
    sample.theta[..n].copy_from_slice(&folded.theta);
    sample.sigma[..n].copy_from_slice(&folded.sigma);
    for (code, status) in sample.identifiability.iter_mut().zip(&folded.identifiability) {
        *code = status.code();
    }
    sample.step_sigma = folded.step_sigma.unwrap_or(f64::NAN);
    for test in folded.arcs.iter().filter(|test| test.arc < ARCS_MAX) {
        sample.chi2_per_row[test.arc] = test.chi2_per_row;
        sample.p_between[test.arc] = test.p_between.map(|p| p.unwrap_or(f64::NAN));
    }
    sample
}

/// Asks for the messages behind those of `generation` at the values `theta`, with the posterior of
/// `generation` where there is one.
pub fn point(
    parameters: &Parameters,
    generation: u16,
    (folded, theta): (Option<&Folded>, &[f64]),
    frame: &Frame<'_>,
) -> JointEstimate {
    let mut sample = self::sample(parameters, generation, folded, frame);
    (sample.count, sample.asks) = (theta.len() as u16, JointEstimate::ASKS_NEXT_GENERATION);
    sample.theta[..theta.len()].copy_from_slice(theta);
    sample
}

/// Adds what was decided.
pub fn judged(sample: &mut JointEstimate, verdict: JointVerdict, arc: Option<usize>, predicted: Option<Predicted>) {
    sample.verdict = verdict.code();
    sample.verdict_arc = arc.map_or(NO_ARC, |arc| arc as u16);
    if let Some(predicted) = predicted {
        (sample.held_out_chi2_per_row, sample.held_out_p) = (predicted.chi2_per_row, predicted.p);
    }
}
