//! Late thrusters.

use super::*;
use nalgebra::vector;

const NOISE: PlanarNoise = PlanarNoise { acceleration_m_s2: 1e-4, rate_rad_s: 1e-5 };
/// A tenth and a fifth of an interval of two seconds.
const LATE: PlanarThrust = PlanarThrust { scale: Vector2::new(1.0, 1.0), delay_s: Vector2::new(0.2, 0.4) };

fn sample(x_n: f64, y_n: f64) -> PlanarSample {
    PlanarSample { wrench: Wrench { force_n: vector![x_n, y_n], torque_n_m: 0.0 }, ..PlanarSample::default() }
}

/// Mean force over interval k.
fn force_n(record: &PlanarRecord<'_>, k: usize) -> Option<Vector2<f64>> {
    LATE.acting(record, k).map(|[_, middle, _]| middle.force_n)
}

#[test]
fn before_its_record_a_craft_at_rest_has_no_thrust_and_a_part_of_a_record_has_the_one_before_it() {
    let samples = [sample(1.0, 2.0), sample(1.0, -2.0), sample(0.0, 0.0)];
    let record = PlanarRecord::new(&samples, 2.0, NOISE);
    let near = |found: Option<Vector2<f64>>, x_n: f64, y_n: f64| {
        assert!((found.expect("held") - vector![x_n, y_n]).amax() < 1e-12, "{found:?}"); // rounding
    };
    near(force_n(&record, 0), 0.9, 1.6);
    near(force_n(&record, 1), 1.0, -1.2);
    near(force_n(&record.part(1, 3), 0), 1.0, -1.2);
    near(force_n(&PlanarRecord { force_before_n: vector![1.0, 2.0], ..record }, 0), 1.0, 2.0);
}

#[test]
fn sums_with_edges_within_are_refused_where_thrusters_are_late() {
    let held = [sample(0.0, 0.0), sample(0.0, 0.0), sample(0.0, 1.0), sample(0.0, 1.0)];
    let sums = [PlanarSample::mean(&held[..3]), PlanarSample::mean(&held[3..])];
    let record = PlanarRecord::new(&sums, 2.0, NOISE);
    assert_eq!(LATE.check(&record), Err(PlanarError::DelayedSums));
    assert!(force_n(&record, 0).is_none() && force_n(&record, 1).is_none()); // itself, and through what came before
    assert_eq!(LATE.check(&PlanarRecord::new(&held, 2.0, NOISE)), Ok(()));
    // Prompt along the axis of the edge.
    let along_x = PlanarThrust { delay_s: vector![0.2, 0.0], ..LATE };
    assert!(along_x.check(&record).is_ok() && along_x.acting(&record, 1).is_some());
}
