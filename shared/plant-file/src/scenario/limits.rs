//! Limits of a scenario in this build: signs, orders, names and sizes, beyond numbers that no
//! system can have.
//!
//! Each limit stands for something that would end in a panic, a run without end or a number without
//! meaning; a
//! scenario is rejected before anything is started.

use super::impossible::Impossible;
use super::{
    AppendageKnown, ArcExperiment, ArmExperiment, ArmKnown, CraftPlan, ModalExperiment, Need, Scenario, SloshExperiment,
};
use std::ops::RangeInclusive;
use telemetry::{ACCELEROMETERS_MAX, ARCS_MAX, BATCH_MAX, Domain, TOPICS};

/// Longest experiment [s]: 116 days are 1e9 frames.
const DURATION_MAX_S: f64 = 1e7;
/// Largest number of any kind: its fourth power is far from the end of f64.
const NUMBER_MAX: f64 = 1e12;

/// Everything in `scenario` that lies beyond a limit.
#[must_use]
pub fn beyond(scenario: &Scenario) -> Vec<Impossible> {
    let mut limits = Limits(Vec::new());
    let period_s = scenario.frame_period_ms as f64 * 1e-3;
    limits.window(scenario.window_frames);
    if let Some(modal) = &scenario.modal {
        limits.modal(modal, period_s);
    }
    if let Some(slosh) = &scenario.slosh {
        limits.slosh(slosh, period_s);
    }
    for (name, arm) in [("inertial", &scenario.inertial), ("mated", &scenario.mated)] {
        if let Some(arm) = arm {
            limits.arm(name, arm);
        }
    }
    if let Some(craft) = &scenario.craft {
        let benchmark = scenario.modal.is_some() || scenario.slosh.is_some() || scenario.inertial.is_some();
        let why = "one craft flies all arcs: take out [modal], [slosh], [inertial] and [mated]";
        limits.unless(!benchmark && scenario.mated.is_none(), "craft", &"stated", why);
        limits.craft(craft, period_s);
    }
    let capture = &scenario.capture;
    limits.within("capture.settle_s", capture.settle_s, 0.0..=DURATION_MAX_S);
    limits.within("capture.contact_timeout_s", capture.contact_timeout_s, 0.0..=DURATION_MAX_S);
    limits.within("capture.model_age_limit_s", capture.model_age_limit_s, 0.0..=DURATION_MAX_S);
    let rate = capture.base_rate_limit_rad_s;
    limits.unless(rate > 0.0 || !rate.is_finite(), "capture.base_rate_limit_rad_s", &rate, "must be above 0");
    limits.0
}

struct Limits(Vec<Impossible>);

impl Limits {
    fn unless(&mut self, good: bool, key: &str, value: &dyn std::fmt::Display, why: &str) {
        if !good {
            self.0.push(Impossible { key: key.into(), value: value.to_string(), why: why.into() });
        }
    }

    /// Values that are not finite are named elsewhere.
    fn within(&mut self, key: &str, value: f64, range: RangeInclusive<f64>) {
        let why = format!("must be {} to {}", range.start(), range.end());
        self.unless(!value.is_finite() || range.contains(&value), key, &format!("{value:?}"), &why);
    }

    /// The same for what is named nowhere else: a value that is not finite is rejected.
    fn within_and_finite(&mut self, key: &str, value: f64, range: RangeInclusive<f64>) {
        let why = format!("must be {} to {}", range.start(), range.end());
        self.unless(range.contains(&value), key, &format!("{value:?}"), &why);
    }

    fn window(&mut self, frames: u64) {
        let carried = TOPICS.iter().filter(|topic| topic.per_frame > 0);
        let most = carried.map(|topic| topic.depth as u64 / 2 / topic.per_frame as u64).min().unwrap_or(1);
        let why = format!("the topics' buffers hold at most {most} frames");
        self.unless(frames <= most, "window_frames", &frames, &why);
    }

