//! What a channel of a recording is likely to be: stated by the user, by its name, or guessed
//! from its unit and how it moves.

use super::names::{Side, side};
use channels::{Channel, Recording};
use recording::units::NOT_STATED;

/// What a channel is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A force, torque, current or voltage that is set.
    Command,
    /// A motion that is imposed.
    Imposed,
    Angle,
    AngleRate,
    Displacement,
    Velocity,
    Acceleration,
    Force,
    Torque,
    /// Says nothing of motion, or is another channel once more.
    Unused,
    /// Its numbers have no unit that says what it is: the user has to say it.
    Unknown,
}

impl Role {
    /// Asks for a body that moves.
    pub fn is_motion(self) -> bool {
        use Role::{Acceleration, Angle, AngleRate, Displacement, Imposed, Velocity};
        matches!(self, Imposed | Angle | AngleRate | Displacement | Velocity | Acceleration)
    }
}

/// A channel, and why it is taken for what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    pub role: Role,
    pub why: String,
}

/// What the user says of channels: their names in the recording.
#[derive(Clone, Debug, Default)]
pub struct Told {
    pub commands: Vec<String>,
    pub measured: Vec<String>,
}

/// Steps of a held signal: an input keeps its value over most samples, or takes few values.
const HELD_SHARE: f64 = 0.8;
/// Noise below this share of a signal is the rounding of its digits, not a sensor's.
const NOISELESS_SHARE: f64 = 1e-6;
/// Noise below this many of the smallest steps of a signal is its rounding: that has 1/√12 of one.
const ROUNDING_STEPS: f64 = 0.5;
/// Orders of differences: what is left of noise is the same in all, of a motion less in each.
const ORDERS: [usize; 4] = [3, 4, 5, 6];

/// Every channel's role.
pub fn guesses(parts: &[Recording], told: &Told) -> Vec<Guess> {
    let channels = &parts[0].channels;
    let rig = Rig::of(channels, told);
    let mut guesses: Vec<Guess> = channels.iter().map(|channel| rig.guess(channel)).collect();
    impose(&mut guesses);
    guesses
}

/// A force, torque, current or voltage.
fn is_effort(unit: &str) -> bool {
    matches!(unit, "N" | "N*m" | "A" | "V")
}

/// What all channels together say of one.
struct Rig<'r> {
    told: &'r Told,
    /// Units of efforts that are commands, by the user or by name.
    commanded: Vec<&'r str>,
    /// Units of efforts of which nobody says that they were measured.
    unsaid: Vec<&'r str>,
    moves: bool,
}

impl<'r> Rig<'r> {
    fn of(channels: &'r [Channel], told: &'r Told) -> Self {
        let mut rig = Rig { told, commanded: Vec::new(), unsaid: Vec::new(), moves: false };
        for channel in channels {
            let unit = channel.unit.as_str();
            rig.moves |= matches!(unit, "m" | "m/s" | "m/s^2" | "rad" | "rad/s");
            match rig.side(channel).map(|(side, _)| side) {
                Some(Side::Commanded) if is_effort(unit) => rig.commanded.push(unit),
                None if is_effort(unit) => rig.unsaid.push(unit),
                _ => {}
            }
        }
        rig
    }

    /// Side of a channel and who says so: the user before the name.
    fn side(&self, channel: &Channel) -> Option<(Side, String)> {
        if self.told.commands.contains(&channel.name) {
            return Some((Side::Commanded, "you say that it is a command".into()));
        }
        if self.told.measured.contains(&channel.name) {
            return Some((Side::Measured, "you say that it was measured".into()));
        }
        side(&channel.name).map(|(side, word)| {
            let what = match side {
                Side::Commanded => "is a command",
                Side::Measured => "was measured",
                Side::Computed => "was computed from other channels, so it is no measurement",
            };
            (side, format!("`{word}` in its name says that it {what}"))
        })
    }

