//! The committed answers, and the difference to them in words.

use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Tests of this binary run side by side and bless one file.
static FILE: Mutex<()> = Mutex::new(());

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/verdicts.json")
}

/// An empty folder of this process.
pub fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("golden-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn stored() -> Map<String, Value> {
    let text = std::fs::read_to_string(path()).unwrap_or_else(|_| "{}".to_owned());
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path().display()))
}

/// Compares `answers` with what is stored under `section`; `None` was skipped.
pub fn compare(section: &str, answers: Option<Value>) {
    let Some(answers) = answers else { return };
    let _one_at_a_time = FILE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut stored = stored();
    if std::env::var_os("OBSID_BLESS").is_some() {
        stored.insert(section.to_owned(), answers);
        std::fs::write(path(), format!("{:#}\n", Value::Object(stored))).unwrap();
        return;
    }
    let before = stored.get(section).unwrap_or_else(|| panic!("verdicts.json has no section {section}"));
    let mut differences = Vec::new();
    differ(section, before, &answers, &mut differences);
    assert!(differences.is_empty(), "{} answers differ:\n{}", differences.len(), differences.join("\n"));
}

/// Every leaf that differs, with its place.
fn differ(place: &str, before: &Value, now: &Value, found: &mut Vec<String>) {
    match (before, now) {
        (Value::Object(old), Value::Object(new)) => {
            let keys = old.keys().chain(new.keys().filter(|key| !old.contains_key(*key)));
            for key in keys {
                let of = |map: &Map<String, Value>| map.get(key).cloned().unwrap_or(Value::Null);
                differ(&format!("{place} / {key}"), &of(old), &of(new), found);
            }
        }
        (Value::Array(old), Value::Array(new)) if old.len() == new.len() => {
            for (k, (old, new)) in old.iter().zip(new).enumerate() {
                differ(&format!("{place} / {k}"), old, new, found);
            }
        }
        _ if before == now => {}
        _ => found.push(format!("  {place}: {before} before, {now} now")),
    }
}

#[test]
fn a_changed_leaf_is_found_with_its_place() {
    let before = serde_json::json!({ "case": { "verdict": "none", "effects": [1, 2] } });
    let now = serde_json::json!({ "case": { "verdict": "named", "effects": [1, 3] }, "new": 1 });
    let mut found = Vec::new();
    differ("x", &before, &now, &mut found);
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[1].contains("x / case / effects / 1: 2 before, 3 now"), "{found:?}");
    differ("x", &before, &before, &mut found);
    assert_eq!(found.len(), 3);
}
