//! The linear model of a pass, by differences of its own functions.

use super::initial::{Start, response};
use super::jacobian::Along;
use super::propagator::{Mean, Propagator};
use super::recursion::Recursion;
use super::transition::Transitions;
use super::{Frozen, Linear, NoiseModel};
use crate::problem::Timeline;
use measurement::Scratch;

mod measurement;

impl Linear {
    /// Room for every event and sample of `propagator`'s run.
    fn empty(propagator: &Propagator<'_>, noise: &NoiseModel, initial_sigma: &[f64], start: &Start) -> Self {
        let layout = propagator.layout.clone();
        let (n, m, c) = (layout.tangent, layout.noise_inputs.len(), layout.clone);
        let events = propagator.timeline.events.len();
        let samples = propagator.timeline.value.len();
        Self {
            transition: vec![0.0; events * n * (n + m)],
            measurement: vec![0.0; samples * (n + m + c)],
            slope: vec![0.0; samples],
            decay: vec![f64::NAN; samples],
            initial_sigma: initial_sigma.to_vec(),
            start: start.change.clone(),
            pull: vec![0.0; samples],
            is_wide: start.sigma == initial_sigma,
            finer: propagator.finer,
            frozen: Frozen {
                rows: layout.len(),
                gain: Vec::with_capacity(samples * layout.len()),
                first: Vec::with_capacity(events),
            },
            factor: Vec::new(),
            nu: vec![0.0; samples],
            states: Vec::with_capacity(events * propagator.x0.len()),
            updated: Vec::with_capacity(events * propagator.x0.len()),
            held: Vec::with_capacity(events * m),
            held_updated: Vec::with_capacity(events * m),
            noise: NoiseModel {
                pole: vec![0.0; noise.pole.len()],
                jitter_s: vec![0.0; noise.pole.len()],
                ..noise.clone()
            },
            names: super::tangent_names(&propagator.system).into_iter().map(|(name, _)| name).collect(),
            input_names: layout.noise_inputs.iter().map(|i| propagator.system.inputs()[*i].name.clone()).collect(),
            state_names: propagator.system.states().iter().map(|state| state.name.clone()).collect(),
            layout,
        }
    }
}

/// Extended Kalman filter over a run with white noise, from `start`, which `propagator` is moved
/// to: its gains, innovations and linear model.
///
/// Cost: `tangent + inputs + clone + 1` readings an event, and as many flows, or a third of their
/// work (`Transitions`).
pub fn linearise(
    propagator: &mut Propagator<'_>,
    noise: &NoiseModel,
    initial_sigma: &[f64],
    start: &Start,
) -> Result<Linear, String> {
    propagator.begin(&start.change);
    pass(propagator, noise, initial_sigma, (start, None))
}

/// [`linearise`] by residuals at every event, where the plant has them.
///
/// Cost: a residual for each number of z at an event, two flows, and the recursion.
///
/// # Errors
/// Those of [`linearise`].
pub fn linearise_along(
    propagator: &mut Propagator<'_>,
    noise: &NoiseModel,
    initial_sigma: &[f64],
    start: &Start,
) -> Result<Linear, String> {
    propagator.begin(&start.change);
    let along = Along::of(propagator);
    pass(propagator, noise, initial_sigma, (start, along))
}

fn pass(
    propagator: &mut Propagator<'_>,
    noise: &NoiseModel,
    initial_sigma: &[f64],
    (start, mut along): (&Start, Option<Along>),
) -> Result<Linear, String> {
    let mut linear = Linear::empty(propagator, noise, initial_sigma, start);
    let (n, m) = (linear.layout.tangent, linear.layout.noise_inputs.len());
    let events = propagator.timeline.events.len();
    let mut update = Update::new(propagator, &linear, start);
    let mut mean = propagator.start();
    let mut transitions = Transitions::new(propagator);
    let (mut next_w, mut sigmas) = (vec![0.0; m], vec![0.0; n + m]);
    if along.is_some() {
        linear.factor.reserve_exact(propagator.timeline.events.iter().map(|event| event.count * event.count).sum());
    }
    for k in 0..events {
        let event = propagator.timeline.events[k];
        propagator.renew(k, &mut mean);
        if let (0, Some(along)) = (k, &mut along) {
            along.take(propagator, 0, &mean.x, &mean.w)?;
            along.begin_mean();
        }
        update.recursion.renew(&event, &linear.noise);
        linear.states.extend_from_slice(&mean.x);
        linear.held.extend_from_slice(&mean.w);
        linear.frozen.first.push(linear.frozen.gain.len());
        if event.count > 0 {
            update.take_up((propagator, along.as_ref()), k, &mut mean, &mut linear)?;
        }
        linear.updated.extend_from_slice(&mean.x);
        linear.held_updated.extend_from_slice(&mean.w);
        propagator.begin_mean(k, &mut mean);
        if event.begins_mean {
            update.recursion.begin_mean();
            along.iter_mut().for_each(Along::begin_mean);
        }
        if k + 1 < events {
            let transition = &mut linear.transition[k * n * (n + m)..(k + 1) * n * (n + m)];
            update.recursion.write_sigmas(&mut sigmas);
            if let Some(along) = &mut along {
                along.begin(propagator, k, &mean.x, &mean.w);
                let end = transitions.arrive(propagator, k, &mean);
                next_w.copy_from_slice(&mean.w);
                propagator.renew_noise(k + 1, &mut next_w);
                along.take(propagator, k + 1, end, &next_w)?;
                transitions.write_by(propagator, k, &mut mean, (&sigmas, &along.between), transition);
            } else {
                transitions.write(propagator, k, &mut mean, &sigmas, transition);
            }
            update.recursion.propagate(transition);
        }
    }
    linear.slope = slopes(&linear.nu, &update.corrected_by, propagator.timeline);
    if start.change.iter().any(|change| *change != 0.0) {
        linear.pull = response(&linear, propagator.timeline, &start.change);
        linear.nu.iter_mut().zip(&linear.pull).for_each(|(nu, pull)| *nu += pull);
    }
    Ok(linear)
}

