//! The text of a proposed plant file.

use super::roles::{Guess, Role, guesses, noise_sigma, resolution};
use crate::plant::words::digits;
use channels::{Channel, Recording};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// A plant file and how it came about.
pub struct Proposal {
    pub text: String,
    /// One a channel: what it was taken for, and why.
    pub lines: Vec<String>,
    channels: Vec<Value>,
}

/// A joint that channels ask for.
struct Axis {
    name: String,
    /// Slides rather than turns.
    linear: bool,
    /// `x`, `y` or `z`.
    along: &'static str,
    why: String,
}

/// What moves.
struct Mechanism {
    /// No rate was recorded.
    only_accelerations: bool,
    spatial: bool,
    /// A free body: an inertial measurement unit on something that is nowhere held.
    free: bool,
    axes: Vec<Axis>,
}

impl Proposal {
    /// # Errors
    /// No channel says anything of motion.
    pub fn new(name: &str, from: &Path, parts: &[Recording]) -> Result<Self, String> {
        let channels = &parts[0].channels;
        let guesses = guesses(parts);
        let used = guesses.iter().any(|guess| !matches!(guess.role, Role::Unused | Role::Command));
        if !used {
            return Err("no channel says anything of motion".into());
        }
        let mechanism = Mechanism::of(channels, &guesses);
        let mut text = head(name, from, &mechanism);
        bodies(&mechanism, &mut text);
        for (channel, guess) in channels.iter().zip(&guesses) {
            actuator(channel, guess, &mechanism, &mut text);
        }
        for (channel, guess) in channels.iter().zip(&guesses) {
            sensor(channel, guess, &mechanism, parts, &mut text);
        }
        closing(&mechanism, parts, &mut text);
        let line = |(channel, guess): (&Channel, &Guess)| {
            format!("{:<26} {:<8} {:<14} {}", channel.name, channel.unit, word(guess.role), guess.why)
        };
        let object = |(channel, guess): (&Channel, &Guess)| json!({ "name": channel.name, "unit": channel.unit, "taken_for": word(guess.role), "why": guess.why });
        Ok(Proposal {
            text,
            lines: channels.iter().zip(&guesses).map(line).collect(),
            channels: channels.iter().zip(&guesses).map(object).collect(),
        })
    }

    /// The proposal as one line of JSON: the file written and the guess for each channel.
    pub fn json(&self, out: &Path) -> String {
        format!("{}\n", json!({ "out": out.display().to_string(), "channels": self.channels }))
    }
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
    }
}

/// A name that a plant file can hold: letters, digits, underscores.
pub fn plain(name: &str) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if !plain.starts_with(char::is_alphabetic) {
        plain.insert_str(0, "rig_");
    }
    plain
}

/// The axis that a channel's name ends in.
fn axis_of(name: &str) -> Option<&'static str> {
    let last = name.rsplit(['_', '.', ' ', '-']).next()?;
    ["x", "y", "z"].into_iter().find(|axis| last.eq_ignore_ascii_case(axis))
}

impl Mechanism {
    fn of(channels: &[Channel], guesses: &[Guess]) -> Self {
        let with = |roles: &[Role]| {
            let chosen = channels.iter().zip(guesses).filter(|(_, guess)| roles.contains(&guess.role));
            chosen.map(|(channel, _)| channel.name.as_str()).collect::<Vec<_>>()
        };
        let coordinates = with(&[Role::Angle, Role::Imposed, Role::Displacement]);
        let rates = with(&[Role::AngleRate]);
        let accelerations = with(&[Role::Acceleration]);
        let three = rates.len() > 1 || accelerations.iter().any(|name| axis_of(name) == Some("z"));
        if coordinates.is_empty()
            && (three || (!accelerations.is_empty() && !rates.is_empty()) || accelerations.len() > 1)
        {
            return Mechanism { only_accelerations: rates.is_empty(), spatial: three, free: true, axes: Vec::new() };
        }
        let mut axes: Vec<Axis> = Vec::new();
        for (channel, guess) in channels.iter().zip(guesses) {
            let coordinate = matches!(guess.role, Role::Angle | Role::Imposed | Role::Displacement);
            let alone = coordinates.is_empty()
                && axes.is_empty()
                && matches!(guess.role, Role::AngleRate | Role::Velocity | Role::Acceleration);
            if coordinate || alone {
                let linear = channel.unit.starts_with('m');
                let vertical =
                    linear && ["height", "altitude", "drop", "vertical"].iter().any(|word| channel.name.contains(word));
                let along =
                    if vertical { "y" } else { axis_of(&channel.name).filter(|axis| *axis != "z").unwrap_or("x") };
                let name = format!("joint_{}", plain(&channel.name));
                axes.push(Axis { name, linear, along, why: format!("of channel '{}'", channel.name) });
            }
        }
        Mechanism { only_accelerations: false, spatial: false, free: false, axes }
    }

