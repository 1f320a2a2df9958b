//! Numbers that no physical system can have.

use super::{ArmExperiment, ModalExperiment, Need, Scenario, SloshExperiment};

impl Scenario {
    /// Numbers that no physical system can have.
    pub(super) fn impossible_numbers(&self) -> Vec<Impossible> {
        let mut found = Impossibles(Vec::new());
        let period_ms = self.frame_period_ms;
        found.integer("format", self.format.into(), self.format == 1, "this build reads format 1");
        found.integer("frame_period_ms", period_ms, (1..=1000).contains(&period_ms), "must be 1 to 1000");
        found.integer("window_frames", self.window_frames, self.window_frames > 0, "must be at least 1");
        if let Some(modal) = &self.modal {
            found.modal(modal);
        }
        if let Some(slosh) = &self.slosh {
            found.slosh(slosh);
        }
        for (name, arm, count) in [("inertial", &self.inertial, 8), ("mated", &self.mated, 9)] {
            if let Some(arm) = arm {
                found.arm(name, arm, count);
            }
        }
        let capture = &self.capture;
        found.finite("capture.settle_s", capture.settle_s);
        found.finite("capture.contact_timeout_s", capture.contact_timeout_s);
        found.finite("capture.model_age_limit_s", capture.model_age_limit_s);
        found.finite("capture.base_rate_limit_rad_s", capture.base_rate_limit_rad_s);
        found.0
    }
}

/// A number in a scenario that cannot be.
#[derive(Clone, Debug, PartialEq)]
pub struct Impossible {
    /// Dotted key.
    pub key: String,
    pub value: String,
    pub why: String,
}

struct Impossibles(Vec<Impossible>);

impl Impossibles {
    fn add(&mut self, key: &str, value: String, why: &str) {
        self.0.push(Impossible { key: key.into(), value, why: why.into() });
    }

    fn integer(&mut self, key: &str, value: u64, good: bool, why: &str) {
        if !good {
            self.add(key, value.to_string(), why);
        }
    }

    fn positive(&mut self, key: &str, value: f64) {
        if !(value.is_finite() && value > 0.0) {
            self.add(key, value.to_string(), "must be a finite number above 0");
        }
    }

    fn finite(&mut self, key: &str, value: f64) {
        if !value.is_finite() {
            self.add(key, value.to_string(), "must be finite");
        }
    }

    fn need(&mut self, experiment: &str, need: &Need) {
        for (name, &percent) in &need.sigma_percent {
            self.positive(&format!("{experiment}.need.sigma_percent.{name}"), percent);
        }
        if let Some(rms) = need.held_out_rms {
            self.positive(&format!("{experiment}.need.held_out_rms"), rms);
        }
    }

    fn modal(&mut self, modal: &ModalExperiment) {
        self.positive("modal.duration_s", modal.duration_s);
        self.positive("modal.known.accelerometer_sigma_m_s2", modal.known.accelerometer_sigma_m_s2);
        self.finite("modal.torque_nm", modal.torque_nm);
        self.finite("modal.pulse_s", modal.pulse_s);
        self.finite("modal.known.rate_hz", modal.known.rate_hz);
        self.finite("modal.known.expected_amplitude_m_s2", modal.known.expected_amplitude_m_s2);
        modal.known.band_hz.iter().flatten().for_each(|&edge| self.finite("modal.known.band_hz", edge));
        modal.known.expected.iter().flatten().for_each(|&number| self.finite("modal.known.expected", number));
        self.need("modal", &modal.need);
    }

    fn slosh(&mut self, slosh: &SloshExperiment) {
        self.positive("slosh.duration_s", slosh.duration_s);
        self.finite("slosh.force_amplitude_n", slosh.force_amplitude_n);
        self.finite("slosh.force_frequency_hz", slosh.force_frequency_hz);
        self.positive("slosh.known.m_0_kg", slosh.known.m_0_kg);
        self.positive("slosh.known.interval_s", slosh.known.interval_s);
        self.positive("slosh.known.accelerometer_vrw_m_s_sqrt_h", slosh.known.accelerometer_vrw_m_s_sqrt_h);
        self.need("slosh", &slosh.need);
    }

    /// The prior of an arm has `count` parameters.
    fn arm(&mut self, name: &str, arm: &ArmExperiment, count: usize) {
        let key = |key: &str| format!("{name}.{key}");
        self.positive(&key("duration_s"), arm.duration_s);
        self.positive(&key("known.h_cm_nms"), arm.known.h_cm_nms.abs());
        self.positive(&key("known.gyro_arw_deg_sqrt_h"), arm.known.gyro_arw_deg_sqrt_h);
        self.finite(&key("known.h_cm_sigma_nms"), arm.known.h_cm_sigma_nms);
        self.finite(&key("known.joint_rate_sigma_rad_s"), arm.known.joint_rate_sigma_rad_s);
        self.finite(&key("known.joint_angle_sigma_rad"), arm.known.joint_angle_sigma_rad);
        arm.known.prior.iter().for_each(|&number| self.finite(&key("known.prior"), number));
        let (given, why) = (arm.known.prior.len(), format!("needs {count} numbers, a1 to a{count}"));
        self.integer(&key("known.prior"), given as u64, given == count, &why);
        self.need(name, &arm.need);
    }
}
