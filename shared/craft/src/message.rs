//! A message as the sample that travels, and back.

use crate::parameters::Parameters;
use identification::joint::Message;
use nalgebra::{DMatrix, DVector};
use telemetry::{INFORMATION_PACKED, Information, Sample};

/// Which message it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tag {
    pub arc: usize,
    pub generation: u16,
    pub held_out: bool,
}

/// A message that was received, and where it is linearised.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    pub arc: usize,
    pub message: Message,
    pub theta: Vec<f64>,
}

/// Why a sample is not folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    #[error("its CRC is wrong")]
    Damaged,
    #[error("it speaks of another list of parameters ({theirs:08x}, here {ours:08x}): another build or plant file")]
    OtherParameters { theirs: u32, ours: u32 },
    #[error("the plant cannot predict the arc")]
    Empty,
    #[error("a number of it is not finite")]
    NotFinite,
}

/// The sample that carries `message`, linearised at `theta`; without a message that of an arc which
/// the plant cannot predict.
#[must_use]
pub fn sample(message: Option<&Message>, parameters: &Parameters, theta: &[f64], tag: Tag) -> Information {
    let mut sample = Information::zeroed_at(0);
    (sample.arc, sample.generation, sample.held_out) = (tag.arc as u16, tag.generation, u16::from(tag.held_out));
    sample.parameter_hash = parameters.hash;
    let Some(message) = message else { return sample.sealed() };
    let n = parameters.len();
    sample.count = n as u16;
    (sample.rows, sample.chi2, sample.log_determinant) = (message.rows as u64, message.chi2, message.log_determinant);
    sample.theta[..n].copy_from_slice(theta);
    sample.gradient[..n].copy_from_slice(message.gradient.as_slice());
    for i in 0..n {
        sample.mask |= u64::from(message.information[(i, i)] > 0.0) << i;
        for j in 0..=i {
            sample.information[packed(i, j)] = message.information[(i, j)];
        }
    }
    sample.sealed()
}

/// The message that `sample` carries.
///
/// # Errors
/// See [`Refused`].
pub fn received(sample: &Information, parameters: &Parameters) -> Result<Received, Refused> {
    if !sample.is_intact() {
        return Err(Refused::Damaged);
    }
    if sample.parameter_hash != parameters.hash {
        return Err(Refused::OtherParameters { theirs: sample.parameter_hash, ours: parameters.hash });
    }
    let n = parameters.len();
    if usize::from(sample.count) != n {
        return Err(Refused::Empty);
    }
    let numbers = [&sample.theta[..], &sample.gradient, &sample.information, &[sample.chi2, sample.log_determinant]];
    if numbers.into_iter().flatten().any(|number| !number.is_finite()) {
        return Err(Refused::NotFinite);
    }
    let message = Message {
        information: DMatrix::from_fn(n, n, |i, j| sample.information[packed(i.max(j), i.min(j))]),
        gradient: DVector::from_column_slice(&sample.gradient[..n]),
        chi2: sample.chi2,
        log_determinant: sample.log_determinant,
        rows: sample.rows as usize,
    };
    Ok(Received { arc: sample.arc.into(), message, theta: sample.theta[..n].to_vec() })
}

/// Place of row i, column j ≤ i in the lower triangle.
const fn packed(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

const _: () = assert!(packed(telemetry::INFORMATION_MAX - 1, telemetry::INFORMATION_MAX - 1) + 1 == INFORMATION_PACKED);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fold::fold;
    use crate::trial;

    fn parameters() -> Parameters {
        Parameters::of_plant(&trial::plant("oscillator")).unwrap()
    }

    /// Some message; no two alike.
    fn message(n: usize, seed: usize) -> Message {
        let number = |k: usize| ((k * 7919 + seed * 104_729) % 1000) as f64 / 1000.0 - 0.5;
        let factor = DMatrix::from_fn(n, n, |i, j| number(i * n + j));
        let product = &factor * factor.transpose();
        Message {
            information: 0.5 * (&product + product.transpose()),
            gradient: DVector::from_fn(n, |i, _| number(i + 77)),
            chi2: 99.0 + number(3),
            log_determinant: number(4),
            rows: 100,
        }
    }

    fn theta(parameters: &Parameters) -> Vec<f64> {
        parameters.unknowns.iter().map(|unknown| unknown.prior + 0.1 * unknown.sigma).collect()
    }

    const TAG: Tag = Tag { arc: 1, generation: 2, held_out: false };

    #[test]
    fn a_message_comes_back_from_its_sample_bit_for_bit() {
        let parameters = parameters();
        let sent = message(parameters.len(), 1);
        let sample = sample(Some(&sent), &parameters, &theta(&parameters), TAG);
        let back = received(&sample, &parameters).unwrap();
        assert_eq!((back.message, back.theta, back.arc), (sent, theta(&parameters), 1));
        assert_eq!(sample.mask.count_ones() as usize, parameters.len());
    }

    #[test]
    fn partitions_that_fold_the_same_samples_in_the_order_of_their_arcs_agree_to_the_last_bit() {
        let parameters = parameters();
        let samples: Vec<Information> = (0..3)
            .map(|arc| {
                let sent = message(parameters.len(), arc);
                sample(Some(&sent), &parameters, &theta(&parameters), Tag { arc, ..TAG })
            })
            .collect();
        let posterior = |order: [usize; 3]| {
            let heard: Vec<Received> = order.iter().map(|arc| received(&samples[*arc], &parameters).unwrap()).collect();
            fold(&parameters, &heard).unwrap()
        };
        let first = posterior([0, 1, 2]);
        for order in [[2, 1, 0], [1, 2, 0]] {
            let other = posterior(order);
            let bits = |of: &DVector<f64>| of.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&first.mean), bits(&other.mean), "they arrived in another order");
            assert_eq!(first.information, other.information);
        }
    }

    #[test]
    fn a_message_of_another_list_of_parameters_is_refused_with_both_hashes() {
        let parameters = parameters();
        let sample = sample(Some(&message(parameters.len(), 1)), &parameters, &theta(&parameters), TAG);
        let other = Parameters { hash: parameters.hash ^ 1, ..parameters.clone() };
        let refused = received(&sample, &other).unwrap_err();
        assert_eq!(refused, Refused::OtherParameters { theirs: parameters.hash, ours: parameters.hash ^ 1 });
        let text = refused.to_string();
        assert!(text.contains(&format!("{:08x}", parameters.hash)), "{text}");
    }

    #[test]
    fn damaged_empty_and_infinite_messages_are_refused() {
        let parameters = parameters();
        let whole = sample(Some(&message(parameters.len(), 1)), &parameters, &theta(&parameters), TAG);
        assert_eq!(received(&Information { rows: 101, ..whole }, &parameters), Err(Refused::Damaged));
        assert_eq!(received(&sample(None, &parameters, &[], TAG), &parameters), Err(Refused::Empty));
        let infinite = Information { chi2: f64::INFINITY, ..whole }.sealed();
        assert_eq!(received(&infinite, &parameters), Err(Refused::NotFinite));
    }
}