    fn guess(&self, channel: &Channel) -> Guess {
        let (unit, side) = (channel.unit.as_str(), self.side(channel));
        let said = |role, why: &str| Guess { role, why: why.to_owned() };
        if unit == NOT_STATED {
            return said(Role::Unknown, "its unit is not stated");
        }
        match (unit, side) {
            (_, Some((Side::Computed, why))) => said(Role::Unused, &why),
            ("-", Some((Side::Commanded, why))) => said(Role::Unknown, &format!("{why}, and its unit is of no force")),
            ("A" | "V", side) => self.electric(channel, side),
            ("N" | "N*m", side) => self.effort(channel, side),
            (unit, side) => {
                let Some((role, what)) = motion(unit) else {
                    return said(Role::Unused, &format!("'{unit}' says nothing of motion"));
                };
                match side {
                    Some((Side::Commanded, why)) if self.told.commands.contains(&channel.name) => {
                        said(Role::Imposed, &why)
                    }
                    Some((Side::Commanded, why)) => {
                        said(Role::Unused, &format!("{why}: of a loop, whose output is what drives the rig"))
                    }
                    _ => said(role, &format!("its unit is that of {what}")),
                }
            }
        }
    }

    /// Current and voltage: one of them drives.
    fn electric(&self, channel: &Channel, side: Option<(Side, String)>) -> Guess {
        let unit = channel.unit.as_str();
        let said = |role, why: String| Guess { role, why };
        match side {
            Some((Side::Commanded, why)) => said(Role::Command, why),
            Some((_, why)) if !self.commanded.is_empty() || !self.unsaid.is_empty() => {
                said(Role::Unused, format!("{why}, and another channel drives"))
            }
            Some((_, why)) => said(Role::Command, format!("{why}, and nothing else drives the rig")),
            None if !self.commanded.is_empty() => said(Role::Unused, "another channel is the command".into()),
            None if unit == "V" && self.unsaid.contains(&"A") => {
                said(Role::Unused, "the current that was recorded beside it sets the torque".into())
            }
            None => said(Role::Command, "its unit is that of a drive's input".into()),
        }
    }

    /// Force and torque: set or read.
    fn effort(&self, channel: &Channel, side: Option<(Side, String)>) -> Guess {
        let measured = if channel.unit == "N" { Role::Force } else { Role::Torque };
        let said = |role, why: &str| Guess { role, why: why.to_owned() };
        match side {
            Some((Side::Commanded, why)) => said(Role::Command, &why),
            Some((_, why)) => said(measured, &why),
            None if is_held(channel) => said(Role::Command, "it is constant over stretches, as a command is"),
            None if is_noiseless(channel) => {
                said(Role::Command, "it has no noise beyond its rounding, as a command has none")
            }
            None if !self.commanded.is_empty() => {
                said(measured, "another channel is the command, and this one is noisy")
            }
            None if self.unsaid.len() > 1 => {
                said(Role::Command, "several forces or torques without a name that says they were measured")
            }
            None if self.moves => said(
                measured,
                &format!(
                    "it is noisy and never held, as a measurement is; if it drives the rig: --command '{}'",
                    channel.name
                ),
            ),
            None => said(Role::Command, "nothing else drives the rig"),
        }
    }
}

/// What a unit says of motion.
fn motion(unit: &str) -> Option<(Role, &'static str)> {
    Some(match unit {
        "rad" => (Role::Angle, "an angle"),
        "rad/s" => (Role::AngleRate, "a rate"),
        "m" => (Role::Displacement, "a displacement"),
        "m/s" => (Role::Velocity, "a velocity"),
        "m/s^2" => (Role::Acceleration, "an acceleration"),
        _ => return None,
    })
}

/// A rig with a measured force and no command is moved as commanded: its displacement is the input.
fn impose(guesses: &mut [Guess]) {
    let has = |guesses: &[Guess], role| guesses.iter().any(|guess| guess.role == role);
    if has(guesses, Role::Command) || has(guesses, Role::Imposed) {
        return;
    }
    for (effort, motion) in [(Role::Force, Role::Displacement), (Role::Torque, Role::Angle)] {
        if !has(guesses, effort) {
            continue;
        }
        if let Some(at) = guesses.iter().position(|guess| guess.role == motion) {
            let why =
                "a force is measured and nothing is commanded: the motion is imposed, the force follows".to_owned();
            guesses[at] = Guess { role: Role::Imposed, why };
        }
    }
}

/// Most samples repeat the one before, or there are few values in all.
pub fn is_held(channel: &Channel) -> bool {
    let repeated = channel.value.windows(2).filter(|pair| pair[0] == pair[1]).count();
    channel.value.len() > 8 && repeated as f64 > HELD_SHARE * (channel.value.len() - 1) as f64
}