    /// The joint whose kind a channel fits: the same place among its like, else the last.
    fn joint(&self, channel: &Channel, linear: bool) -> Option<&Axis> {
        let digits: String = channel.name.chars().filter(char::is_ascii_digit).collect();
        let fits = || self.axes.iter().filter(move |axis| axis.linear == linear);
        let numbered = fits().find(|axis| !digits.is_empty() && axis.name.contains(&digits));
        numbered.or_else(|| fits().next_back())
    }

    fn body(&self) -> String {
        if self.free { "body".into() } else { format!("part_{}", self.axes.len()) }
    }

    fn vertical(&self) -> bool {
        self.axes.iter().any(|axis| axis.linear && axis.along == "y")
    }
}

fn head(name: &str, from: &Path, mechanism: &Mechanism) -> String {
    let space = if mechanism.spatial { "spatial" } else { "planar" };
    let gravity = if mechanism.spatial { "[0, 0, \"-9.81 m/s^2\"]" } else { "[0, \"-9.81 m/s^2\"]" };
    let file = from.file_name().map(|name| name.to_string_lossy().replace(['"', '\\'], "_")).unwrap_or_default();
    format!(
        "# Proposed from {file}. Lines marked FILL IN hold what only you know; the rest was guessed from names, units and values.\n\
         format = 1\n\
         name = \"{name}\"\n\
         about = \"Rig recorded in {file}\" # FILL IN: one sentence\n\
         space = \"{space}\" # {}\n\
         gravity = {gravity} # FILL IN: leave it out where it does not act\n",
        if mechanism.spatial {
            "more than one axis of turning or a z axis was recorded"
        } else {
            "all channels fit one plane"
        }
    )
}

