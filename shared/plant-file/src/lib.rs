//! Plant files: TOML in, a checked [`Plant`] out, and back. Scenarios: [`scenario`].
//!
//! What it is: [`parse`] reads a plant and reports all faults of a file at once, each with line,
//! column and a cure. Every number has a unit. [`write()`] puts a plant back into a file that is
//! read as the same plant.
//!
//! May import: `dynamics`, `catalogue`, `telemetry` (names and limits of a scenario), TOML.
//!
//! Must never know: recordings, estimators, processes; it opens no file, its callers pass the text.
//!
//! ```
//! let text = r#"
//!     format = 1
//!     name = "cart"
//!     space = "planar"
//!     [[body]]
//!     name = "cart"
//!     mass = { value = "2 kg", sigma = "1 %" }
//!     inertia = "0.1 kg m^2"
//!     joint = { kind = "prismatic", name = "rail", axis = "x", friction = "0.3 N*s/m" }
//! "#;
//! let plant = plant_file::parse("cart.toml", text).expect("a complete plant").plant;
//! assert_eq!(plant.bodies[0].name, "cart");
//! let faults = plant_file::parse("cart.toml", &text.replace("2 kg", "2 m")).unwrap_err();
//! assert_eq!(faults.len(), 1); // a mass in metres: line, column and cure
//! ```
//!
//! # Format 1
//!
//! The blocks of this header, put together, are a complete plant.
//!
//! ```toml
//! format = 1
//! name = "drive_rig"
//! about = "one sentence for `obsid plant describe`"
//! space = "planar"                        # moves in x-y, turns about z; or "spatial"
//! gravity = [0, "-9.81 m/s^2"]            # default none
//! ```
//!
//! **Numbers.** `"0.16 N/m"`, `"5 ms"`, `"0.09 deg/sqrt(h)"`, `"3 kg m^2"`; bare where there is no
//! dimension, and zero is bare anywhere. To be estimated: `{ value = "400 kg", sigma = "2 kg" }`,
//! with `scope = "shared"` (default), `"per recording"` or `"per segment"`; a sigma in % is
//! relative to the value (of a number without dimension: absolute). Units: kg m s A K rad deg °
//! arcmin arcsec rev rpm min h d Hz N Nm lbf Pa J W V C ohm Ω H T G (gauss) g (standard gravity, so
//! mg, ug; in a mass: gram) ppm ppb %; prefixes n u m c k M; `*`, space, `/`, `^2`, `sqrt(…)`,
//! brackets. Angles in rad or deg, never bare; a frequency may be given in rad/s or rpm, a rate
//! never in Hz.
//!
//! **Vectors.** Lists of numbers, each with its unit: `["0.5 m", 0, 0]`; in a plane two are enough,
//! and one (about z) where something turns. One sigma for all:
//! `{ value = ["0.5 m", 0, 0], sigma = "5 mm" }` (or a list of them); in %, components that are
//! zero are known exactly. Many in one unit: `{ unit = "rad/s", values = [0.1, 0.2] }`. A direction
//! is `"x"`, `"-z"` or any vector that is not zero: `[1, 1, 0]`.
//!
//! **Names** are unique in a file; a joint without a name has its body's. References to names may
//! point anywhere in the file.
//!
//! ## Bodies
//!
//! ```toml
//! [[body]]
//! name = "hub"                            # no parent: inertial space
//! mass = "400 kg"
//! inertia = "320 kg*m^2"
//! joint = { kind = "free" }
//!
//! [[body]]
//! name = "link_1"
//! parent = "hub"
//! mass = { value = "12.1 kg", sigma = "1 %" }   # without slosh masses, with undeformed appendages and locked wheels
//! com = ["1.9 m", 0]                      # centre of mass in the body's axes, default its origin
//! inertia = "17.27 kg*m^2"                # about the centre of mass; spatial [xx, yy, zz] or [xx, yy, zz, xy, xz, yz] (matrix elements)
//!
//! [body.joint]                            # or joint = { … }
//! kind = "revolute"                       # "free" (no parent), "fixed", "revolute", "prismatic"
//! name = "shoulder"
//! axis = "z"                              # revolute in a plane: always z. In the body's axes, so after orientation
//! position = ["0.99 m", "0.99 m"]         # on the parent, default its origin
//! orientation = { axis = "z", angle = "30 deg" }   # of the body's axes at angle zero, in the parent's; default none
//! friction = "0.1 N*m*s/rad"              # viscous; N*s/m for a prismatic joint. Default 0, as are
//! rotor_inertia = "0 kg*m^2"              # reflected to the joint; a mass for a prismatic joint
//! stiffness = "0 N*m/rad"                 # spring to
//! rest = "0 deg"
//! ```
//!
//! A body's origin is at its joint. Zero inertia (a point mass, a rod about its axis) is possible
//! where nothing turns but with other inertia.
//!
//! ## Tanks and appendages
//!
//! ```toml
//! [[tank]]
//! name = "fuel"
//! body = "hub"
//! mass = "28.7 kg"                        # of the slosh mass, which is not in the body's
//! position = ["-0.45 m", "0.2 m"]         # of the mass at rest; of the pivot of a pendulum
//! kind = "spring"
//! axis = "y"                              # or axes = ["x", "y", "z"], independent
//! stiffness = "0.16 N/m"                  # one for all axes, or a list
//! damping = "0.03 N*s/m"                  # likewise, default 0
//! # kind = "pendulum": rest = "-x" (from the pivot to the mass at rest), length = "0.6 m", damping = "0.25 N*m*s/rad"
//!
//! [[appendage]]
//! name = "panel"
//! body = "hub"                            # whose mass and inertia include it undeformed
//! points.tip = ["5.5 m", 0]               # where accelerometers can sit, undeformed
//!
//! [[appendage.mode]]                      # with the hub locked, mass-normalised
//! name = "bending_1"
//! frequency = "1.0 Hz"
//! damping_ratio = 0.005                   # or "0.5 %"
//! translation = [0, "2.4 sqrt(kg)"]       # participation, default 0: squares add up to less than the body's mass
//! rotation = "10 sqrt(kg)*m"              # about the origin of the body's axes, default 0; squares: than its inertia
//! shape.tip = [0, "0.63 1/sqrt(kg)"]      # displacement at each point
//! ```
//!
//! ## Inputs
//!
//! ```toml
//! [[actuator]]
//! name = "shoulder_motor"
//! kind = "joint_torque"                   # joint; N*m, or N in a prismatic joint
//! joint = "shoulder"
//! command = { kind = "sine", amplitude = "2 N*m", frequency = "0.1 Hz" }   # or a list: the terms add up; default none
//! noise = "0.01 N*m"                      # white, of what acts, per control period; default 0
//! range = "20 N*m"                        # largest |command|; default none
//! recorded = true                         # the recording holds the command
//! ```
//!
//! | kind | its keys | command |
//! |---|---|---|
//! | `joint_torque` | joint | N\*m, N |
//! | `body_force` | body, direction, position (default origin) | N |
//! | `thruster` | body, direction, position; commanded between zero and its range | N |
//! | `body_torque` | body, direction (in a plane z) | N\*m |
//! | `wheel` | body, axis (in a plane z), inertia, friction, initial_speed | N\*m |
//! | `motor` | joint, constant [N\*m/A], gear (default 1), drive = "current" (default) or "voltage" with resistance \[ohm\] and back_emf [V\*s/rad] | A, V |
//! | `prescribed_joint` | joint, what = "position", "rate" or "acceleration"; exact: no noise, range or controller | rad, m, … |
//! | `prescribed_base` | direction (inertial axes), what; exact likewise | m, m/s, m/s^2 |
//!
//! Directions and positions are in the body's axes. A joint's torque turns the outboard body about
//! +axis and the parent back. A wheel's command is the torque on the *body* about +axis: the rotor
//! speeds up the other way.
//!
//! Terms of a signal; each is zero outside `begin` (default 0) … `end` (default never), and its
//! time counts from `begin`:
//!
//! | kind | its keys |
//! |---|---|
//! | `constant` | value |
//! | `sine` | amplitude, frequency, phase (default 0) |
//! | `square` | amplitude, frequency |
//! | `multisine` | rms, period, first, last (harmonics) |
//! | `chirp` | amplitude, begin_frequency, end_frequency |
//! | `fourier` | offset, period, sine, cosine: `offset + Σ (a_k sin kωt − b_k cos kωt)/(kω)`, coefficients per second |
//! | `step` | size |
//! | `pulse` | size, width, period (default: one pulse) |
//! | `staircase` | step, every |
//! | `slew` | size, width |
//! | `table` | time, value, smooth (default false: held) |
//!
//! ```toml
//! [[controller]]
//! name = "shoulder_loop"
//! actuator = "shoulder_motor"
//! position_sensor = "shoulder_angle"      # kp and ki act on it,
//! rate_sensor = "shoulder_rate"           # kd on this
//! kp = "600 N*m/rad"                      # gains default to 0
//! ki = "0 N*m/rad/s"
//! kd = "300 N*m*s/rad"
//! reference = { kind = "slew", size = "30 deg", width = "10 s" }
//! feed_forward = 0.9                      # share of the inverse dynamics along all references, default 0
//! reference_rate = true                   # kd acts on the error of the rate, not on the rate alone
//! ```
//!
//! ## Sensors
//!
//! ```toml
//! [[source]]                              # a clock
//! name = "imu_clock"
//! clock_offset = { value = "0 ms", sigma = "2 ms", scope = "per recording" }
//! clock_skew = "20 ppm"
//!
//! [[sensor]]
//! name = "shoulder_angle"
//! kind = "encoder"
//! joint = "shoulder"
//! resolution = "19 bit"                   # quantisation: so many steps a turn; or a step, "10 urad"
//!
//! [[sensor]]
//! name = "shoulder_rate"
//! kind = "joint_rate"
//! joint = "shoulder"
//!
//! [[sensor]]
//! name = "imu_gyro"
//! kind = "gyro"
//! body = "hub"
//! noise = "0.09 deg/sqrt(h)"              # a density (unit·√s), or a standard deviation of one sample ("0.1 mrad/s"); default 0
//! bias = { value = 0, sigma = "1 deg/h", scope = "per recording" }   # default 0, as are
//! scale = "0 ppm"                         # reading = (1 + scale) value + bias
//! resolution = 0
//! delay = "0 ms"
//! range = "10 deg/s"                      # default none, as are
//! low_pass = "50 Hz"                      # first order
//! period = "10 ms"                        # default: the record's
//! reading = "instant"                     # or "mean" over the interval that begins at the stamp
//! source = "imu_clock"                    # default: the record's clock
//!
//! [[sensor]]
//! name = "imu_acceleration"
//! kind = "accelerometer"
//! body = "hub"
//! position = ["0.5 m", "-0.3 m"]
//! axis = "xy"                             # two channels imu_acceleration_x, imu_acceleration_y; or one direction
//! misalignment = { axis = "z", angle = "0.1 deg" }   # turns the sensitive axis; not where there is none (joints, wheels, about z in a plane)
//! ```
//!
//! | kind | its keys | channel |
//! |---|---|---|
//! | `gyro`, `attitude` | body, axis (in a plane z) | rad/s, rad |
//! | `accelerometer` | body, position, axis; or point = "panel:tip", axis | m/s^2 |
//! | `encoder`, `joint_rate`, `joint_torque` | joint | rad, rad/s, N\*m; m, m/s, N |
//! | `force`, `torque` | joint, axis of the outboard body | N, N\*m |
//! | `position`, `velocity` | body, position, axis of inertial space | m, m/s |
//! | `wheel_speed` | actuator | rad/s |
//!
//! - `accelerometer`: specific force, acceleration − gravity, in body axes: at rest under
//!   `gravity = [0, "-9.81 m/s^2"]` it reads +9.81 along y.
//! - `gyro`: rate against inertial space in body axes.
//! - `attitude`: in a plane the angle against inertial space, counted over all turns; in space a
//!   component of the rotation vector from inertial to body axes, at most π long: at π it jumps to
//!   −π.
//! - `force`, `torque`: what the joint exerts on the outboard body, at the joint's origin, in the
//!   outboard body's axes, all paths together (bearing, drive, spring, friction): a mass that hangs
//!   at rest reads −m g. About a revolute (along a prismatic) axis it is what is left when the
//!   rotor inertia is accelerated.
//! - `joint_torque`: what the actuators of the joint apply, of an imposed motion what imposes it;
//!   springs, friction and the joint's effects are not in it.
//! - `wheel_speed`: of the rotor relative to its body about +axis.
//!
//! In space the same keys are vectors of three:
//!
//! ```toml spatial
//! format = 1
//! name = "imu"
//! space = "spatial"
//!
//! [[body]]
//! name = "hub"
//! mass = "400 kg"
//! com = { value = ["1 cm", 0, "-2 cm"], sigma = "10 %" }
//! inertia = ["66 kg*m^2", "70 kg*m^2", "90 kg*m^2", "2 kg*m^2", 0, 0]
//! joint = { kind = "free" }
//!
//! [[sensor]]
//! name = "gyro"
//! kind = "gyro"
//! body = "hub"
//! axis = "xyz"                            # three channels gyro_x, gyro_y, gyro_z
//! misalignment = { axis = "y", angle = "0.1 deg" }   # of all three, about y
//! ```
//!
//! ## Surroundings, beginnings, running
//!
//! ```toml
//! [environment]
//! constant_force = ["1 mN", 0]            # on the first free body, at its centre of mass, inertial axes; likewise
//! constant_torque = "1e-4 N*m"
//! gravity_gradient = { orbit_rate = "1.1e-3 rad/s", phase = "0 deg" }   # phase: direction to the planet at t = 0, in x-y from x
//! atmosphere = { density = "2e-12 kg/m^3", wind = ["7.6 km/s", 0] }     # felt only by effects: drag, linear_drag, magnus_lift (their
//!                                         # coefficients include the density)
//! magnetic_field = ["20 uT", 0]           # felt only by the effect residual_dipole
//!
//! [initial]
//! momentum = "68 N*m*s"                   # about the centre of mass, which rests in the origin; overrides the first body, which is free
//! on_reference = true                     # controlled joints begin on their references
//! "joint:shoulder" = { position = "10 deg", rate = "0 deg/s" }
//! # also "body:NAME.x|y|z|rx|ry|rz" of a free body, "tank:NAME", "tank:NAME.2", "mode:NAME", "wheel:ACTUATOR"
//!
//! [[segment]]                             # none: one record from [initial] on
//! name = "coast"
//! begin = "10 s"
//! end = "20 s"                            # default: the next segment's begin or the record's end
//! initial = { "joint:shoulder" = { position = { value = 0, sigma = "1 deg", scope = "per segment" } } }
//!
//! [simulation]
//! duration = "60 s"
//! period = "10 ms"                        # inputs are held, controllers run, sensors are read
//! step = "5 ms"                           # longest integration step, default the period
//! integrator = "runge_kutta_4"            # "midpoint", "exact_zero_order_hold"
//! jitter = 0
//!
//! [[effect]]                              # `obsid effects` lists kinds, sites and parameters
//! kind = "joint_coulomb"
//! site = "joint:shoulder"
//! force = "0.2 N*m"
//!
//! [[effect]]
//! kind = "linear_drag"
//! site = "body:hub"
//!
//! [[effect]]
//! kind = "residual_dipole"
//! site = "body:hub"
//! ```
//!
//! Initial rates of a free body: `x`, `y`, `z` (of its origin) in inertial axes, `rx`, `ry`, `rz`
//! in body axes; position `rx`, `ry`, `rz` is a rotation vector. A joint whose position is
//! prescribed begins where that motion does. A segment's `initial` replaces `[initial]` as a whole;
//! time between segments is not recorded; they do not overlap. On one line an effect is
//! `joint_coulomb@joint:shoulder force=0.2`.

