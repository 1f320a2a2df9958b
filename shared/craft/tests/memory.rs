//! A pass with its sensitivities takes its memory at the start, whatever the length of the record.

use identification::fit::{EstimationSession, LinearisedProblem};
use identification::problem::Problem;

#[global_allocator]
static ALLOCATOR: runtime::sys::CountingAllocator = runtime::sys::CountingAllocator;

/// Blocks taken by the linear model and the sensitivities of a record of so many seconds.
fn blocks(duration_s: f64) -> u64 {
    let text = include_str!("../../../deploy/plants/study_case.toml");
    let mut plant = plant_file::parse("study_case", text).unwrap().plant;
    // means, and readings of instants off their stamps
    plant.set_parameter("imu.clock_offset", -4e-3).unwrap();
    let recording = simulation::record(&plant, 5, duration_s, &mut |_| {}).unwrap();
    let problem = Problem::new(&plant, &[recording], &[]).unwrap();
    let session = EstimationSession { along: true, ..EstimationSession::new(&problem, 1).unwrap() };
    let theta = session.prior();
    let before = runtime::sys::allocations();
    let mut linearised = LinearisedProblem::new(&session, &plant, &theta, &session.noise).unwrap();
    linearised.take_jacobian(&session, &plant, &theta);
    runtime::sys::allocations() - before
}

#[test]
fn a_pass_and_its_sensitivities_take_no_memory_after_their_start() {
    // two events a control period, as the IMU stamps a time of its own; lists of the start that
    // grow by doubling take a few blocks for each of some forty plants
    let (short, long, events) = (blocks(0.5), blocks(3.5), 2 * 300);
    let more = long.saturating_sub(short);
    assert!(short > 0 && 2 * more < events, "{short} blocks for 50 periods, {more} more for 300 more");
}
