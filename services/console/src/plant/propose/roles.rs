//! What a channel of a recording is likely to be: guessed from its unit, its name, and how it
//! moves.

use channels::{Channel, Recording};

/// What a channel is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A force, torque, current or voltage that is set.
    Command,
    /// A displacement or angle that is imposed.
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
}

/// A channel, and why it is taken for what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    pub role: Role,
    pub why: String,
}

/// Steps of a held signal: an input keeps its value over most samples, or takes few values.
const HELD_SHARE: f64 = 0.8;

/// Every channel's role.
pub fn guesses(parts: &[Recording]) -> Vec<Guess> {
    let channels = &parts[0].channels;
    let mut guesses: Vec<Guess> = channels.iter().map(|channel| guess(channel, channels)).collect();
    impose(&mut guesses);
    guesses
}

fn guess(channel: &Channel, all: &[Channel]) -> Guess {
    let name = channel.name.to_lowercase();
    let said = |role, why: &str| Guess { role, why: why.to_owned() };
    if ["derived", "denoised", "filtered", "smoothed"].iter().any(|word| name.contains(word)) {
        return said(Role::Unused, "its name says that it was computed from another channel, so it is no measurement");
    }
    let efforts = all.iter().filter(|other| matches!(other.unit.as_str(), "N" | "N*m" | "A" | "V")).count();
    let moves = all.iter().any(|other| matches!(other.unit.as_str(), "m" | "m/s" | "m/s^2" | "rad" | "rad/s"));
    let measured = ["measured", "sensor", "load", "cell", "reaction"].iter().any(|word| name.contains(word));
    match channel.unit.as_str() {
        "A" | "V" => said(Role::Command, "its unit is that of a drive's input"),
        "N" | "N*m" => {
            let measured_role = if channel.unit == "N" { Role::Force } else { Role::Torque };
            if measured {
                said(measured_role, "its name says that it was measured")
            } else if is_held(channel) {
                said(Role::Command, "it is constant over stretches, as a command is")
            } else if efforts > 1 || name.contains("command") || noise_share(channel) < 1e-6 {
                said(Role::Command, "it has no noise of its own, as a command has none")
            } else if moves {
                said(measured_role, "it is noisy and never held, as a measurement is")
            } else {
                said(Role::Command, "nothing else drives the rig")
            }
        }
        "rad" => said(Role::Angle, "its unit is that of an angle"),
        "rad/s" => said(Role::AngleRate, "its unit is that of a rate"),
        "m" => said(Role::Displacement, "its unit is that of a displacement"),
        "m/s" => said(Role::Velocity, "its unit is that of a velocity"),
        "m/s^2" => said(Role::Acceleration, "its unit is that of an acceleration"),
        unit => said(Role::Unused, &format!("'{unit}' says nothing of motion")),
    }
}

/// A rig with a measured force and no command is moved as commanded: its displacement is the input.
fn impose(guesses: &mut [Guess]) {
    let has = |guesses: &[Guess], role| guesses.iter().any(|guess| guess.role == role);
    if has(guesses, Role::Command) {
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

/// Standard deviation of the noise over that of the channel.
fn noise_share(channel: &Channel) -> f64 {
    let n = channel.value.len() as f64;
    let mean = channel.value.iter().sum::<f64>() / n;
    let variance = channel.value.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / n;
    if variance > 0.0 { noise_sigma(&channel.value) / variance.sqrt() } else { 0.0 }
}

/// White noise of one sample from what is left of a channel after its third difference:
/// `σ(∇³y)/√20`. The median takes no notice of the jumps of a command or a contact; motion below a
/// twentieth of the sample rate is gone.
pub fn noise_sigma(values: &[f64]) -> f64 {
    let mut third: Vec<f64> = values.windows(4).map(|y| (y[3] - 3.0 * y[2] + 3.0 * y[1] - y[0]).abs()).collect();
    if third.is_empty() {
        return 0.0;
    }
    third.sort_by(f64::total_cmp);
    // The upper of the two in the middle, as proposals have always had it; against interpolation
    // the digits change, not the estimate. Median of |x| of a normal distribution: 0.6745 σ.
    third[third.len() / 2] / 0.6745 / 20.0_f64.sqrt()
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
        let roles = |channels| guesses(&set(channels)).into_iter().map(|guess| guess.role).collect::<Vec<_>>();
        assert_eq!(roles(vec![held, place.clone()]), [Role::Command, Role::Displacement]);
        assert_eq!(roles(vec![place, noisy]), [Role::Imposed, Role::Force]);
    }
}
