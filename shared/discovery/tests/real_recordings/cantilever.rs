//! Spectrum of a struck cantilever: its stiffness over mass is off, its boundary is not.

use crate::desk::{folder, print, rig};
use discovery::diagnose::Verdict;
use discovery::features::{FeatureOptions, Spectrum, diagnose_spectrum};
use recording::Imported;

#[test]
fn a_flat_scale_wins_on_the_cantilever_and_spring_and_mass_are_not_separable() {
    let Some(folder) = folder("cantilever_impulse_fft") else { return };
    let Imported::Spectrum(read) = recording::read(&folder.join("impulse_spectrum.csv.gz")).unwrap() else {
        panic!("the file is a spectrum")
    };
    let column = read.column_named("acceleration_rms").unwrap();
    let spectrum = Spectrum {
        name: "impulse".to_owned(),
        frequency_hz: read.frequency_hz.clone(),
        magnitude: read.columns[column].values.clone(),
    };
    for mode in spectrum.modes().iter().take(20) {
        println!("{mode:?}");
    }
    let found = diagnose_spectrum(&rig("cantilever"), &spectrum, &FeatureOptions::default());
    print(&found);
    for place in &found.located {
        println!("  {} {}", place.channel, place.site);
    }
    assert_ne!(found.verdict, Verdict::None);
    assert_eq!(found.effects[0].kind, "frequency_scale");
}
