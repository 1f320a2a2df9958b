//! Channels that were computed from other channels.
//!
//! An independent measurement b of the same motion does not hold the noise of a. Whatever filter h
//! maps a to b, `b - h * a` then keeps at least `σ_a² ‖h‖²`; a residual below half of that (and by
//! an F test) shows that a's own noise went into b: b is a filtered copy. The test needs noise in a
//! that is known not to be motion: rounding, or a white floor at the top of its spectrum.
//! Noise-free data stay undecided and unreported.

use super::content::is_input;
use super::{Check, FALSE_ALARM, Finding, Severity, quantity, short};
use crate::lattice::lattice;
use crate::spectrum::{Averaging, density};
use channels::{Channel, Recording, Uniform};
use identification::statistics::{LeastSquares, deviation, fisher_tail, least_squares, white_floor};

/// Half widths [samples] and own past of the filters tried: moving ones, then recursive ones (b's
/// own past is free of a's noise under the null as well).
const FILTERS: [(usize, usize); 9] = [(0, 0), (1, 0), (2, 0), (4, 0), (8, 0), (16, 0), (32, 0), (1, 2), (4, 2)];
/// Residual of a copy, as a share of its largest value: single precision.
const COPY_SHARE: f64 = 3e-7;
/// Rows used at most; a filter of 65 taps is fixed by far fewer.
const FUNCTION_ROWS_MAX: usize = 8000;
/// Residual power below this share of what an independent channel would have to keep: where a's
/// noise is its rounding, which is no motion for certain, ...
const ROUNDING_SHARE: f64 = 0.5;
/// ... and where it is a white floor, which could be broad-band motion that b sees too, with noise
/// of its own.
const FLOOR_SHARE: f64 = 0.05;

/// Channels that follow from others, each from the one that it follows best.
///
/// Copies first: as the simplest function of each other they would pass for filtered ones, too.
/// `progress` receives the share done.
pub fn examine(recording: &Recording, progress: &mut dyn FnMut(f64)) -> Vec<Finding> {
    let grids: Vec<Option<Uniform>> =
        recording.channels.iter().map(|c| c.uniform().filter(|u| u.value.len() >= 24)).collect();
    let noise: Vec<Option<OwnNoise>> = grids.iter().map(|u| u.as_ref().and_then(|u| own_noise(&u.value))).collect();
    let channels = recording.channels.len();
    let pairs = (channels * channels) as f64;
    let (mut findings, same) = copies(recording, &grids);
    let sources = Sources::of(recording);
    for (j, b) in recording.channels.iter().enumerate() {
        progress(j as f64 / channels as f64);
        let mut best: Option<(f64, Finding)> = None;
        for i in sources.of_channel(j) {
            let a = &recording.channels[i];
            // what a copy follows from, its original follows from
            if same[j].is_some() || same[i] == Some(j) || !may_follow(recording, i, j) {
                continue;
            }
            let (Some(ua), Some(ub), Some(noise)) = (&grids[i], &grids[j], noise[i]) else { continue };
            if let Some((share, finding)) = filtered(a, b, ua, ub, noise, FALSE_ALARM / pairs)
                && best.as_ref().is_none_or(|(s, _)| share < *s)
            {
                best = Some((share, finding));
            }
        }
        if let Some((_, finding)) = best {
            let mirrored = findings.iter().any(|f| f.channel == finding.others[0] && f.others[0] == finding.channel);
            if !mirrored {
                findings.push(finding);
            }
        }
    }
    findings.extend(sources.note(recording));
    findings
}

/// Pairs that are compared at most: those of 64 channels. A budget: all pairs of 5000 channels are
/// six thousand times as many.
const PAIRS_MAX: usize = 4096;

/// Which channels may be the source of each: all, of many those of its place and those that stand
/// next to it.
struct Sources {
    places: Vec<Vec<String>>,
    /// Sources of one channel.
    most: usize,
}

impl Sources {
    fn of(recording: &Recording) -> Self {
        let places: Vec<Vec<String>> = recording.channels.iter().map(|of| quantity::place(&of.name)).collect();
        let most = if places.len() * places.len() <= PAIRS_MAX { places.len() } else { PAIRS_MAX / places.len() };
        Sources { places, most: most.max(1) }
    }

    /// In the order of the recording.
    fn of_channel(&self, j: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.places.len()).filter(|i| *i != j).collect();
        if all.len() > self.most {
            let key = |i: &usize| (self.places[*i] != self.places[j], i.abs_diff(j));
            all.select_nth_unstable_by_key(self.most - 1, key);
            all.truncate(self.most);
            all.sort_unstable();
        }
        all
    }

    /// Says which were not compared, where not all were.
    fn note(&self, recording: &Recording) -> Option<Finding> {
        let (first, channels) = (recording.channels.first()?, self.places.len());
        (self.most + 1 < channels).then(|| {
            Finding::new(Check::Derived, Severity::Note, &first.name, channels as f64, "-")
                .because(format!(
                    "{channels} channels are too many to compare each with each: each was compared with the {} of \
                     its place or next to it",
                    self.most
                ))
                .cure("examine fewer channels together where one may have been computed from another")
        })
    }
}

