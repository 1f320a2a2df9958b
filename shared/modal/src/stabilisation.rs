//! Stabilisation over the order sweep: which poles repeat from one model order to the next.
//!
//! A physical mode appears at the same frequency, damping and shape in many successive orders; a
//! pole that models noise wanders. Poles are linked to the track whose last member (at most
//! `ORDER_GAP_MAX` orders back) they agree with; every rejected pole has its reason.

use crate::mac::modal_assurance_criterion;
use crate::ssi_cov::Pole;

/// Orders a track may miss: a new singular vector can disturb an old mode for one complex pair.
const ORDER_GAP_MAX: usize = 3;
/// Least assurance criterion of one shape at two orders.
const SAME_SHAPE: f64 = 0.8;

/// Agreement demanded between successive orders.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct StabilityCriteria {
    /// Relative change of frequency.
    pub frequency_change_max: f64,
    /// Relative change of damping.
    pub damping_change_max: f64,
    /// Absolute change of damping that is always allowed: the relative one is meaningless near
    /// zero.
    pub damping_change_floor: f64,
    pub mac_min: f64,
    /// Poles above this damping ratio are not sought.
    pub damping_max: f64,
}

impl Default for StabilityCriteria {
    /// Customary criteria of the stabilisation diagram: 1 % in frequency, MAC 0.95; damping loose
    /// (30 %) because its scatter is.
    fn default() -> Self {
        Self {
            frequency_change_max: 0.01,
            damping_change_max: 0.3,
            damping_change_floor: 0.002,
            mac_min: 0.95,
            damping_max: 0.25,
        }
    }
}

/// Why a pole is not part of a reported mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rejection {
    /// A real pole: bias, drift or a filter, not an oscillation.
    NotOscillating,
    /// Outside the requested band or the pass band of its decimation.
    OutOfBand {
        frequency_min_hz: f64,
        frequency_max_hz: f64,
    },
    /// Growing, or not decaying.
    DampingNotPositive {
        damping_ratio: f64,
    },
    DampingAboveLimit {
        damping_ratio: f64,
        damping_max: f64,
    },
    /// Repeats over too few orders.
    NotStable {
        orders_found: usize,
        orders_needed: usize,
    },
    /// Appears only in orders above one that already leaves white noise.
    ModelsNoise {
        complete_order: usize,
    },
    /// Repeats only below the order at which the last mode appears, as two close modes that are
    /// taken for one do.
    NotInModel {
        order_min: usize,
    },
    /// Damping within three of its standard deviations of zero, or frequency not known to half the
    /// bandwidth.
    NotResolved {
        damping_ratio: f64,
        sigma_damping: f64,
        sigma_frequency_hz: f64,
    },
    /// Shape scattered over the complex plane.
    PhaseNotCollinear {
        phase_collinearity: f64,
        needed: f64,
    },
    /// In the band in which a tone wandered.
    HiddenByTone,
    /// At a combination of stronger modes of a record that is clipped.
    Combination,
    /// The same mode is better known at another sample rate.
    BetterElsewhere {
        decimation: usize,
    },
}

/// A rejected pole and the reason.
#[derive(Clone, Debug)]
pub struct RejectedPole {
    pub decimation: usize,
    pub order: usize,
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub reason: Rejection,
}

/// Poles of successive orders that agree, at most one per order, in rising order.
#[derive(Clone, Debug)]
pub struct Track {
    pub poles: Vec<Pole>,
}

impl StabilityCriteria {
    /// Reason to reject a pole, for any poles of other orders.
    #[must_use]
    pub fn hard_rejection(&self, pole: &Pole, band_hz: (f64, f64)) -> Option<Rejection> {
        if pole.eigenvalue.im <= 0.0 {
            Some(Rejection::NotOscillating)
        } else if pole.frequency_hz < band_hz.0 || pole.frequency_hz > band_hz.1 {
            Some(Rejection::OutOfBand { frequency_min_hz: band_hz.0, frequency_max_hz: band_hz.1 })
        } else if pole.damping_ratio <= 0.0 {
            Some(Rejection::DampingNotPositive { damping_ratio: pole.damping_ratio })
        } else if pole.damping_ratio > self.damping_max {
            Some(Rejection::DampingAboveLimit { damping_ratio: pole.damping_ratio, damping_max: self.damping_max })
        } else {
            None
        }
    }

