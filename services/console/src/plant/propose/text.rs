//! The text of a proposed plant file.

use super::beginning::closing;
use super::mechanism::{Mechanism, is_carried};
use super::parts::{actuator, sensor};
use super::roles::{Guess, Role, Told, guesses, is_held};
use channels::{Channel, Recording};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// A plant file and how it came about.
pub struct Proposal {
    pub text: String,
    /// One a channel: what it was taken for, and why.
    pub lines: Vec<String>,
    /// What the user has to say of channels whose unit does not say what they are.
    pub asked: Vec<String>,
    channels: Vec<Value>,
}

impl Proposal {
    /// # Errors
    /// No channel says anything of motion; what to do.
    pub fn new(name: &str, from: &Path, parts: &[Recording], told: &Told) -> Result<Self, (String, String)> {
        let channels = &parts[0].channels;
        let guesses = guesses(parts, told);
        let asked: Vec<String> = channels.iter().zip(&guesses).filter_map(question).collect();
        if !guesses.iter().any(|guess| guess.role.is_motion()) {
            let motion =
                "give a recording with at least one angle, rate, displacement, velocity or acceleration over time";
            let cure = if asked.is_empty() { motion.to_owned() } else { asked.join("; ") };
            return Err(("no channel says anything of motion".into(), cure));
        }
        let mechanism = Mechanism::of(channels, &guesses);
        let mut text = head(name, from, &mechanism, parts, &guesses);
        bodies(&mechanism, &mut text);
        for (channel, guess) in channels.iter().zip(&guesses) {
            actuator(channel, guess, &mechanism, &mut text);
        }
        for (channel, guess) in channels.iter().zip(&guesses) {
            sensor(channel, guess, &mechanism, parts, &mut text);
        }
        closing(&mechanism, &guesses, parts, &mut text);
        let line = |(channel, guess): (&Channel, &Guess)| {
            format!("{:<26} {:<8} {:<14} {}", channel.name, channel.unit, word(guess.role), guess.why)
        };
        let object = |(channel, guess): (&Channel, &Guess)| json!({ "name": channel.name, "unit": channel.unit, "taken_for": word(guess.role), "why": guess.why });
        Ok(Proposal {
            text,
            lines: channels.iter().zip(&guesses).map(line).collect(),
            asked,
            channels: channels.iter().zip(&guesses).map(object).collect(),
        })
    }

    /// The text with a number at each place that is to be filled in.
    pub fn filled(&self) -> String {
        self.text.replace("\"? ", "\"1 ").replace("\"?\"", "\"x\"")
    }

    /// Places that are to be filled in.
    pub fn blanks(&self) -> usize {
        self.text.lines().filter(|line| line.contains("FILL IN")).count() - 1
    }

    /// The proposal as one line of JSON: the file written and the guess for each channel.
    pub fn json(&self, out: &Path) -> String {
        let object = json!({ "out": out.display().to_string(), "channels": self.channels,
            "to_fill_in": self.blanks(), "asked": self.asked });
        format!("{object}\n")
    }
}

/// How the user says what a channel is, whose unit does not.
fn question((channel, guess): (&Channel, &Guess)) -> Option<String> {
    let name = (guess.role == Role::Unknown).then_some(&channel.name)?;
    let full = if is_held(channel) {
        format!(
            "; where 1 stands for full thrust, a map scales it: --map FILE with [channels] \"{name}\" = {{ name = \"{name}\", \
             unit = \"N\", scale = 0.8 }}"
        )
    } else {
        String::new()
    };
    Some(format!(
        "say the unit of '{name}': --channel '{name} = {name} [UNIT]', as in [rad], [deg/s], [m/s^2], [N], [A]{full}"
    ))
}

const fn word(role: Role) -> &'static str {
    match role {
        Role::Command => "command",
        Role::Imposed => "imposed motion",
        Role::Angle => "angle",
        Role::AngleRate => "rate",
        Role::Displacement => "displacement",
        Role::Velocity => "velocity",
        Role::Acceleration => "acceleration",
        Role::Force => "force",
        Role::Torque => "torque",
        Role::Unused => "not used",
        Role::Unknown => "asked about",
    }
}

fn head(name: &str, from: &Path, mechanism: &Mechanism, parts: &[Recording], guesses: &[Guess]) -> String {
    let space = if mechanism.spatial { "spatial" } else { "planar" };
    let file = from.file_name().map(|name| name.to_string_lossy().replace(['"', '\\'], "_")).unwrap_or_default();
    format!(
        "# Proposed from {file}. FILL IN: a place with \"?\" that only you know, value and sigma (how far off it may be;\n\
         # a number alone, as in mass = \"2 kg\", is taken as exact). CHECK: a guess. The rest is from names, units and values.\n\
         format = 1\n\
         name = \"{name}\"\n\
         about = \"Rig recorded in {file}\"\n\
         space = \"{space}\" # {}\n{}",
        if mechanism.spatial {
            "more than one axis of turning or a z axis was recorded"
        } else {
            "all channels fit one plane"
        },
        gravity(mechanism, parts, guesses)
    )
}

