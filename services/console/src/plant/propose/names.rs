//! What the name of a channel says of its side: commanded, measured, or computed from others; names
//! that a plant file can hold.

use Side::{Commanded, Computed, Measured};

/// The side of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Somebody set it.
    Commanded,
    /// A sensor read it.
    Measured,
    /// A program made it of other channels.
    Computed,
}

/// Words of names, in small letters, with what they say. A word counts where it stands alone: as
/// prefix, suffix, part of a path or of a camel-case name.
const WORDS: &[(&str, Side)] = &[
    ("actuator", Commanded),
    ("actuators", Commanded),
    ("cmd", Commanded),
    ("cmds", Commanded),
    ("command", Commanded),
    ("commanded", Commanded),
    ("commands", Commanded),
    ("consigne", Commanded),
    ("control", Commanded),
    ("ctrl", Commanded),
    ("demand", Commanded),
    ("demanded", Commanded),
    ("des", Commanded),
    ("desired", Commanded),
    ("excitation", Commanded),
    ("goal", Commanded),
    ("input", Commanded),
    ("ref", Commanded),
    ("reference", Commanded),
    ("req", Commanded),
    ("request", Commanded),
    ("requested", Commanded),
    ("set", Commanded),
    ("setpoint", Commanded),
    ("setpt", Commanded),
    ("soll", Commanded),
    ("sollwert", Commanded),
    ("sp", Commanded),
    ("stim", Commanded),
    ("stimulus", Commanded),
    ("target", Commanded),
    ("tgt", Commanded),
    ("act", Measured),
    ("actual", Measured),
    ("enc", Measured),
    ("encoder", Measured),
    ("fb", Measured),
    ("fbk", Measured),
    ("feedback", Measured),
    ("ist", Measured),
    ("istwert", Measured),
    ("loadcell", Measured),
    ("cell", Measured),
    ("mea", Measured),
    ("meas", Measured),
    ("measured", Measured),
    ("measurement", Measured),
    ("mess", Measured),
    ("obs", Measured),
    ("observed", Measured),
    ("output", Measured),
    ("pv", Measured),
    ("reaction", Measured),
    ("read", Measured),
    ("reading", Measured),
    ("resp", Measured),
    ("response", Measured),
    ("sens", Measured),
    ("sensed", Measured),
    ("sensor", Measured),
    ("denoised", Computed),
    ("derived", Computed),
    ("err", Computed),
    ("error", Computed),
    ("est", Computed),
    ("estimate", Computed),
    ("estimated", Computed),
    ("filt", Computed),
    ("filtered", Computed),
    ("pred", Computed),
    ("predicted", Computed),
    ("residual", Computed),
    ("smoothed", Computed),
];

/// What `name` says, and the word that says it; `None` where it says nothing, or both that it was
/// set and that it was read. A computed channel is one whatever it was made of.
pub fn side(name: &str) -> Option<(Side, &'static str)> {
    let words = words(name);
    let said = words.iter().filter_map(|word| WORDS.iter().find(|(known, _)| known == word));
    let said: Vec<(Side, &'static str)> = said.map(|(word, side)| (*side, *word)).collect();
    let first = said.iter().find(|(side, _)| *side == Computed).or(said.first()).copied()?;
    let contradicted = said.iter().any(|(side, _)| *side != first.0) && first.0 != Computed;
    (!contradicted).then_some(first)
}

/// The words of a name in small letters: parted by what is no letter, and before a capital behind a
/// small letter or in front of one (`qRefDeg`, `IQRef`, `set-point`).
pub fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (k, c) in letters.iter().enumerate() {
        let before = k.checked_sub(1).map(|k| letters[k]);
        let capital_begins = c.is_uppercase()
            && before.is_some_and(|before| {
                before.is_lowercase()
                    || (before.is_uppercase() && letters.get(k + 1).is_some_and(|next| next.is_lowercase()))
            });
        if capital_begins || !c.is_alphabetic() {
            words.push(String::new());
        }
        if c.is_alphabetic() {
            words.last_mut().expect("never empty").extend(c.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    // `set point` is one word in two
    let pairs: Vec<String> = words.windows(2).map(|pair| pair.concat()).collect();
    words.extend(pairs.into_iter().filter(|pair| matches!(pair.as_str(), "setpoint" | "loadcell")));
    words
}

/// A name that a plant file can hold: letters, digits, underscores.
pub fn plain(name: &str) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if !plain.starts_with(char::is_alphabetic) {
        plain.insert_str(0, "rig_");
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_believed_in_every_usual_spelling() {
        let commanded = "cmd_torque torque_cmd TorqueCmd torqueCmd TORQUE_CMD cmdTorque cmd.torque torque/cmd \
            /arm/command/effort tau_ref tauRef IqRef IQRef iq_ref ref_current u_set setCurrent set_point SetPoint \
            setpoint.torque desired_torque torque_des tauDes T_des targetTorque tgt_force demand_Nm force_req \
            Fx_commanded motor-command M_Soll actuator_torque";
        let measured = "torque_meas meas_torque TorqueMeas act_torque torque_act torqueActual actualTorque \
            tau_fb feedback/torque fbkCurrent sensor_force force.sensed load_cell loadCell F_ist enc_torque /ft_sensor/fx";
        let computed = "error_torque torqueErr torque_filtered est_torque accel_derived_x tau_pred cmd_filt";
        for (side_of, names) in [(Commanded, commanded), (Measured, measured), (Computed, computed)] {
            for name in names.split_whitespace() {
                assert_eq!(side(name).map(|said| said.0), Some(side_of), "{name}");
            }
        }
        let count = [commanded, measured, computed].iter().map(|names| names.split_whitespace().count()).sum::<usize>();
        assert!(count >= 40, "{count} spellings");
    }

    #[test]
    fn a_word_within_a_word_and_a_contradiction_say_nothing() {
        for name in ["torque", "offset_torque", "reset", "contact_force", "factor", "asset", "prefix", "cmd_meas", "x"]
        {
            assert_eq!(side(name), None, "{name}");
        }
    }
}
