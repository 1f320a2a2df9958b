//! What a name says of its quantity: which of two things a unit is, and which words in brackets are
//! no units.

use crate::units::unit_named;

/// A quantity that names tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Temperature,
    Mass,
    Force,
    Torque,
    Acceleration,
    Rate,
    Speed,
    Angle,
    MagneticField,
    Voltage,
    Current,
}

use Quantity::{Acceleration, Angle, Current, Force, MagneticField, Mass, Rate, Speed, Temperature, Torque, Voltage};

/// Words of names and their quantities; a word of more than four letters may begin a longer one.
const WORDS: &[(&[&str], Quantity)] = &[
    (&["temp", "temperature", "temperatur", "thermo", "thermocouple", "thermistor", "ntc"], Temperature),
    (&["mass", "masse", "massa", "masa", "weight", "gewicht", "fuel", "propellant"], Mass),
    (&["force", "thrust", "kraft", "schub", "tension", "forza", "fuerza"], Force),
    (&["torque", "torq", "trq", "tq", "tau", "moment", "drehmoment", "coppia"], Torque),
    (&["acc", "accel", "acceleration", "accelerometer", "beschleunigung", "vibration"], Acceleration),
    (&["gyro", "gyr", "omega", "rate", "gyroscope", "angvel", "drehrate"], Rate),
    (&["speed", "velocity", "vel", "geschwindigkeit", "wind"], Speed),
    (&["angle", "winkel", "roll", "pitch", "yaw", "theta"], Angle),
    (&["mag", "magn", "magnetic", "magnetometer", "compass", "bfield"], MagneticField),
    (&["voltage", "volt", "spannung"], Voltage),
    (&["current", "strom"], Current),
];

/// The quantity that a name tells: of several the first, `gyro_temp` a temperature.
pub(crate) fn quantity_of(name: &str) -> Option<Quantity> {
    quantities_of(name).first().copied()
}

/// The quantities that the words of a name tell.
fn quantities_of(name: &str) -> Vec<Quantity> {
    let words = words(name);
    let small: Vec<String> = words.iter().map(|word| word.to_lowercase()).collect();
    let is = |of: &&&str| small.iter().any(|word| word == **of || (of.len() > 4 && word.starts_with(**of)));
    let letter = words.iter().any(|word| word == "T").then_some(Temperature);
    let told = WORDS.iter().filter(|(of, _)| of.iter().any(|of| is(&of))).map(|(_, quantity)| *quantity);
    letter.into_iter().chain(told).collect()
}

/// The words of a name as they stand: `motorTemp_2` is `motor`, `Temp`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut small = false;
    for c in name.chars() {
        if (c.is_uppercase() && small) || !c.is_alphabetic() {
            words.push(String::new());
        }
        small = c.is_lowercase();
        if let Some(last) = words.last_mut().filter(|_| c.is_alphabetic()) {
            last.push(c);
        }
    }
    words
}

impl Quantity {
    /// Whether the quantity may be in the SI unit `si`; that of a sensor's signal is of any.
    pub(crate) fn may_be_in(self, si: &str) -> bool {
        if matches!(si, "V" | "A" | "-" | "ohm" | "?") {
            return true;
        }
        match self {
            Temperature => si == "K",
            Mass => matches!(si, "kg" | "N" | "kg/s"),
            Force => matches!(si, "N" | "kg"),
            Torque => matches!(si, "N*m" | "kg*m" | "N*m*s" | "A*m^2" | "kg*m^2"),
            Acceleration => matches!(si, "m/s^2" | "rad/s^2" | "m/s^2/N"),
            Rate => !matches!(si, "s" | "m" | "K" | "kg" | "rad"),
            Speed => matches!(si, "m/s" | "rad/s" | "Hz" | "1/s" | "m/s/N"),
            Angle => si == "rad",
            MagneticField => si == "T",
            Voltage | Current => false,
        }
    }
}

/// The unit `text` of a column called `name`, spelled so that it is one thing alone: grams of a
/// mass, degrees Celsius of a temperature, gauss of a magnetic field, pounds of a force.
pub(crate) fn in_view_of(name: &str, text: &str) -> String {
    // every other unit is one thing alone
    const OF_TWO: &[&str] = &["g", "mg", "ug", "lb", "lbs", "C", "F", "G", "mG", "uG", "NM", "nm"];
    let plain = units::plain(text);
    if !OF_TWO.contains(&plain.as_str()) {
        return text.to_owned();
    }
    let quantity = match plain.as_str() {
        "G" | "mG" | "uG" => quantity_of(name).or_else(|| of_letters(name)),
        _ => quantity_of(name),
    };
    let spelled = match (quantity, plain.as_str()) {
        (Some(Mass), "g") => "gram",
        (Some(Mass), "mg") => "mgram",
        (Some(Mass), "ug") => "ugram",
        (Some(Mass), "lb" | "lbs") => "lbm",
        (Some(Force), "lb" | "lbs") => "lbf",
        (Some(Temperature), "C") => "degC",
        (Some(Temperature), "F") => "degF",
        (Some(MagneticField), "G") => "gauss",
        (Some(MagneticField), "mG") => "mgauss",
        (Some(MagneticField), "uG") => "ugauss",
        (Some(Acceleration), "G") => "g",
        (Some(Acceleration), "mG") => "mg",
        (Some(Torque), "NM" | "nm") => "N*m",
        _ => text,
    };
    spelled.to_owned()
}

/// The quantity of a name of a letter and an axis, where it is a field or an acceleration alone.
fn of_letters(name: &str) -> Option<Quantity> {
    match name.to_lowercase().replace('_', "").as_str() {
        "mx" | "my" | "mz" | "bx" | "by" | "bz" | "hx" | "hy" | "hz" | "b" => Some(MagneticField),
        "ax" | "ay" | "az" | "a" => Some(Acceleration),
        _ => None,
    }
}

/// The unit of one letter, or of a spelling that is another unit elsewhere, in which the name of a
/// quantity ends: `temp_C`, `acc_x_g`, `omega_rads`, `acc_ms2`.
pub(crate) fn ending_of(name: &str, ending: &str) -> Option<&'static str> {
    if ending.chars().count() > 4 {
        return None;
    }
    match (quantity_of(name)?, ending) {
        (Temperature, "C") => Some("degC"),
        (Temperature, "K") => Some("K"),
        (Acceleration, "g") => Some("g"),
        (Acceleration, "ms2" | "mss") => Some("m/s^2"),
        (Rate | Speed, "rads") => Some("rad/s"),
        (Rate | Speed, "degs") => Some("deg/s"),
        (Speed, "ms") => Some("m/s"),
        (Force, "N") => Some("N"),
        (Mass, "g") => Some("gram"),
        (Voltage, "V") => Some("V"),
        (Current, "A") => Some("A"),
        _ => None,
    }
}

/// Units that are words of everyday language, or letters that number sensors.
const LABELS: &[&str] = &["in", "min", "h", "d", "U", "C", "raw", "day", "turn", "none"];

/// Whether `word` behind the name in parentheses is a unit of it: no number of a sensor, and no word
/// that would be a unit of another quantity, as inches and minutes are of `Temp (in)` and
/// `Rate (min)`.
pub(crate) fn is_unit_of(name: &str, word: &str) -> bool {
    let word = word.trim();
    if word.is_empty() || word.bytes().all(|byte| byte.is_ascii_digit()) {
        return false;
    }
    let Some(unit) = unit_named(&in_view_of(name, word)) else { return false };
    let quantities = quantities_of(name);
    !LABELS.contains(&word) || quantities.is_empty() || quantities.iter().any(|of| of.may_be_in(unit.si))
}
