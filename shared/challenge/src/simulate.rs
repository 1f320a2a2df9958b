//! The true signals of a recording: sampled inputs, closed loops, sensors with their faults, at
//! exact sampling instants.
//!
//! A command is held from its instant on; the samples of an instant see the command that begins
//! there. Noise comes in as lists, so that the same experiment can be run with and without it.

use crate::equations::Numbers;
use crate::motion::{Motion, Rig};

/// Source of the inputs.
#[derive(Clone, Debug)]
pub enum Command {
    /// Per input, per period.
    Held(Vec<Vec<f64>>),
    Loop(Loop),
}

/// A sampled controller on input 0: `u = kp (r − y_p) + kd (r' − y_r)`.
#[derive(Clone, Debug)]
pub struct Loop {
    pub kp: f64,
    pub kd: f64,
    pub position_sensor: usize,
    pub rate_sensor: Option<usize>,
    /// Amplitude, frequency \[Hz\], phase \[rad\].
    pub sines: Vec<[f64; 3]>,
}

impl Loop {
    /// Reference and its rate.
    #[must_use]
    pub fn reference(&self, t_s: f64) -> (f64, f64) {
        let tau = core::f64::consts::TAU;
        let value = self.sines.iter().map(|[a, f, p]| a * libm::sin(tau * f * t_s + p)).sum();
        let rate = self.sines.iter().map(|[a, f, p]| a * tau * f * libm::cos(tau * f * t_s + p)).sum();
        (value, rate)
    }
}

/// One experiment with its noise.
#[derive(Clone, Debug)]
pub struct Experiment {
    pub period_s: f64,
    pub samples: usize,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub command: Command,
    /// Per input, per period: the acting value minus the command. Empty: zero.
    pub input_noise: Vec<Vec<f64>>,
    /// Per sensor, per sample. Empty: zero.
    pub sensor_noise: Vec<Vec<f64>>,
    /// Per sensor: quantisation step; zero: no quantisation.
    pub resolution: Vec<f64>,
}

/// The recorded signals.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Per sensor, as recorded.
    pub measured: Vec<Vec<f64>>,
    /// Per input, as recorded.
    pub command: Vec<Vec<f64>>,
}

/// Runs `experiment` on `rig`; `names` are those of the sensors, `numbers` has their biases and
/// scales.
#[must_use]
pub fn simulate(rig: &Rig, numbers: &Numbers, names: &[String], experiment: &Experiment) -> Trace {
    let (sensors, inputs) = (names.len(), rig.faults.inputs.len());
    let mut trace = Trace { measured: vec![Vec::new(); sensors], command: vec![Vec::new(); inputs] };
    let mut motion = rig.begin(&experiment.q, &experiment.v);
    let scale_and_bias =
        |name: &String| [numbers.or_zero(&format!("{name}.scale")), numbers.or_zero(&format!("{name}.bias"))];
    let own: Vec<[f64; 2]> = names.iter().map(scale_and_bias).collect();
    // readings of the delayed sensors at the instants they belong to
    let mut late: Vec<Option<f64>> = vec![None; sensors];
    for k in 0..experiment.samples {
        let t_s = k as f64 * experiment.period_s;
        let before = effective(rig, &trace.command, experiment, k, 0.0);
        if let Command::Held(held) = &experiment.command {
            trace.command.iter_mut().zip(held).for_each(|(list, held)| list.push(held[k]));
        }
        let tell = |s: usize, truth: f64| finish(rig, experiment, own[s], s, k, t_s, truth);
        if let Command::Loop(closed) = &experiment.command {
            // what is fed back does not see the command of its own instant
            let y = rig.read(&motion, &before);
            let feedback = |s: usize| tell(s, lagged(rig, &motion, s, late[s].unwrap_or(y[s])));
            let (r, rate) = closed.reference(t_s);
            let mut u = closed.kp * (r - feedback(closed.position_sensor));
            u += closed.rate_sensor.map_or(0.0, |s| closed.kd * (rate - feedback(s)));
            trace.command[0].push(u);
        }
        let now = effective(rig, &trace.command, experiment, k, 0.0);
        let truth = rig.read(&motion, &now);
        if k == 0 {
            settle_lags(rig, &mut motion, &truth);
        }
        let begin = rig.coordinates(&motion.x);
        let instants: Vec<f64> = (0..sensors).map(|s| lagged(rig, &motion, s, late[s].unwrap_or(truth[s]))).collect();
        late = period(rig, &mut motion, &trace.command, experiment, k);
        let end = rig.coordinates(&motion.x);
        let mean = rig.equations.read_mean((&begin.0, &begin.1), (&end.0, &end.1), experiment.period_s);
        let truth = mean.unwrap_or(instants);
        for (s, list) in trace.measured.iter_mut().enumerate() {
            list.push(tell(s, truth[s]));
        }
    }
    trace
}

