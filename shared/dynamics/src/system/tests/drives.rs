//! Actuators.

use super::*;
use crate::description::{Base, Drive, Prescribed};

fn rotor(actuators: Vec<Actuator>, friction: f64) -> Plant {
    let mut hinge = joint("shaft", JointKind::Revolute { axis: Z }, [0.0; 3]);
    hinge.viscous_friction = known(friction);
    Plant { bodies: vec![body("rotor", None, hinge, 1.0, [0.0; 3], [0.0, 0.0, 0.02])], actuators, ..Plant::default() }
}

#[test]
fn a_wheels_torque_turns_the_body_one_way_and_its_rotor_the_other() {
    let wheel = ActuatorKind::Wheel {
        body: "hub".to_owned(),
        axis: Z,
        inertia_kg_m2: known(0.5),
        viscous_friction_n_m_s_rad: known(0.0),
        initial_speed_rad_s: known(100.0),
    };
    let plant = Plant {
        bodies: vec![free("hub", 50.0, [0.0; 3], [0.0, 0.0, 8.0])],
        actuators: vec![actuator("wheel", wheel)],
        sensors: vec![sensor("speed", SensorKind::WheelSpeed { actuator: "wheel".to_owned() })],
        ..Plant::default()
    };
    let system = System::new(&plant).unwrap();
    let x = system.initial_state(&plant.initial, &|_| None).unwrap();
    assert_eq!(readings(&system, &x, &[0.0]), [100.0]);
    let x_dot = rates(&system, &x, &[0.3]);
    let hub = x_dot[index(&system, "body:hub.rz.rate")];
    // locked inertia holds the rotor's: (8 − 0.5) α = 0.3
    assert!((hub - 0.3 / 7.5).abs() < 1e-15);
    assert!((x_dot[index(&system, "wheel:wheel")] - (-0.3 / 0.5 - hub)).abs() < 1e-15);
}

#[test]
fn a_motor_at_constant_voltage_ends_at_the_speed_of_its_back_emf_and_friction() {
    let (k, gear, ohm, ke, friction) = (0.05, 20.0, 2.0, 0.05, 0.1);
    let voltage = Drive::Voltage { resistance_ohm: known(ohm), back_emf_v_s_rad: known(ke) };
    let motor =
        ActuatorKind::Motor { joint: "shaft".to_owned(), constant_n_m_a: known(k), gear: known(gear), drive: voltage };
    let system = System::new(&rotor(vec![actuator("motor", motor)], friction)).unwrap();
    let mut x = vec![0.0; 2];
    integrate(&system, &mut x, &[24.0], 1e-3, 1000); // 30 time constants
    let terminal = k * gear / ohm * 24.0 / (friction + k * gear * ke * gear / ohm);
    assert!((x[1] / terminal - 1.0).abs() < 1e-12, "{} {terminal}", x[1]);
}

#[test]
fn a_thrust_line_through_the_centre_of_mass_does_not_turn_and_one_beside_it_does() {
    let thruster = |name: &str, y: f64| {
        let position_m = three([-1.0, y, 0.3]);
        actuator(name, ActuatorKind::Thruster { body: "hub".to_owned(), position_m, direction: [1.0, 0.0, 0.0] })
    };
    let plant = Plant {
        space: Space::Spatial,
        bodies: vec![free("hub", 80.0, [0.2, 0.1, 0.3], [10.0, 20.0, 30.0])],
        actuators: vec![thruster("through", 0.1), thruster("beside", 0.6)],
        ..Plant::default()
    };
    let system = System::new(&plant).unwrap();
    let mut x = vec![0.0; 13];
    x[3] = 1.0;
    let through = rates(&system, &x, &[10.0, 0.0]);
    assert!(through[7..10].iter().all(|a| a.abs() < 1e-15), "{through:?}"); // rounding
    assert!((through[10] - 10.0 / 80.0).abs() < 1e-15);
    let beside = rates(&system, &x, &[0.0, 10.0]);
    assert!((beside[9] + 10.0 * 0.5 / 30.0).abs() < 1e-15); // force along x, arm +0.5 in y
}

#[test]
fn a_prescribed_joint_needs_the_force_that_mass_friction_and_spring_ask_for() {
    let mut slide = joint("slide", JointKind::Prismatic { axis: [1.0, 0.0, 0.0] }, [0.0; 3]);
    (slide.viscous_friction, slide.stiffness, slide.rotor_inertia) = (known(3.0), known(20.0), known(0.5));
    let hinge = joint("swing", JointKind::Revolute { axis: Z }, [0.0; 3]);
    let shaken = ActuatorKind::PrescribedJoint { joint: "slide".to_owned(), what: Prescribed::Position };
    let force = SensorKind::Force { joint: "slide".to_owned(), axis: [1.0, 0.0, 0.0] };
    let plant = Plant {
        bodies: vec![
            body("table", None, slide, 4.0, [0.0; 3], [0.0; 3]),
            body("bob", Some("table"), hinge, 2.0, [0.0, -0.5, 0.0], [0.0, 0.0, 0.1]),
        ],
        actuators: vec![actuator("shaker", shaken)],
        sensors: vec![
            sensor("force", force),
            sensor("drive", SensorKind::JointTorque { joint: "slide".to_owned() }),
            sensor("encoder", SensorKind::Encoder { joint: "slide".to_owned() }),
        ],
        ..Plant::default()
    };
    let system = System::new(&plant).unwrap();
    let names: Vec<&str> = system.states().iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["joint:swing", "joint:swing.rate"]);
    assert_eq!(system.inputs().len(), 3);
    let (x, u) = ([0.3, 0.8], [0.05, 0.4, 2.0]);
    let x_dot = rates(&system, &x, &u);
    // (I + m l²) θ'' = −m l a cos θ, pendulum hanging along −y
    let (sin, cos) = (libm::sin(0.3), libm::cos(0.3));
    let swing = -2.0 * 0.5 * 2.0 * cos / (0.1 + 2.0 * 0.25);
    assert!((x_dot[1] - swing).abs() < 1e-14, "{} {swing}", x_dot[1]);
    // momentum along x: m_table a + m_bob (a + l θ'' cos θ − l θ'² sin θ); the rotor's share does
    // not pass through the guide
    let transmitted = 4.0 * 2.0 + 2.0 * (2.0 + 0.5 * swing * cos - 0.5 * 0.64 * sin);
    let y = readings(&system, &x, &u);
    assert!((y[0] - transmitted).abs() < 1e-13, "{y:?} {transmitted}"); // rounding
    let drive = transmitted + 0.5 * 2.0 + 3.0 * 0.4 + 20.0 * 0.05;
    assert!((y[1] - drive).abs() < 1e-13, "{y:?} {drive}");
    assert_eq!(y[2], 0.05);
}