/// Two different measurements of one clock.
fn may_follow(recording: &Recording, i: usize, j: usize) -> bool {
    let (a, b) = (&recording.channels[i], &recording.channels[j]);
    i != j && !is_input(a) && !is_input(b) && a.same_clock(b)
}

/// Channels that repeat an earlier one, and per channel its original.
fn copies(recording: &Recording, grids: &[Option<Uniform>]) -> (Vec<Finding>, Vec<Option<usize>>) {
    let probes: Vec<Option<Probe>> = grids.iter().map(|grid| Probe::of(&grid.as_ref()?.value)).collect();
    let mut original = vec![None; grids.len()];
    let mut findings = Vec::new();
    for (j, b) in recording.channels.iter().enumerate() {
        for (i, a) in recording.channels.iter().enumerate().take(j) {
            let (Some(ua), Some(ub)) = (&grids[i], &grids[j]) else { continue };
            if original[j].is_none()
                && original[i].is_none()
                && let (Some(of_a), Some(of_b)) = (&probes[i], &probes[j])
                && of_a.may_give(&ua.value, &ub.value, of_b)
                && may_follow(recording, i, j)
                && related(a, b)
                && let Some(finding) = copied(a, b, ua, ub)
            {
                original[j] = Some(i);
                findings.push(finding);
            }
        }
    }
    (findings, original)
}

/// Where a channel is least and most, and its largest value: what tells at once that it is no
/// straight line of another.
struct Probe {
    least: usize,
    most: usize,
    largest: f64,
}

impl Probe {
    /// `None` of a constant.
    fn of(values: &[f64]) -> Option<Self> {
        let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let (least, most) = ((0..values.len()).min_by(by)?, (0..values.len()).max_by(by)?);
        let largest = values[most].abs().max(values[least].abs());
        (values[most] > values[least]).then_some(Probe { least, most, largest })
    }

    /// Whether b, of which `of_b` is known, may be a line of a: between the two points through
    /// which it is drawn a line departs from the best one by no more than these do, `COPY_SHARE`
    /// of the largest value each.
    fn may_give(&self, a: &[f64], b: &[f64], of_b: &Probe) -> bool {
        const PLACES: usize = 8;
        let (Some(low), Some(high)) = (b.get(self.least), b.get(self.most)) else { return false };
        let slope = (high - low) / (a[self.most] - a[self.least]);
        let near = |k: usize| {
            let line = low + slope * (a[k] - a[self.least]);
            (b[k] - line).abs() <= 3.0 * COPY_SHARE * of_b.largest
        };
        let n = a.len().min(b.len());
        (0..n).step_by((n / PLACES).max(1)).all(near)
    }
}

fn related(a: &Channel, b: &Channel) -> bool {
    match (quantity::of(&a.unit), quantity::of(&b.unit)) {
        (Some(p), Some(q)) => p.kind == q.kind && p.order == q.order,
        _ => true,
    }
}

fn copied(a: &Channel, b: &Channel, ua: &Uniform, ub: &Uniform) -> Option<Finding> {
    let fit = least_squares(&[ua.value.clone(), vec![1.0; ua.value.len()]], &ub.value, 0)?;
    let largest = ub.value.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let exact = fit.residual.iter().all(|e| e.abs() <= COPY_SHARE * largest);
    (exact && deviation(&ub.value) > 1e-5 * largest).then(|| {
        let (scale, offset) = (fit.coefficients[0], fit.coefficients[1]);
        Finding::new(Check::Copied, Severity::Warning, &b.name, scale, "-")
            .with(&[&a.name])
            .because(format!(
                "{} = {} x {} + {} to the last digit, in all {} samples",
                b.name,
                short(scale),
                a.name,
                short(offset),
                ub.value.len()
            ))
            .cure("use one of the two; counting both as measurements halves the noise that is not there")
    })
}

/// Noise of a channel that is no motion: rounding, else a white floor below a tenth of the
/// deviation.
#[derive(Clone, Copy, Debug)]
pub struct OwnNoise {
    pub sigma: f64,
    pub freedom: f64,
    /// Share of the noise below which a residual shows that another channel was computed from this
    /// one.
    pub share_max: f64,
}

/// Noise of a channel from its own samples; `None` where neither its resolution nor a white floor
/// shows it.
pub fn own_noise(x: &[f64]) -> Option<OwnNoise> {
    own_noise_below(x, 0.1)
}

