//! The simulator against Basilisk (bsk 2.12.1): six records of a craft with sloshing propellant,
//! noise-free.
//!
//! The records are not part of the repository: `OBSID_RECORDINGS` names their folder, else
//! `../shared/recordings` beside the workspace is taken if it is there. Without them the test says
//! so and passes, unless `OBSID_REQUIRE` asks for `recordings`.

use dynamics::description::{
    Actuator, ActuatorKind, Body, Joint, JointKind, Noise, Orientation, Plant, Quantity, Reading, Sensor, SensorKind,
    Signal, SignalKind, SimulationSettings, Tank, TankModel,
};
use serde_json::Value;
use simulation::Simulator;
use std::path::{Path, PathBuf};

const fn q(value: f64) -> Quantity {
    Quantity::known(value)
}

const fn q3(x: f64, y: f64) -> [Quantity; 3] {
    [q(x), q(y), q(0.0)]
}

/// Folder of the records, or why there is none.
fn recordings() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings");
    let folder = std::env::var_os("OBSID_RECORDINGS").map_or(beside, PathBuf::from);
    if folder.join("README.md").is_file() && folder.join("basilisk_slosh").is_dir() {
        return Some(folder.join("basilisk_slosh"));
    }
    let required = std::env::var("OBSID_REQUIRE").unwrap_or_default();
    assert!(!required.split(',').any(|what| what.trim() == "recordings"), "no recordings in {}", folder.display());
    println!("skipped: no recordings in {}", folder.display());
    None
}