    fn modal(&mut self, modal: &ModalExperiment, period_s: f64) {
        self.within("modal.duration_s", modal.duration_s, 0.0..=DURATION_MAX_S);
        self.within("modal.torque_nm", modal.torque_nm, -NUMBER_MAX..=NUMBER_MAX);
        self.within("modal.pulse_s", modal.pulse_s, 0.0..=DURATION_MAX_S);
        let known = &modal.known;
        self.within("modal.known.rate_hz", known.rate_hz, 0.0..=NUMBER_MAX);
        if modal.plant.is_some() && known.rate_hz > 0.0 {
            let rows = known.rate_hz * period_s;
            let whole = (rows - rows.round()).abs() < 1e-9 && (1.0..=BATCH_MAX as f64).contains(&rows);
            let why = format!("a frame of {period_s} s must bring a whole number of rows, 1 to {BATCH_MAX}");
            self.unless(whole, "modal.known.rate_hz", &known.rate_hz, &why);
        }
        if let Some([low, high]) = known.band_hz {
            let text = format!("[{low}, {high}]");
            self.unless(0.0 <= low && low < high, "modal.known.band_hz", &text, "must rise, from 0 or above");
        }
        for channel in &known.channels {
            let why = format!("channels are numbered from 1 to {ACCELEROMETERS_MAX}");
            self.unless((1..=ACCELEROMETERS_MAX).contains(channel), "modal.known.channels", channel, &why);
        }
        for [frequency_hz, damping] in &known.expected {
            let text = format!("[{frequency_hz}, {damping}]");
            let good = *frequency_hz > 0.0 && (0.0..1.0).contains(damping);
            self.unless(good, "modal.known.expected", &text, "needs a frequency above 0 and a damping ratio of 0 to 1");
        }
        self.within("modal.known.expected_amplitude_m_s2", known.expected_amplitude_m_s2, 0.0..=NUMBER_MAX);
        if let Some(appendage) = &known.appendage {
            self.appendage(appendage);
        }
        self.need("modal", Domain::Modal, &modal.need);
    }

    fn appendage(&mut self, known: &AppendageKnown) {
        let key = |key: &str| format!("modal.known.appendage.{key}");
        let taken: f64 = known.coupling_sqrt_kg_m.iter().map(|c| c * c).sum();
        let why = format!(
            "must be above {taken}, which the modes take along (the squares of their couplings), and at most {NUMBER_MAX:e}"
        );
        let good = known.inertia_kg_m2 > taken && known.inertia_kg_m2 <= NUMBER_MAX;
        self.unless(good, &key("inertia_kg_m2"), &known.inertia_kg_m2, &why);
        self.within_and_finite(&key("inertia_relative_sd"), known.inertia_relative_sd, 0.0..=1.0);
        self.within_and_finite(&key("coupling_relative_sd"), known.coupling_relative_sd, 0.0..=1.0);
        for angle in known.arm_angle_rad.iter().flatten() {
            self.within_and_finite(&key("arm_angle_rad"), *angle, -NUMBER_MAX..=NUMBER_MAX);
        }
        for [frequency_hz, damping] in &known.locked {
            let text = format!("[{frequency_hz}, {damping}]");
            let good = *frequency_hz > 0.0 && *frequency_hz <= NUMBER_MAX && *damping > 0.0 && *damping < 1.0;
            self.unless(good, &key("locked"), &text, "needs a frequency above 0 and a damping ratio between 0 and 1");
        }
    }