fn lagged(rig: &Rig, motion: &Motion, sensor: usize, truth: f64) -> f64 {
    let lag = rig.faults.sensors[sensor].lag_s > 0.0;
    if lag { motion.x[rig.places().sensors + sensor] } else { truth }
}

fn settle_lags(rig: &Rig, motion: &mut Motion, truth: &[f64]) {
    let at = rig.places().sensors;
    motion.x[at..at + truth.len()].copy_from_slice(truth);
}

/// Faults, scale, bias, noise, quantisation.
fn finish(
    rig: &Rig,
    experiment: &Experiment,
    [scale, bias]: [f64; 2],
    s: usize,
    k: usize,
    t_s: f64,
    truth: f64,
) -> f64 {
    let mut y = rig.faults.sensors[s].reading(t_s, truth * (1.0 + scale) + bias);
    y += experiment.sensor_noise.get(s).map_or(0.0, |list| list[k]);
    let step = experiment.resolution.get(s).copied().unwrap_or(0.0);
    if step > 0.0 { step * libm::round(y / step) } else { y }
}

/// Acting inputs at `offset_s` into period `k`: delayed, mapped, with their noise. Lags belong to
/// the motion.
fn effective(rig: &Rig, commands: &[Vec<f64>], experiment: &Experiment, k: usize, offset_s: f64) -> Vec<f64> {
    let act = |(j, fault): (usize, &crate::hidden::InputFault)| {
        let back = libm::ceil((fault.delay_s - offset_s) / experiment.period_s - 1e-9).max(0.0) as usize;
        let command = k.checked_sub(back).and_then(|at| commands[j].get(at).copied());
        let noise = experiment.input_noise.get(j).map_or(0.0, |list| list[k]);
        fault.acting(command.unwrap_or(0.0)) + noise
    };
    rig.faults.inputs.iter().enumerate().map(act).collect()
}

/// Moves over period `k`, stopping where a delayed command switches and where a delayed sensor
/// reads; returns its readings.
fn period(
    rig: &Rig,
    motion: &mut Motion,
    commands: &[Vec<f64>],
    experiment: &Experiment,
    k: usize,
) -> Vec<Option<f64>> {
    let dt = experiment.period_s;
    let mut stops: Vec<(f64, Option<usize>)> = vec![(dt, None)];
    for fault in rig.faults.inputs.iter().filter(|fault| fault.delay_s > 0.0) {
        let rest = fault.delay_s - dt * libm::floor(fault.delay_s / dt);
        stops.push((rest, None));
    }
    for (s, fault) in rig.faults.sensors.iter().enumerate().filter(|(_, fault)| fault.delay_s > 0.0) {
        stops.push((dt - fault.delay_s.min(0.999 * dt), Some(s)));
    }
    stops.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut late = vec![None; rig.faults.sensors.len()];
    let mut at = 0.0;
    for (stop, sensor) in stops {
        let u = effective(rig, commands, experiment, k, at + 1e-9 * dt);
        if stop - at > 1e-9 * dt {
            rig.advance(motion, &u, stop - at);
            at = stop;
        }
        if let Some(s) = sensor {
            late[s] = Some(rig.read(motion, &u)[s]);
        }
    }
    late
}