/// Columns of a gzipped table.
fn columns(file: &Path) -> Vec<Vec<f64>> {
    let reader = flate2::read::GzDecoder::new(std::fs::File::open(file).unwrap());
    let mut reader = csv::Reader::from_reader(reader);
    let mut columns = vec![Vec::new(); reader.headers().unwrap().len()];
    for row in reader.records() {
        for (column, field) in columns.iter_mut().zip(row.unwrap().iter()) {
            column.push(field.parse().unwrap());
        }
    }
    columns
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn pair(value: &Value) -> [f64; 2] {
    [number(&value[0]), number(&value[1])]
}

fn hub(truth: &Value) -> Body {
    let zero = q(0.0);
    Body {
        name: "hub".to_owned(),
        parent: None,
        joint: Joint {
            name: "hub".to_owned(),
            kind: JointKind::Free,
            position_m: [zero; 3],
            orientation: Orientation::default(),
            viscous_friction: zero,
            rotor_inertia: zero,
            stiffness: zero,
            rest: zero,
        },
        mass_kg: q(number(&truth["m0"])),
        com_m: [zero; 3],
        inertia_com_kg_m2: [zero, zero, q(number(&truth["I0"])), zero, zero, zero],
    }
}

fn tanks(truth: &Value) -> Vec<Tank> {
    let tank = |name: String, at: [f64; 2], mass: f64, model| Tank {
        name,
        body: "hub".to_owned(),
        position_m: q3(at[0], at[1]),
        mass_kg: q(mass),
        model,
    };
    let spring = |(index, particle): (usize, &Value)| {
        let axis = pair(&particle["p"]);
        let model = TankModel::Spring {
            axes: vec![[axis[0], axis[1], 0.0]],
            stiffness_n_m: vec![q(number(&particle["k"]))],
            damping_n_s_m: vec![q(number(&particle["c"]))],
        };
        tank(format!("spring{index}"), pair(&particle["b"]), number(&particle["m"]), model)
    };
    let pendulum = |(index, pendulum): (usize, &Value)| {
        // Basilisk's D is against the velocity of the mass [N s/m]: about the pivot D L²
        let length_m = number(&pendulum["L"]);
        let model = TankModel::Pendulum {
            rest: [-1.0, 0.0, 0.0],
            length_m: q(length_m),
            damping_n_m_s_rad: q(number(&pendulum["D"]) * length_m * length_m),
        };
        tank(format!("pendulum{index}"), pair(&pendulum["d"]), number(&pendulum["m"]), model)
    };
    let particles = truth["particles"].as_array().unwrap().iter().enumerate().map(spring);
    particles.chain(truth["pendulums"].as_array().unwrap().iter().enumerate().map(pendulum)).collect()
}

fn sensor(name: &str, kind: SensorKind) -> Sensor {
    Sensor {
        name: name.to_owned(),
        kind,
        noise: Noise::default(),
        bias: q(0.0),
        scale: q(0.0),
        misalignment: Orientation::default(),
        range: None,
        resolution: q(0.0),
        low_pass_hz: None,
        delay_s: q(0.0),
        period_s: None,
        reading: Reading::Mean,
        source: None,
    }
}

/// The craft that `truth` describes under the commands of the record's first four columns.
fn craft(truth: &Value, record: &[Vec<f64>]) -> Plant {
    let step_s = number(&truth["dt"]);
    let body = || "hub".to_owned();
    let command = |column: usize| {
        let kind = SignalKind::Table { time_s: record[0].clone(), value: record[column].clone(), smooth: false };
        vec![Signal { kind, begin_s: q(0.0), end_s: None }]
    };
    let force = |direction| ActuatorKind::BodyForce { body: body(), position_m: q3(0.0, 0.0), direction };
    let actuator = |name: &str, kind, column| Actuator {
        name: name.to_owned(),
        kind,
        command: command(column),
        noise: q(0.0),
        range: None,
        recorded: true,
    };
    let at = pair(&truth["sensor_from_hub_CM"]);
    let acceleration =
        |axis| SensorKind::Accelerometer { body: body(), position_m: q3(at[0], at[1]), axis, point: None };
    Plant {
        name: "craft".to_owned(),
        bodies: vec![hub(truth)],
        tanks: tanks(truth),
        actuators: vec![
            actuator("force_x", force([1.0, 0.0, 0.0]), 1),
            actuator("force_y", force([0.0, 1.0, 0.0]), 2),
            actuator("torque", ActuatorKind::BodyTorque { body: body(), direction: [0.0, 0.0, 1.0] }, 3),
        ],
        sensors: vec![
            sensor("acceleration_x", acceleration([1.0, 0.0, 0.0])),
            sensor("acceleration_y", acceleration([0.0, 1.0, 0.0])),
            sensor("rate", SensorKind::Gyro { body: body(), axis: [0.0, 0.0, 1.0] }),
        ],
        simulation: SimulationSettings { period_s: step_s, step_s, ..SimulationSettings::default() },
        ..Plant::default()
    }
}

/// Both integrate with RK4 at the record's step: no truncation remains. Commands are printed with
/// ten digits, which is what 1e-9 leaves room for.
#[test]
fn six_records_of_basilisk_are_reproduced_from_their_commands() {
    let Some(folder) = recordings() else { return };
    let names = [
        "r1_1d_seed_sine",
        "r2_1d_burst_decay",
        "r3_planar_lateral",
        "r4_planar_two_masses",
        "r5_pendulum_3_thrust_levels",
        "r6_spring_3_thrust_levels",
    ];
    for name in names {
        let record = columns(&folder.join(format!("{name}.csv.gz")));
        let clean = columns(&folder.join(format!("truth/{name}.clean.csv.gz")));
        let truth = std::fs::read_to_string(folder.join(format!("truth/{name}.truth.json"))).unwrap();
        let plant = craft(&serde_json::from_str(&truth).unwrap(), &record);
        let mut simulator = Simulator::new(&plant, 0, "craft").unwrap();
        let (mut difference, mut greatest) = ([0.0f64; 3], [0.0f64; 3]);
        let rows = clean[0].len();
        for k in 0..rows {
            let row = simulator.step();
            for (channel, column) in clean[1..].iter().enumerate() {
                let expected = column[k];
                difference[channel] = difference[channel].max((row.value(channel) - expected).abs());
                greatest[channel] = greatest[channel].max(expected.abs());
            }
        }
        let relative: [f64; 3] =
            core::array::from_fn(|i| if greatest[i] > 0.0 { difference[i] / greatest[i] } else { difference[i] });
        println!("{name}: acceleration x, y, rate differ by {relative:?} of their greatest values");
        assert!(relative.iter().all(|relative| *relative <= 1e-9), "{name}: {relative:?}");
        assert!(greatest[0] > 0.0);
    }
}
