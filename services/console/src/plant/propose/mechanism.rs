//! What moves: the joints that the channels of a recording ask for.

use super::names::{plain, words};
use super::roles::{Guess, Role, noise_sigma};
use channels::Channel;

/// A joint that channels ask for.
pub struct Axis {
    pub name: String,
    /// Slides rather than turns.
    pub linear: bool,
    /// `x`, `y` or `z`.
    pub along: &'static str,
    pub why: String,
}

/// What moves.
pub struct Mechanism {
    /// No rate was recorded.
    pub only_accelerations: bool,
    pub spatial: bool,
    /// A free body: an inertial measurement unit on something that is nowhere held.
    pub free: bool,
    /// The axis about which a bearing lets the free body turn: its weight is carried.
    pub bearing: Option<&'static str>,
    pub axes: Vec<Axis>,
}

/// Beginnings of words that end in an axis: `gx`, `accY`, `omegaz`.
const BEFORE_AXES: &[&str] = &[
    "", "a", "acc", "accel", "f", "force", "g", "gyr", "gyro", "m", "om", "omega", "p", "pos", "rate", "t", "tau",
    "thr", "thrust", "torque", "v", "vel", "w",
];

/// The axis that a channel's name ends in: `rate_x`, `gyroY`, `az`, `yaw_rate`.
pub fn axis_of(name: &str) -> Option<&'static str> {
    let words = words(name);
    let turn = |word: &String| [("roll", "x"), ("pitch", "y"), ("yaw", "z")].into_iter().find(|(of, _)| of == word);
    if let Some((_, axis)) = words.iter().find_map(turn) {
        return Some(axis);
    }
    // a number behind the letter counts like things, it names no axis
    let last = words.last().filter(|_| name.ends_with(char::is_alphabetic))?;
    let ends = |axis: &&str| last.strip_suffix(*axis).is_some_and(|stem| BEFORE_AXES.contains(&stem));
    ["x", "y", "z"].into_iter().find(ends)
}

impl Mechanism {
    /// The mechanism of the channels that were recorded.
    pub fn of(channels: &[Channel], guesses: &[Guess]) -> Self {
        let with = |roles: &[Role]| {
            let chosen = channels.iter().zip(guesses).filter(|(_, guess)| roles.contains(&guess.role));
            chosen.map(|(channel, _)| channel.name.as_str()).collect::<Vec<_>>()
        };
        let coordinates = with(&[Role::Angle, Role::Imposed, Role::Displacement]);
        let rates = with(&[Role::AngleRate]);
        let accelerations = with(&[Role::Acceleration]);
        // two rates about one axis are two joints
        let about: std::collections::BTreeSet<_> = rates.iter().filter_map(|name| axis_of(name)).collect();
        let three = about.len() > 1 || accelerations.iter().any(|name| axis_of(name) == Some("z"));
        if coordinates.is_empty()
            && (three || (!accelerations.is_empty() && !rates.is_empty()) || accelerations.len() > 1)
        {
            let bearing = if three { bearing(channels, guesses) } else { None };
            let only_accelerations = rates.is_empty();
            return Mechanism { only_accelerations, spatial: three, free: true, bearing, axes: Vec::new() };
        }
        let mut axes: Vec<Axis> = Vec::new();
        for (channel, guess) in channels.iter().zip(guesses) {
            let coordinate = matches!(guess.role, Role::Angle | Role::Imposed | Role::Displacement);
            let alone = coordinates.is_empty()
                && (axes.is_empty() || guess.role == Role::AngleRate)
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
        Mechanism { only_accelerations: false, spatial: false, free: false, bearing: None, axes }
    }

    /// The joint whose kind a channel fits: the same place among its like, else the last.
    pub fn joint(&self, channel: &Channel, linear: bool) -> Option<&Axis> {
        let digits: String = channel.name.chars().filter(char::is_ascii_digit).collect();
        let fits = || self.axes.iter().filter(move |axis| axis.linear == linear);
        let numbered = fits().find(|axis| !digits.is_empty() && axis.name.contains(&digits));
        numbered.or_else(|| fits().next_back())
    }

    /// The body that carries sensors without a joint.
    pub fn body(&self) -> String {
        if self.free { "body".into() } else { format!("part_{}", self.axes.len()) }
    }

    /// A joint slides along gravity.
    pub fn vertical(&self) -> bool {
        self.axes.iter().any(|axis| axis.linear && axis.along == "y")
    }
}

/// Specific force above this share of gravity is no free fall: half way between none and all.
const WEIGHT_SHARE: f64 = 0.5;
const STANDARD_GRAVITY: f64 = 9.806_65;
/// Ratio of a rate's deviation to its noise from which the body turns about its axis: noise alone
/// has 1.
const TURNING_RATIO: f64 = 5.0;

/// The accelerometers read the reaction to gravity on the mean: something carries the body.
pub fn is_carried(channels: &[Channel], guesses: &[Guess]) -> bool {
    let read = channels.iter().zip(guesses).filter(|(_, guess)| guess.role == Role::Acceleration);
    let square: f64 = read.map(|(channel, _)| mean(&channel.value).powi(2)).sum();
    square.sqrt() > WEIGHT_SHARE * STANDARD_GRAVITY
}

/// The one axis about which a carried body turns, where its rates about the others are noise and no
/// force is recorded that may carry it.
fn bearing(channels: &[Channel], guesses: &[Guess]) -> Option<&'static str> {
    let pushed =
        channels.iter().zip(guesses).any(|(channel, guess)| guess.role == Role::Command && channel.unit == "N");
    let rates: Vec<&Channel> =
        channels.iter().zip(guesses).filter(|(_, guess)| guess.role == Role::AngleRate).map(|(own, _)| own).collect();
    let turns = |channel: &&&Channel| {
        let (mean, count) = (mean(&channel.value), channel.value.len() as f64);
        let square: f64 = channel.value.iter().map(|value| (value - mean).powi(2)).sum();
        (square / count).sqrt() > TURNING_RATIO * noise_sigma(&channel.value)
    };
    let turning: Vec<&&Channel> = rates.iter().filter(turns).collect();
    match &turning[..] {
        [one] if rates.len() > 1 && !pushed && is_carried(channels, guesses) => axis_of(&one.name),
        _ => None,
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::axis_of;

    #[test]
    fn a_name_ends_in_an_axis_in_the_usual_spellings() {
        let names = [("rate_x", "x"), ("gyroY", "y"), ("az", "z"), ("wx", "x"), ("Fy", "y"), ("imu.accel.z", "z")];
        for (name, axis) in names.into_iter().chain([("yaw_rate", "z"), ("pitchRate", "y"), ("omega z", "z")]) {
            assert_eq!(axis_of(name), Some(axis), "{name}");
        }
        for name in ["mix", "speed", "phase_y1", "box", "display"] {
            assert_eq!(axis_of(name), None, "{name}");
        }
    }
}
