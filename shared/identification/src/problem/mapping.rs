//! Names, scales and signs of a recording's channels turned into those of the plant.

use channels::Recording;

/// One channel: `ours = scale × theirs`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// Name in the plant.
    pub ours: String,
    /// Name in the recording.
    pub theirs: String,
    /// −1 turns a sign, π/180 degrees into radians.
    pub scale: f64,
}

impl From<(String, String)> for Mapping {
    fn from((ours, theirs): (String, String)) -> Self {
        Self { ours, theirs, scale: 1.0 }
    }
}

/// Renames and scales the channels of `recording`. A scale other than ±1 changes the unit, which is
/// then taken to be the plant's.
///
/// # Errors
/// The names that the recording does not have, and scales that are no numbers or zero.
pub fn apply_map(recording: &mut Recording, map: &[Mapping]) -> Result<(), Vec<String>> {
    let held = |name: &str| recording.channels.iter().any(|channel| channel.name == name);
    let bad = |m: &&Mapping| !held(&m.theirs) || !m.scale.is_finite() || m.scale == 0.0;
    let missing: Vec<String> = map.iter().filter(bad).map(|m| m.theirs.clone()).collect();
    if !missing.is_empty() {
        return Err(missing);
    }
    // one channel of theirs may be several of ours; what keeps its name stays beside it
    let mut channels = Vec::with_capacity(recording.channels.len());
    for channel in &recording.channels {
        let mut uses = map.iter().filter(|m| m.theirs == channel.name).peekable();
        let replaced = map.iter().any(|m| m.ours == channel.name && m.theirs != channel.name);
        if uses.peek().is_none() && !replaced {
            channels.push(channel.clone());
        }
        for mapping in uses {
            let mut mapped = channel.clone();
            mapped.name.clone_from(&mapping.ours);
            if mapping.scale != 1.0 {
                mapped.value.iter_mut().for_each(|value| *value *= mapping.scale);
            }
            if mapping.scale.abs() != 1.0 {
                mapped.unit.clear();
            }
            channels.push(mapped);
        }
    }
    recording.channels = channels;
    Ok(())
}
