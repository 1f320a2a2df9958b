//! How many frames a diagnosis takes: as many as its work is worth, counted, at any speed.
//!
//! A diagnosis is computed on a thread of its own while frames go on. Its answer belongs to the
//! frame in which the share of all frames since the question pays for what it has cost:
//!
//! ```text
//! granted(k) = RATE k T − HEAD_START ≥ work,   k frames of T nanoseconds behind the question
//! ```
//!
//! so that no frame waits for more than its share, and none at all where the thread is ahead.

use identification::work::QUICK_WORK;

/// Count at which the search of one diagnosis ends; what it has begun may cost several times as
/// much ([`frames_max`]). It pays for 20 s of the study case's arm motion whole; of a longer arc
/// the beginning is diagnosed, in which a motion may lack the reversal that tells friction from a
/// constant torque.
pub const WORK_MAX: f64 = 1.5 * QUICK_WORK;
/// Work that a nanosecond of a frame pays for: half a core, which counts 3.3 to 5 a nanosecond of
/// the study case.
const RATE: f64 = 2.0;
/// Work that the thread is ahead of the frames: more than it does between two counts.
const HEAD_START: f64 = 4e9;
/// Work of the dearest diagnosis, in limits: a search ends at its limit, what it has begun does
/// not. One of the study case whose noise took the limit was counted at eight.
const LIMITS_MAX: f64 = 20.0;

/// Work that frames pay for, `frames` of `period_ns` behind the question; less than zero before any
/// is.
#[must_use]
pub fn granted(frames: u64, period_ns: u64) -> f64 {
    RATE * period_ns as f64 * frames as f64 - HEAD_START
}

/// Frames of `period_ns` in which the dearest diagnosis has answered.
#[must_use]
pub fn frames_max(period_ns: u64) -> u64 {
    ((LIMITS_MAX * WORK_MAX + HEAD_START) / (RATE * period_ns as f64)).ceil() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: u64 = 10_000_000;

    #[test]
    fn no_frame_pays_for_more_than_its_share_and_the_dearest_diagnosis_is_paid_for_in_time() {
        assert!(granted(0, PERIOD_NS) < 0.0);
        let most = frames_max(PERIOD_NS);
        for frame in 0..most {
            let own = granted(frame + 1, PERIOD_NS) - granted(frame, PERIOD_NS);
            assert!((own - RATE * PERIOD_NS as f64).abs() < 1e-3, "{own}");
        }
        assert!(granted(most, PERIOD_NS) >= LIMITS_MAX * WORK_MAX);
    }
}
