//! Frequency responses as evidence: their modes, found as `obsid modal` finds them, are a list of
//! modes.

use super::modes_file::ModesFile;
use crate::Failure;
use crate::modal::responses::{Identified, are_complex, identified};
use discovery::features::{MeasuredMode, ShapeComponent};
use nalgebra::Complex;
use recording::Spectrum;
use std::ops::RangeInclusive;

/// Orders of the fraction: those of `obsid modal`.
const ORDERS: RangeInclusive<usize> = 2..=30;

/// The modes of the responses in `spectra`, all of one structure; `None` where they are no complex
/// responses, and where one file of them shows no modes that way: its peaks are used then, which a
/// note says.
///
/// # Errors
/// [`Failure::Input`] where several files cannot be taken together, or show no modes.
pub fn modes_or_peaks(spectra: &mut [(Spectrum, String)]) -> Result<Option<ModesFile>, Failure> {
    let none = |found: &Option<ModesFile>| found.as_ref().is_some_and(|found| found.modes.is_empty());
    match (modes(spectra), spectra) {
        (Err(_), [(one, _)]) => {
            one.notes.push("no rational fraction describes the responses: its peaks are used".into())
        }
        (Ok(found), [(one, _)]) if none(&found) => {
            one.notes.push("no mode of the responses stands out of their noise: its peaks are used".into());
        }
        (found, _) => return found,
    }
    Ok(None)
}

fn modes(spectra: &[(Spectrum, String)]) -> Result<Option<ModesFile>, Failure> {
    let all: Vec<Spectrum> = spectra.iter().map(|(spectrum, _)| spectrum.clone()).collect();
    if !are_complex(&all) {
        return Ok(None);
    }
    let found = identified(&all, ORDERS)?;
    let modes: Vec<MeasuredMode> = (0..found.fit.modes.len()).map(|k| measured(&found, k)).collect();
    let mut notes = vec![format!(
        "{} modes of {} frequency responses (rational fraction of order {}) are the evidence; deviations are those of the residual",
        modes.len(),
        found.names.len(),
        found.fit.order
    )];
    let left_out = found.fit.unresolved.len();
    if left_out > 0 {
        notes.push(format!("{left_out} poles whose damping is within three deviations of zero are left out"));
    }
    notes.extend(all.iter().flat_map(|spectrum| spectrum.notes.iter().cloned()));
    let files: Vec<&str> = all.iter().map(|spectrum| spectrum.file.as_str()).collect();
    let digests: Vec<&str> = spectra.iter().map(|(_, digest)| digest.as_str()).collect();
    Ok(Some(ModesFile { file: files.join(" "), digest: digests.join(" "), modes, tracks: Vec::new(), notes }))
}

