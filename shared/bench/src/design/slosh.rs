//! Bursts of thrust with the least bound of the slosh parameters, within thrust, stroke, impulse
//! and time.
//!
//! Whole cycles of a square wave near the expected mode, once or repeated, then coasting: unlike a
//! sine, that tells thrust scale, bias and start from the tank. The grid is small and searched
//! completely; the amplitude is the greatest that all limits allow, for every bound falls with it.
//! The result is a plant file that the simulator takes, and a scenario that flies it.

use crate::plants;
use crate::slosh::{Slosh, expected};
use nalgebra::Vector3;
use physics::slosh_estimator::SloshSettings;
use physics::slosh_likelihood::{SloshHypothesis, SloshUnknowns};
use physics::slosh_plan::{PlannedStep, promise, stroke_m};
use plant_file::FileError;
use std::fmt::Write;

/// Amplitude of the paper's thrust.
const PAPER_THRUST_N: f64 = 44.0;
/// Of the accelerometer in the scenario: that of the built-in tank.
const SCENARIO_INTERVAL_S: f64 = 0.1;
/// Blocks of the planned arc.
const CAPACITY: usize = 4096;
const CYCLES: [u32; 5] = [1, 2, 3, 4, 6];
const REPEATS_S: [f64; 6] = [300.0, 450.0, 600.0, 900.0, 1800.0, f64::INFINITY];
const DETUNINGS: [f64; 5] = [0.9, 0.95, 1.0, 1.05, 1.1];

/// What the hardware allows, and the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustLimits {
    pub thrust_max_n: f64,
    /// Displacement of the slosh mass.
    pub stroke_max_m: f64,
    /// Integral of |thrust|.
    pub impulse_max_n_s: f64,
    /// Length of the record.
    pub duration_s: f64,
    /// Velocity random walk of the accelerometer.
    pub vrw_m_s_sqrt_h: f64,
}

/// One burst record of unit amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    cycles: u32,
    cycle_s: f64,
    repeat_s: f64,
}

impl Shape {
    fn length_s(&self) -> f64 {
        f64::from(self.cycles) * self.cycle_s
    }

    /// Beginnings of the bursts that end within the record.
    fn begins_s(&self, duration_s: f64) -> Vec<f64> {
        let mut begins = vec![0.0];
        while self.repeat_s.is_finite() {
            let next = begins.len() as f64 * self.repeat_s;
            if next + self.length_s() > duration_s {
                break;
            }
            begins.push(next);
        }
        begins
    }

    fn force_n(&self, time_s: f64, duration_s: f64) -> f64 {
        let since = if self.repeat_s.is_finite() { time_s % self.repeat_s } else { time_s };
        if since >= self.length_s() || time_s - since + self.length_s() > duration_s {
            return 0.0;
        }
        if since % self.cycle_s < self.cycle_s / 2.0 { 1.0 } else { -1.0 }
    }
}

/// A shape at the amplitude the limits allow.
pub struct Candidate {
    shape: Shape,
    amplitude_n: f64,
    stroke_m: f64,
    impulse_n_s: f64,
    sigma: Vector3<f64>,
}

/// What is expected and what is known of the sensors.
pub struct Task {
    limits: ThrustLimits,
    hypothesis: SloshHypothesis,
    settings: SloshSettings,
    step: PlannedStep,
    truth: Vector3<f64>,
}

impl Task {
    /// The benchmark's tank, start, bias and thrust scale unknown; steps of a second in records
    /// above 2000 s, else of half.
    pub fn new(limits: ThrustLimits) -> Self {
        let (hypothesis, base_mass_kg) = expected(&Slosh::bp2());
        let interval_s = if limits.duration_s > 2000.0 { 1.0 } else { 0.5 };
        Self::of(limits, hypothesis, base_mass_kg, interval_s)
    }

    fn of(limits: ThrustLimits, hypothesis: SloshHypothesis, base_mass_kg: f64, interval_s: f64) -> Self {
        let parameters = hypothesis.parameters;
        Self {
            limits,
            hypothesis,
            settings: SloshSettings { base_mass_kg, unknowns: SloshUnknowns::ParametersStateBiasScale },
            step: PlannedStep { interval_s, sigma_m_s2: limits.vrw_m_s_sqrt_h / 60.0 / interval_s.sqrt() },
            truth: Vector3::new(parameters.slosh_mass_kg, parameters.stiffness_n_m, parameters.damping_n_s_m),
        }
    }

