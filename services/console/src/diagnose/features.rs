//! Spectra as evidence: the command line hands them to the feature form of the diagnosis.
//!
//! A file may hold a magnitude, or real and imaginary parts under names that end so; phases and
//! coherences carry no peaks. Only the first response of the file is used; a note names it.

use discovery::diagnose::Diagnosis;
use discovery::features::{self, FeatureOptions};
use dynamics::description::Plant;
use recording::Spectrum;

/// Endings of the names of two columns that are one response.
const PARTS: [(&str, &str); 4] = [("_real", "_imag"), ("_re", "_im"), (".real", ".imag"), (".re", ".im")];
/// Words in the names of columns that are no response.
const NO_RESPONSE: [&str; 2] = ["phase", "coherence"];

/// What is missing from `plant` according to `spectrum`.
///
/// The only place that knows of the feature form (measured against the plant's frequencies): it is
/// called here and nowhere else.
pub fn diagnose(plant: &Plant, spectrum: &Spectrum) -> Diagnosis {
    let Some((name, magnitude)) = response(spectrum) else {
        return Diagnosis::cannot_decide(format!(
            "{} has no column that is the magnitude of a response, or its real and imaginary part",
            spectrum.file
        ));
    };
    let used =
        features::Spectrum { name: spectrum.file.clone(), frequency_hz: spectrum.frequency_hz.clone(), magnitude };
    let mut diagnosis = features::diagnose_spectrum(plant, &used, &FeatureOptions::default());
    if spectrum.columns.len() > 1 {
        diagnosis.notes.push(format!("{}: the response used is {name}", spectrum.file));
    }
    diagnosis.notes.extend(spectrum.notes.iter().map(|note| format!("{}: {note}", spectrum.file)));
    diagnosis
}

/// Name and magnitude of the first response.
fn response(spectrum: &Spectrum) -> Option<(String, Vec<f64>)> {
    spectrum.columns.iter().filter(|column| column.kind.has_resonances()).find_map(|column| {
        let name = column.name.to_lowercase();
        for (real, imaginary) in PARTS {
            let Some(stem) = name.strip_suffix(real) else { continue };
            let other = spectrum.columns.iter().find(|c| c.name.to_lowercase() == format!("{stem}{imaginary}"))?;
            let size = column.values.iter().zip(&other.values).map(|(re, im)| libm::hypot(*re, *im)).collect();
            return Some((column.name[..stem.len()].to_owned(), size));
        }
        let is_size = column.values.iter().all(|v| *v >= 0.0) && !NO_RESPONSE.iter().any(|word| name.contains(word));
        is_size.then(|| (column.name.clone(), column.values.clone()))
    })
}

#[cfg(test)]
mod tests {
    use super::response;
    use recording::Spectrum;

    fn spectrum(columns: &str, row: &str) -> Spectrum {
        let path = std::env::temp_dir().join(format!("obsid-spectrum-{}-{}.csv", std::process::id(), columns.len()));
        let rows: String = (1..20).map(|i| format!("{i},{row}\n")).collect();
        std::fs::write(&path, format!("frequency [Hz],{columns}\n{rows}")).unwrap();
        let read = recording::read(&path);
        std::fs::remove_file(&path).unwrap();
        match read.unwrap() {
            recording::Imported::Spectrum(spectrum) => spectrum,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_first_response_is_a_magnitude_or_two_parts_and_neither_phase_nor_coherence() {
        let parts = spectrum("coherence [-],hub_real [m/s^2/N],hub_imag [m/s^2/N]", "1,-3,4");
        let (name, size) = response(&parts).unwrap();
        assert_eq!((name.as_str(), size[0]), ("hub", 5.0));
        assert_eq!(response(&spectrum("phase [rad],tip [m/s^2]", "1,2")).unwrap().0, "tip");
        assert!(response(&spectrum("phase [rad]", "1")).is_none());
        assert!(response(&spectrum("alone_real [m/s^2/N]", "-1")).is_none());
    }
}
