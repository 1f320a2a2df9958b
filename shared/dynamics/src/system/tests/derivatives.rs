//! Jacobians, and small changes of state.

use super::*;

#[test]
fn jacobians_by_dual_numbers_equal_central_differences() {
    let mut plant = everything(true);
    let at = |name: &str, kind| sensor(name, kind);
    plant.sensors = vec![
        at(
            "tip",
            SensorKind::Accelerometer {
                body: "hub".to_owned(),
                position_m: three([0.0; 3]),
                axis: [0.0, 1.0, 0.0],
                point: Some(("panel".to_owned(), "tip".to_owned())),
            },
        ),
        at("attitude", SensorKind::Attitude { body: "arm".to_owned(), axis: [0.6, 0.0, 0.8] }),
        at("force", SensorKind::Force { joint: "slide".to_owned(), axis: Z }),
        at("position", SensorKind::Position { body: "tool".to_owned(), position_m: three([0.1, 0.2, 0.3]), axis: Z }),
        at("effort", SensorKind::JointTorque { joint: "hinge".to_owned() }),
    ];
    let system = System::new(&plant).unwrap();
    let (x, u) = (random_state(&system, 3), [3.0, -8.0, 0.7, -0.4]);
    let space = system.linearise(&mut Workspace::new(&system), 0.0, &x, &u);
    let h = 1e-6;
    let both = |x: &[f64], u: &[f64]| (rates(&system, x, u), readings(&system, x, u));
    for column in 0..x.len() + u.len() {
        let moved = |h: f64| {
            let (mut x, mut u) = (x.clone(), u.to_vec());
            if column < x.len() {
                x[column] += h
            } else {
                u[column - x.len()] += h
            }
            both(&x, &u)
        };
        let (ahead, behind) = (moved(h), moved(-h));
        let found = |rates: bool, row: usize| match (rates, column.checked_sub(x.len())) {
            (true, None) => space.a[(row, column)],
            (true, Some(input)) => space.b[(row, input)],
            (false, None) => space.c[(row, column)],
            (false, Some(input)) => space.d[(row, input)],
        };
        for (rates, ahead, behind) in [(true, &ahead.0, &behind.0), (false, &ahead.1, &behind.1)] {
            for row in 0..ahead.len() {
                let difference = (ahead[row] - behind[row]) / (2.0 * h);
                // ε/h = 2e-10 times values of up to 1e3
                let error = difference - found(rates, row);
                assert!(error.abs() < 1e-6 * difference.abs().max(1.0), "row {row} column {column}: {error:e}");
            }
        }
    }
}

#[test]
fn a_change_of_state_added_is_the_change_found() {
    let system = System::new(&everything(false)).unwrap();
    let (a, b) = (random_state(&system, 1), random_state(&system, 2));
    assert_eq!(system.tangent_len() + 1, a.len());
    let (mut delta, mut back) = (vec![0.0; a.len() - 1], vec![0.0; a.len()]);
    system.difference(&a, &b, &mut delta);
    system.retract(&a, &delta, &mut back);
    let first = system.layout.quaternions[0];
    let sign = if back[first] * b[first] < 0.0 { -1.0 } else { 1.0 };
    for (k, (back, b)) in back.iter().zip(&b).enumerate() {
        let b = if (first..first + 4).contains(&k) { sign * b } else { *b };
        assert!((back - b).abs() < 1e-14, "{k}"); // rounding
    }
}

#[test]
fn states_have_the_names_they_should() {
    let system = System::new(&everything(false)).unwrap();
    let names: Vec<&str> = system.states().iter().map(|state| state.name.as_str()).collect();
    assert_eq!(&names[..4], ["body:hub.x", "body:hub.y", "body:hub.z", "body:hub.qw"]);
    assert_eq!(&names[7..9], ["joint:hinge", "joint:slide"]);
    assert_eq!(
        &names[9..17],
        [
            "tank:fuel",
            "tank:fuel.2",
            "tank:fuel.3",
            "tank:oxidiser",
            "tank:oxidiser.2",
            "mode:bend",
            "mode:twist",
            "mode:boom"
        ]
    );
    assert_eq!(names[17], "body:hub.rx.rate");
    assert_eq!(&names[names.len() - 2..], ["wheel:wheel1", "wheel:wheel2"]);
    assert_eq!(system.states()[8].unit, "m");
}
