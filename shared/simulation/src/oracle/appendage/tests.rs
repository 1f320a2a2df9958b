//! Claims about hub and appendage: the table, momentum, an independent integration, both loops'
//! poles.

use super::*;
use crate::oracle::hub_controller::{HubController, HubControllerState, staircase_rad};

fn quiet(parameters: &AppendageParameters) -> AppendageTruth {
    AppendageTruth::new(parameters, 200.0, 0.0, 0, "panel")
}

fn pulse(k: u32) -> f64 {
    rectangular_pulse_nm(f64::from(k) / 200.0, 2.0, 1.0)
}

#[test]
fn inertia_coupling_and_locked_frequencies_are_the_published_ones() {
    let design = AppendageParameters::design();
    assert!((design.total_inertia_kg_m2() - 177.503_333_33).abs() < 0.6e-8);
    let coupling = design.coupling();
    assert!(
        (coupling[0] - 10.231_943_38).abs() < 0.6e-8 && (coupling[1] - 2.121_261_81).abs() < 0.6e-8,
        "{coupling:?}"
    );
    let locked = design.hub_locked_modes();
    assert!((locked[0].0 - 1.001_027_19).abs() < 0.6e-8 && (locked[1].0 - 6.273_330_30).abs() < 0.6e-8, "{locked:?}");
}

#[test]
fn hub_free_modes_are_the_published_ones() {
    let modes = AppendageParameters::design().modes();
    let table = [(1.561_099_92, 0.007_782_72), (6.484_425_84, 0.008_330_56)];
    for (mode, (frequency, damping)) in modes.iter().zip(table) {
        // half a unit of the last printed digit
        assert!((mode.frequency_hz - frequency).abs() < 0.51e-8, "{mode:?}");
        assert!((mode.damping_ratio - damping).abs() < 0.51e-8, "{mode:?}");
    }
    let five = AppendageParameters::design_five_modes().modes();
    let table = [(1.56105, 0.51e-5), (6.48397, 0.51e-5), (17.6755, 0.51e-4), (34.4991, 0.51e-4), (56.9632, 0.51e-4)];
    for (mode, (frequency, tolerance)) in five.iter().zip(table) {
        assert!((mode.frequency_hz - frequency).abs() < tolerance, "{mode:?}");
    }
}

#[test]
fn torque_goes_into_the_angular_momentum_of_hub_and_beam() {
    let design = AppendageParameters::design_five_modes();
    let (inertia, coupling) = (design.total_inertia_kg_m2(), design.coupling());
    let mut panel = quiet(&design);
    for k in 0..1000 {
        panel.step(pulse(k));
        let rates = &panel.state().x[6..];
        let momentum = inertia * rates[0] + coupling.iter().zip(&rates[1..]).map(|(c, d)| c * d).sum::<f64>();
        let impulse = 2.0 * f64::from((k + 1).min(200)) / 200.0;
        // rounding of 10³ steps
        assert!((momentum - impulse).abs() < 1e-11, "step {k}: {momentum} against {impulse}");
    }
}

/// Runge–Kutta with 50 µs on the second-order equations, accelerations by a solve at each stage.
#[test]
fn exact_hold_equals_a_fine_integration_of_the_equations_of_motion() {
    let design = AppendageParameters::design();
    let (j, c) = (design.total_inertia_kg_m2(), design.coupling());
    let locked = design.hub_locked_modes();
    let omega = [0, 1].map(|k| core::f64::consts::TAU * locked[k].0);
    let flexible = design.beam;
    // θ̈ from d̈_k = −c_k θ̈ − 2ζω ḋ − ω² d and J θ̈ + Σ c d̈ = u
    let accelerations = |x: [f64; 6], u: f64| {
        let own = [0, 1].map(|k| -2.0 * locked[k].1 * omega[k] * x[4 + k] - omega[k] * omega[k] * x[1 + k]);
        let hub = (u - c[0] * own[0] - c[1] * own[1]) / (j - c[0] * c[0] - c[1] * c[1]);
        [hub, own[0] - c[0] * hub, own[1] - c[1] * hub]
    };
    let slope = |x: [f64; 6], u: f64| {
        let a = accelerations(x, u);
        [x[3], x[4], x[5], a[0], a[1], a[2]]
    };
    let moved = |x: [f64; 6], k: [f64; 6], h: f64| core::array::from_fn(|i| x[i] + h * k[i]);
    let mut panel = quiet(&design);
    let mut x = [0.0; 6];
    for k in 0..1000 {
        let u = pulse(k);
        let measured = panel.step(u).acceleration_m_s2;
        let a = accelerations(x, u);
        for (i, y) in measured.iter().enumerate() {
            let position = 0.5 * (i + 1) as f64;
            let expected = (0.5 + position) * a[0]
                + flexible.mode(1).shape(position) * a[1]
                + flexible.mode(2).shape(position) * a[2];
            // RK4: (ωh)⁵/120 = 3e-16 per step, 10⁵ steps, times 0.2 m/s²
            assert!((y - expected).abs() < 1e-11, "sample {k}, sensor {i}: {}", y - expected);
        }
        for _ in 0..100 {
            let h = 5e-5;
            let k_1 = slope(x, u);
            let k_2 = slope(moved(x, k_1, 0.5 * h), u);
            let k_3 = slope(moved(x, k_2, 0.5 * h), u);
            let k_4 = slope(moved(x, k_3, h), u);
            x = core::array::from_fn(|i| x[i] + h / 6.0 * (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]));
        }
    }
}

