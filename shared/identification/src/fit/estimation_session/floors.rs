//! Unspecified noise of inputs: the floor that it starts at, and the prior of its level.

use super::EstimationSession;
use crate::filter::gains::gains_in_parts;
use crate::filter::{NoiseModel, Propagator, Start, gains, initial_sigmas, linearise};
use crate::fit::FitError;

/// Mean increase of `ln S` per sample that an unspecified disturbance starts at: not seen in any
/// recording we can hold.
const FLOOR_INFLATION: f64 = 1e-4;
/// An unspecified disturbance is small beside the forces at work: prior standard deviation of its
/// level, as a share of their rms.
const DISTURBANCE_SHARE: f64 = 0.01;
/// Largest change of a rate over an interval that a floor may make [m/s or rad/s].
const KICK_MAX: f64 = 1e-2;
/// A disturbance may always grow to this many times its floor.
const FLOORS_LEAST: f64 = 10.0;
/// Increase of `Σ ln S` of all recordings at most that a lowered floor makes. Of a component of the
/// readings whose variance it raises by the share λ, `Σ ln S` rises by `ln(1 + λ)` and the information
/// falls by `1/(1 + λ)`: of none by more than a tenth, be it that of a constant force. All
/// inputs share it.
const RECORD_INFLATION: f64 = 0.1;
/// Turns in which a floor is lowered, and the standard deviation, as a share of a floor, that stands
/// for none.
const LOWERINGS_MAX: usize = 4;
const NO_FLOOR: f64 = 1e-6;
/// Events whose gains are held at a time.
const EVENTS_HELD: usize = 256;
/// Events that decide on the floor, and halvings of the decades in which it is looked for.
const FLOOR_EVENTS: usize = 400;
const HALVINGS: usize = 24;

impl EstimationSession<'_> {
    /// Gives inputs without stated noise the level that inflates the innovations by
    /// [`FLOOR_INFLATION`].
    pub(super) fn set_floors(&mut self) -> Result<(), FitError> {
        let missing: Vec<usize> =
            (0..self.noise.input_sigma.len()).filter(|k| self.noise.input_sigma[*k] <= 0.0).collect();
        if missing.is_empty() {
            return Ok(());
        }
        let theta = self.prior();
        let mut timeline = self.timelines[0].clone();
        timeline.events.truncate(FLOOR_EVENTS);
        let last = timeline.events.last().map_or(0, |event| event.first + event.count);
        for list in [&mut timeline.value, &mut timeline.stamp_s, &mut timeline.interval_s] {
            list.truncate(last);
        }
        timeline.channel.truncate(last);
        let plant = self.problem.instance(&self.problem.plant, &theta, 0);
        let mut propagator = Propagator::new(self.problem, 0, &plant, &timeline).map_err(FitError::Filter)?;
        let sigmas = initial_sigmas(&plant, &propagator.system, &self.problem.runs[0].initial, &[]);
        let mut start = self.noise.clone();
        // noise enough that the filter follows whatever the priors are
        let begin = Start::prior(&sigmas);
        let linear = linearise(&mut propagator, &start, &sigmas, &begin).or_else(|_| {
            missing.iter().for_each(|k| start.input_sigma[*k] = 1.0);
            linearise(&mut propagator, &start, &sigmas, &begin)
        });
        let linear = linear.map_err(FitError::Filter)?;
        let determinant = |noise: &NoiseModel| gains(&linear, &timeline, noise).map(|g| g.log_determinant);
        let none = determinant(&self.noise).unwrap_or(f64::NEG_INFINITY);
        self.work.add(propagator.work() + (1 + missing.len() * HALVINGS) as f64 * propagator.recursion_work());
        for k in missing {
            let mut noise = self.noise.clone();
            let (mut low, mut high) = (-12.0, 6.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                noise.input_sigma[k] = libm::exp(middle * core::f64::consts::LN_10);
                // what no channel sees would grow without end
                let kick = linear.kick(k) * noise.input_sigma[k];
                let inflated =
                    kick > KICK_MAX || determinant(&noise).is_none_or(|d| d - none > FLOOR_INFLATION * last as f64);
                if inflated { high = middle } else { low = middle }
            }
            start.input_sigma[k] = libm::exp(low * core::f64::consts::LN_10);
        }
        self.noise = start;
        Ok(())
    }

    /// Lowers the floors of unspecified inputs until none takes information from the recordings as
    /// wholes. A floor that a few samples do not show still lets momentum wander, which hides a force
    /// that lasts.
    ///
    /// Cost: one linearisation, and a few recursions for each input.
    pub fn lower_floors(&mut self) {
        let unstated: Vec<usize> =
            (0..self.disturbance_sigma.len()).filter(|k| self.disturbance_sigma[*k].is_finite()).collect();
        let Ok(linears) = self.linearise(&self.problem.plant, &self.prior(), &self.noise) else { return };
        let determinant = |noise: &NoiseModel| -> Option<f64> {
            let runs = linears.iter().zip(self.timelines.iter());
            runs.map(|(linear, timeline)| gains_in_parts(linear, timeline, noise, EVENTS_HELD, &mut |_, _| {})).sum()
        };
        let mut without = self.noise.clone();
        unstated.iter().for_each(|k| without.input_sigma[*k] *= NO_FLOOR);
        let Some(none) = determinant(&without) else { return };
        let most = RECORD_INFLATION / unstated.len().max(1) as f64;
        let mut lowered = without.clone();
        for k in unstated {
            let mut noise = without.clone();
            noise.input_sigma[k] = self.noise.input_sigma[k];
            for _ in 0..LOWERINGS_MAX {
                let inflation = determinant(&noise).map_or(f64::INFINITY, |own| own - none);
                if inflation <= most {
                    break;
                }
                // of one component ln(1 + λ) is short of λ, which falls with the variance; of several
                // this goes further than it has to
                let share = most / libm::expm1(inflation.min(10.0));
                noise.input_sigma[k] *= share.sqrt().max(NO_FLOOR);
            }
            lowered.input_sigma[k] = noise.input_sigma[k].max(without.input_sigma[k]);
        }
        self.noise = lowered;
    }

    /// Per noise input of unspecified size, a share of the force that moves what it pushes:
    /// `Δv / Γ` along the filtered trajectory.
    pub(super) fn set_disturbance_priors(&mut self, unstated: &[usize]) {
        for factor in [1.0, 10.0, 100.0] {
            let mut open = self.noise.clone();
            unstated.iter().for_each(|k| open.input_sigma[*k] *= factor);
            let Ok(linears) = self.linearise(&self.problem.plant, &self.prior(), &open) else { continue };
            for k in unstated {
                let forces: Vec<f64> = linears.iter().flat_map(|linear| linear.forces(*k)).collect();
                let rms = (forces.iter().map(|f| f * f).sum::<f64>() / forces.len().max(1) as f64).sqrt();
                let least = FLOORS_LEAST * self.noise.input_sigma[*k];
                self.disturbance_sigma[*k] = (DISTURBANCE_SHARE * rms).max(least);
            }
            return;
        }
    }
}
