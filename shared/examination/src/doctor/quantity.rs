//! What a unit and a name say: kind of quantity, order of time derivative, factor to SI, and which
//! body or axis.

/// Kinds of quantity that are related by differentiation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Angle,
    Length,
    Force,
    Torque,
    Electric,
    Other,
}

/// A unit understood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    pub kind: Kind,
    /// Order of time derivative: 0 position, 1 rate, 2 acceleration.
    pub order: usize,
    /// SI units in one of this unit.
    pub factor: f64,
}

impl Quantity {
    /// Whether it is an angle itself, not a rate or an acceleration.
    pub fn is_angle(&self) -> bool {
        self.kind == Kind::Angle && self.order == 0
    }

    /// Force, torque, voltage or current: what drives.
    pub fn drives(&self) -> bool {
        matches!(self.kind, Kind::Force | Kind::Torque | Kind::Electric)
    }
}

/// Quantity of a unit text; `None` when it is not understood.
pub fn of(unit: &str) -> Option<Quantity> {
    let unit = unit.trim().replace('²', "^2").replace("s2", "s^2").replace("deg", "°").replace('·', "*");
    let (base, order) = match unit.as_str() {
        u if u.ends_with("/s^2") => (&u[..u.len() - 4], 2),
        u if u.ends_with("/s") => (&u[..u.len() - 2], 1),
        u => (u, 0),
    };
    let (kind, factor) = match base {
        "rad" => (Kind::Angle, 1.0),
        "mrad" => (Kind::Angle, 1e-3),
        "°" => (Kind::Angle, core::f64::consts::PI / 180.0),
        "m" => (Kind::Length, 1.0),
        "mm" => (Kind::Length, 1e-3),
        "g" if order == 0 => return Some(Quantity { kind: Kind::Length, order: 2, factor: 9.80665 }),
        "N" if order == 0 => (Kind::Force, 1.0),
        "N*m" | "Nm" | "N m" if order == 0 => (Kind::Torque, 1.0),
        "V" | "A" if order == 0 => (Kind::Electric, 1.0),
        "" | "-" => return None,
        _ => (Kind::Other, 1.0),
    };
    Some(Quantity { kind, order, factor })
}

/// Words that name the quantity or how it was got, not where it sits.
const COMMON_WORDS: &[&str] = &[
    "angle",
    "rate",
    "position",
    "displacement",
    "velocity",
    "speed",
    "acceleration",
    "accel",
    "acc",
    "gyro",
    "omega",
    "theta",
    "angular",
    "height",
    "derived",
    "denoised",
    "filtered",
    "filt",
    "smoothed",
    "raw",
    "measured",
    "meas",
    "estimated",
    "est",
    "encoder",
    "enc",
    "imu",
    "joint",
    "dot",
    "ddot",
    "pos",
    "vel",
    "q",
    "qd",
    "qdd",
    "dq",
    "ddq",
    "x0",
];

/// The words of a name that say where it sits: axis, number, body. Sorted.
pub fn place(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    let mut words: Vec<String> = Vec::new();
    for word in lower.split(|c: char| !c.is_alphanumeric()) {
        let digits = word.find(|c: char| c.is_ascii_digit()).unwrap_or(word.len());
        words.extend([&word[..digits], &word[digits..]].into_iter().filter(|w| !w.is_empty()).map(String::from));
    }
    words.retain(|w| !COMMON_WORDS.contains(&w.as_str()));
    words.sort();
    words
}

/// Name without its axis, and the axis 0..3, for `x`/`y`/`z`, `roll`/`pitch`/`yaw` and `1`/`2`/`3`
/// at the end.
pub fn axis(name: &str) -> Option<(String, usize)> {
    let lower = name.to_lowercase();
    for names in [["x", "y", "z"], ["roll", "pitch", "yaw"], ["phi", "theta", "psi"]] {
        for (k, axis) in names.iter().enumerate() {
            if let Some(stem) = lower.strip_suffix(axis)
                && (stem.is_empty() || stem.ends_with(['_', '.', ' ', '-', '[']))
            {
                return Some((stem.trim_end_matches(['_', '.', ' ', '-', '[']).to_string(), k));
            }
        }
    }
    None
}

/// Quantity of a channel: its unit, else (no unit given) what its name says, in SI.
pub fn of_channel(channel: &channels::Channel) -> Option<Quantity> {
    of(&channel.unit).or_else(|| {
        let lower = channel.name.to_lowercase();
        let has =
            |words: &[&str]| words.iter().any(|w| lower.split(|c: char| !c.is_alphanumeric()).any(|part| part == *w));
        let (kind, order) = if has(&["rate", "omega", "gyro"]) {
            (Kind::Angle, 1)
        } else if has(&["angle", "theta", "roll", "pitch", "yaw"]) {
            (Kind::Angle, 0)
        } else if has(&["position", "displacement", "height"]) {
            (Kind::Length, 0)
        } else if has(&["velocity", "speed"]) {
            (Kind::Length, 1)
        } else if has(&["acceleration", "accel", "acc"]) {
            (Kind::Length, 2)
        } else {
            return None;
        };
        Some(Quantity { kind, order, factor: 1.0 })
    })
}
