//! Damping as evidence.

use super::*;

/// A hinged bar with a beam of five clamped modes: the plant of these tests, with a shaft that has
/// a damper where `damper` says so.
fn rig(damper: f64) -> Plant {
    let frequency = [2.0, 5.1, 9.7, 15.6, 22.9];
    let rotation = [1.2, 0.7, 0.9, 0.3, 0.6];
    let mut text = String::from(
        "format = 1\nname = \"rig\"\nabout = \"bar on a sprung shaft with a beam\"\nspace = \"planar\"\n\
         [[body]]\nname = \"bar\"\nmass = \"20 kg\"\ninertia = \"9 kg*m^2\"\n[body.joint]\nkind = \"revolute\"\nname = \"shaft\"\nstiffness = \"4000 N*m/rad\"\n",
    );
    text.push_str(&format!(
        "friction = \"{damper} N*m*s/rad\"\n[[appendage]]\nname = \"beam\"\nbody = \"bar\"\npoints.tip = [\"2 m\", 0]\n"
    ));
    for k in 0..5 {
        text.push_str(&format!(
            "[[appendage.mode]]\nname = \"bending_{}\"\nfrequency = \"{} Hz\"\ndamping_ratio = 0.004\nrotation = \"{} sqrt(kg)*m\"\nshape.tip = [0, \"{} 1/sqrt(kg)\"]\n",
            k + 1,
            frequency[k],
            rotation[k],
            if k % 2 == 0 { 0.9 } else { -0.9 }
        ));
    }
    plant_file::parse("rig", &text).unwrap().plant
}

/// Modes of a plant as measured with relative standard deviations of frequency and damping.
fn measured(plant: &Plant, of_frequency: f64, of_damping: f64, seed: u64) -> Vec<MeasuredMode> {
    let mut draw = Noise::new(seed);
    let mode = |m: plant_modes::PlantMode| MeasuredMode {
        frequency_hz: m.frequency_hz * (1.0 + of_frequency * draw.normal()),
        sigma_hz: of_frequency * m.frequency_hz,
        damping_ratio: m.damping_ratio * (1.0 + of_damping * draw.normal()),
        damping_sigma: of_damping * m.damping_ratio,
        prominence: 30.0,
        shape: Vec::new(),
    };
    plant_modes(plant, &[]).unwrap().into_iter().map(mode).collect()
}

fn all_damping_times(plant: &Plant, factor: f64) -> Plant {
    let mut changed = plant.clone();
    changed.appendages[0].modes.iter_mut().for_each(|mode| mode.damping_ratio.value *= factor);
    changed
}

fn asked(plant: &Plant, modes: &[MeasuredMode]) -> Diagnosis {
    diagnose_modes(plant, "modes", modes, &FeatureOptions::default())
}

#[test]
fn a_plant_whose_frequencies_and_damping_are_right_is_left_alone() {
    let plant = rig(0.0);
    let alarms: Vec<String> = (0..100)
        .map(|seed| asked(&plant, &measured(&plant, 2e-3, 0.08, seed)))
        .filter(|found| found.verdict != Verdict::None)
        .map(|found| found.reason)
        .collect();
    // one expected at the most at alpha 0.01; Bonferroni over changes that overlap is on the safe
    // side of it
    assert!(alarms.len() <= 1, "{alarms:?}");
}

#[test]
fn a_factor_on_all_damping_is_named_with_its_size_and_says_nothing_of_frequencies() {
    let plant = cantilever();
    let found = asked(&plant, &measured(&all_damping_times(&plant, 1.8), 2e-3, 0.05, 3));
    assert_eq!(found.verdict, Verdict::Named, "{}", found.reason);
    assert_eq!(found.effects.len(), 1, "{}", found.reason);
    assert_eq!((found.effects[0].kind.as_str(), found.effects[0].status), ("damping_scale", Status::Confirmed));
    let factor = &found.effects[0].parameters[0];
    assert!((factor.value - 1.8).abs() < 3.0 * factor.sigma && factor.sigma < 0.1, "{factor:?}");
    // a factor on damping moves no frequency: to rounding of eigenvalues beside one 6e4 times as
    // large
    let augmented = plant_file::parse("augmented", found.augmented_plant.as_ref().unwrap()).unwrap().plant;
    let (before, after) = (plant_modes(&plant, &[]).unwrap(), plant_modes(&augmented, &[]).unwrap());
    assert!(before.iter().zip(&after).all(|(a, b)| (a.frequency_hz / b.frequency_hz - 1.0).abs() < 1e-6));
    let again = asked(&augmented, &measured(&all_damping_times(&plant, 1.8), 2e-3, 0.05, 4));
    assert_eq!(again.verdict, Verdict::None, "{}", again.reason);
}

