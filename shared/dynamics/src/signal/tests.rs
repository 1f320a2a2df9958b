//! Claims about signals: derivatives, limits, published closed forms.

use super::*;

const fn q(value: f64) -> Quantity {
    Quantity::known(value)
}

fn always(kind: SignalKind) -> Signal {
    Signal { kind, begin_s: q(0.0), end_s: None }
}

fn sum(signals: &[Signal]) -> SignalSum {
    SignalSum::new(signals, 30.0, "test").unwrap()
}

fn smooth_kinds() -> Vec<SignalKind> {
    vec![
        SignalKind::Constant { value: q(0.4) },
        SignalKind::Sine { amplitude: q(1.0), frequency_hz: q(0.3), phase_rad: q(0.2) },
        SignalKind::Multisine { rms: q(0.5), period_s: q(20.0), first: 2, last: 20 },
        SignalKind::Chirp { amplitude: q(0.7), begin_hz: q(0.05), end_hz: q(0.8) },
        SignalKind::Fourier { offset: q(0.1), period_s: q(15.0), sine: vec![q(0.3), q(-0.2)], cosine: vec![q(0.1)] },
        SignalKind::Slew { size: q(1.5), width_s: q(12.0) },
        SignalKind::Table {
            time_s: vec![0.0, 3.0, 9.0, 14.0, 31.0],
            value: vec![0.0, 1.0, -1.0, 0.5, 0.2],
            smooth: true,
        },
    ]
}

#[test]
fn rate_and_acceleration_are_the_derivatives_of_the_value() {
    let h = 1e-4;
    for kind in smooth_kinds() {
        let signal = sum(&[always(kind.clone())]);
        for step in 1..200 {
            let t = 0.1499 * f64::from(step);
            let (before, at, after) = (signal.at(t - h), signal.at(t), signal.at(t + h));
            // central difference: truncation h²/6 times a fourth derivative below (2π)⁴ · 1 Hz⁴; at
            // a knot the third derivative jumps: h/2 · 1
            let truncation = if matches!(kind, SignalKind::Table { .. }) { 1e-4 } else { 1e-5 };
            assert!(((after.value - before.value) / (2.0 * h) - at.rate).abs() < truncation, "{kind:?} at {t}");
            assert!(((after.rate - before.rate) / (2.0 * h) - at.acceleration).abs() < truncation, "{kind:?} at {t}");
        }
    }
}

#[test]
fn a_term_is_zero_outside_its_limits_and_runs_on_its_own_time() {
    let kind = SignalKind::Sine { amplitude: q(2.0), frequency_hz: q(0.25), phase_rad: q(0.0) };
    let limited = sum(&[Signal { kind: kind.clone(), begin_s: q(3.0), end_s: Some(q(5.0)) }]);
    let free = sum(&[always(kind)]);
    assert_eq!(limited.at(2.999), SignalValue::default());
    assert_eq!(limited.at(5.0), SignalValue::default());
    assert_eq!(limited.at(4.0), free.at(1.0));
}

#[test]
fn terms_add() {
    let kinds = smooth_kinds();
    let together = sum(&kinds.iter().cloned().map(always).collect::<Vec<_>>());
    let apart: f64 = kinds.into_iter().map(|kind| sum(&[always(kind)]).at(7.7).value).sum();
    assert!((together.at(7.7).value - apart).abs() < 1e-14); // rounding
}

#[test]
fn the_arm_reference_is_its_closed_form() {
    let reference = simulation::fourier_reference::FourierReference::trajectory_b();
    for joint in 0..2 {
        let signal = sum(&[always(SignalKind::Fourier {
            offset: q(reference.q0_rad[joint]),
            period_s: q(reference.period_s),
            sine: reference.a_rad_s[joint].into_iter().map(q).collect(),
            cosine: reference.b_rad_s[joint].into_iter().map(q).collect(),
        })]);
        for step in 0..300 {
            let t = 0.1 * f64::from(step);
            let (target, got) = (reference.at(t), signal.at(t));
            let wanted = [target.angle_rad[joint], target.rate_rad_s[joint], target.acceleration_rad_s2[joint]];
            for (got, wanted) in [got.value, got.rate, got.acceleration].into_iter().zip(wanted) {
                // sums of angles against angles of sums: rounding of five harmonics and of
                // arguments up to 31 rad
                assert!((got - wanted).abs() < 1e-14, "t = {t}: {got} {wanted}");
            }
        }
    }
}

