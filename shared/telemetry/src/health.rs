//! Words of health monitoring: where an error counts, what it is, what is done about it.

use crate::names::coded;

coded! {
    /// What an error is counted with.
    HealthLevel {
        /// Nothing: it counts by itself.
        Process = 0 "process",
        /// All errors of its partition.
        Partition = 1 "partition",
        /// All errors of the run.
        Module = 2 "module",
    }
}

coded! {
    /// How a process ends before its run, or why a run stands still.
    HealthError {
        /// By a signal from outside: SIGKILL, SIGTERM or SIGINT.
        Kill = 0 "killed",
        /// By a signal that it caused.
        Crash = 1 "crashed",
        /// By itself, with an exit code that is not 0.
        Exit = 2 "ended with an error",
        /// It did nothing for its limit, and was killed for it.
        Hang = 3 "hung",
        /// No partition did a frame for a while.
        Stall = 4 "stalled",
    }
}

coded! {
    /// What is done about an error, the mildest first: each is more than the one before.
    HealthAction {
        /// From the last checkpoint; of a stalled run all partitions, with services made anew.
        Restart = 0 "restart",
        /// Without a checkpoint, from priors.
        ColdRestart = 1 "cold restart",
        /// Restart, and the mode SAFE for the vehicle.
        SafeMode = 2 "safe mode",
        /// The run goes on without the partition.
        GiveUp = 3 "end of the partition",
        EndRun = 4 "end of the run",
    }
}