/// Updates of the filter, event by event.
struct Update {
    recursion: Recursion<Vec<f64>>,
    scratch: Scratch,
    predicted: Vec<f64>,
    change: Vec<f64>,
    /// When every lagging channel was last read \[s\].
    read_s: Vec<f64>,
    /// Of every sample what the update of its event made of its own prediction.
    corrected_by: Vec<f64>,
}

impl Update {
    fn new(propagator: &Propagator<'_>, linear: &Linear, start: &Start) -> Self {
        let channels = linear.noise.sensor_sigma.len();
        Self {
            recursion: Recursion::new(&linear.layout, &start.sigma),
            scratch: Scratch::new(propagator),
            predicted: vec![0.0; channels],
            change: vec![0.0; linear.layout.len()],
            read_s: vec![f64::NAN; channels],
            corrected_by: vec![0.0; propagator.timeline.value.len()],
        }
    }

    /// The samples of event `k`: rows of measurement, gains and innovations join `linear`, `mean`
    /// is corrected.
    fn take_up(
        &mut self,
        (propagator, along): (&mut Propagator<'_>, Option<&Along>),
        k: usize,
        mean: &mut Mean,
        linear: &mut Linear,
    ) -> Result<(), String> {
        let event = propagator.timeline.events[k];
        let samples = event.first..event.first + event.count;
        let row_len = linear.row_len();
        let out = &mut linear.measurement[event.first * row_len..];
        match along {
            Some(along) => self.scratch.measurement_along(propagator, (k, along), mean, out),
            None => self.scratch.measurement(propagator, k, mean, out),
        }
        self.decays(propagator, k, linear);
        propagator.predict(k, mean, &mut self.predicted);
        let rows = &linear.measurement[samples.start * row_len..samples.end * row_len];
        let channels = &propagator.timeline.channel[samples.clone()];
        let (decay, slope) = (&linear.decay[samples.clone()], &linear.slope[samples.clone()]);
        if !self.recursion.update(&linear.noise, channels, rows, (decay, slope)) {
            return Err(format!("the filter's covariance is not positive at {} s", event.t_s));
        }
        linear.frozen.gain.extend_from_slice(&self.recursion.gain);
        if along.is_some() {
            linear.factor.extend_from_slice(&self.recursion.factor);
        }
        self.change.fill(0.0);
        for (slot, predicted) in self.predicted.iter().enumerate().take(event.count) {
            let innovation = propagator.timeline.value[event.first + slot] - predicted;
            linear.nu[event.first + slot] = innovation;
            for (row, change) in self.change.iter_mut().enumerate() {
                *change += self.recursion.gain[row * event.count + slot] * innovation;
            }
        }
        if !self.change.iter().all(|c| c.abs() < 1e9) {
            return Err(format!("the filtered state runs away at {} s", event.t_s));
        }
        for (row, sample) in rows.chunks_exact(row_len.max(1)).zip(samples) {
            self.corrected_by[sample] = match linear.layout.lag_of[propagator.timeline.channel[sample]] {
                Some(lag) => self.change[linear.layout.lags_at() + lag],
                None => linear.layout.places(row).map(|(place, h)| h * self.change[place]).sum(),
            };
        }
        propagator.correct(mean, &self.change);
        Ok(())
    }

    /// Shares of their old output that lagging channels of event `k` keep.
    fn decays(&mut self, propagator: &Propagator<'_>, k: usize, linear: &mut Linear) {
        let event = propagator.timeline.events[k];
        for sample in event.first..event.first + event.count {
            let channel = propagator.timeline.channel[sample];
            if linear.layout.lag_of[channel].is_some() {
                let since = event.t_s - self.read_s[channel];
                linear.decay[sample] = if since > 0.0 { propagator.lag_decay(channel, since) } else { 0.0 };
                self.read_s[channel] = event.t_s;
            }
        }
    }
}

/// Rates of change of the predicted readings, from the rates over the last two intervals of the
/// same channel, each since what was filtered then: none of the innovation that a slope stands
/// beside is in it, or whatever depends on a slope would explain noise by itself.
fn slopes(nu: &[f64], corrected_by: &[f64], timeline: &Timeline) -> Vec<f64> {
    let mut slope = vec![0.0; nu.len()];
    for channel in 0..timeline.channel.iter().max().map_or(0, |last| last + 1) {
        let own: Vec<usize> = (0..nu.len()).filter(|i| timeline.channel[*i] == channel).collect();
        let predicted = |i: usize| timeline.value[i] - nu[i];
        let mut last: Option<(f64, f64)> = None;
        for pair in own.windows(2) {
            let dt_s = timeline.stamp_s[pair[1]] - timeline.stamp_s[pair[0]];
            if dt_s <= 0.0 {
                continue;
            }
            // over the interval, which is its middle's
            let over = (predicted(pair[1]) - (predicted(pair[0]) + corrected_by[pair[0]])) / dt_s;
            let change = last.map_or(0.0, |(before, before_s)| (over - before) / (0.5 * (dt_s + before_s)));
            slope[pair[1]] = over + 0.5 * dt_s * change;
            last = Some((over, dt_s));
        }
        if let [first, second, ..] = own[..] {
            slope[first] = slope[second];
        }
    }
    slope
}
