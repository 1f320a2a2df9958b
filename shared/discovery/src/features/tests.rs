use super::*;
use crate::diagnose::Verdict;
use crate::noise::Noise;
use identification::held_out::Status;
use plant_modes::plant_modes;

mod damping;
mod shapes;

fn cantilever() -> Plant {
    let text = include_str!("../../../../deploy/plants/rigs/cantilever.toml");
    plant_file::parse("cantilever", text).unwrap().plant
}

/// Eigenvalue number n of `g`, by bisection between its sign changes over z.
fn roots(g: impl Fn(f64) -> f64, count: usize) -> Vec<f64> {
    let (mut found, mut z) = (Vec::new(), 0.05);
    while found.len() < count {
        let (mut low, mut high) = (z, z + 0.01);
        if g(low) * g(high) < 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if g(middle) * g(low) > 0.0 { low = middle } else { high = middle }
            }
            found.push(0.5 * (low + high));
        }
        z += 0.01;
    }
    found
}

/// Closed forms, divided by cosh: clamped beam with a tip mass of `mu` beam masses, and with a root
/// spring of `kr` EI/L.
fn with_tip_mass(mu: f64) -> Vec<f64> {
    let g = |z: f64| {
        let (c, s, t, e) = (libm::cos(z), libm::sin(z), libm::tanh(z), 1.0 / libm::cosh(z));
        e + c + mu * z * (c * t - s)
    };
    roots(g, 7)
}

fn with_root_spring(kr: f64) -> Vec<f64> {
    let g = |z: f64| {
        let (c, s, t, e) = (libm::cos(z), libm::sin(z), libm::tanh(z), 1.0 / libm::cosh(z));
        kr * (e + c) + z * (c * t - s)
    };
    roots(g, 7)
}

fn hz(eigenvalues: &[f64]) -> Vec<f64> {
    let (length, stiffness, mass) = (0.759f64, 114.657_717_5, 2.044_080_34);
    let unit = f64::sqrt(stiffness / mass) / (length * length) / core::f64::consts::TAU;
    eigenvalues.iter().map(|z| z * z * unit).collect()
}

/// Magnitude of an acceleration at the tip after a blow: modes of damping `zeta`, a floor of noise.
fn spectrum(frequency_hz: &[f64], zeta: f64, seed: u64) -> Spectrum {
    let mut draw = Noise::new(seed);
    let lines: Vec<f64> = (0..20_000).map(|k| 0.05 * f64::from(k)).collect();
    let magnitude = lines.iter().map(|f| {
        let (mut re, mut im) = (1e-4 * draw.normal(), 1e-4 * draw.normal());
        for (k, f_0) in frequency_hz.iter().enumerate() {
            let x = f / f_0;
            let (a, b) = (1.0 - x * x, 2.0 * zeta * x);
            let size = 0.01 * x * x / (1.0 + k as f64) / (a * a + b * b);
            re += size * a;
            im -= size * b;
        }
        libm::hypot(re, im)
    });
    Spectrum { name: "blow".to_owned(), magnitude: magnitude.collect(), frequency_hz: lines }
}

fn scatter(frequency_hz: &[f64], relative: f64, seed: u64) -> Vec<MeasuredMode> {
    let mut draw = Noise::new(seed);
    let mode = |f: &f64| MeasuredMode {
        frequency_hz: f * (1.0 + relative * draw.normal()),
        sigma_hz: relative * f,
        damping_ratio: f64::NAN,
        damping_sigma: f64::NAN,
        prominence: 30.0,
        shape: Vec::new(),
    };
    frequency_hz.iter().map(mode).collect()
}

#[test]
fn peaks_give_frequency_and_damping_within_their_standard_errors() {
    let truth = hz(&with_tip_mass(0.0));
    let mut squares = Vec::new();
    for seed in 0..10 {
        let found = spectrum(&truth, 0.004, seed).modes();
        assert_eq!(found.len(), truth.len(), "{found:?}");
        for (mode, f) in found.iter().zip(&truth) {
            assert!((mode.frequency_hz / f - 1.0).abs() < 1e-3, "{mode:?} {f}");
            assert!((mode.damping_ratio - 0.004).abs() < 5.0 * mode.damping_sigma + 4e-4, "{mode:?}");
            squares.push(((mode.frequency_hz - f) / mode.sigma_hz).powi(2));
        }
    }
    let z = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // 70 of them: an rms of 1 would lie within 0.75 and 1.25; the floor of a tenth of a line makes
    // it smaller
    assert!(z < 1.5, "{z}");
}

#[test]
fn noise_alone_has_no_peaks() {
    let mut draw = Noise::new(4);
    let magnitude: Vec<f64> = (0..20_000).map(|_| libm::hypot(draw.normal(), draw.normal())).collect();
    let frequency_hz = (0..20_000).map(|k| 0.1 * f64::from(k)).collect();
    let found = Spectrum { name: "noise".to_owned(), frequency_hz, magnitude };
    assert!(found.modes().is_empty());
    assert_eq!(diagnose_spectrum(&cantilever(), &found, &FeatureOptions::default()).verdict, Verdict::CannotDecide);
}

