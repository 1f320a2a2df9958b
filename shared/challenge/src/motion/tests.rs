use super::*;
use crate::bench::{BENCHES, Bench, kept};
use crate::equations::Numbers;
use crate::hidden::{Hidden, Seat};
use crate::realised::rig;

fn bench(name: &str) -> &'static Bench {
    BENCHES.iter().find(|bench| bench.plant == name).unwrap()
}

fn hidden(kind: &str, values: &[(&str, f64)]) -> Hidden {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    Hidden { kind: kind.to_owned(), site: String::new(), values }
}

/// The drive without viscous friction: inertia 0.167 kg m², 2.3 N m/A.
fn drive(level: f64) -> Rig {
    let bench = bench("drive_rig");
    let mut numbers = Numbers::of(&kept(bench));
    numbers.0.insert("drive.friction".to_owned(), 0.0);
    rig(bench, &numbers, &[(hidden("joint_coulomb", &[("force", level)]), Seat::Coordinate(0))], 1, 2)
}

#[test]
fn a_body_on_dry_friction_runs_out_over_v_squared_and_stays_where_it_stopped() {
    let rig = drive(0.1);
    let mut motion = rig.begin(&[0.0], &[0.8]);
    let (inertia, level) = (0.167, 0.1);
    let stop_s = 0.8 * inertia / level; // 1.336 s
    rig.advance(&mut motion, &[0.0], 0.5 * stop_s);
    assert!((motion.x[1] - 0.4).abs() < 1e-9); // halfway through a steady deceleration; tolerance of the integrator
    rig.advance(&mut motion, &[0.0], 3.0);
    assert_eq!((motion.x[1], motion.contacts[0]), (0.0, Contact::Stuck));
    assert!((motion.x[0] - 0.5 * 0.64 * inertia / level).abs() < 1e-8, "{}", motion.x[0]);
    let rest = motion.x[0];
    rig.advance(&mut motion, &[0.99 * level / 2.3], 10.0);
    assert_eq!(motion.x[0], rest); // below break-away nothing moves at all: no creep
}

#[test]
fn above_break_away_it_slides_with_what_is_left_of_the_force() {
    let rig = drive(0.1);
    for sign in [1.0, -1.0] {
        let mut motion = rig.begin(&[0.0], &[0.0]);
        rig.advance(&mut motion, &[sign * 0.3 / 2.3], 1.0);
        let expected = sign * 0.2 / 0.167;
        assert!((motion.x[1] - expected).abs() < 1e-9 && motion.contacts[0] == Contact::Sliding(sign), "{motion:?}");
    }
}

#[test]
fn a_body_at_rest_accelerates_in_the_reading_of_the_instant_at_which_it_is_pushed() {
    let bench = bench("oscillator");
    let numbers = Numbers::of(&kept(bench));
    let rig = rig(bench, &numbers, &[(hidden("joint_coulomb", &[("force", 0.5)]), Seat::Coordinate(0))], 1, 2);
    let motion = rig.begin(&[0.0], &[0.0]);
    let acceleration = |push: f64| rig.read(&motion, &[push])[1];
    assert!((acceleration(-2.0) + 1.5 / 1.8).abs() < 1e-9 && acceleration(0.4) == 0.0, "{}", acceleration(-2.0));
}

#[test]
fn an_oscillator_on_dry_friction_loses_four_friction_heights_a_cycle() {
    let bench = bench("oscillator");
    let mut numbers = Numbers::of(&kept(bench));
    numbers.0.insert("rail.friction".to_owned(), 0.0);
    let level = 0.5;
    let rig = rig(bench, &numbers, &[(hidden("joint_coulomb", &[("force", level)]), Seat::Coordinate(0))], 1, 2);
    let mut motion = rig.begin(&[5e-3], &[0.0]);
    let cycle_s = core::f64::consts::TAU * (1.8_f64 / 2200.0).sqrt();
    for cycle in 1..=4 {
        rig.advance(&mut motion, &[0.0], cycle_s);
        let height = 5e-3 - 4.0 * f64::from(cycle) * level / 2200.0;
        assert!((motion.x[0] - height).abs() < 1e-9, "{cycle}: {} {height}", motion.x[0]); // Lorenz 1924: exact
    }
}

#[test]
fn a_lagging_input_is_an_exponential_however_it_is_cut() {
    let bench = bench("drive_rig");
    let numbers = Numbers::of(&kept(bench));
    let lag = [(hidden("actuator_lag", &[("time_constant", 0.02)]), Seat::Input(0))];
    let rig = rig(bench, &numbers, &lag, 1, 2);
    let run = |pieces: usize| {
        let mut motion = rig.begin(&[0.0], &[0.0]);
        (0..pieces).for_each(|_| rig.advance(&mut motion, &[1.0], 0.1 / pieces as f64));
        motion.x
    };
    let (whole, cut) = (run(1), run(40));
    let acting = 1.0 - libm::exp(-5.0);
    assert!((whole[2] - acting).abs() < 1e-14 && (cut[2] - acting).abs() < 1e-14);
    assert!(whole.iter().zip(&cut).all(|(a, b)| (a - b).abs() < 1e-9)); // tolerance of the integrator
}