/// What is left of the channel beside a motion is the rounding of its digits.
fn is_noiseless(channel: &Channel) -> bool {
    let n = channel.value.len() as f64;
    let mean = channel.value.iter().sum::<f64>() / n;
    let spread = (channel.value.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n).sqrt();
    let sigma = ORDERS.iter().map(|order| noise_by(&channel.value, *order)).fold(f64::INFINITY, f64::min);
    let step = resolution(&channel.value).or_else(|| last_digit(&channel.value, spread));
    let rounding = ROUNDING_STEPS * step.unwrap_or(0.0);
    sigma <= rounding.max(NOISELESS_SHARE * spread)
}

/// White noise of one sample from what is left of a channel after its third difference. The median
/// takes no notice of the jumps of a command or a contact; motion below a twentieth of the sample
/// rate is gone.
pub fn noise_sigma(values: &[f64]) -> f64 {
    noise_by(values, 3)
}

/// The same by the difference of an order n: `σ(∇ⁿy)/√(2n choose n)`.
fn noise_by(values: &[f64], order: usize) -> f64 {
    let mut left = values.to_vec();
    let mut gain = 1.0;
    for k in 1..=order {
        left = left.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gain *= 2.0 * (2 * k - 1) as f64 / k as f64;
    }
    if left.is_empty() {
        return 0.0;
    }
    left.iter_mut().for_each(|x| *x = x.abs());
    left.sort_by(f64::total_cmp);
    // The upper of the two in the middle, as proposals have always had it; against interpolation
    // the digits change, not the estimate. Median of |x| of a normal distribution: 0.6745 σ.
    left[left.len() / 2] / 0.6745 / f64::sqrt(gain)
}

/// Smallest step of which all differences are multiples; `None` where there is none above the
/// digits of the file.
pub fn resolution(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let span = sorted.last()? - sorted.first()?;
    let steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-9 * span).collect();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let whole = |step: &&f64| ((**step / least) - (**step / least).round()).abs() < 0.05 || **step > 50.0 * least;
    let share = steps.iter().filter(whole).count() as f64 / steps.len().max(1) as f64;
    let distinct = steps.len() + 1;
    (distinct > 1 && share > 0.95 && (distinct as f64) < 0.9 * values.len() as f64).then_some(least)
}