#![forbid(unsafe_code)]

mod bodies;
mod effect_text;
mod inputs;
mod numbers;
mod origin;
mod outputs;
mod run;
pub mod scenario;
mod section;
mod set_text;
pub mod units;
pub mod validate;
mod write;

pub use effect_text::{effect_warnings, parse_effect};
pub use set_text::{set, set_all};
pub use write::write;

use crate::validate::{Fault, Place, faults_of_parts, with_faults_of_equations};
use catalogue::CATALOGUE;
use core::ops::Range;
use dynamics::description::{Plant, Space};
use dynamics::effect::Catalogue;
use origin::{Origin, locate};
use section::{Finding, Reader, Section};
use toml::de::DeTable;

/// Something in a plant file that cannot be used, or (as a warning) is not plausible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    pub file: String,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    pub message: String,
    /// What to do; empty where nothing is known.
    pub cure: String,
    /// Bytes of the text.
    pub span: Range<usize>,
}

impl core::fmt::Display for FileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)?;
        if self.cure.is_empty() { Ok(()) } else { write!(f, " ({})", self.cure) }
    }
}

impl core::error::Error for FileError {}

/// A plant file that can be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    pub plant: Plant,
    /// Possible, but not plausible.
    pub warnings: Vec<FileError>,
}

/// Reads and checks a plant file; `file_name` is only for messages.
///
/// # Errors
/// Everything that is wrong, in the order of the text; never empty.
pub fn parse(file_name: &str, text: &str) -> Result<Parsed, Vec<FileError>> {
    parse_with(CATALOGUE, file_name, text)
}