#[test]
fn a_shaken_base_is_a_joint_that_moves_the_same_way() {
    let swing = || joint("swing", JointKind::Revolute { axis: Z }, [0.0; 3]);
    let direction = [0.6, 0.8, 0.0];
    let read = |body: &str| {
        let body = || body.to_owned();
        let (position_m, axis) = (three([0.1, -0.4, 0.0]), [1.0, 0.0, 0.0]);
        vec![
            sensor("a", SensorKind::Accelerometer { body: body(), position_m, axis, point: None }),
            sensor("v", SensorKind::Velocity { body: body(), position_m, axis }),
            sensor("x", SensorKind::Position { body: body(), position_m, axis }),
        ]
    };
    let mut shaken = Plant {
        bodies: vec![body("bob", None, swing(), 2.0, [0.0, -0.5, 0.0], [0.0, 0.0, 0.1])],
        sensors: read("bob"),
        ..Plant::default()
    };
    shaken.environment.gravity_m_s2 = three([0.0, -9.81, 0.0]);
    let mut driven = shaken.clone();
    let rail = joint("rail", JointKind::Prismatic { axis: direction }, [0.0; 3]);
    driven.bodies.insert(0, body("table", None, rail, 1.0, [0.0; 3], [0.0; 3]));
    driven.bodies[1].parent = Some("table".to_owned());
    let what = Prescribed::Position;
    shaken.actuators =
        vec![actuator("base", ActuatorKind::PrescribedBase { base: Base::Translation { direction }, what })];
    driven.actuators = vec![actuator("rail", ActuatorKind::PrescribedJoint { joint: "rail".to_owned(), what })];
    let (shaken, driven) = (System::new(&shaken).unwrap(), System::new(&driven).unwrap());
    let (x, u) = ([0.7, -0.5], [0.3, 0.9, -4.0]);
    let (one, other) = (rates(&shaken, &x, &u), rates(&driven, &x, &u));
    assert!((one[1] - other[1]).abs() < 1e-13, "{one:?} {other:?}"); // rounding
    for (one, other) in readings(&shaken, &x, &u).iter().zip(readings(&driven, &x, &u)) {
        assert!((one - other).abs() < 1e-13, "{one} {other}");
    }
}

/// A turning and a sliding body side by side, friction and springs on both: the short way is the
/// articulated one.
#[test]
fn axes_that_stand_apart_accelerate_as_the_articulated_bodies_do() {
    for space in [Space::Planar, Space::Spatial] {
        let mut hinge = joint("shaft", JointKind::Revolute { axis: Z }, [0.3, 0.0, 0.0]);
        (hinge.viscous_friction, hinge.rotor_inertia, hinge.stiffness) = (known(0.2), known(0.03), known(1.5));
        let mut rail = joint("rail", JointKind::Prismatic { axis: [0.6, 0.8, 0.0] }, [0.0; 3]);
        rail.viscous_friction = known(0.7);
        let mut plant = Plant {
            space,
            bodies: vec![
                body("rotor", None, hinge, 1.0, [0.1, 0.2, 0.0], [0.01, 0.02, 0.03]),
                body("carriage", None, rail, 4.0, [0.0; 3], [0.1; 3]),
            ],
            actuators: vec![torque_of("shaft"), torque_of("rail")],
            ..Plant::default()
        };
        plant.catalogue = super::effects::CATALOGUE;
        plant.add_effect("spring", &"joint:shaft".parse().unwrap(), &[("size", 0.4)]).unwrap();
        let system = System::new(&plant).unwrap();
        assert!(system.lightness_apart.is_some());
        let (x, u) = (random_state(&system, 3), [0.7, -1.3]);
        let mut whole = vec![0.0; x.len()];
        system.derivative_and_read(&mut Workspace::new(&system), 0.0, &x, &u, &mut whole, &mut []);
        for (short, whole) in rates(&system, &x, &u).iter().zip(&whole) {
            assert!((short - whole).abs() <= 1e-14 * whole.abs(), "{short} {whole}");
        }
        plant.environment.gravity_m_s2 = three([0.0, -9.81, 0.0]);
        assert!(System::new(&plant).unwrap().lightness_apart.is_none());
    }
}
