//! Golden verdicts: answers that a change of structure must leave as they are.
//!
//! `verdicts.json` holds the verdict, the effects with status and parameters (four significant
//! digits) of 40 seeded challenge cases and of the public recordings, and the digests of four runs.
//! `OBSID_BLESS=1 cargo test --release --test golden_verdicts` writes the file anew; the commit
//! that does so explains every line that changed.
//!
//! Public recordings are looked for in `OBSID_RECORDINGS`, then in `../shared/recordings`; their
//! entries are skipped (said) without them. `laws` holds the same diagnoses against what the
//! recordings' documentation says.

mod answers;
mod laws;
mod recordings;
mod store;

use recordings::Recordings;
use serde_json::{Map, Value};
use store::{compare, scratch};

#[test]
fn seeded_challenge_cases_are_answered_as_before() {
    compare("challenge", Some(answers::challenge(&scratch("challenge"), 40, 34)));
}

#[test]
fn public_recordings_are_answered_as_before() {
    let of = |(name, found): (&String, &Value)| (name.clone(), answers::answer(found));
    compare("recordings", Recordings::diagnoses().map(|all| Value::Object(all.iter().map(of).collect())));
}

#[test]
fn runs_end_with_the_digests_of_before() {
    let scenario = |name: &str| format!("deploy/scenarios/{name}.toml");
    let mut digests = Map::new();
    for name in ["default", "short"] {
        digests.insert(format!("run {name}"), answers::digest(&["run", &scenario(name)]));
    }
    compare("runs", Some(Value::Object(digests)));
}

#[test]
fn replays_end_with_the_digests_of_before() {
    compare("replays", Recordings::find().map(|recordings| recordings.digests()));
}