/// [`parse`] with the effects of another catalogue.
///
/// # Errors
/// As [`parse`].
pub fn parse_with(catalogue: Catalogue, file_name: &str, text: &str) -> Result<Parsed, Vec<FileError>> {
    let (document, syntax) = DeTable::parse_recoverable(text);
    let located = |findings: Vec<Finding>| locate(file_name, text, findings);
    if !syntax.is_empty() {
        let finding = |error: &toml::de::Error| {
            let message = error.message().lines().collect::<Vec<_>>().join(", ");
            let span = error.span().unwrap_or(0..0);
            let cure = syntax_cure(&message, text.get(span.clone()).unwrap_or(""));
            Finding { span, message, cure }
        };
        return Err(located(syntax.iter().map(finding).collect()));
    }
    let reader = Reader::default();
    let (plant, origin) = read(&reader, catalogue, document.get_ref(), text.len());
    let readable = reader.findings.borrow().is_empty();
    let (warnings, faults): (Vec<Fault>, Vec<Fault>) =
        faults_of(&plant, reader.space.get(), readable).into_iter().partition(|fault| fault.warning);
    let mut errors = origin.findings(&reader, &plant, faults);
    errors.extend(reader.findings.take());
    if errors.is_empty() {
        let warnings = located(origin.findings(&reader, &plant, warnings));
        Ok(Parsed { plant, warnings })
    } else {
        Err(located(errors))
    }
}