/// Signals printed with the design: tip peak 0.224, root sensor peak 0.0275, decay rms 0.015 to
/// 0.107 m/s², hub ends at 2.90°.
#[test]
fn signals_of_the_pulse_experiment_are_the_published_ones() {
    let mut panel = quiet(&AppendageParameters::design());
    let (mut peak, mut squares) = ([0.0f64; SENSORS], [0.0; SENSORS]);
    for k in 0..1000 {
        let y = panel.step(pulse(k)).acceleration_m_s2;
        for i in 0..SENSORS {
            peak[i] = peak[i].max(y[i].abs());
            squares[i] += if k >= 200 { y[i] * y[i] } else { 0.0 };
        }
    }
    let rms = squares.map(|sum| (sum / 800.0).sqrt());
    assert!((peak[9] - 0.224).abs() < 0.6e-3 && (peak[0] - 0.0275).abs() < 0.6e-4, "{peak:?}");
    assert!((rms[9] - 0.107).abs() < 0.6e-3 && (rms[0] - 0.015).abs() < 0.6e-3, "{rms:?}");
    assert!((panel.hub_angle_rad().to_degrees() - 2.90).abs() < 0.006, "{}", panel.hub_angle_rad().to_degrees());
}

/// The free decay of each sensor pair must turn with the mode shapes: a pure mode stays pure.
#[test]
fn a_system_started_in_one_mode_shows_the_shape_of_that_mode_at_every_sensor() {
    let design = AppendageParameters::design();
    for mode in design.modes() {
        // drive to steady state at the mode's frequency: the response is then dominated by that
        // mode
        let mut panel = AppendageTruth::new(&design, 2000.0, 0.0, 0, "panel");
        let omega = core::f64::consts::TAU * mode.frequency_hz;
        let mut spectrum = [[0.0; 2]; SENSORS];
        let (start, stop) = (400_000u32, 500_000u32);
        for k in 0..stop {
            let (sin, cos) = (omega * f64::from(k) / 2000.0).sin_cos();
            let y = panel.step(sin).acceleration_m_s2;
            if k >= start {
                for i in 0..SENSORS {
                    spectrum[i] = [spectrum[i][0] + y[i] * cos, spectrum[i][1] - y[i] * sin];
                }
            }
        }
        let [tip_re, tip_im] = spectrum[SENSORS - 1];
        for (i, [re, im]) in spectrum.into_iter().enumerate() {
            let norm = tip_re * tip_re + tip_im * tip_im;
            let ratio = [(re * tip_re + im * tip_im) / norm, (im * tip_re - re * tip_im) / norm];
            // the rest of the system answers with about 2ζ of the resonance: 5 %
            for part in 0..2 {
                assert!(
                    (ratio[part] - mode.shape[i][part]).abs() < 0.05,
                    "{:.3} Hz, sensor {i}: {ratio:?}",
                    mode.frequency_hz
                );
            }
        }
    }
}

/// Published for the closed loop: peak torque 5.24 Nm, hub at 2.61° after 5 s, tip peak 0.304 m/s².
#[test]
fn the_closed_loop_on_the_hub_gives_the_published_signals() {
    let mut panel = quiet(&AppendageParameters::design());
    let (controller, mut memory) = (HubController::benchmark(), HubControllerState::default());
    let (mut torque_max, mut tip_max) = (0.0f64, 0.0f64);
    for k in 0..1000 {
        let reference = staircase_rad(f64::from(k) / 200.0, 0.5f64.to_radians());
        let (angle, rate) = (panel.hub_angle_rad(), panel.hub_rate_rad_s());
        let torque = controller.torque_nm(&mut memory, reference, angle, rate, 1.0 / 200.0);
        let y = panel.step(torque).acceleration_m_s2;
        torque_max = torque_max.max(torque.abs());
        tip_max = tip_max.max(y[9].abs());
    }
    assert!((torque_max - 5.24).abs() < 0.0051, "{torque_max}");
    assert!((tip_max - 0.304).abs() < 0.51e-3, "{tip_max}");
    assert!((panel.hub_angle_rad().to_degrees() - 2.61).abs() < 0.006, "{}", panel.hub_angle_rad().to_degrees());
}