fn measured(found: &Identified, k: usize) -> MeasuredMode {
    let mode = &found.fit.modes[k];
    let component = |(name, psi): (&String, &modal::c64)| ShapeComponent {
        channel: name.clone(),
        value: Complex::new(psi.re, psi.im),
        sigma: 0.0,
    };
    MeasuredMode {
        frequency_hz: mode.frequency_hz,
        sigma_hz: mode.frequency_sd,
        damping_ratio: mode.damping_ratio,
        damping_sigma: mode.damping_sd,
        prominence: 1.0,
        shape: found.names.iter().zip(&mode.mode_shape).map(component).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use discovery::diagnose::Verdict;
    use dynamics::description::Plant;
    use dynamics::system::{System, Workspace};
    use nalgebra::{DMatrix, DVector};
    use recording::Column;

    /// A clamped panel of five modes and six accelerometers, pushed at its tip.
    fn panel(frequency: f64, damping: f64) -> Plant {
        let mut text = String::from(
            "format = 1\nname = \"panel\"\nabout = \"clamped panel\"\nspace = \"planar\"\n\
             [[body]]\nname = \"bar\"\nmass = \"20 kg\"\ninertia = \"9 kg*m^2\"\n\
             [body.joint]\nkind = \"revolute\"\nname = \"shaft\"\nstiffness = \"40000 N*m/rad\"\n\
             [[actuator]]\nname = \"shaker\"\nkind = \"joint_torque\"\njoint = \"shaft\"\n\
             [[appendage]]\nname = \"beam\"\nbody = \"bar\"\n",
        );
        for k in 0..6 {
            text.push_str(&format!("points.p{k} = [\"{} m\", 0]\n", 0.5 + 0.3 * f64::from(k)));
        }
        for (n, (hz, rotation)) in [(2.0, 1.2), (5.1, 0.7), (9.7, 0.9), (15.6, 0.5), (22.9, 0.6)].iter().enumerate() {
            text.push_str(&format!(
                "[[appendage.mode]]\nname = \"bending_{n}\"\nfrequency = \"{} Hz\"\ndamping_ratio = {}\nrotation = \"{rotation} sqrt(kg)*m\"\n",
                hz * frequency,
                0.01 * damping
            ));
            for k in 0..6 {
                let shape = libm::sin((n as f64 + 0.5) * core::f64::consts::PI * f64::from(k + 1) / 6.0);
                text.push_str(&format!("shape.p{k} = [0, \"{shape} 1/sqrt(kg)\"]\n"));
            }
        }
        for k in 0..6 {
            text.push_str(&format!(
                "[[sensor]]\nname = \"acceleration_{k}z\"\nkind = \"accelerometer\"\npoint = \"beam:p{k}\"\naxis = \"y\"\nnoise = \"1 mm/s^2\"\n"
            ));
        }
        plant_file::parse("panel", &text).unwrap().plant
    }

    /// `C (iω − A)⁻¹ B + D` by a solve at every line, with a relative error of one per mil of the
    /// largest response.
    fn responses(plant: &Plant) -> Spectrum {
        let system = System::new(plant).unwrap();
        let x = vec![0.0; system.states().len()];
        let space = system.linearise(&mut Workspace::new(&system), 0.0, &x, &[0.0]);
        let frequency_hz: Vec<f64> = (1..1200).map(|k| 0.025 * f64::from(k)).collect();
        let n = x.len();
        let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
        let at = |f: &f64| -> DVector<Complex<f64>> {
            let s = Complex::new(0.0, core::f64::consts::TAU * f);
            let resolvent = DMatrix::from_diagonal_element(n, n, s) - complex(&space.a);
            let inside = resolvent.lu().solve(&complex(&space.b)).unwrap();
            (complex(&space.c) * inside + complex(&space.d)).column(0).into_owned()
        };
        let all: Vec<_> = frequency_hz.iter().map(at).collect();
        let largest = all.iter().flat_map(|y| y.iter().map(|y| y.norm_sqr().sqrt())).fold(0.0, f64::max);
        // a fixed sequence without order, as good as noise here
        let mut seed = 1_u64;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            1e-4 * largest * ((seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5)
        };
        let mut columns = Vec::new();
        for k in 0..6 {
            let parts = [("real", 0), ("imag", 1)];
            for (part, of) in parts {
                let values = all.iter().map(|y| if of == 0 { y[k].re + noise() } else { y[k].im + noise() });
                let name = format!("accelerance_{k}z_9z_{part}");
                columns.push(Column::si(&name, "m/s^2/N", values.collect()));
            }
        }
        Spectrum { file: "panel.uff".into(), frequency_hz, columns, notes: Vec::new() }
    }

    fn asked(truth: &Plant) -> discovery::diagnose::Diagnosis {
        let mut spectra = vec![(responses(truth), String::new())];
        let found = modes_or_peaks(&mut spectra).unwrap().expect("complex responses");
        crate::diagnose::modes_file::diagnose(&panel(1.0, 1.0), &found)
    }

    #[test]
    fn frequency_responses_of_the_plant_itself_miss_nothing_and_have_its_shapes() {
        let found = asked(&panel(1.0, 1.0));
        assert_eq!(found.verdict, Verdict::None, "{} {:?}", found.reason, found.notes);
        assert!(found.notes.iter().any(|note| note.contains("shapes over 6 sensors, MAC")), "{:?}", found.notes);
    }

    #[test]
    fn frequency_responses_name_stiffness_and_damping_that_are_both_wrong() {
        let found = asked(&panel(0.9, 2.0));
        let mut kinds: Vec<(&str, f64)> =
            found.effects.iter().map(|effect| (effect.kind.as_str(), effect.parameters[0].value)).collect();
        kinds.sort_by_key(|(kind, _)| *kind);
        assert_eq!(found.verdict, Verdict::Named, "{} {:?}", found.reason, found.notes);
        let [("damping_scale", damping), ("frequency_scale", frequency)] = kinds[..] else { panic!("{kinds:?}") };
        // 5 % of discrepancy is the least that a damping ratio is trusted to, over five of them
        assert!((damping - 2.0).abs() < 0.15 && (frequency - 0.9).abs() < 2e-3, "{kinds:?}");
    }
}