#[test]
fn the_file_of_the_cantilever_is_the_closed_form() {
    let modes = plant_modes(&cantilever(), &[]).unwrap();
    for (mode, f) in modes.iter().zip(hz(&with_tip_mass(0.0))) {
        assert!((mode.frequency_hz / f - 1.0).abs() < 1e-5, "{mode:?} {f}"); // six digits in the file
    }
}

#[test]
fn a_plant_that_is_right_is_left_alone() {
    for seed in 0..8 {
        let measured = scatter(&hz(&with_tip_mass(0.0)), 2e-3, seed);
        let found = diagnose_modes(&cantilever(), "modes", &measured, &FeatureOptions::default());
        assert_eq!(found.verdict, Verdict::None, "seed {seed}: {}", found.reason);
    }
}

#[test]
fn a_common_factor_is_named_with_its_size_and_predicts_the_upper_modes() {
    let truth: Vec<f64> = hz(&with_tip_mass(0.0)).iter().map(|f| 0.93 * f).collect();
    let found = diagnose_spectrum(&cantilever(), &spectrum(&truth, 0.003, 2), &FeatureOptions::default());
    assert_eq!(found.verdict, Verdict::Named, "{}", found.reason);
    assert_eq!(found.effects[0].kind, "frequency_scale");
    assert_eq!(found.effects[0].status, Status::Confirmed);
    let factor = &found.effects[0].parameters[0];
    assert!((factor.value - 0.93).abs() < 3.0 * factor.sigma.max(1e-4), "{factor:?}");
    let augmented = plant_file::parse("augmented", found.augmented_plant.as_ref().unwrap()).unwrap().plant;
    let again = diagnose_spectrum(&augmented, &spectrum(&truth, 0.003, 3), &FeatureOptions::default());
    assert_eq!(again.verdict, Verdict::None, "{}", again.reason);
}

#[test]
fn one_mode_that_is_off_is_that_mode() {
    let mut truth = hz(&with_tip_mass(0.0));
    truth[3] *= 1.04;
    let measured = scatter(&truth, 1e-3, 5);
    let found = diagnose_modes(&cantilever(), "modes", &measured, &FeatureOptions::default());
    assert_eq!(found.effects[0].kind, "frequency_of_one_mode", "{}", found.reason);
    assert_eq!(found.effects[0].site, "mode:bending_4");
}

#[test]
fn tip_mass_and_root_spring_of_the_reciprocal_size_are_one_spectrum_and_reported_as_such() {
    let (mass, spring) = (with_tip_mass(0.08), with_root_spring(1.0 / 0.08));
    assert!(mass.iter().zip(&spring).all(|(a, b)| (a - b).abs() < 1e-9), "{mass:?} {spring:?}");
    let measured = scatter(&hz(&mass), 2e-3, 6);
    let found = diagnose_modes(&cantilever(), "modes", &measured, &FeatureOptions::default());
    assert_eq!(found.verdict, Verdict::NotSeparable, "{}", found.reason);
    let named: Vec<&str> = core::iter::once(found.effects[0].kind.as_str())
        .chain(found.effects[0].rivals.iter().map(|rival| rival.kind.as_str()))
        .collect();
    assert!(named.contains(&"point_mass") && named.contains(&"root_rotation_spring"), "{named:?}");
    assert!(!named[..2].contains(&"frequency_scale"), "{named:?}");
}

#[test]
fn peaks_of_another_kind_do_not_disturb_the_match() {
    let mut truth: Vec<f64> = hz(&with_tip_mass(0.0)).iter().map(|f| 0.9 * f).collect();
    truth.extend([50.0, 150.0, 310.0]);
    truth.sort_by(f64::total_cmp);
    let found = diagnose_modes(&cantilever(), "modes", &scatter(&truth, 1e-3, 8), &FeatureOptions::default());
    assert_eq!(found.effects[0].kind, "frequency_scale", "{}", found.reason);
    assert!((found.effects[0].parameters[0].value - 0.9).abs() < 2e-3);
    assert!(found.notes.iter().any(|note| note.contains("150.")), "{:?}", found.notes);
}

#[test]
fn amplitudes_in_question_rise_so_that_neighbours_bracket_what_lies_between_them() {
    for plant in [cantilever(), crate::synthetic::plant("drive_rig"), crate::synthetic::plant("hub_appendage")] {
        for change in changes::Change::all(&plant, true) {
            let grid = change.grid(&plant);
            assert!(grid.len() > 1 && grid.windows(2).all(|pair| pair[0] < pair[1]), "{}: {grid:?}", plant.name);
        }
    }
}
