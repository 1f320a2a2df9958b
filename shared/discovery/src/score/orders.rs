//! Orders at which the innovations repeat over a coordinate: candidate orders of a ripple.
//!
//! ```text
//! P(N) = Σ_c |Σ_k ν_k exp(i N q_k) / σ_c|²,   N every half period over what was travelled
//! ```
//!
//! A ripple of an encoder shows in its own channel; one of a gear shows in every channel a little
//! later, in step with the coordinate.

use super::lines::LINES;
use dynamics::description::{Plant, SensorKind};
use identification::filter::Linear;
use identification::problem::Timeline;

/// Bound of the orders tested.
const ORDERS_MAX: usize = 2000;
/// Largest frequency of a ripple at the mean speed [cycles per sample]; the Nyquist limit is 0.5.
/// Chosen, no derivation.
const CYCLES_PER_SAMPLE_MAX: f64 = 0.3;

/// Strongest orders over one joint, of one channel or of all together, and the number of orders
/// tested.
#[derive(Clone, Debug)]
pub struct Orders {
    pub joint: String,
    pub channel: Option<usize>,
    pub list: Vec<f64>,
    pub looked: usize,
}

/// Strongest orders of one run over every joint.
///
/// Cost: samples times orders, a rotation each.
pub fn orders(linear: &Linear, timeline: &Timeline, plant: &Plant, sigma: &[f64]) -> Vec<Orders> {
    let mut found = Vec::new();
    for body in &plant.bodies {
        let joint = &body.joint.name;
        let Some(grid) = Grid::new(linear, timeline, &format!("joint:{joint}")) else { continue };
        let power: Vec<Vec<f64>> = (0..sigma.len()).map(|c| grid.power(linear, timeline, (c, sigma[c]))).collect();
        let pooled: Vec<f64> = (0..grid.looked).map(|k| power.iter().map(|own| own[k]).sum()).collect();
        let of = |channel: Option<usize>, power: &[f64]| {
            let list = grid.peaks(power);
            Orders { joint: joint.clone(), channel, list, looked: grid.looked }
        };
        found.push(of(None, &pooled));
        for (channel, sensor) in plant.sensors.iter().enumerate() {
            if matches!(&sensor.kind, SensorKind::Encoder { joint: own } if own == joint) {
                found.push(of(Some(channel), &power[channel]));
            }
        }
    }
    found
}

/// Coordinate at every sample and the orders that are tested.
struct Grid {
    q: Vec<f64>,
    first: f64,
    step: f64,
    looked: usize,
}

impl Grid {
    fn new(linear: &Linear, timeline: &Timeline, coordinate: &str) -> Option<Self> {
        let place = |name: &str| linear.state_names.iter().position(|state| state == name);
        let (at, rate, x) = (place(coordinate)?, place(&format!("{coordinate}.rate"))?, linear.state_names.len());
        let events = timeline.events.iter().enumerate();
        let of = |k: usize, state: usize| linear.states[k * x + state];
        let q: Vec<f64> = events.flat_map(|(k, event)| core::iter::repeat_n(of(k, at), event.count)).collect();
        let (low, high) = q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| (l.min(*q), h.max(*q)));
        let square = linear.states.chunks(x).map(|state| state[rate] * state[rate]).sum::<f64>();
        let speed = (square / timeline.events.len().max(1) as f64).sqrt();
        let first = core::f64::consts::TAU / (high - low);
        let fastest = CYCLES_PER_SAMPLE_MAX * core::f64::consts::TAU / (timeline.period_s * speed);
        let step = 0.5 * first;
        let looked = ((fastest - first) / step).min(ORDERS_MAX as f64);
        (looked >= 2.0 && first.is_finite()).then_some(Self { q, first, step, looked: looked as usize })
    }

    /// Power of a channel at every order.
    fn power(&self, linear: &Linear, timeline: &Timeline, (channel, sigma): (usize, f64)) -> Vec<f64> {
        let mut sums = vec![[0.0; 2]; self.looked];
        for sample in (0..self.q.len()).filter(|sample| timeline.channel[*sample] == channel) {
            // where the pass starts elsewhere than at the prior's mean, the oscillation from that
            // mean is no ripple
            let nu = (linear.nu[sample] - linear.pull[sample]) / sigma;
            let (turn, begin) = (self.step * self.q[sample], self.first * self.q[sample]);
            let [c, s] = [libm::cos(turn), libm::sin(turn)];
            let mut z = [nu * libm::cos(begin), nu * libm::sin(begin)];
            for sum in &mut sums {
                *sum = [sum[0] + z[0], sum[1] + z[1]];
                z = [c * z[0] - s * z[1], s * z[0] + c * z[1]];
            }
        }
        sums.into_iter().map(|[re, im]| re * re + im * im).collect()
    }

    /// Orders of the largest local maxima.
    fn peaks(&self, power: &[f64]) -> Vec<f64> {
        let last = power.len() - 1;
        let top = |k: &usize| power[*k] >= power[k.saturating_sub(1)] && power[*k] >= power[(*k + 1).min(last)];
        let mut list: Vec<usize> = (0..power.len()).filter(top).collect();
        list.sort_by(|a, b| power[*b].total_cmp(&power[*a]).then(a.cmp(b)));
        list.into_iter().take(LINES).map(|k| self.first + self.step * k as f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, problem, recording, with_effect};
    use identification::fit::{EstimationSession, LinearisedProblem};

    /// Effect, site, values, channel.
    type Case = (&'static str, &'static str, &'static [(&'static str, f64)], Option<usize>);

    #[test]
    fn the_order_of_a_ripple_is_found_between_the_orders_that_everybody_knows() {
        let nominal = plant("drive_rig");
        let cases: [Case; 2] = [
            ("encoder_ripple", "sensor:angle", &[("amplitude", 3e-4), ("order", 22.5)], Some(0)),
            ("joint_gear_ripple", "joint:drive", &[("sine", 0.05), ("order", 19.3)], None),
        ];
        for (kind, site, values, channel) in cases {
            let problem = problem(&nominal, recording(&with_effect(&nominal, kind, site, values), 4, 3.0));
            let session = EstimationSession::new(&problem, 1).unwrap();
            let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
            let found = orders(&linearised.linears[0], &session.timelines[0], &nominal, &session.noise.sensor_sigma);
            let own = found.iter().find(|own| own.channel == channel).unwrap();
            assert!((own.list[0] - values[1].1).abs() < 0.6, "{kind} {:?}", own.list);
        }
    }
}
