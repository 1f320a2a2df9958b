use super::*;
use crate::fit::EstimationSession;
use crate::synthetic::{plant, problem, recording, with_effect};
use dynamics::description::Plant;

/// `[Φ | Γ]` of one event by slopes and by flows, and whether the probe of that by slopes agrees.
struct Pair {
    slopes: Vec<f64>,
    flows: Vec<f64>,
    agrees: bool,
}

impl Pair {
    /// Largest distance, relative to the largest entry of its row.
    fn apart(&self, len: usize) -> f64 {
        let size = |row: &[f64]| row.iter().map(|b| b.abs()).fold(0.0, f64::max);
        let off = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size(b);
        self.slopes.chunks_exact(len).zip(self.flows.chunks_exact(len)).map(off).fold(0.0, f64::max)
    }
}

/// Along a run of `plant` with `more`, which is stepped as `plant` is and finer, and the length of
/// a row.
fn along(plant: &Plant, more: &dyn Fn(&Plant) -> Plant, duration_s: f64) -> (Vec<Pair>, usize) {
    let problem = problem(plant, recording(plant, 3, duration_s));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let mut propagator = Propagator::new(&problem, 0, &more(plant), &session.timelines[0]).unwrap();
    let mut own = Transitions::new(&propagator);
    let (n, len) = (own.n, own.n + own.m);
    let sigmas = vec![1e-3; len];
    let mut mean = propagator.start();
    let mut step = |k: usize| {
        let mut pair = Pair { slopes: vec![0.0; n * len], flows: vec![0.0; n * len], agrees: false };
        own.base.copy_from_slice(&mean.x);
        own.take_slopes(&mut propagator, k, &mut pair.slopes);
        pair.agrees = own.is_that_of_the_flow(&mut propagator, k, &mean, &sigmas, &pair.slopes);
        own.take_flows(&mut propagator, k, &mean, &mut pair.flows);
        mean.x.copy_from_slice(&own.base);
        pair
    };
    ((0..session.timelines[0].events.len() - 1).map(&mut step).collect(), len)
}

#[test]
fn slopes_in_the_middle_of_a_step_give_the_transitions_of_the_flow() {
    for (name, duration_s) in [("double_pendulum", 4.0), ("hub_appendage", 1.0), ("drive_rig", 1.0)] {
        let (pairs, len) = along(&plant(name), &Plant::clone, duration_s);
        let worst = pairs.iter().map(|pair| pair.apart(len)).fold(0.0, f64::max);
        assert!(pairs.len() > 50 && worst < 2e-3, "{name}: {worst} in {}", pairs.len());
        assert!(pairs.iter().all(|pair| pair.agrees), "{name}");
    }
}

#[test]
fn where_a_law_turns_within_a_step_slopes_are_off_and_the_probe_says_so() {
    let sharp = [("force", 0.02), ("smooth_rate", 5e-4)];
    let more = |plant: &Plant| with_effect(plant, "joint_coulomb", "joint:pivot_2", &sharp);
    let (pairs, len) = along(&plant("double_pendulum"), &more, 4.0);
    let off: Vec<&Pair> = pairs.iter().filter(|pair| pair.apart(len) > 0.1).collect();
    // one direction of several may happen to agree
    let missed = off.iter().filter(|pair| pair.agrees).count();
    assert!(off.len() > 20 && 20 * missed < off.len(), "{missed} of {}", off.len());
    let agrees = pairs.iter().filter(|pair| pair.agrees).count();
    assert!(2 * agrees > pairs.len(), "{agrees} of {}", pairs.len());
}