    fn forces<'a>(&'a self, force: impl Fn(f64) -> f64 + 'a) -> impl Iterator<Item = f64> + 'a {
        let dt = self.step.interval_s;
        (0..(self.limits.duration_s / dt).round() as u64).map(move |k| force((k as f64 + 0.5) * dt))
    }

    /// The greatest amplitude within the limits, what it moves and costs, and the bound.
    fn judge(&self, unit: &dyn Fn(f64) -> f64) -> Option<(f64, f64, f64, Vector3<f64>)> {
        let (dt, limits) = (self.step.interval_s, self.limits);
        let base_mass_kg = self.settings.base_mass_kg;
        let stroke = stroke_m(&self.hypothesis, base_mass_kg, dt, self.forces(unit));
        let impulse: f64 = self.forces(unit).map(|force| force.abs() * dt).sum();
        let amplitude_n = limits.thrust_max_n.min(limits.stroke_max_m / stroke).min(limits.impulse_max_n_s / impulse);
        let forces = self.forces(move |t| amplitude_n * unit(t));
        let sigma = promise::<CAPACITY>(&self.hypothesis, &self.settings, self.step, forces)?;
        Some((amplitude_n, amplitude_n * stroke, amplitude_n * impulse, sigma))
    }

    /// Sum of the squares of the relative bounds: what is least known counts most.
    fn score(&self, sigma: &Vector3<f64>) -> f64 {
        sigma.component_div(&self.truth).norm_squared()
    }

    /// The best shape of the grid; `None`: no burst fits the record.
    pub fn best(&self) -> Option<Candidate> {
        let period_s = 1.0 / self.hypothesis.parameters.natural_frequency_hz(self.settings.base_mass_kg);
        let mut best: Option<Candidate> = None;
        for cycles in CYCLES {
            for repeat_s in REPEATS_S {
                for detuning in DETUNINGS {
                    // Edges on whole steps.
                    let half_s = (period_s * detuning / 2.0 / self.step.interval_s).round() * self.step.interval_s;
                    let shape = Shape { cycles, cycle_s: 2.0 * half_s, repeat_s };
                    if shape.length_s() > self.limits.duration_s.min(repeat_s) {
                        continue;
                    }
                    let force = move |t: f64| shape.force_n(t, self.limits.duration_s);
                    let Some((amplitude_n, stroke_m, impulse_n_s, sigma)) = self.judge(&force) else { continue };
                    if best.as_ref().is_none_or(|best| self.score(&sigma) < self.score(&best.sigma)) {
                        best = Some(Candidate { shape, amplitude_n, stroke_m, impulse_n_s, sigma });
                    }
                }
            }
        }
        best
    }

    fn line(&self, name: &str, judged: (f64, f64, f64, &Vector3<f64>)) -> String {
        let (amplitude, stroke, impulse, sigma) = judged;
        let percent = sigma.component_div(&self.truth) * 100.0;
        format!(
            "{name:<34} {amplitude:>10.4} {stroke:>9.3} {impulse:>11.1} {:>9.3} {:>9.3} {:>9.3}\n",
            percent[0], percent[1], percent[2]
        )
    }
}

/// A scenario that flies the designed plant: it states no thrust, so that the plant's own is flown.
pub fn scenario_text(task: &Task, plant: &str) -> String {
    let ThrustLimits { duration_s, vrw_m_s_sqrt_h, .. } = task.limits;
    let [m_s, k_s, c_s] = task.truth.into();
    format!(
        "# Thrust for slosh, as 'obsid design slosh' found it.
format = 1
name = \"designed-slosh\"
seed = 1

[slosh]
duration_s = {duration_s:.1}
plant = {{ file = {plant} }}

[slosh.known]
m_0_kg = {}
interval_s = {SCENARIO_INTERVAL_S}
accelerometer_vrw_m_s_sqrt_h = {vrw_m_s_sqrt_h}
expected = [{m_s}, {k_s}, {c_s}]
",
        task.settings.base_mass_kg
    )
}