#[test]
fn every_accelerometer_has_its_own_noise_of_the_size_asked_for() {
    let mut panel = AppendageTruth::new(&AppendageParameters::design(), 200.0, ACCELEROMETER_SIGMA_M_S2, 8, "panel");
    let n = 20_000;
    let (mut square, mut product) = ([0.0; SENSORS], 0.0);
    for _ in 0..n {
        let y = panel.step(0.0).acceleration_m_s2; // at rest: noise alone
        square.iter_mut().zip(y).for_each(|(sum, y)| *sum += y * y);
        product += y[0] * y[1];
    }
    let sigma = square.map(|sum: f64| (sum / f64::from(n)).sqrt());
    // relative standard error 1/√(2N) = 0.5 %; 4 of them
    assert!(sigma.iter().all(|s| (s / 3.10e-4 - 1.0).abs() < 0.02), "{sigma:?}");
    assert!((product / f64::from(n) / (sigma[0] * sigma[1])).abs() < 4.5 / f64::from(n).sqrt());
}

#[test]
fn a_checkpoint_continues_with_the_same_bits() {
    let fresh = || AppendageTruth::new(&AppendageParameters::design(), 200.0, ACCELEROMETER_SIGMA_M_S2, 8, "panel");
    let mut undisturbed = fresh();
    for k in 0..250 {
        undisturbed.step(pulse(k));
    }
    let bytes = postcard::to_allocvec(&undisturbed.state()).unwrap();
    let mut restarted = fresh();
    restarted.restore(&postcard::from_bytes(&bytes).unwrap());
    for k in 250..500 {
        assert_eq!(undisturbed.step(pulse(k)), restarted.step(pulse(k)));
    }
}

#[test]
fn the_pulse_covers_exactly_the_samples_before_its_end() {
    let on = (0..1000).filter(|k| pulse(*k) != 0.0).count();
    assert_eq!(on, 200);
    assert_eq!((pulse(0), pulse(199), pulse(200)), (2.0, 2.0, 0.0));
}

/// Published: 0.2754 Hz / 0.664, 1.53177 Hz / 0.19988, 6.48349 Hz / 0.013750, and a real pole at
/// −0.2386 1/s.
#[test]
fn poles_of_the_sampled_loop_are_the_published_closed_loop_modes() {
    let panel = quiet(&AppendageParameters::design());
    let gains = HubController::benchmark();
    let h = 1.0 / 200.0;
    // state (x, ∫e); r = 0; u = −Kp θ + Ki (I − h θ) − Kd θ': the controller's law, written as a
    // matrix
    let mut feedback = DMatrix::zeros(1, 7);
    feedback[(0, 0)] = -gains.proportional_nm_rad - gains.integral_nm_rad_s * h;
    feedback[(0, 3)] = -gains.derivative_nms_rad;
    feedback[(0, 6)] = gains.integral_nm_rad_s;
    let mut open = DMatrix::zeros(7, 7);
    open.view_mut((0, 0), (6, 6)).copy_from(&panel.transition);
    (open[(6, 6)], open[(6, 0)]) = (1.0, -h);
    let mut input = DMatrix::zeros(7, 1);
    input.view_mut((0, 0), (6, 1)).copy_from(&panel.input);
    let closed = open + input * feedback;
    let mut poles: Vec<Complex<f64>> =
        closed.complex_eigenvalues().iter().map(|z| z.ln() / h).filter(|p| p.im >= 0.0).collect();
    poles.sort_by(|a, b| a.modulus().total_cmp(&b.modulus()));
    let hertz = |p: &Complex<f64>| p.modulus() / core::f64::consts::TAU;
    let ratio = |p: &Complex<f64>| -p.re / p.modulus();
    assert!(poles.len() == 4, "{poles:?}");
    // half a unit of the last printed digit
    assert!((poles[0].re + 0.2386).abs() < 0.51e-4 && poles[0].im == 0.0, "{poles:?}");
    let table = [
        (0.2754, 0.51e-4, 0.664, 0.51e-3),
        (1.53177, 0.51e-5, 0.19988, 0.51e-5),
        (6.48349, 0.51e-5, 0.013_750, 0.51e-6),
    ];
    for (pole, (frequency, f_digit, damping, d_digit)) in poles[1..].iter().zip(table) {
        assert!((hertz(pole) - frequency).abs() < f_digit, "{}", hertz(pole));
        assert!((ratio(pole) - damping).abs() < d_digit, "{}", ratio(pole));
    }
}