fn bodies(mechanism: &Mechanism, text: &mut String) {
    let inertia = if mechanism.spatial {
        "{ value = [\"0.1 kg*m^2\", \"0.1 kg*m^2\", \"0.1 kg*m^2\"], sigma = \"0.05 kg*m^2\" }"
    } else {
        "{ value = \"0.1 kg*m^2\", sigma = \"100 %\" }"
    };
    let com = if mechanism.spatial { "[0, 0, 0]" } else { "[0, 0]" };
    let mut body = |name: &str, parent: Option<String>, joint: String, com: &str| {
        let parent =
            parent.map_or(String::new(), |parent| format!("parent = \"{parent}\" # guessed: one carries the other\n"));
        let _ = write!(
            text,
            "\n[[body]]\nname = \"{name}\" # FILL IN: what it is called\n{parent}mass = {{ value = \"1 kg\", sigma = \"100 %\" }} # FILL IN\n\
             com = {{ value = {com}, sigma = \"0.1 m\" }} # FILL IN: centre of mass in the body's axes\n\
             inertia = {inertia} # FILL IN: about the centre of mass\n{joint}"
        );
    };
    if mechanism.free {
        let why = if mechanism.only_accelerations {
            "accelerations alone were recorded. FILL IN: what vibrates in place is a body on a spring (joint) or an appendage"
        } else {
            "rates and accelerations alone were recorded: nothing holds it"
        };
        body("body", None, format!("joint = {{ kind = \"free\" }} # {why}\n"), com);
    }
    for (i, axis) in mechanism.axes.iter().enumerate() {
        let kind = if axis.linear { "prismatic" } else { "revolute" };
        let along = if axis.linear { format!("axis = \"{}\"\n", axis.along) } else { "axis = \"z\"\n".to_owned() };
        let unit = if axis.linear { "N*s/m" } else { "N*m*s/rad" };
        let turned = if axis.linear {
            ""
        } else {
            "orientation = { angle = \"-90 deg\" } # FILL IN: so that it hangs at angle zero; \"0 deg\" without gravity\n"
        };
        let place =
            if i == 0 { "" } else { "position = [\"0.5 m\", 0] # FILL IN: where the joint is on the part before\n" };
        let joint = format!(
            "\n[body.joint]\nkind = \"{kind}\" # {}\nname = \"{}\"\n{along}{place}{turned}friction = {{ value = \"0.01 {unit}\", sigma = \"0.05 {unit}\" }} # FILL IN: viscous\n",
            axis.why, axis.name
        );
        let parent = (i > 0).then(|| format!("part_{i}"));
        let com = if axis.linear { "[0, 0]" } else { "[\"0.1 m\", 0]" };
        body(&format!("part_{}", i + 1), parent, joint, com);
    }
}

fn actuator(channel: &Channel, guess: &Guess, mechanism: &Mechanism, text: &mut String) {
    let name = plain(&channel.name);
    let why = &guess.why;
    let axis = axis_of(&channel.name).filter(|axis| mechanism.spatial || *axis != "z").unwrap_or("x");
    let begin = format!("\n[[actuator]] # {why}\nname = \"{name}\"\n");
    let held = "# its command is the channel of that name in the recording; what stands here is for simulation\n";
    let peak = channel.value.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let amplitude = digits(if peak > 0.0 { peak } else { 1.0 }, 3);
    let unit = channel.unit.as_str();
    let command = |unit: &str| {
        format!(
            "{held}command = {{ kind = \"square\", amplitude = \"{amplitude} {unit}\", frequency = \"0.1 Hz\" }} # FILL IN: as large as recorded, its form is a guess\n"
        )
    };
    let kind = match (guess.role, unit) {
        (Role::Imposed, _) => {
            let Some(joint) = mechanism.joint(channel, unit == "m") else { return };
            format!(
                "kind = \"prescribed_joint\"\njoint = \"{}\"\nwhat = \"position\"\n{held}command = {{ kind = \"sine\", amplitude = \"{amplitude} {unit}\", frequency = \"0.5 Hz\" }} # FILL IN\n",
                joint.name
            )
        }
        (Role::Command, "A" | "V") => {
            let Some(joint) = mechanism.joint(channel, false).or(mechanism.axes.last()) else { return };
            let drive = if unit == "A" {
                "drive = \"current\"\n".to_owned()
            } else {
                "drive = \"voltage\"\nresistance = { value = \"1 ohm\", sigma = \"100 %\" } # FILL IN\nback_emf = { value = \"0.05 V*s/rad\", sigma = \"100 %\" } # FILL IN\n".to_owned()
            };
            format!(
                "kind = \"motor\"\njoint = \"{}\"\nconstant = {{ value = \"0.05 N*m/A\", sigma = \"100 %\" }} # FILL IN\ngear = 1 # FILL IN\n{drive}{}",
                joint.name,
                command(unit)
            )
        }
        (Role::Command, "N") if mechanism.free => {
            format!(
                "kind = \"body_force\"\nbody = \"{}\"\ndirection = \"{axis}\" # FILL IN, with position = [\"0 m\", \"0 m\"] where it acts\n{}",
                mechanism.body(),
                command(unit)
            )
        }
        (Role::Command, "N*m") if mechanism.free => {
            let about = if mechanism.spatial { format!("direction = \"{axis}\" # FILL IN\n") } else { String::new() };
            format!("kind = \"body_torque\"\nbody = \"{}\"\n{about}{}", mechanism.body(), command(unit))
        }
        (Role::Command, _) => match mechanism.joint(channel, unit == "N") {
            Some(joint) => format!("kind = \"joint_torque\"\njoint = \"{}\"\n{}", joint.name, command(unit)),
            None if unit == "N" => format!(
                "kind = \"body_force\"\nbody = \"{}\"\ndirection = \"{axis}\" # FILL IN\n{}",
                mechanism.body(),
                command(unit)
            ),
            None => {
                let _ = write!(text, "\n# '{}' [{unit}] has no joint that it could act in\n", channel.name);
                return;
            }
        },
        _ => return,
    };
    let _ = write!(text, "{begin}{kind}");
}