/// Gravity: on a free body what its accelerometers say, else on.
fn gravity(mechanism: &Mechanism, parts: &[Recording], guesses: &[Guess]) -> String {
    let down = if mechanism.spatial { "[0, 0, \"-9.81 m/s^2\"]" } else { "[0, \"-9.81 m/s^2\"]" };
    let acts = |why: &str| format!("gravity = {down} # CHECK: {why}\n");
    if !mechanism.free {
        return acts("leave it out where the motion is horizontal");
    }
    if guesses.iter().all(|guess| guess.role != Role::Acceleration) {
        "# no gravity: it does not show in rates\n".into()
    } else if is_carried(&parts[0].channels, guesses) {
        acts("the accelerometers read its reaction on the mean")
    } else {
        "# CHECK: no gravity, the accelerometers read none on the mean (free fall, or gravity was subtracted)\n".into()
    }
}

fn bodies(mechanism: &Mechanism, text: &mut String) {
    const MASS: &str = "mass = { value = \"? kg\", sigma = \"? kg\" } # FILL IN: weigh it\n";
    let inertia = if mechanism.spatial { "[\"? kg*m^2\", \"? kg*m^2\", \"? kg*m^2\"]" } else { "\"? kg*m^2\"" };
    let mut body = |name: &str, parent: Option<String>, joint: String, com: &str, turns: bool| {
        let parent =
            parent.map_or(String::new(), |parent| format!("parent = \"{parent}\" # CHECK: one carries the other\n"));
        let inertia = if turns {
            format!(
                "inertia = {{ value = {inertia}, sigma = \"? kg*m^2\" }} # FILL IN: about the centre of mass; \
                 rod m L^2/12, disc m r^2/2, box m (a^2 + b^2)/12\n"
            )
        } else {
            "inertia = 0 # nothing turns\n".to_owned()
        };
        let _ = write!(text, "\n[[body]]\nname = \"{name}\"\n{parent}{MASS}{com}{inertia}{joint}");
    };
    if mechanism.free {
        let why = if mechanism.only_accelerations {
            "CHECK: accelerations alone were recorded; what vibrates in place is a body on a spring (joint) or an appendage"
        } else {
            "rates and accelerations alone were recorded: nothing holds it"
        };
        let joint = match mechanism.bearing {
            Some(axis) => format!(
                "joint = {{ kind = \"revolute\", name = \"bearing\", axis = \"{axis}\" }} # CHECK: the accelerometers read the \
                 reaction to gravity and one rate alone moves: a bearing carries it\n"
            ),
            None => format!("joint = {{ kind = \"free\" }} # {why}\n"),
        };
        let com = match mechanism.bearing {
            Some(_) => "# CHECK: its centre of mass is on the axis; else com = [\"? m\", \"? m\", 0]\n",
            None => "# its origin is its centre of mass\n",
        };
        body("body", None, joint, com, true);
    }
    let turns_behind = |i: usize| mechanism.axes[i..].iter().any(|axis| !axis.linear);
    let turning = |i: usize| mechanism.axes[..=i].iter().any(|axis| !axis.linear);
    for (i, axis) in mechanism.axes.iter().enumerate() {
        let kind = if axis.linear { "prismatic" } else { "revolute" };
        let along = if axis.linear { axis.along } else { "z" };
        let turned = if axis.linear {
            ""
        } else {
            "orientation = { angle = \"-90 deg\" } # CHECK: so that it hangs at angle zero; \"0 deg\" without gravity\n"
        };
        let place = if i > 0 && turns_behind(0) && turning(i - 1) {
            "position = [\"? m\", \"? m\"] # FILL IN: where the joint is on the part before\n"
        } else {
            ""
        };
        let joint = format!(
            "\n[body.joint]\nkind = \"{kind}\" # {}\nname = \"{}\"\naxis = \"{along}\"\n{place}{turned}\
             # friction: none is stated, so that a diagnosis finds what there is\n",
            axis.why, axis.name
        );
        let parent = (i > 0).then(|| format!("part_{i}"));
        let com = if axis.linear {
            ""
        } else {
            "com = { value = [\"? m\", 0], sigma = \"? m\" } # FILL IN: from the joint to the centre of mass; drop the line \
             for a balanced rotor\n"
        };
        body(&format!("part_{}", i + 1), parent, joint, com, turning(i));
    }
}
