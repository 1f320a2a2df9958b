//! The general simulator against the special ones, which were written from other equations.

use super::plants;
use crate::Simulator;
use crate::fourier_reference::FourierReference;
use crate::oracle::appendage::{AppendageParameters, AppendageTruth, SENSORS, rectangular_pulse_nm};
use crate::oracle::arm::{ArmNoise, FreeFloatingArm};
use crate::oracle::arm_parameters::ArmParameters;
use crate::oracle::hub_controller::{HubController, HubControllerState, staircase_rad};
use crate::oracle::slosh::{SloshParameters, SloshTruth, sine_force_n};
use dynamics::description::{Controller, Signal, SignalKind};
use plants::q;

/// Greatest difference and greatest value of a channel.
#[derive(Clone, Copy, Default)]
struct Spread {
    difference: f64,
    value: f64,
}

impl Spread {
    fn take(&mut self, one: f64, other: f64) {
        assert!(one.is_finite() && other.is_finite());
        self.difference = self.difference.max((one - other).abs());
        self.value = self.value.max(other.abs());
    }

    fn relative(&self) -> f64 {
        self.difference / self.value
    }
}

/// Sixty seconds of the arm, both ways; every third of a minute of the last 20 s stands still.
fn compare_arm(noise: ArmNoise) -> [Spread; 7] {
    let (parameters, reference) = (ArmParameters::paper_table_ii(), FourierReference::trajectory_b());
    let mut special = FreeFloatingArm::new(&parameters, reference, &noise, 68.0, 0.01, 5, "arm");
    let mut general = Simulator::new(&plants::arm(&noise), 5, "arm").unwrap();
    let mut spread = [Spread::default(); 7];
    for k in 0..6000 {
        let excited = !(4000..4500).contains(&k);
        general.set_excited(excited);
        let measured = special.step(excited);
        let row = general.step();
        let [angle, rate, torque] = [measured.joint_angle_rad, measured.joint_rate_rad_s, measured.joint_torque_nm];
        let expected = [measured.omega0_z_rad_s, angle[0], rate[0], torque[0], angle[1], rate[1], torque[1]];
        for (channel, expected) in expected.into_iter().enumerate() {
            spread[channel].take(row.value(channel), expected);
        }
    }
    spread
}

/// Two formulations, both RK4 at 5 ms: what differs is rounding, 1e-16 a step, kept from growing by
/// the loop (the base floats: its errors add up over 12 000 steps).
#[test]
fn the_arm_of_bp1a_is_the_special_simulators_sample_by_sample() {
    for noise in [ArmNoise::none(), ArmNoise::default()] {
        for (channel, spread) in compare_arm(noise).iter().enumerate() {
            assert!(spread.value > 0.1, "channel {channel} must move");
            assert!(spread.relative() < 1e-9, "channel {channel}: {:.1e}", spread.relative());
        }
    }
}

#[test]
fn the_tank_of_bp2_is_the_special_simulators_under_exact_hold() {
    let mut special = SloshTruth::new(&SloshParameters::benchmark(), 0.1, 0.0, 0, "craft");
    let mut general = Simulator::new(&plants::slosh(), 0, "craft").unwrap();
    let mut spread = Spread::default();
    for k in 0..10_000 {
        let expected = special.step(sine_force_n(0.1 * (f64::from(k) + 0.5), 44.0, 0.01));
        spread.take(general.step().value(0), expected.acceleration_m_s2);
    }
    // rounding of velocities of up to 1.4 m/s, differenced over 0.1 s and compared with 0.04 m/s²:
    // 1e-14 a step, adding at random
    assert!(spread.relative() < 1e-11, "{:.1e}", spread.relative());
}

fn pulse() -> Vec<Signal> {
    plants::always(SignalKind::Pulse { size: q(1e-3), width_s: q(0.5), period_s: None })
}

/// The hub turns by microradians, so that what the special simulator neglects (ω² η against η'') is
/// below 1e-12.
#[test]
fn the_beam_of_bp3_is_the_special_simulators_sample_by_sample() {
    for parameters in [AppendageParameters::design(), AppendageParameters::design_five_modes()] {
        let mut special = AppendageTruth::new(&parameters, 200.0, 0.0, 0, "flexible");
        let mut general = Simulator::new(&plants::appendage(&parameters, pulse()), 0, "flexible").unwrap();
        let mut spread = [Spread::default(); SENSORS];
        for k in 0..4000 {
            let expected = special.step(rectangular_pulse_nm(0.005 * f64::from(k), 1e-3, 0.5));
            let row = general.step();
            for (i, spread) in spread.iter_mut().enumerate() {
                spread.take(row.value(i), expected.acceleration_m_s2[i]);
            }
        }
        // rounding of 4000 products with matrices of entries up to ω² = 1e6
        assert!(spread.iter().all(|spread| spread.relative() < 1e-9), "{:?}", spread.map(|spread| spread.relative()));
    }
}

#[test]
fn the_loop_of_bp3b_is_the_special_simulators_with_its_hub_controller() {
    let parameters = AppendageParameters::design();
    let mut plant = plants::appendage(&parameters, vec![]);
    let gains = HubController::benchmark();
    plant.controllers.push(Controller {
        name: "attitude".to_owned(),
        actuator: "torque".to_owned(),
        position_sensor: Some("hub.angle".to_owned()),
        rate_sensor: Some("hub.rate".to_owned()),
        kp: q(gains.proportional_nm_rad),
        ki: q(gains.integral_nm_rad_s),
        kd: q(gains.derivative_nms_rad),
        reference: plants::always(SignalKind::Staircase { step: q(1e-7), every_s: q(1.0) }),
        feed_forward: q(0.0),
        reference_rate: false,
    });
    let mut general = Simulator::new(&plant, 0, "flexible").unwrap();
    let mut special = AppendageTruth::new(&parameters, 200.0, 0.0, 0, "flexible");
    let mut memory = HubControllerState::default();
    let mut spread = Spread::default();
    for k in 0..4000 {
        let (angle, rate) = (special.hub_angle_rad(), special.hub_rate_rad_s());
        let torque = gains.torque_nm(&mut memory, staircase_rad(0.005 * f64::from(k), 1e-7), angle, rate, 0.005);
        let expected = special.step(torque).acceleration_m_s2[SENSORS - 1];
        spread.take(general.step().value(SENSORS - 1), expected);
    }
    assert!(spread.relative() < 1e-9, "{:.1e}", spread.relative()); // as above
}