/// The power of ten that all values are multiples of; `None` where it is below the digits of a
/// signal of this spread.
fn last_digit(values: &[f64], spread: f64) -> Option<f64> {
    let least = (spread * NOISELESS_SHARE).log10().floor() as i32;
    let most = spread.log10().ceil() as i32;
    let is_multiple = |value: &f64, step: f64| {
        let steps = value / step;
        (steps - steps.round()).abs() <= 1e-9 * steps.abs().max(1.0)
    };
    let all = |power: &i32| values.iter().all(|value| is_multiple(value, 10f64.powi(*power)));
    (least..=most).rev().find(all).map(|power| 10f64.powi(power))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::noise::Stream;

    fn channel(name: &str, unit: &'static str, values: Vec<f64>) -> Channel {
        Channel::new(name, unit, (0..values.len()).map(|k| k as f64 * 0.01).collect(), values)
    }

    #[test]
    fn noise_is_found_under_a_slow_motion_and_beside_jumps() {
        let stream = Stream::new(1, "noise");
        let at = |k: usize| (k as f64 * 0.01).sin() + if k > 700 { 3.0 } else { 0.0 };
        let values: Vec<f64> = (0..2000).map(|k| at(k) + 0.02 * stream.normal(k as u64)).collect();
        assert!((noise_sigma(&values) / 0.02 - 1.0).abs() < 0.1); // median of 2000 correlated samples: 3 % one sigma
    }

    #[test]
    fn the_step_of_an_encoder_is_found_and_none_where_there_is_none() {
        let smooth: Vec<f64> = (0..3000).map(|k| (k as f64 * 0.013).sin()).collect();
        let step = 1.57e-3;
        let coarse: Vec<f64> = smooth.iter().map(|value| (value / step).round() * step).collect();
        assert!((resolution(&coarse).unwrap() / step - 1.0).abs() < 1e-6); // rounding of a difference
        assert_eq!(resolution(&smooth), None);
    }

    #[test]
    fn a_held_force_is_a_command_and_a_noisy_one_beside_a_motion_a_measurement() {
        let stream = Stream::new(1, "force");
        let held = channel("push", "N", (0..400).map(|k| f64::from(k / 50 % 2)).collect());
        let noisy = channel("force", "N", (0..400).map(|k| stream.normal(k)).collect());
        let place = channel("place", "m", (0..400).map(|k| (k as f64 * 0.05).sin()).collect());
        let set = |channels: Vec<Channel>| vec![Recording { name: "x".into(), channels }];
        let roles = |channels| {
            guesses(&set(channels), &Told::default()).into_iter().map(|guess| guess.role).collect::<Vec<_>>()
        };
        assert_eq!(roles(vec![held, place.clone()]), [Role::Command, Role::Displacement]);
        assert_eq!(roles(vec![place, noisy]), [Role::Imposed, Role::Force]);
    }

    #[test]
    fn a_smooth_force_in_rounded_digits_is_a_command_however_fast_it_moves() {
        let at = |k: usize| (0.091 * k as f64).sin() + 0.4 * (0.05 * k as f64).cos();
        let rounded: Vec<f64> = (0..2000).map(|k| (at(k) * 1e4).round() * 1e-4).collect();
        let place = channel("place", "m", (0..2000).map(|k| (k as f64 * 0.05).sin()).collect());
        let stream = Stream::new(5, "read");
        let read = (0..2000).map(|k| ((at(k) + 1e-3 * stream.normal(k as u64)) * 1e4).round() * 1e-4).collect();
        let of = |values| roles(vec![channel("force", "N", values), place.clone()], &Told::default());
        assert_eq!(of(rounded), [Role::Command, Role::Displacement]);
        assert_eq!(of(read), [Role::Force, Role::Imposed]);
    }

    fn roles(channels: Vec<Channel>, told: &Told) -> Vec<Role> {
        let set = [Recording { name: "x".into(), channels }];
        guesses(&set, told).into_iter().map(|guess| guess.role).collect()
    }

    fn noisy(name: &str, unit: &'static str) -> Channel {
        let stream = Stream::new(3, name);
        channel(name, unit, (0..400).map(|k| (k as f64 * 0.05).sin() + 0.1 * stream.normal(k)).collect())
    }

    #[test]
    fn of_a_commanded_and_a_measured_effort_one_drives_the_rig() {
        let of = |names: [(&str, &'static str); 3]| {
            roles(names.into_iter().map(|(name, unit)| noisy(name, unit)).collect(), &Told::default())
        };
        use Role::{Angle, AngleRate, Command, Torque, Unused};
        assert_eq!(of([("iq_ref", "A"), ("iq_meas", "A"), ("speed", "rad/s")]), [Command, Unused, AngleRate]);
        assert_eq!(of([("current", "A"), ("bus_voltage", "V"), ("pos", "rad")]), [Command, Unused, Angle]);
        assert_eq!(of([("tauCmd", "N*m"), ("tauFb", "N*m"), ("q", "rad")]), [Command, Torque, Angle]);
        // a drive that logs its current alone: that is what turns it
        assert_eq!(
            of([("current_act", "A"), ("speed_ref", "rad/s"), ("speed", "rad/s")]),
            [Command, Unused, AngleRate]
        );
    }

    #[test]
    fn the_user_is_believed_before_the_name() {
        let channels = || vec![noisy("tau_cmd", "N*m"), noisy("tau_meas", "N*m"), noisy("q", "rad")];
        let told = Told { commands: vec!["tau_meas".into()], measured: vec!["tau_cmd".into()] };
        assert_eq!(roles(channels(), &told), [Role::Torque, Role::Command, Role::Angle]);
        let imposed = Told { commands: vec!["q".into()], ..Told::default() };
        assert_eq!(roles(channels(), &imposed)[2], Role::Imposed);
    }

    #[test]
    fn a_channel_without_a_unit_is_asked_about() {
        let channels = vec![noisy("thruster_cmd", "-"), noisy("w", NOT_STATED), noisy("q", "rad")];
        assert_eq!(roles(channels, &Told::default()), [Role::Unknown, Role::Unknown, Role::Angle]);
    }
}