/// As [`own_noise`], with another bound on the floor as a share of the deviation.
pub fn own_noise_below(x: &[f64], share: f64) -> Option<OwnNoise> {
    let spread = deviation(x);
    if let Some(l) = lattice(x) {
        let equal = x.windows(2).filter(|w| (w[1] - w[0]).abs() < 0.5 * l.step).count();
        let sigma = l.step / 12.0_f64.sqrt();
        // Fewer equal neighbours than half, or the rounding errors follow the motion and are no
        // noise.
        if 2 * equal < x.len() && sigma < 0.1 * spread && sigma > 1e-7 * spread {
            return Some(OwnNoise { sigma, freedom: x.len() as f64, share_max: ROUNDING_SHARE });
        }
    }
    let floor = white_floor(x).filter(|f| f.flat && f.sigma < share * spread && f.sigma > 1e-9 * spread)?;
    if x.len() >= 256 {
        // Orders 4 to 8 cannot tell white from a random walk; the upper octaves can (5 dB apart).
        let s = density(x, 1.0, Averaging::for_length(x.len()));
        let ((low, _), (high, _)) = (s.band(0.2, 0.3)?, s.band(0.4, 0.51)?);
        if low > 1.5 * high || high > 1.5 * low {
            return None;
        }
    }
    Some(OwnNoise { sigma: floor.sigma, freedom: floor.freedom, share_max: FLOOR_SHARE })
}

fn filtered(
    a: &Channel,
    b: &Channel,
    ua: &Uniform,
    ub: &Uniform,
    noise: OwnNoise,
    alpha: f64,
) -> Option<(f64, Finding)> {
    let OwnNoise { sigma, freedom: noise_freedom, share_max } = noise;
    let mut best: Option<(f64, usize, LeastSquares)> = None;
    // A slow quantity follows from its own past and anything faster: recursive filters are tried
    // towards the derivative only.
    let order = |c: &Channel| quantity::of_channel(c).map_or(0, |q| q.order);
    for (half, own) in FILTERS.into_iter().filter(|(_, own)| *own == 0 || order(b) > order(a)) {
        if ua.value.len() < 4 * (2 * half + 2) {
            continue;
        }
        let Some(fit) = fir(&ua.value, &ub.value, half, own) else { continue };
        let taps = 2 * half + 1;
        let gain = fit.coefficients[..taps].iter().map(|h| h * h).sum::<f64>().sqrt();
        let freedom = (fit.residual.len() - fit.rank) as f64;
        let power = fit.residual.iter().map(|e| e * e).sum::<f64>() / freedom;
        let share = power / (sigma * gain).powi(2).max(1e-300);
        // Taps that fit nothing have no size to speak of.
        if fit.r2 < 0.5
            || share > share_max
            || fisher_tail(1.0 / share, noise_freedom, freedom) > alpha / FILTERS.len() as f64
        {
            continue;
        }
        if best.as_ref().is_none_or(|(s, ..)| share < 0.5 * s) {
            best = Some((share, half, fit));
        }
    }
    let (share, half, fit) = best?;
    let taps: Vec<String> = fit.coefficients[..2 * half + 1].iter().take(9).map(|h| short(*h)).collect();
    let finding = Finding::new(Check::Derived, Severity::Fault, &b.name, share.sqrt(), "-")
        .with(&[&a.name])
        .because(format!(
            "a filter of {} taps on {}{} gives {} to {} {} rms (R2 = {}); with noise of its own it could not fall below {} (the noise of {}, {} {}, through that filter). Taps from {} samples ahead: {}{}",
            2 * half + 1, a.name, if fit.coefficients.len() > 2 * half + 2 { " and two of its own past" } else { "" }, b.name, short((share).sqrt() * sigma * norm(&fit, half)), b.unit, short(fit.r2), short(sigma * norm(&fit, half)),
            a.name, short(sigma), a.unit, half, taps.join(" "), if half > 4 { " …" } else { "" }
        ))
        .cure(format!("no measurement: do not fit on it. Use {} and let the estimator form the derivative", a.name));
    Some((share, finding))
}

fn norm(fit: &LeastSquares, half: usize) -> f64 {
    fit.coefficients[..2 * half + 1].iter().map(|h| h * h).sum::<f64>().sqrt()
}

/// `b_k ≈ Σ h_i a_(k+i) + Σ g_j b_(k-j) + c`, i from `half` ahead to `half` behind, j up to `own`.
fn fir(a: &[f64], b: &[f64], half: usize, own: usize) -> Option<LeastSquares> {
    let rows: Vec<usize> = (half.max(own)..b.len() - half).collect();
    let stride = rows.len().div_ceil(FUNCTION_ROWS_MAX);
    let rows: Vec<usize> = rows.into_iter().step_by(stride).collect();
    let centre = identification::statistics::mean(a);
    let mut columns: Vec<Vec<f64>> =
        (0..=2 * half).map(|i| rows.iter().map(|k| a[k + half - i] - centre).collect()).collect();
    columns.push(vec![1.0; rows.len()]);
    columns.extend((1..=own).map(|j| rows.iter().map(|k| b[k - j]).collect::<Vec<f64>>()));
    least_squares(&columns, &rows.iter().map(|&k| b[k]).collect::<Vec<_>>(), 0)
}
