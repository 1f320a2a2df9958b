//! The benchmark's plants written as descriptions, and parts to build others.

use crate::fourier_reference::FourierReference;
use crate::oracle::appendage::{AppendageParameters, SENSORS};
use crate::oracle::arm::ArmNoise;
use crate::oracle::arm_parameters::ArmParameters;
use crate::oracle::slosh::SloshParameters;
use dynamics::description::{
    Actuator, ActuatorKind, Appendage, Body, Controller, Initial, Integrator, Joint, JointKind, Mode, Noise,
    Orientation, Plant, Quantity, Reading, Sensor, SensorKind, Signal, SignalKind, SimulationSettings, Tank, TankModel,
};

pub const Z: [f64; 3] = [0.0, 0.0, 1.0];

pub const fn q(value: f64) -> Quantity {
    Quantity::known(value)
}

pub const fn q3(value: [f64; 3]) -> [Quantity; 3] {
    [q(value[0]), q(value[1]), q(value[2])]
}

pub fn always(kind: SignalKind) -> Vec<Signal> {
    vec![Signal { kind, begin_s: q(0.0), end_s: None }]
}

pub fn body(
    name: &str,
    parent: Option<&str>,
    kind: JointKind,
    at_m: [f64; 2],
    mass_kg: f64,
    com_x_m: f64,
    i_zz: f64,
) -> Body {
    let zero = q(0.0);
    Body {
        name: name.to_owned(),
        parent: parent.map(str::to_owned),
        joint: Joint {
            name: name.to_owned(),
            kind,
            position_m: q3([at_m[0], at_m[1], 0.0]),
            orientation: Orientation::default(),
            viscous_friction: zero,
            rotor_inertia: zero,
            stiffness: zero,
            rest: zero,
        },
        mass_kg: q(mass_kg),
        com_m: q3([com_x_m, 0.0, 0.0]),
        inertia_com_kg_m2: [zero, zero, q(i_zz), zero, zero, zero],
    }
}

pub fn actuator(name: &str, kind: ActuatorKind, command: Vec<Signal>) -> Actuator {
    Actuator { name: name.to_owned(), kind, command, noise: q(0.0), range: None, recorded: true }
}

pub fn sensor(name: &str, kind: SensorKind) -> Sensor {
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
        reading: Reading::Instant,
        source: None,
    }
}

/// BP1A: Table II on trajectory B in closed loop, sensors in the order and under the names of the
/// special simulator.
pub fn arm(noise: &ArmNoise) -> Plant {
    let p = ArmParameters::paper_table_ii();
    let turn = JointKind::Revolute { axis: Z };
    let reference = FourierReference::trajectory_b();
    let mut plant = Plant { name: "arm".to_owned(), ..Plant::default() };
    plant.bodies = vec![
        body("base", None, JointKind::Free, [0.0; 2], p.base_mass_kg, 0.0, p.base_inertia_com_kg_m2),
        body("joint1", Some("base"), turn, p.r0_m, p.link_mass_kg[0], p.l_m[0], p.link_inertia_com_kg_m2[0]),
        body(
            "joint2",
            Some("joint1"),
            turn,
            [p.l_m[0] + p.r_m[0], 0.0],
            p.link_mass_kg[1],
            p.l_m[1],
            p.link_inertia_com_kg_m2[1],
        ),
    ];
    let gyro = SensorKind::Gyro { body: "base".to_owned(), axis: Z };
    plant.sensors.push(Sensor { noise: Noise::Density(q(noise.gyro_arw_rad_sqrt_s)), ..sensor("gyro.z", gyro) });
    for (j, name) in ["joint1", "joint2"].into_iter().enumerate() {
        let joint = name.to_owned();
        plant.actuators.push(actuator(name, ActuatorKind::JointTorque { joint: joint.clone() }, vec![]));
        let white = |sigma| Noise::PerSample(q(sigma));
        plant.sensors.push(Sensor {
            noise: white(noise.joint_angle_sigma_rad),
            resolution: q(noise.joint_angle_lsb_rad),
            ..sensor(&format!("{name}.angle"), SensorKind::Encoder { joint: joint.clone() })
        });
        plant.sensors.push(Sensor {
            noise: white(noise.joint_rate_sigma_rad_s),
            ..sensor(&format!("{name}.rate"), SensorKind::JointRate { joint: joint.clone() })
        });
        plant.sensors.push(Sensor {
            noise: white(noise.joint_torque_sigma_nm),
            ..sensor(&format!("{name}.torque"), SensorKind::JointTorque { joint })
        });
        plant.controllers.push(Controller {
            name: name.to_owned(),
            actuator: name.to_owned(),
            position_sensor: Some(format!("{name}.angle")),
            rate_sensor: Some(format!("{name}.rate")),
            kp: q([600.0, 250.0][j]),
            ki: q(0.0),
            kd: q([300.0, 120.0][j]),
            reference: always(SignalKind::Fourier {
                offset: q(reference.q0_rad[j]),
                period_s: q(reference.period_s),
                sine: reference.a_rad_s[j].map(q).to_vec(),
                cosine: reference.b_rad_s[j].map(q).to_vec(),
            }),
            feed_forward: q(0.9),
            reference_rate: true,
        });
    }
    plant.initial =
        Initial { momentum_com_n_m_s: Some(q3([0.0, 0.0, 68.0])), on_reference: true, ..Initial::default() };
    plant.simulation.step_s = 0.005;
    plant
}

