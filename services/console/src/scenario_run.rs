//! A run: what is carried out, over which link, and how it went.

use clap::ValueEnum;
use plant_file::scenario::Scenario;
use runtime::RunConfig;
use runtime::deaths::DeathRow;
use runtime::statistics::PartitionRow;

/// What carries the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LinkKind {
    /// Processes over shared memory.
    #[default]
    Shm,
    /// One thread, partition after partition.
    Lockstep,
}

/// A run, and its scenario as the partitions read it.
pub struct ScenarioRun {
    pub config: RunConfig,
    pub scenario: Scenario,
}

/// How a run went.
pub struct Finished {
    pub rows: Vec<PartitionRow>,
    /// Of its processes, over all lives.
    pub deaths: Vec<DeathRow>,
    pub wall_s: f64,
    pub link: LinkKind,
    /// Why it did not get to its end.
    pub failure: Option<String>,
}

/// Frames that a run will have, about.
#[must_use]
pub fn frames_expected(run: &ScenarioRun) -> u64 {
    let scenario = &run.scenario;
    let between = 3 * run.config.window_frames;
    if let Some(replay) = &run.config.replay {
        return replay.frames + 2 * between;
    }
    let durations = [
        scenario.modal.as_ref().map(|modal| modal.duration_s),
        scenario.slosh.as_ref().map(|slosh| slosh.duration_s),
        scenario.inertial.as_ref().map(|arm| arm.duration_s),
        scenario
            .mated
            .as_ref()
            .filter(|_| scenario.capture.enabled)
            .map(|arm| arm.duration_s + scenario.capture.settle_s),
    ];
    let arcs = scenario.craft.iter().flat_map(|craft| &craft.arcs).map(|arc| &arc.duration_s);
    durations.iter().flatten().chain(arcs).map(|&duration_s| scenario.frames(duration_s) + between).sum::<u64>()
        + 2 * between
}