    fn slosh(&mut self, slosh: &SloshExperiment, period_s: f64) {
        self.within("slosh.duration_s", slosh.duration_s, 0.0..=DURATION_MAX_S);
        self.within("slosh.force_amplitude_n", slosh.force_amplitude_n, -NUMBER_MAX..=NUMBER_MAX);
        self.within("slosh.force_frequency_hz", slosh.force_frequency_hz, 0.0..=NUMBER_MAX);
        let known = &slosh.known;
        self.within("slosh.known.m_0_kg", known.m_0_kg, 0.0..=NUMBER_MAX);
        for number in known.expected.iter().flatten() {
            let good = *number > 0.0 && *number <= NUMBER_MAX;
            self.unless(good, "slosh.known.expected", number, "mass, stiffness and damping must be above 0");
        }
        for number in known.expected_sigma.iter().flatten() {
            let good = *number > 0.0 && *number <= NUMBER_MAX;
            self.unless(good, "slosh.known.expected_sigma", number, "standard deviations must be above 0");
        }
        if slosh.plant.is_some() {
            let frames = known.interval_s / period_s;
            let whole = frames >= 0.999_999 && (frames - frames.round()).abs() < 1e-6;
            let why = format!("must be a whole number of frames of {period_s} s");
            self.unless(whole, "slosh.known.interval_s", &known.interval_s, &why);
        }
        self.need("slosh", Domain::Slosh, &slosh.need);
    }

    fn arm(&mut self, name: &str, arm: &ArmExperiment) {
        let key = |key: &str| format!("{name}.{key}");
        self.within(&key("duration_s"), arm.duration_s, 0.0..=DURATION_MAX_S);
        let known = &arm.known;
        self.within(&key("known.h_cm_nms"), known.h_cm_nms, -NUMBER_MAX..=NUMBER_MAX);
        self.within(&key("known.h_cm_sigma_nms"), known.h_cm_sigma_nms, 0.0..=NUMBER_MAX);
        self.within(&key("known.joint_rate_sigma_rad_s"), known.joint_rate_sigma_rad_s, 0.0..=NUMBER_MAX);
        self.within(&key("known.joint_angle_sigma_rad"), known.joint_angle_sigma_rad, 0.0..=NUMBER_MAX);
        self.within(&key("known.gyro_arw_deg_sqrt_h"), known.gyro_arw_deg_sqrt_h, 0.0..=NUMBER_MAX);
        let torque = known.joint_torque_sigma_nm.unwrap_or(1.0);
        self.unless(
            torque > 0.0 && torque <= NUMBER_MAX,
            &key("known.joint_torque_sigma_nm"),
            &torque,
            "must be above 0",
        );
        self.within_and_finite(
            &key("known.joint_torque_scale_sigma"),
            known.joint_torque_scale_sigma,
            0.0..=NUMBER_MAX,
        );
        let prior = known.prior_relative_sd.unwrap_or(1.0);
        self.unless(prior > 0.0 && prior <= NUMBER_MAX, &key("known.prior_relative_sd"), &prior, "must be above 0");
        self.sheets(&key("known"), known);
        for number in &known.prior {
            self.within(&key("known.prior"), *number, -NUMBER_MAX..=NUMBER_MAX);
        }
        self.need(name, Domain::Inertial, &arm.need);
    }

    fn craft(&mut self, craft: &CraftPlan, frame_s: f64) {
        let count = craft.arcs.len();
        let why = format!("a craft flies 1 to {ARCS_MAX} arcs");
        self.unless((1..=ARCS_MAX).contains(&count), "craft.arc", &count, &why);
        let held_out = craft.arcs.iter().filter(|arc| arc.experiment == ArcExperiment::HeldOut).count();
        self.unless(held_out <= 1, "craft.arc", &held_out, "one arc at most is held out");
        for (k, arc) in craft.arcs.iter().enumerate() {
            let key = |key: &str| format!("craft.arc.{k}.{key}");
            let again = craft.arcs[..k].iter().any(|other| other.name == arc.name);
            self.unless(!again && !arc.name.is_empty(), &key("name"), &arc.name, "each arc needs a name of its own");
            self.within_and_finite(&key("duration_s"), arc.duration_s, frame_s..=DURATION_MAX_S);
            let frames = arc.period_ms.map(|period_ms| period_ms as f64 * 1e-3 / frame_s);
            let whole = frames.is_none_or(|frames| frames > 0.5 && (frames - frames.round()).abs() < 1e-9);
            let why = format!("must be a whole number of frames of {frame_s} s");
            self.unless(whole, &key("period_ms"), &arc.period_ms.unwrap_or(0), &why);
        }
    }

