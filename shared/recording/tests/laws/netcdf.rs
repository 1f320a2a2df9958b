//! netCDF of the classic formats, written by netCDF4 1.7.5: 200 samples of a rate and of a voltage.

use recording::Imported;
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

#[test]
fn the_three_classic_formats_hold_what_was_written() {
    for name in ["cdf1.nc", "cdf2.nc", "cdf5.nc"] {
        let set = recording::series(recording::read(&path(name)).unwrap()).unwrap();
        let named = |own: &str| set.recording.channel_named(own).unwrap_or_else(|| panic!("{name}: {:?}", set.notes));
        let rate = named("rate[1]");
        assert_eq!((rate.unit.as_str(), rate.value.len(), set.origin_s), ("rad/s", 200, 1_709_651_098), "{name}");
        for (k, value) in rate.value.iter().enumerate() {
            assert_eq!(*value as f32, (0.2 * k as f64).cos() as f32, "{name}");
        }
        // stored 0 to 49 again and again, of which one is marked as missing
        let voltage = named("counts");
        assert_eq!((voltage.unit.as_str(), voltage.value.len()), ("V", 199), "{name}");
        assert!((voltage.value[9] - 1.1).abs() < 1e-12 && !voltage.time_s.contains(&0.03), "{name}");
    }
}

#[test]
fn what_a_header_claims_beyond_the_file_is_an_error_at_once() {
    let whole = std::fs::read(path("cdf2.nc")).unwrap();
    let cut = crate::scratch("cut.nc");
    for length in (4..whole.len()).step_by(37) {
        std::fs::write(&cut, &whole[..length]).unwrap();
        let error = recording::read(&cut).map(|_: Imported| ()).unwrap_err().explain();
        assert!(error.contains("cure: "), "{length}: {error}");
    }
    // every byte of the header another one: read or refused, never a panic, never more than the file
    for at in 4..700 {
        let mut changed = whole.clone();
        changed[at] ^= 0xff;
        std::fs::write(&cut, &changed).unwrap();
        if let Ok(set) = recording::read(&cut).and_then(recording::series) {
            let samples: usize = set.recording.channels.iter().map(|channel| channel.value.len()).sum();
            assert!(samples <= whole.len(), "{at}: {samples}");
        }
    }
}
