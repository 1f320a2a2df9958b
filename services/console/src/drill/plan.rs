//! The plan of a drill: which faults strike whom in which run, from one seed.

use crate::partition;
use telemetry::PartitionId;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Kill,
    Young,
    Point,
    Crash,
    Stop,
    Hang,
    Memory,
    Descriptors,
    Corrupt,
    Checkpoint,
    Clock,
    Hog,
    Disk,
    Shm,
    Rogue,
}

impl Kind {
    /// Every kind: its word, and what it does.
    pub const ALL: &'static [(Kind, &'static str, &'static str)] = &[
        (Kind::Kill, "kill", "SIGKILL at any moment"),
        (Kind::Young, "young", "SIGKILL 0 to 15 ms after a start"),
        (Kind::Point, "point", "SIGKILL before connect, in a frame, behind its outputs, in half a checkpoint"),
        (Kind::Crash, "crash", "SIGSEGV by a write through a null pointer"),
        (Kind::Stop, "stop", "SIGSTOP, SIGCONT 5 to 100 ms later"),
        (Kind::Hang, "hang", "SIGSTOP until it is found"),
        (Kind::Memory, "memory", "no more address space (RLIMIT_AS)"),
        (Kind::Descriptors, "descriptors", "no more descriptors (RLIMIT_NOFILE)"),
        (Kind::Corrupt, "corrupt", "a damaged sample in every topic"),
        (Kind::Checkpoint, "checkpoint", "a checkpoint cut at any byte"),
        (Kind::Clock, "clock", "everybody stopped together: the clock jumps"),
        (Kind::Hog, "hog", "a busy loop on every core"),
        (Kind::Disk, "disk", "the disk of the recording is full"),
        (Kind::Shm, "shm", "/dev/shm full for 0.3 s (in a namespace of its own)"),
        (Kind::Rogue, "rogue", "a process of the same user writes into connections and services"),
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        Kind::ALL.iter().find(|(kind, ..)| *kind == self).map_or("", |(_, word, _)| word)
    }

    /// The kind with this word.
    pub fn named(word: &str) -> Option<Self> {
        Kind::ALL.iter().find(|(_, own, _)| *own == word).map(|(kind, ..)| *kind)
    }
}

/// When a fault strikes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Microseconds after all partitions were started.
    Into { us: u64 },
    /// Microseconds after life `epoch` of the victim was started.
    Young { epoch: u32, us: u64 },
}

/// One fault from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strike {
    pub kind: Kind,
    pub victim: PartitionId,
    pub when: When,
    /// Length of a stop \[ms\], or what else the kind draws.
    pub number: u64,
}

/// One run of a drill.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunPlan {
    /// What this run is for; kills come on top.
    pub kind: Kind,
    pub strikes: Vec<Strike>,
    /// Faults that partitions inject into themselves: thousandths of the run, and a draw.
    pub own: Vec<(Kind, PartitionId, u64, u64)>,
}

/// Kills that every run gets beside the fault that it is for.
const KILLS_EACH: usize = 3;
/// Of a run that is for nothing but kills.
const KILLS_ALONE: usize = 6;

/// Draws of one run; `flight_us` is how long its partitions fly undisturbed.
#[must_use]
pub fn plan(seed: u64, number: u64, kinds: &[Kind], flight_us: u64) -> RunPlan {
    let mut random = Random(seed ^ number.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let kind = kinds[(number % kinds.len() as u64) as usize];
    let mut plan = RunPlan { kind, strikes: Vec::new(), own: Vec::new() };
    let kills = match kind {
        Kind::Kill | Kind::Young => KILLS_ALONE,
        _ if kinds.contains(&Kind::Kill) => KILLS_EACH,
        _ => 0,
    };
    for _ in 0..kills {
        let kind = if kind == Kind::Young { Kind::Young } else { Kind::Kill };
        plan.strikes.push(strike(kind, &mut random, flight_us));
    }
    match kind {
        Kind::Kill | Kind::Young | Kind::Hog | Kind::Disk | Kind::Shm | Kind::Corrupt => {}
        Kind::Point | Kind::Crash | Kind::Checkpoint => {
            for _ in 0..KILLS_EACH {
                let victim = victim(&mut random);
                plan.own.push((kind, victim, random.below(900), random.below(1001)));
            }
        }
        Kind::Clock => plan.strikes.push(strike(kind, &mut random, flight_us)),
        _ => (0..2).for_each(|_| plan.strikes.push(strike(kind, &mut random, flight_us))),
    }
    plan
}

fn victim(random: &mut Random) -> PartitionId {
    // drills fly no craft
    let victims = partition::of_run(false);
    victims[random.below(victims.len() as u64) as usize]
}

/// Nothing strikes in the last fifth: who has ended in order cannot be killed any more.
fn strike(kind: Kind, random: &mut Random, flight_us: u64) -> Strike {
    let victim = victim(random);
    let when = match kind {
        Kind::Young => When::Young { epoch: random.below(2) as u32, us: random.below(15_001) },
        _ => When::Into { us: random.below(flight_us * 4 / 5) },
    };
    Strike { kind, victim, when, number: random.below(1 << 16) }
}

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in 0..`limit` (bias below limit / 2^64).
    pub fn below(&mut self, limit: u64) -> u64 {
        ((u128::from(self.next()) * u128::from(limit)) >> 64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_one_plan_and_another_seed_another() {
        let all: Vec<Kind> = Kind::ALL.iter().map(|(kind, ..)| *kind).collect();
        let of = |seed| (0..30).map(|run| plan(seed, run, &all, 1_000_000)).collect::<Vec<_>>();
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        for (kind, word, _) in Kind::ALL {
            assert_eq!(Kind::named(word), Some(*kind));
            assert!(of(1).iter().any(|plan| plan.kind == *kind));
        }
    }

    #[test]
    fn victims_and_moments_are_spread_over_partitions_and_flight() {
        let strikes: Vec<Strike> = (0..400).flat_map(|run| plan(7, run, &[Kind::Kill], 1_000_000).strikes).collect();
        let victims = partition::of_run(false);
        for id in &victims {
            let hits = strikes.iter().filter(|strike| strike.victim == *id).count();
            // 2400 draws among n: mean 2400/n, standard deviation below its root; five of them.
            let mean = strikes.len() as f64 / victims.len() as f64;
            assert!((hits as f64 - mean).abs() < 5.0 * mean.sqrt(), "{id}: {hits} of {mean}");
        }
        assert!(strikes.iter().all(|strike| matches!(strike.when, When::Into { us } if us < 800_000)));
    }
}