/// The best burst beside the paper's sine, for a reader.
pub fn table(task: &Task, best: &Candidate) -> String {
    let Shape { cycles, cycle_s, repeat_s } = best.shape;
    let name = match repeat_s.is_finite() {
        true => format!("{cycles} cycle(s) of {cycle_s:.1} s every {repeat_s:.0} s"),
        false => format!("{cycles} cycle(s) of {cycle_s:.1} s, once"),
    };
    let mut text = format!(
        "{:<34} {:>10} {:>9} {:>11} {:>9} {:>9} {:>9}\n",
        "", "thrust N", "stroke m", "impulse N s", "m_s %", "k_s %", "c_s %"
    );
    text += &task.line(&name, (best.amplitude_n, best.stroke_m, best.impulse_n_s, &best.sigma));
    let sine = |t: f64| (std::f64::consts::TAU * 0.01 * t).sin();
    if let Some((amplitude, stroke, impulse, sigma)) = task.judge(&sine) {
        text += &task.line("sine of 0.01 Hz (paper), same limits", (amplitude, stroke, impulse, &sigma));
        let _ = writeln!(
            text,
            "The paper's {PAPER_THRUST_N} N would move the slosh mass {:.0} m.",
            stroke * PAPER_THRUST_N / amplitude
        );
    }
    let _ = writeln!(
        text,
        "\nBounds of one sigma with start, bias and thrust scale unknown, {:.0} s, {} (m/s)/sqrt(h).",
        task.limits.duration_s, task.limits.vrw_m_s_sqrt_h
    );
    text
}

/// The built-in tank under the new thrust.
///
/// # Errors
/// What a reader of plant files has against it.
pub fn plant_text(best: &Candidate, limits: &ThrustLimits) -> Result<String, Vec<FileError>> {
    let text = plants::built_in("tank_1d").expect("the benchmarks' plants are built in");
    let terms: Vec<String> = best
        .shape
        .begins_s(limits.duration_s)
        .into_iter()
        .map(|begin_s| {
            format!(
                "    {{ kind = \"square\", amplitude = \"{} N\", frequency = \"{} Hz\", begin = \"{begin_s} s\", end = \"{} s\" }},\n",
                best.amplitude_n,
                1.0 / best.shape.cycle_s,
                begin_s + best.shape.length_s()
            )
        })
        .collect();
    let written: String = text
        .lines()
        .map(|line| match line {
            line if line.starts_with("command = ") => format!("command = [\n{}]\n", terms.concat()),
            line if line.starts_with("duration = ") => format!("duration = \"{} s\"\n", limits.duration_s),
            line if line.starts_with("noise = ") => format!("noise = \"{} m/s/sqrt(h)\"\n", limits.vrw_m_s_sqrt_h),
            line => format!("{line}\n"),
        })
        .collect();
    plant_file::parse("designed thrust", &written)?;
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ThrustLimits = ThrustLimits {
        thrust_max_n: 44.0,
        stroke_max_m: 0.5,
        impulse_max_n_s: f64::INFINITY,
        duration_s: 1200.0,
        vrw_m_s_sqrt_h: 0.008,
    };

    fn designed(limits: ThrustLimits) -> Candidate {
        let (hypothesis, base_mass_kg) = expected(&Slosh::bp2());
        Task::of(limits, hypothesis, base_mass_kg, 2.0).best().expect("a burst fits")
    }

    #[test]
    fn a_design_keeps_the_limit_that_binds() {
        let by_stroke = designed(LIMITS);
        assert!((by_stroke.stroke_m - 0.5).abs() < 1e-9 && by_stroke.amplitude_n < 44.0); // linear: rounding
        let by_impulse = designed(ThrustLimits { impulse_max_n_s: 10.0, ..LIMITS });
        assert!((by_impulse.impulse_n_s - 10.0).abs() < 1e-9 && by_impulse.stroke_m < 0.5);
        let by_thrust = designed(ThrustLimits { stroke_max_m: 1e3, ..LIMITS });
        assert!((by_thrust.amplitude_n - 44.0).abs() < 1e-12);
    }

    #[test]
    fn the_designed_plant_is_one() {
        let text = plant_text(&designed(LIMITS), &LIMITS).map_err(|_| ()).expect("readable");
        assert!(text.contains("square") && text.contains("duration = \"1200 s\""));
    }
}