    /// What is stated of sensors, arm and target must be possible.
    fn sheets(&mut self, name: &str, known: &ArmKnown) {
        let sheet = &known.sheet;
        let errors = [
            ("gyro_bias_rad_s", sheet.gyro_bias_rad_s),
            ("gyro_scale", sheet.gyro_scale),
            ("joint_rate_scale", sheet.joint_rate_scale),
            ("joint_zero_rad", sheet.joint_zero_rad),
            ("latency_s", sheet.latency_s),
        ];
        for (error, sigma) in errors {
            self.within_and_finite(&format!("{name}.sheet.{error}"), sigma, 0.0..=NUMBER_MAX);
        }
        if let Some(chaser) = &known.chaser {
            let bodies = [chaser.mass_kg, chaser.mass_relative_sd, chaser.inertia_kg_m2, chaser.inertia_relative_sd];
            for number in bodies.iter().flatten().chain([&chaser.length_sd_m, &chaser.link_1_length_sd_m]) {
                let good = *number > 0.0 && *number <= NUMBER_MAX;
                self.unless(good, &format!("{name}.chaser"), number, "masses, inertias and sigmas must be above 0");
            }
            self.within_and_finite(&format!("{name}.chaser.grasp_sd_m"), chaser.grasp_sd_m, 0.0..=NUMBER_MAX);
        }
        if let Some(target) = &known.target {
            for number in [&target.mass_kg, &target.inertia_kg_m2].into_iter().chain(&target.sigma) {
                let good = *number > 0.0 && *number <= NUMBER_MAX;
                self.unless(good, &format!("{name}.target"), number, "mass, inertia and sigmas must be above 0");
            }
        }
    }

    fn need(&mut self, name: &str, domain: Domain, need: &Need) {
        let names: Vec<&str> = telemetry::parameters(domain).iter().map(|parameter| parameter.name).collect();
        for (parameter, percent) in &need.sigma_percent {
            let why = format!("{domain} has the parameters {}", names.join(", "));
            let key = format!("{name}.need.sigma_percent.{parameter}");
            self.unless(names.contains(&parameter.as_str()), &key, percent, &why);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE_BODY: &str = include_str!("../../../../deploy/scenarios/one_body.toml");

    /// Keys that are rejected once `from` reads `to`.
    fn refused(from: &str, to: &str) -> Vec<String> {
        assert!(ONE_BODY.contains(from));
        let scenario: Scenario = toml::from_str(&ONE_BODY.replace(from, to)).unwrap();
        beyond(&scenario).into_iter().map(|impossible| impossible.key).collect()
    }

    #[test]
    fn numbers_of_an_appendage_that_are_none_are_refused() {
        assert_eq!(refused("", ""), [""; 0]);
        for (from, to, key) in [
            ("arm_angle_rad = [0.6, -1.1]", "arm_angle_rad = [0.6, nan]", "arm_angle_rad"),
            ("[4.03270332, 0.005]", "[inf, 0.005]", "locked"),
            ("inertia_kg_m2 = 539.5", "inertia_kg_m2 = inf", "inertia_kg_m2"),
            ("inertia_relative_sd = 0.01", "inertia_relative_sd = nan", "inertia_relative_sd"),
            ("coupling_relative_sd = 1.0e-4", "coupling_relative_sd = nan", "coupling_relative_sd"),
        ] {
            assert_eq!(refused(from, to), [format!("modal.known.appendage.{key}")], "{to}");
        }
    }
}