#[test]
fn edges_meant_to_lie_on_samples_do() {
    let staircase = sum(&[always(SignalKind::Staircase { step: q(0.1), every_s: q(1.0) })]);
    let pulse = sum(&[always(SignalKind::Pulse { size: q(2.0), width_s: q(0.3), period_s: Some(q(1.0)) })]);
    let square = sum(&[always(SignalKind::Square { amplitude: q(1.0), frequency_hz: q(0.5) })]);
    for k in 0..500u32 {
        let t = f64::from(k) * 0.1; // 0.1 is not a binary fraction: products fall on both sides of the edges
        assert_eq!(staircase.at(t).value, 0.1 * (1.0 + f64::from(k / 10)), "t = {t}");
        assert_eq!(pulse.at(t).value, if k % 10 < 3 { 2.0 } else { 0.0 }, "t = {t}");
        assert_eq!(square.at(t).value, if k % 20 < 10 { 1.0 } else { -1.0 }, "t = {t}");
    }
}

#[test]
fn a_multisine_has_the_rms_asked_for_and_a_low_crest() {
    let signal = sum(&[always(SignalKind::Multisine { rms: q(0.5), period_s: q(20.0), first: 3, last: 60 })]);
    let n = 2000;
    let values: Vec<f64> = (0..n).map(|k| signal.at(20.0 * f64::from(k) / f64::from(n)).value).collect();
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / f64::from(n)).sqrt();
    let peak = values.iter().fold(0.0f64, |p, v| p.max(v.abs()));
    assert!((rms - 0.5).abs() < 1e-12, "{rms}"); // orthogonality over a whole period: rounding
    // Schroeder (1970): flat spectra reach about 1.7; in-phase harmonics would have √(2·58) = 10.8
    assert!(peak / rms < 2.0, "{}", peak / rms);
}

#[test]
fn a_spline_passes_through_its_rows_and_a_held_table_stays_on_them() {
    let (time_s, value) = (vec![0.0, 1.0, 2.5, 4.0], vec![1.0, -2.0, 0.5, 3.0]);
    let table = |smooth| sum(&[always(SignalKind::Table { time_s: time_s.clone(), value: value.clone(), smooth })]);
    for (t, v) in time_s.iter().zip(&value) {
        assert!((table(true).at(*t).value - v).abs() < 1e-14);
        assert_eq!(table(false).at(*t).value, *v);
        assert_eq!(table(false).at(*t + 0.9).value, *v);
    }
    // a straight line is its own spline
    let line = sum(&[always(SignalKind::Table {
        time_s: vec![0.0, 1.0, 3.0, 4.0],
        value: vec![0.0, 2.0, 6.0, 8.0],
        smooth: true,
    })]);
    assert!((line.at(1.7).value - 3.4).abs() < 1e-14 && (line.at(1.7).rate - 2.0).abs() < 1e-14);
}

#[test]
fn signals_without_meaning_are_refused_by_name() {
    let bad = [
        SignalKind::Square { amplitude: q(1.0), frequency_hz: q(0.0) },
        SignalKind::Multisine { rms: q(1.0), period_s: q(1.0), first: 0, last: 3 },
        SignalKind::Table { time_s: vec![0.0, 0.0], value: vec![1.0, 2.0], smooth: false },
        SignalKind::Table { time_s: vec![0.0], value: vec![], smooth: true },
        SignalKind::Slew { size: q(1.0), width_s: q(0.0) },
    ];
    for kind in bad {
        let error = SignalSum::new(&[always(kind)], 1.0, "actuator:motor").unwrap_err();
        assert!(error.to_string().contains("actuator:motor"), "{error}");
    }
}