#[test]
fn stiffness_and_damping_that_are_both_wrong_are_both_named_with_their_sizes() {
    let plant = cantilever();
    let mut truth = all_damping_times(&plant, 0.5);
    truth.appendages[0].modes.iter_mut().for_each(|mode| mode.frequency_hz.value *= 0.94);
    let found = asked(&plant, &measured(&truth, 2e-3, 0.05, 5));
    assert_eq!(found.verdict, Verdict::Named, "{}", found.reason);
    let mut kinds: Vec<&str> = found.effects.iter().map(|effect| effect.kind.as_str()).collect();
    kinds.sort_unstable();
    assert_eq!(kinds, ["damping_scale", "frequency_scale"], "{}", found.reason);
    for effect in &found.effects {
        let expected = if effect.kind == "damping_scale" { 0.5 } else { 0.94 };
        let factor = &effect.parameters[0];
        assert!((factor.value - expected).abs() < 3.0 * factor.sigma.max(1e-4), "{factor:?}");
        assert_eq!(effect.status, Status::Confirmed);
    }
}

#[test]
fn one_mode_whose_damping_is_off_is_that_mode() {
    let plant = cantilever();
    let mut truth = plant.clone();
    truth.appendages[0].modes[2].damping_ratio.value *= 3.0;
    let found = asked(&plant, &measured(&truth, 2e-3, 0.05, 6));
    assert_eq!(found.effects.len(), 1, "{}", found.reason);
    assert_eq!(found.effects[0].kind, "damping_of_one_mode", "{}", found.reason);
    assert_eq!(found.effects[0].site, "mode:bending_3");
}

#[test]
fn a_dashpot_at_a_joint_damps_each_mode_by_the_square_of_its_shape_there_and_is_named() {
    let (plant, damper) = (rig(0.0), 6.0);
    let (before, after) = (plant_modes(&plant, &[]).unwrap(), plant_modes(&rig(damper), &[]).unwrap());
    // independent: modes of M, K written by hand; light damping adds c θ² / 2ω, θ the joint's part
    // of the mass-normalised shape
    let beam = &plant.appendages[0].modes;
    let n = beam.len() + 1;
    let mass = nalgebra::DMatrix::from_fn(n, n, |i, j| match (i, j) {
        (0, 0) => 9.0,
        (0, k) | (k, 0) => beam[k - 1].rotation_sqrt_kg_m[2].value,
        (i, j) => f64::from(u8::from(i == j)),
    });
    let omega = |k: usize| core::f64::consts::TAU * beam[k - 1].frequency_hz.value;
    let stiffness = nalgebra::DVector::from_fn(n, |i, _| if i == 0 { 4000.0 } else { omega(i) * omega(i) });
    let scaled = nalgebra::DMatrix::from_fn(n, n, |i, j| mass[(i, j)] / (stiffness[i] * stiffness[j]).sqrt());
    let eigen = nalgebra::SymmetricEigen::new(scaled);
    for (k, eigenvalue) in eigen.eigenvalues.iter().enumerate() {
        let omega = 1.0 / eigenvalue.sqrt();
        let theta = eigen.eigenvectors[(0, k)] * omega / 4000.0f64.sqrt();
        let mode = |of: &[plant_modes::PlantMode]| {
            let near =
                |m: &&plant_modes::PlantMode| (m.frequency_hz * core::f64::consts::TAU / omega - 1.0).abs() < 1e-2;
            of.iter().find(near).unwrap().damping_ratio
        };
        let (found, expected) = (mode(&after) - mode(&before), damper * theta * theta / (2.0 * omega));
        // what modes add to each other is of the second order
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }
    let found = asked(&plant, &measured(&rig(damper), 1e-3, 0.04, 7));
    let c = &found.effects[0].parameters[0];
    assert!((c.value - damper).abs() < 3.0 * c.sigma && c.sigma < 0.2 * damper, "{} {c:?}", found.reason);
    // a film that brakes the bar, which only turns about the shaft, is the damper in the shaft by
    // another name
    assert_eq!(found.verdict, Verdict::NotSeparable, "{}", found.reason);
    let names: Vec<&str> = core::iter::once(found.effects[0].kind.as_str())
        .chain(found.effects[0].rivals.iter().map(|rival| rival.kind.as_str()))
        .take(2)
        .collect();
    assert!(names.contains(&"joint_viscous") && names.contains(&"spin_damping"), "{names:?}");
}

#[test]
fn a_damping_that_is_off_by_less_than_damping_is_ever_trusted_to_is_no_finding() {
    let plant = cantilever();
    // three per cent, measured to three per mil
    let found = asked(&plant, &measured(&all_damping_times(&plant, 1.03), 2e-3, 3e-3, 8));
    assert_eq!(found.verdict, Verdict::None, "{}", found.reason);
}

#[test]
fn a_peak_as_narrow_as_the_lines_says_nothing_of_damping() {
    let plant = cantilever();
    // lines of 0.05 Hz: the half-power width 2 ζ f of the plant is 0.015 to 1.7 Hz, that of the
    // lower modes below five lines
    let truth = hz(&with_tip_mass(0.0));
    let spectrum = spectrum(&truth, 0.001, 1);
    let (modes, narrow) = spectrum.modes_with_own_damping();
    assert!(narrow > 0 && narrow < modes.len(), "{narrow} of {}", modes.len());
    for mode in &modes {
        assert_eq!(mode.damping_ratio.is_finite(), 2.0 * 0.001 * mode.frequency_hz > 0.25, "{mode:?}");
    }
    let found = diagnose_spectrum(&plant, &spectrum, &FeatureOptions::default());
    assert!(found.notes.iter().any(|note| note.contains("as narrow as the lines")), "{:?}", found.notes);
}
