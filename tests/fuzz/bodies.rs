//! What a reader does with bytes that nobody vouches for: it answers or gives a reason, and never
//! panics.
//!
//! One body per format, for the fuzzer (`cargo +nightly fuzz run csv`, from `tests/fuzz`) and for
//! the seeded run of the suite.

use runtime::checkpoint::Store;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a reader does with bytes.
pub type Body = fn(&[u8]);

/// Every format with its body.
pub const BODIES: [(&str, Body); 6] = [
    ("csv", |bytes| recording_file("csv", bytes)),
    ("mcap", |bytes| recording_file("mcap", bytes)),
    ("uff", |bytes| recording_file("uff", bytes)),
    ("plant", plant),
    ("scenario", scenario),
    ("checkpoint", checkpoint),
];

/// A folder of this process and thread, so that bodies may run side by side.
fn folder() -> PathBuf {
    let thread = format!("{:?}", std::thread::current().id());
    let number: String = thread.chars().filter(char::is_ascii_digit).collect();
    let folder = std::env::temp_dir().join(format!("obsid-hostile-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    folder
}

/// Removes what the bodies of this thread wrote.
pub fn clean_up() {
    let _ = std::fs::remove_dir_all(folder());
}

fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    std::fs::write(&path, bytes).expect("a temporary file");
    path
}

fn recording_file(extension: &str, bytes: &[u8]) {
    let path = written(&format!("hostile.{extension}"), bytes);
    match recording::read(&path) {
        Ok(imported) => drop(recording::segments(imported)),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn plant(bytes: &[u8]) {
    if let Err(errors) = plant_file::parse("hostile.toml", &String::from_utf8_lossy(bytes)) {
        assert!(!errors.is_empty() && errors.iter().all(|error| error.line > 0 && !error.message.is_empty()));
    }
}

fn scenario(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(refusal) = plant_file::scenario::Scenario::read(&text, &BTreeMap::new(), true) {
        assert!(!refusal.to_string().is_empty());
    }
}

fn checkpoint(bytes: &[u8]) {
    let folder: &Path = &folder();
    std::fs::write(folder.join("hostile.0"), bytes).expect("a temporary file");
    // a slot that does not check is as if it were not there
    drop(Store::new(folder, "hostile").load());
}
