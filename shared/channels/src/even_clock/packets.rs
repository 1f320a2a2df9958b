//! Rows that were lost among packets: of a logger's batches, or of the rows between two ticks of a
//! coarse clock.
//!
//! Without a loss the first row of packet p, number `i_p`, has the stamp `u + T i_p`, T the time
//! from row to row, with u the same for all packets but for their delay. Lost rows raise u by T each
//! from there on; a packet that is late alone raises it once. So a loss is where the lowest of the
//! next u exceeds the highest of those before by more than two rows and by more than neighbours
//! scatter.

use super::Line;

/// Neighbours in length beyond which steps are of another kind: an outage is a packet at least.
const KIND_RATIO: f64 = 1.5;
/// Steps from packet to packet that show what is usual, and how many of them for each longer one.
const USUAL_MIN: usize = 4;
/// Kinds of steps that are tried.
const KINDS_MAX: usize = 8;
/// Packets on each side that show whether a delay lasts.
const BESIDE: usize = 4;
/// Packets on each side that show how many rows were lost.
const LEVEL: usize = 16;
/// Packets over which the time from row to row is first estimated.
const SPAN: usize = 8;

/// Steps of one kind: from packet to packet, where no packet is lost.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind {
    shortest_s: f64,
    longest_s: f64,
}

/// Kinds of steps that may be the usual ones, shortest first.
pub(super) fn kinds(steps: &[f64], ulps: f64) -> Vec<Kind> {
    let mut sorted: Vec<f64> = steps.iter().copied().filter(|step| *step > ulps).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let of_kind = |pair: &f64, next: &f64| *next <= KIND_RATIO * pair;
    let mut longer = sorted.len();
    let mut kinds = Vec::new();
    for kind in sorted.chunk_by(of_kind) {
        longer -= kind.len();
        if kind.len() >= USUAL_MIN && kind.len() >= USUAL_MIN * longer {
            kinds.push(Kind { shortest_s: kind[0], longest_s: kind[kind.len() - 1] });
        }
    }
    kinds.truncate(KINDS_MAX);
    kinds
}

/// Rows of the even clock behind packets, and the longest wait for one.
pub(super) struct Packets {
    /// Row of each stamp; lost ones are counted.
    pub rows: Vec<usize>,
    /// Longest step at which nothing was lost \[s\].
    pub wait_s: f64,
}

impl Packets {
    /// Of stamps whose steps from packet to packet are of `kind`.
    pub fn of(time: &[f64], steps: &[f64], kind: Kind) -> Option<Self> {
        let starts: Vec<usize> = (1..time.len()).filter(|row| steps[row - 1] >= kind.shortest_s).collect();
        let mut interval = first_interval(time, &starts)?;
        let mut packets = Packets { rows: Vec::new(), wait_s: 0.0 };
        for _ in 0..3 {
            packets = Self::counted(time, steps, &starts, (kind, interval));
            interval = Some(Line::of(&packets.rows, time).slope).filter(|slope| *slope > 0.0)?;
        }
        Some(packets)
    }

    fn counted(time: &[f64], steps: &[f64], starts: &[usize], (kind, interval): (Kind, f64)) -> Self {
        let lost = lost_before(time, steps, starts, (kind, interval));
        let mut rows: Vec<usize> = (0..time.len()).collect();
        let (mut sum, mut wait_s) = (0, 0.0_f64);
        let ends = starts.iter().skip(1).copied().chain([time.len()]);
        for ((start, end), lost) in starts.iter().zip(ends).zip(lost) {
            sum += lost;
            rows[*start..end].iter_mut().for_each(|row| *row += sum);
            if lost == 0 {
                wait_s = wait_s.max(steps[start - 1]);
            }
        }
        Packets { rows, wait_s }
    }
}

/// Median over spans of packets of the time from row to row.
fn first_interval(time: &[f64], starts: &[usize]) -> Option<f64> {
    let span = (starts.len() / 4).clamp(1, SPAN);
    let ends = starts.iter().skip(span);
    let mut each: Vec<f64> = starts.iter().zip(ends).map(|(a, b)| (time[*b] - time[*a]) / (b - a) as f64).collect();
    each.sort_unstable_by(f64::total_cmp);
    each.get(each.len() / 2).copied().filter(|interval| *interval > 0.0)
}

/// Rows lost right before each packet; see the module's law. How many follows from the usual u on
/// both sides: the first packet behind a loss may be a part of one.
fn lost_before(time: &[f64], steps: &[f64], starts: &[usize], (kind, interval): (Kind, f64)) -> Vec<usize> {
    let off: Vec<f64> = starts.iter().map(|row| time[*row] - interval * *row as f64).collect();
    let losses = losses(&off, interval);
    let mut lost = vec![0; off.len()];
    // nothing is known of the wait for the first packet but what is usual
    let first_step = steps[starts[0] - 1];
    if first_step > KIND_RATIO * kind.longest_s {
        lost[0] = libm::round((first_step - kind.longest_s) / interval) as usize;
    }
    for (k, loss) in losses.iter().enumerate() {
        let from = if k == 0 { 0 } else { losses[k - 1] };
        let to = losses.get(k + 1).copied().unwrap_or(off.len());
        let before = &off[from.max(loss.saturating_sub(LEVEL))..*loss];
        let behind = &off[*loss..to.min(loss + LEVEL)];
        lost[*loss] = libm::round((usual(behind) - usual(before)) / interval) as usize;
    }
    lost
}

/// Packets before which rows were lost.
fn losses(off: &[f64], interval: f64) -> Vec<usize> {
    let moves: Vec<f64> = off.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let least = (2.0 * interval).max(3.0 * usual(&moves));
    let lowest = |part: &[f64]| part.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = |part: &[f64]| part.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut losses: Vec<usize> = Vec::new();
    for p in 1..off.len() {
        let since = losses.last().copied().unwrap_or(0);
        let before = &off[since.max(p.saturating_sub(BESIDE))..p];
        if lowest(&off[p..off.len().min(p + BESIDE)]) - highest(before) > least {
            losses.push(p);
        }
    }
    losses
}

/// The median; zero of none.
fn usual(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