/// BP2: bus on a line with its slosh mass, 44 N sine, mean acceleration.
pub fn slosh() -> Plant {
    let p = SloshParameters::benchmark();
    let axis = [1.0, 0.0, 0.0];
    let bus = "bus".to_owned();
    let thrust = SignalKind::Sine { amplitude: q(44.0), frequency_hz: q(0.01), phase_rad: q(0.0) };
    Plant {
        name: "craft".to_owned(),
        bodies: vec![body("bus", None, JointKind::Prismatic { axis }, [0.0; 2], p.m_0_kg, 0.0, 500.0)],
        tanks: vec![Tank {
            name: "tank".to_owned(),
            body: bus.clone(),
            position_m: q3([0.0; 3]),
            mass_kg: q(p.m_s_kg),
            model: TankModel::Spring {
                axes: vec![axis],
                stiffness_n_m: vec![q(p.k_s_n_m)],
                damping_n_s_m: vec![q(p.c_s_n_s_m)],
            },
        }],
        actuators: vec![actuator("thrust", ActuatorKind::JointTorque { joint: bus.clone() }, always(thrust))],
        sensors: vec![Sensor {
            reading: Reading::Mean,
            ..sensor(
                "accelerometer.x",
                SensorKind::Accelerometer { body: bus, position_m: q3([0.0; 3]), axis, point: None },
            )
        }],
        simulation: SimulationSettings {
            period_s: 0.1,
            step_s: 0.1,
            integrator: Integrator::ExactZeroOrderHold,
            ..SimulationSettings::default()
        },
        ..Plant::default()
    }
}

/// BP3: hub on its axis with the beam, accelerometers along it, torque on the hub.
pub fn appendage(parameters: &AppendageParameters, torque: Vec<Signal>) -> Plant {
    let hub = "hub".to_owned();
    let length_m = parameters.beam.length_m;
    let sensor_m = |i: usize| length_m * (i + 1) as f64 / SENSORS as f64;
    let points = (0..SENSORS).map(|i| (format!("p{}", i + 1), q3([parameters.root_radius_m + sensor_m(i), 0.0, 0.0])));
    let mode = |k: usize| Mode {
        name: format!("mode{}", k + 1),
        frequency_hz: q(parameters.hub_locked_modes()[k].0),
        damping_ratio: q(parameters.damping_ratio[k]),
        translation_sqrt_kg: q3([0.0; 3]),
        rotation_sqrt_kg_m: q3([0.0, 0.0, parameters.coupling()[k]]),
        shape_per_sqrt_kg: (0..SENSORS)
            .map(|i| q3([0.0, parameters.beam.mode(k + 1).shape(sensor_m(i)), 0.0]))
            .collect(),
    };
    let accelerometer = |i: usize| {
        let kind = SensorKind::Accelerometer {
            body: hub.clone(),
            position_m: q3([parameters.root_radius_m + sensor_m(i), 0.0, 0.0]),
            axis: [0.0, 1.0, 0.0],
            point: Some(("beam".to_owned(), format!("p{}", i + 1))),
        };
        sensor(&format!("accelerometer{}", i + 1), kind)
    };
    let mut sensors: Vec<Sensor> = (0..SENSORS).map(accelerometer).collect();
    sensors.push(sensor("hub.angle", SensorKind::Encoder { joint: hub.clone() }));
    sensors.push(sensor("hub.rate", SensorKind::JointRate { joint: hub.clone() }));
    let turn = JointKind::Revolute { axis: Z };
    Plant {
        name: "flexible".to_owned(),
        catalogue: catalogue::CATALOGUE,
        bodies: vec![body("hub", None, turn, [0.0; 2], 1.0, 0.0, parameters.total_inertia_kg_m2())],
        appendages: vec![Appendage {
            name: "beam".to_owned(),
            body: hub.clone(),
            points: points.collect(),
            modes: (0..parameters.damping_ratio.len()).map(mode).collect(),
        }],
        actuators: vec![actuator("torque", ActuatorKind::JointTorque { joint: hub }, torque)],
        sensors,
        simulation: SimulationSettings {
            period_s: 0.005,
            step_s: 0.005,
            integrator: Integrator::ExactZeroOrderHold,
            ..SimulationSettings::default()
        },
        ..Plant::default()
    }
}

/// A mass of 2 kg on a line, force `command`; sensors: displacement, rate. Solutions are known
/// without integration.
pub fn cart(command: Vec<Signal>) -> Plant {
    let joint = || "cart".to_owned();
    let along = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
    Plant {
        name: "cart".to_owned(),
        catalogue: catalogue::CATALOGUE,
        bodies: vec![body("cart", None, along, [0.0; 2], 2.0, 0.0, 1.0)],
        actuators: vec![actuator("force", ActuatorKind::JointTorque { joint: joint() }, command)],
        sensors: vec![
            sensor("displacement", SensorKind::Encoder { joint: joint() }),
            sensor("rate", SensorKind::JointRate { joint: joint() }),
            sensor("force", SensorKind::JointTorque { joint: joint() }),
        ],
        ..Plant::default()
    }
}