    /// How far a pole agrees with one of another order: 0 no agreement, 1 frequency, 2 damping too,
    /// 3 shape too.
    #[must_use]
    pub fn agreement(&self, a: &Pole, b: &Pole) -> usize {
        let allowed = (self.damping_change_max * b.damping_ratio).max(self.damping_change_floor);
        let agrees = [
            (a.frequency_hz - b.frequency_hz).abs() <= self.frequency_change_max * b.frequency_hz,
            (a.damping_ratio - b.damping_ratio).abs() <= allowed,
            modal_assurance_criterion(&a.mode_shape, &b.mode_shape) >= self.mac_min,
        ];
        agrees.iter().take_while(|agrees| **agrees).count()
    }

    /// Distance in units of the criteria; above 1 the poles do not agree.
    fn distance(&self, a: &Pole, b: &Pole) -> f64 {
        let frequency = (a.frequency_hz - b.frequency_hz).abs() / (self.frequency_change_max * b.frequency_hz);
        let allowed = (self.damping_change_max * b.damping_ratio).max(self.damping_change_floor);
        let damping = (a.damping_ratio - b.damping_ratio).abs() / allowed;
        let shape = (1.0 - modal_assurance_criterion(&a.mode_shape, &b.mode_shape)) / (1.0 - self.mac_min);
        frequency.max(damping).max(shape)
    }
}

/// Links poles (given in rising order) to tracks; every pole ends in exactly one track.
#[must_use]
pub fn tracks(poles: Vec<Pole>, criteria: &StabilityCriteria) -> Vec<Track> {
    let mut tracks: Vec<Track> = Vec::new();
    let mut remaining = poles.into_iter().peekable();
    while let Some(order) = remaining.peek().map(|pole| pole.order) {
        let mut waiting: Vec<Option<Pole>> = Vec::new();
        while remaining.peek().is_some_and(|pole| pole.order == order) {
            waiting.push(remaining.next());
        }
        // Closest pairs first, so that two close modes do not exchange tracks.
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (p, pole) in waiting.iter().flatten().enumerate() {
            for (t, track) in tracks.iter().enumerate() {
                let last = track.poles.last().expect("a track is made with a pole");
                let distance = criteria.distance(pole, last);
                if order - last.order <= ORDER_GAP_MAX && distance <= 1.0 {
                    pairs.push((distance, t, p));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        for (_, t, p) in pairs {
            let track_is_free = tracks[t].poles.last().is_some_and(|last| last.order < order);
            if track_is_free && let Some(pole) = waiting[p].take() {
                tracks[t].poles.push(pole);
            }
        }
        tracks.extend(waiting.into_iter().flatten().map(|pole| Track { poles: vec![pole] }));
    }
    tracks
}

/// Whether a pole whose track ends below the order of a model has its place in it: a pole of that
/// model, of no other track, within its half width in the complex plane (three deviations, at the
/// least significance that a mode has) and of a shape alike.
///
/// Two close modes are one wide pole as long as the order is too low for both.
pub(crate) fn is_in_model(mode: &Pole, model: &[Pole], before: &[Track], behind: &[Track]) -> bool {
    let width_hz = |pole: &Pole| pole.damping_ratio * pole.frequency_hz;
    let is_of_another = |pole: &Pole| {
        let same = |other: &Pole| other.order == pole.order && other.eigenvalue == pole.eigenvalue;
        before.iter().chain(behind).any(|track| track.poles.iter().any(same))
    };
    let is_it = |pole: &Pole| {
        let apart_hz = libm::hypot(pole.frequency_hz - mode.frequency_hz, width_hz(pole) - width_hz(mode));
        apart_hz <= width_hz(mode) && modal_assurance_criterion(&pole.mode_shape, &mode.mode_shape) > SAME_SHAPE
    };
    model.iter().any(|pole| is_it(pole) && !is_of_another(pole))
}