fn sensor(channel: &Channel, guess: &Guess, mechanism: &Mechanism, parts: &[Recording], text: &mut String) {
    let name = plain(&channel.name);
    let body = mechanism.body();
    let spatial_axis = axis_of(&channel.name).filter(|axis| mechanism.spatial || *axis != "z");
    let along = spatial_axis.or(mechanism.axes.last().map(|axis| axis.along)).unwrap_or("x");
    let on_joint = |kind: &str, linear: bool| {
        mechanism.joint(channel, linear).map(|joint| format!("kind = \"{kind}\"\njoint = \"{}\"\n", joint.name))
    };
    let what = match guess.role {
        Role::Angle => on_joint("encoder", false),
        Role::Displacement | Role::Imposed => on_joint("encoder", channel.unit == "m"),
        Role::AngleRate => on_joint("joint_rate", false).or_else(|| {
            let axis =
                if mechanism.spatial { format!("axis = \"{}\"\n", spatial_axis.unwrap_or("z")) } else { String::new() };
            Some(format!("kind = \"gyro\"\nbody = \"{body}\"\n{axis}"))
        }),
        Role::Velocity => on_joint("joint_rate", true).or_else(|| {
            Some(format!("kind = \"velocity\"\nbody = \"{body}\"\naxis = \"{along}\" # of inertial space\n"))
        }),
        Role::Acceleration => Some(format!(
            "kind = \"accelerometer\"\nbody = \"{body}\"\nposition = {{ value = {}, sigma = \"2 cm\" }} # FILL IN: where it sits\naxis = \"{along}\"\n",
            if mechanism.spatial { "[0, 0, 0]" } else { "[0, 0]" }
        )),
        Role::Force => on_joint("joint_torque", true),
        Role::Torque => on_joint("joint_torque", false),
        Role::Command | Role::Unused => None,
    };
    let Some(what) = what else {
        if guess.role != Role::Command {
            let _ = write!(
                text,
                "\n# '{}' [{}] is not used: {}\n",
                channel.name.replace('\n', " "),
                channel.unit,
                guess.why
            );
        }
        return;
    };
    // two channels cannot have one name: what is imposed is also read
    let imposed = guess.role == Role::Imposed;
    let name = if imposed { format!("{name}_reading") } else { name };
    let why = if imposed { "the imposed motion as it was read" } else { guess.why.as_str() };
    let values = longest(channel, parts);
    let (sigma, step) = (noise_sigma(values), resolution(values));
    let floor = step.map_or(0.0, |step| step / 12.0_f64.sqrt());
    let unit = channel.unit.as_str();
    let noise = if sigma > floor {
        format!("noise = \"{} {unit}\" # of one sample, from the recording's third differences\n", digits(sigma, 2))
    } else {
        format!("noise = \"{} {unit}\" # not above the resolution\n", digits(floor.max(1e-12), 2))
    };
    let step = step.map_or(String::new(), |step| {
        format!("resolution = \"{} {unit}\" # smallest step in the recording\n", digits(step, 3))
    });
    let bias = digits((3.0 * sigma).max(floor).max(1e-9), 2);
    let _ = write!(
        text,
        "\n[[sensor]] # {}\nname = \"{name}\"\n{what}{noise}{step}bias = {{ value = 0, sigma = \"{bias} {unit}\", scope = \"per recording\" }} # FILL IN: of the data sheet\n{}",
        why,
        own_period(channel, parts)
    );
}