/// Faults of the plant; of its equations only where everything is `readable`. Where the space is
/// not known, those that hold in both.
fn faults_of(plant: &Plant, space: Option<Space>, readable: bool) -> Vec<Fault> {
    if space.is_none() {
        let other = faults_of_parts(&Plant { space: Space::Spatial, ..plant.clone() });
        return faults_of_parts(plant).into_iter().filter(|fault| other.contains(fault)).collect();
    }
    let parts = faults_of_parts(plant);
    if readable { with_faults_of_equations(plant, parts) } else { parts }
}

/// What to do about a text that is no TOML.
fn syntax_cure(message: &str, at: &str) -> String {
    if message.contains("duplicate key") || message.contains("cannot extend") || message.contains("redefine") {
        let word = at.trim_matches(['[', ']', '"', ' ']);
        return format!(
            "'{word}' is defined once more here: a key stands once in a table, [[{word}]] begins a further table, [{word}] never repeats"
        );
    }
    "this is no TOML: https://toml.io".into()
}

/// The plant as far as it can be read, with stand-ins for the rest.
fn read(reader: &Reader, catalogue: Catalogue, document: &DeTable<'_>, length: usize) -> (Plant, Origin) {
    let place = Place { section: "plant", index: 0, key: String::new() };
    let root = Section::new(reader, document, 0..length.min(1), place, "the plant file".into());
    let mut origin = Origin::default();
    let mut plant = Plant { catalogue, ..Plant::default() };
    head(&root, &mut plant);
    plant.environment = run::environment(&root);
    plant.bodies = root.tables("body").iter_mut().map(bodies::body).collect();
    origin.put_parents_first(&mut plant);
    plant.tanks = root.tables("tank").iter_mut().map(bodies::tank).collect();
    plant.appendages = root.tables("appendage").iter_mut().map(bodies::appendage).collect();
    plant.actuators = root.tables("actuator").iter_mut().map(|section| inputs::actuator(section, &plant)).collect();
    plant.sources = root.tables("source").iter_mut().map(outputs::source).collect();
    for (i, section) in root.tables("sensor").iter_mut().enumerate() {
        let channels = outputs::sensors(section, &plant);
        origin.put_channels(i, &channels);
        plant.sensors.extend(channels);
    }
    plant.controllers =
        root.tables("controller").iter_mut().map(|section| inputs::controller(section, &plant)).collect();
    plant.initial = root.table("initial").map(|section| run::initial(&section, &plant)).unwrap_or_default();
    plant.segments = root.tables("segment").iter_mut().map(|section| run::segment(section, &plant)).collect();
    plant.simulation = root.table("simulation").map(|section| run::simulation(&section)).unwrap_or_default();
    plant.effects = root.tables("effect").iter_mut().map(|section| run::effect(section, &plant)).collect();
    root.finish();
    (plant, origin)
}

/// Format, name, text and space.
fn head(root: &Section<'_, '_>, plant: &mut Plant) {
    if !root.has("format") {
        root.get("format");
        root.missing("format", "a plant file begins with format = 1");
    } else if root.count("format") != 1 {
        root.error("format", "this format of plant files is unknown", "this version reads format = 1");
    }
    plant.name = root.required_text("name", "what the plant is called");
    plant.about = root.text("about").unwrap_or_default();
    let spaces = [("planar", Space::Planar), ("spatial", Space::Spatial)];
    let space = root.word("space", &spaces, None);
    root.reader.space.set(space);
    plant.space = space.unwrap_or_default();
}

#[cfg(test)]
mod tests;
