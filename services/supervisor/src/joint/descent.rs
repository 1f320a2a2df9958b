//! From one common point of linearisation to the next, downhill.
//!
//! Of a Gauss–Newton step from the lowest point the messages at its end give the objective: where
//! it rose, the step is taken again as short as the parabola of the line predicts. Parameters that
//! are nearly confounded (mass, stiffness and place of a fuel in one period of its slosh) make a
//! curved ridge of the likelihood, along which each step falls short, some by half; steps twice as
//! long, tried where they did, arrived later than steps as they are.

use craft::fold::Folded;
use craft::message::{Received, received};
use craft::parameters::Parameters;
use craft::point::CommonPoint;
use serde::{Deserialize, Serialize};
use telemetry::Information;
use zerocopy::FromBytes;

/// A step that is taken again, of what it was: at most half, or it would be the same again; at
/// least a tenth, below which a parabola is not that of so long a line.
const SHORTENED: [f64; 2] = [0.1, 0.5];

/// Messages as they travelled, as messages.
pub fn read(messages: &[Vec<u8>], parameters: &Parameters) -> Vec<Received> {
    let samples = messages.iter().filter_map(|bytes| Information::read_from_bytes(bytes).ok());
    samples.filter_map(|sample| received(&sample, parameters).ok()).collect()
}

/// The lowest point so far, and the step from it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Descent {
    pub generation: u16,
    pub messages: Vec<Vec<u8>>,
    /// Of the Gauss–Newton step.
    share: f64,
    /// At the end of the step the plant cannot predict an arc that it could before.
    pub is_impossible: bool,
}

impl Default for Descent {
    fn default() -> Self {
        Self { generation: 0, messages: Vec::new(), share: 1.0, is_impossible: false }
    }
}

impl Descent {
    /// Takes up the messages of a generation. They are the new point unless the objective rose or
    /// an arc cannot be predicted; points of other arcs, or without a point in common, are not
    /// compared.
    pub fn take(&mut self, parameters: &Parameters, generation: u16, messages: &[Vec<u8>]) {
        if core::mem::take(&mut self.is_impossible) {
            self.share *= SHORTENED[1];
            return;
        }
        let of = |messages: &[Vec<u8>]| CommonPoint::of(parameters, &read(messages, parameters));
        let compared = of(&self.messages).zip(of(messages));
        let least = compared.as_ref().and_then(|(lowest, new)| lowest.least(new));
        let rose = compared.is_some_and(|(lowest, new)| lowest.arcs == new.arcs && new.objective > lowest.objective);
        if rose {
            self.share *= least.unwrap_or(0.0).clamp(SHORTENED[0], SHORTENED[1]);
            return;
        }
        (self.generation, self.messages) = (generation, messages.to_vec());
        self.share = 1.0;
    }

    /// Where the next messages are asked for: so far from the lowest point to the mean `folded`
    /// there.
    pub fn next(&self, parameters: &Parameters, folded: &Folded) -> Vec<f64> {
        let Some(at) = read(&self.messages, parameters).first().map(|one| parameters.deviations(&one.theta)) else {
            return folded.theta.clone();
        };
        // of messages at points of their own there is no step
        let share = if folded.step_sigma.is_some() { self.share } else { 1.0 };
        parameters.values(&(&at + share * (&folded.knowledge.mean - &at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use telemetry::Sample;
    use zerocopy::IntoBytes;

    fn parameters() -> Parameters {
        let text = include_str!("../../../../deploy/plants/oscillator.toml");
        Parameters::of_plant(&plant_file::parse("oscillator", text).unwrap().plant).unwrap()
    }

    /// One arc where every parameter is `d` prior sigmas off, its objective a parabola of second
    /// derivative `2 bend` with its minimum at `least`, and the information of arc and prior
    /// `claimed`.
    fn messages(parameters: &Parameters, d: f64, least: f64, [bend, claimed]: [f64; 2]) -> Vec<Vec<u8>> {
        let n = parameters.len();
        let mut sample = Information::zeroed_at(0);
        (sample.parameter_hash, sample.count, sample.rows) = (parameters.hash, n as u16, 100);
        sample.chi2 = 1e3 + n as f64 * (bend * (d - least).powi(2) - d * d);
        for i in 0..n {
            let unknown = &parameters.unknowns[i];
            sample.theta[i] = unknown.prior + d * unknown.sigma;
            sample.gradient[i] = bend * (least - d) + d;
            sample.information[i * (i + 1) / 2 + i] = claimed - 1.0;
        }
        vec![sample.sealed().as_bytes().to_vec()]
    }

    /// Deviations of the points that are asked for one after the other, from the priors.
    fn walked(least: f64, bends: [f64; 2], steps: u16) -> Vec<f64> {
        let parameters = parameters();
        let (mut descent, mut at) = (Descent::default(), vec![0.0]);
        for generation in 1..=steps {
            descent.take(&parameters, generation, &messages(&parameters, at[at.len() - 1], least, bends));
            let folded = Folded::of(&parameters, &read(&descent.messages, &parameters)).unwrap();
            at.push(parameters.deviations(&descent.next(&parameters, &folded))[0]);
        }
        at
    }

    #[test]
    fn where_the_objective_is_its_quadratic_model_the_steps_are_those_of_gauss_and_newton() {
        let at = walked(0.3, [5.0, 5.0], 2);
        assert!((at[1] - 0.3).abs() < 1e-9 && (at[2] - 0.3).abs() < 1e-9, "{at:?}");
    }

    #[test]
    fn where_the_objective_rose_the_step_is_taken_again_as_short_as_the_line_says() {
        let at = walked(0.1, [50.0, 10.0], 2);
        assert!((at[1] - 0.5).abs() < 1e-9 && (at[2] - 0.1).abs() < 1e-9, "{at:?}");
    }

    #[test]
    fn where_an_arc_cannot_be_predicted_the_step_is_halved_and_no_arc_is_lost() {
        let parameters = parameters();
        let mut descent = Descent::default();
        descent.take(&parameters, 1, &messages(&parameters, 0.0, 0.4, [5.0, 5.0]));
        descent.is_impossible = true;
        descent.take(&parameters, 2, &[]);
        let folded = Folded::of(&parameters, &read(&descent.messages, &parameters)).unwrap();
        let next = parameters.deviations(&descent.next(&parameters, &folded))[0];
        assert!(descent.generation == 1 && !descent.is_impossible && (next - 0.2).abs() < 1e-9, "{next}");
    }
}