/// Values of the channel in the part where it has most.
fn longest<'p>(channel: &Channel, parts: &'p [Recording]) -> &'p [f64] {
    let of = |part: &'p Recording| part.channel_named(&channel.name).map(|found| found.value.as_slice());
    parts.iter().filter_map(of).max_by_key(|values| values.len()).unwrap_or(&[])
}

fn own_period(channel: &Channel, parts: &[Recording]) -> String {
    let (period_s, _) = rates(parts);
    let own_s = median_step(&channel.time_s);
    if (own_s / period_s - 1.0).abs() < 0.01 { String::new() } else { format!("period = \"{} s\"\n", digits(own_s, 6)) }
}

/// Sample period of the fastest channel, and the length of all parts.
pub fn rates(parts: &[Recording]) -> (f64, f64) {
    let steps = parts.iter().flat_map(|part| &part.channels).map(|channel| median_step(&channel.time_s));
    let period_s = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let length = |part: &Recording| {
        let ends = part.channels.iter().filter_map(|channel| Some(channel.time_s.last()? - channel.time_s.first()?));
        ends.fold(0.0, f64::max)
    };
    let period_s = if period_s.is_finite() { period_s } else { 0.01 };
    (period_s, parts.iter().map(|part| length(part) + period_s).sum())
}

/// The upper of the two in the middle: a step that the file has, with its digits. Half way between
/// two, as `estimation::quantiles` gives it, may be a period that no channel has.
fn median_step(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

fn closing(mechanism: &Mechanism, parts: &[Recording], text: &mut String) {
    let (period_s, length_s) = rates(parts);
    let imposed = text.contains("prescribed_joint");
    let first = mechanism.axes.first().filter(|_| !imposed);
    let begin_of = |part: &Recording| {
        let axis = first?;
        let (unit, rate) = if axis.linear { ("m", "m/s") } else { ("rad", "rad/s") };
        let value = part.channels.iter().find(|channel| format!("joint_{}", plain(&channel.name)) == axis.name);
        let value = value.filter(|channel| channel.unit == unit).and_then(|channel| channel.value.first());
        let value = digits(value.copied().unwrap_or(0.0), 4);
        Some(format!(
            "\"joint:{}\" = {{ position = {{ value = \"{value} {unit}\", sigma = \"1 {unit}\", scope = \"per segment\" }}, rate = {{ value = 0, sigma = \"1 {rate}\", scope = \"per segment\" }} }}",
            axis.name
        ))
    };
    if parts.len() == 1 {
        if let Some(begin) = begin_of(&parts[0]) {
            let begin = begin.replace("per segment", "per recording");
            let _ = write!(text, "\n[initial] # the first sample\n{begin}\n");
        }
    } else {
        let mut at_s = 0.0;
        for (i, part) in parts.iter().enumerate() {
            let end_s = at_s + rates(std::slice::from_ref(part)).1;
            let initial = begin_of(part).map_or(String::new(), |begin| format!("initial = {{ {begin} }}\n"));
            let why = if i == 0 { "" } else { " # time begins again here in the recording" };
            let _ = write!(
                text,
                "\n[[segment]]{why}\nname = \"part_of_record_{}\"\nbegin = \"{} s\"\nend = \"{} s\"\n{initial}",
                i + 1,
                digits(at_s, 9),
                digits(end_s, 9)
            );
            at_s = end_s;
        }
    }
    if mechanism.vertical() {
        let _ = write!(text, "\n# y points upwards, along which gravity acts\n");
    }
    let _ = write!(
        text,
        "\n[simulation] # from the time column\nduration = \"{} s\"\nperiod = \"{} s\"\n",
        digits(length_s, 9),
        digits(period_s, 9)
    );
}
