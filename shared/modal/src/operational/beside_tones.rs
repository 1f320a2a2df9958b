//! Modes of a stationary record beside its tones, which are taken out, and what a tone hides.

use super::rejected;
use crate::identifier::ModalError;
use crate::selection::{Mode, Selection};
use crate::stabilisation::Rejection;
use crate::tones::{Tone, ToneSearch};

/// Times that tones are sought again in what is left.
const ROUNDS: usize = 3;

/// Takes the tones out of a record with the modes `selection`, and selects modes from what is left
/// (`identified`) until no tone is found.
///
/// # Errors
/// Those of `identified`.
pub(super) fn identified(
    search: &mut ToneSearch,
    mut selection: Selection,
    identified: impl Fn(&[f64]) -> Result<Selection, ModalError>,
) -> Result<Selection, ModalError> {
    let with_tones = selection.modes.clone();
    for _ in 0..ROUNDS {
        let modes_hz: Vec<f64> = selection.modes.iter().map(|mode| mode.frequency_hz).collect();
        let mut taken = search.steady(&modes_hz);
        if taken == 0 {
            taken = selection.modes.iter().filter(|mode| search.wandering(mode)).count();
            taken += search.wandering_pairs(&selection.modes);
            taken += search.wandering_peaks(&modes_hz);
        }
        if taken == 0 {
            break;
        }
        search.join_side_bands();
        selection = identified(search.rest())?;
    }
    let remainder = |mode: &Mode| search.tones.iter().any(|tone| tone.wander_hz > 0.0 && is_within(mode, tone));
    let mut hidden: Vec<Mode> = selection.modes.extract_if(.., |mode| remainder(mode)).collect();
    hidden.extend(with_tones.into_iter().filter(|mode| is_lost(mode, &selection.modes, &search.tones)));
    selection.rejected.extend(hidden.iter().map(|mode| rejected(mode, Rejection::HiddenByTone)));
    Ok(selection)
}

fn is_within(mode: &Mode, tone: &Tone) -> bool {
    (mode.frequency_hz - tone.frequency_hz).abs() < tone.hides_hz
}

/// Whether a mode that was found with a steady tone on it is not found without: too little of the
/// mode is left, or it was the tone.
fn is_lost(mode: &Mode, found: &[Mode], tones: &[Tone]) -> bool {
    let half_width_hz = |mode: &Mode| mode.damping_ratio * mode.frequency_hz;
    let apart = |hz: f64| (mode.frequency_hz - hz).abs();
    let on_it =
        |tone: &&Tone| tone.wander_hz == 0.0 && apart(tone.frequency_hz) < tone.hides_hz.max(half_width_hz(mode));
    let Some(tone) = tones.iter().find(on_it) else { return false };
    let is = |other: &Mode| apart(other.frequency_hz) < half_width_hz(mode) + half_width_hz(other) + tone.hides_hz;
    !found.iter().any(is)
}
