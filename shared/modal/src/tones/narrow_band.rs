//! Is the content of a narrow band a driven mode, or one or two lines?
//!
//! Under white noise a mode's envelope is a Gaussian process that forgets at the rate ζω: its
//! spectrum about its peak is a Lorentzian of half width ζf, and what a line takes out of it leaves
//! the rest of that Lorentzian. A line leaves nothing but the floor. With `I_k` the Hann-tapered
//! periodogram of the envelope over cells of 1/T, the Whittle likelihood of `A (Λ_g(k − k₀) + φ)`
//! is maximised before and after the best one or two lines are removed; the gain is the statistic.
//! Its distribution under the hypothesis of a mode is found by simulation at the fitted g and φ
//! (parametric bootstrap, fixed seed), so that record length, damping and floor are accounted for.
//! Whittle 1953; Rife & Boorstyn 1974.
//!
//! A mode that forgets nothing within the record is a line to it: g ≥ `LEAST_FORGETTING` / 2π
//! cells.

use super::baseband::{gain, hann};
use super::fourier::turn;
use crate::seeded::Seeded;
use core::f64::consts::{PI, TAU};
use faer::c64;

/// Half width of the band in cells, where the frequency allows it.
pub(super) const HALF_CELLS: usize = 24;
/// Fewest cells in half a band that show a skirt.
pub(super) const HALF_CELLS_MIN: usize = 6;
/// ζωT of the most persistent motion that is called a mode: its envelope changes three times.
const LEAST_FORGETTING: f64 = 3.0;
/// Probability that a mode is taken for one line, and for two, in weights that the line has no part
/// in.
pub(super) const LINE_CHANCE: f64 = 1.0 / 1500.0;
/// Simulated modes whose gains show their tail: twenty above the start of it, its scale to a
/// quarter.
const FIRST_SIMULATIONS: usize = 200;
/// A tail this far below the chance asked for is below it with a scale wrong by a third, too.
const CLEAR_SHARE: f64 = 0.1;
/// Largest change of a tone's amplitude over the record, as a logarithm. A decay that does not
/// differ from a mode by its skirt, ζωT < 3, falls by more unless it hardly falls at all.
const GROWTH_MAX: f64 = 0.2;
/// Deviations by which the change may seem larger: two sides, once in a hundred lines.
const GROWTH_SIGMA: f64 = 2.6;
/// Cells beside a line whose power is that of its neighbourhood.
const BESIDE: [isize; 6] = [-4, -3, -2, 2, 3, 4];
/// Lines sought together.
const LINES_MAX: usize = 2;
/// Frequencies per cell in the search of a line.
const FINE: usize = 4;
/// Ratio of successive half widths tried.
const WIDTH_RATIO: f64 = 1.4;
/// Floors tried, relative to the peak of the Lorentzian.
const FLOORS: [f64; 11] = [0.0, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0];

/// A band of so many cells, with everything that does not depend on the data.
pub(super) struct NarrowBand {
    half_cells: usize,
    taper: Vec<f64>,
    /// Of the search, cell by cell and between: `e^{−2πi ν j / n}`.
    fine: Vec<Vec<c64>>,
    widths: Vec<f64>,
    /// Per width: what the taper makes of the Lorentzian, at quarter cells from its centre.
    shapes: Vec<Vec<f64>>,
}

/// `A (Λ_g(k − k₀) + φ)`: indices of g and φ, k₀ in quarter cells, and the log-likelihood.
#[derive(Clone, Copy, Debug)]
struct Fit {
    width: usize,
    floor: usize,
    centre: isize,
    log_likelihood: f64,
}

/// A line of the envelope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Cells from the centre.
    pub cells: f64,
    amplitude: c64,
    /// Change of the logarithm of its amplitude over the record.
    growth: f64,
}

impl NarrowBand {
    pub fn new(half_cells: usize) -> Self {
        let count = 4 * half_cells;
        let reach = (half_cells * FINE) as isize;
        let phasors = |nu: f64| (0..count).map(|j| turn(-TAU * nu * j as f64 / count as f64)).collect();
        let mut widths = vec![LEAST_FORGETTING / TAU];
        while widths[widths.len() - 1] < half_cells as f64 {
            widths.push(widths[widths.len() - 1] * WIDTH_RATIO);
        }
        let shape =
            |width: &f64| (0..=3 * FINE * half_cells).map(|x| tapered(*width, x as f64 / FINE as f64)).collect();
        Self {
            half_cells,
            taper: (0..count).map(|j| hann(j, count)).collect(),
            fine: (-reach..=reach).map(|k| phasors(k as f64 / FINE as f64)).collect(),
            shapes: widths.iter().map(shape).collect(),
            widths,
        }
    }

    /// The lines that stand in the band, if a mode explains it with less than `chance`.
    pub fn lines(&self, envelope: &[c64], chance: f64) -> Option<Vec<Line>> {
        let before = self.fit(&self.periodogram(envelope));
        let count = (1..=LINES_MAX).find(|count| self.is_unlikely(envelope, before, *count, chance))?;
        let lines = self.best_lines(envelope, count);
        if lines.iter().all(|line| line.growth.abs() < GROWTH_MAX) {
            return Some(lines);
        }
        // A mode under the line seems to make it grow; then a mode is what is left. Of a line that
        // wanders other lines are; and a peak of chance grows, so that chance has to be excluded
        // for all candidates.
        let rest = without(envelope, &lines);
        let may_be_steady =
            |line: &Line| line.growth.abs() < GROWTH_MAX + GROWTH_SIGMA * self.growth_deviation(&rest, line);
        let leaves_a_mode = || !self.is_unlikely(&rest, self.fit(&self.periodogram(&rest)), 1, LINE_CHANCE);
        let no_chance = || self.chance(envelope, before, count) < chance / super::CANDIDATES_MAX as f64;
        (lines.iter().all(may_be_steady) && no_chance() && leaves_a_mode()).then_some(lines)
    }

    /// Standard deviation of the growth of a line in what is left beside it, which a mode under the
    /// line makes large: of `g = n Re(Σ w x y / a) / Σ w x²` with the power `s` per value,
    /// `n (½ s Σ w² x²)^½ / (|a| Σ w x²)`.
    fn growth_deviation(&self, rest: &[c64], line: &Line) -> f64 {
        let count = rest.len() as f64;
        let (mut squares, mut spread, mut both) = (0.0, 0.0, 0.0);
        for (j, w) in self.taper.iter().enumerate() {
            let x = j as f64 + 0.5 - 0.5 * count;
            squares += w * w;
            spread += w * x * x;
            both += w * w * x * x;
        }
        let centre = libm::round(line.cells * FINE as f64) as isize + (self.half_cells * FINE) as isize;
        let beside = BESIDE.map(|cells| centre + cells * FINE as isize);
        let inside = beside.iter().filter_map(|k| usize::try_from(*k).ok().and_then(|k| self.fine.get(k)));
        let powers: Vec<f64> = inside.map(|phasors| self.correlate(rest, phasors).norm_sqr() / squares).collect();
        let power = powers.iter().sum::<f64>() / powers.len().max(1) as f64;
        count * (0.5 * power * both).sqrt() / (line.amplitude.norm_sqr().sqrt() * spread)
    }

    /// Whether a mode as fitted gains as much by so many lines with a probability below `chance`:
    /// by the exponential tail of the gains of simulated modes where that is clear or the chance is
    /// rarer than modes can be simulated, by their number otherwise.
    fn is_unlikely(&self, envelope: &[c64], before: Fit, count: usize, chance: f64) -> bool {
        let gain = self.gain(envelope, before, count);
        let mut random = Seeded::new(0x70E5);
        let mut gains: Vec<f64> = Vec::new();
        while (gains.len() as f64) < 1.0 / LINE_CHANCE {
            let simulated = self.simulated_gain(before, count, &mut random);
            if simulated >= gain {
                return false;
            }
            gains.push(simulated);
            if gains.len() == FIRST_SIMULATIONS {
                let is_clear = tail(&mut gains, gain) < CLEAR_SHARE * chance;
                if is_clear || chance < LINE_CHANCE {
                    return is_clear;
                }
            }
        }
        true
    }

    /// Probability that a mode as fitted gains as much by so many lines, by the tail of
    /// [`FIRST_SIMULATIONS`] gains.
    fn chance(&self, envelope: &[c64], before: Fit, count: usize) -> f64 {
        let mut random = Seeded::new(0x70E5);
        let mut gains: Vec<f64> =
            (0..FIRST_SIMULATIONS).map(|_| self.simulated_gain(before, count, &mut random)).collect();
        tail(&mut gains, self.gain(envelope, before, count))
    }

    fn simulated_gain(&self, before: Fit, count: usize, random: &mut Seeded) -> f64 {
        let simulated = self.simulate(before, random);
        self.gain(&simulated, self.fit(&self.periodogram(&simulated)), count)
    }

    /// What so many lines gain in log-likelihood.
    fn gain(&self, envelope: &[c64], before: Fit, count: usize) -> f64 {
        let rest = without(envelope, &self.best_lines(envelope, count));
        self.fit(&self.periodogram(&rest)).log_likelihood - before.log_likelihood
    }

    /// Power per cell, the gain of the envelope taken out.
    fn periodogram(&self, envelope: &[c64]) -> Vec<f64> {
        let cells = self.fine.iter().enumerate().step_by(FINE);
        let power = |(k, phasors): (usize, &Vec<c64>)| {
            let response = gain((k / FINE) as f64 - self.half_cells as f64, self.half_cells);
            self.correlate(envelope, phasors).norm_sqr() / (response * response)
        };
        cells.map(power).collect()
    }

    fn correlate(&self, envelope: &[c64], phasors: &[c64]) -> c64 {
        let terms = envelope.iter().zip(&self.taper).zip(phasors);
        terms.fold(c64::new(0.0, 0.0), |sum, ((y, w), e)| sum + *y * *e * *w)
    }

    /// Lines that take most out of the envelope, one after the other and then each beside the
    /// others.
    fn best_lines(&self, envelope: &[c64], count: usize) -> Vec<Line> {
        let mut lines: Vec<Line> = Vec::new();
        for _ in 0..count {
            lines.push(self.best_line(&without(envelope, &lines)));
        }
        if count > 1 {
            for k in 0..count {
                let others: Vec<Line> = (0..count).filter(|other| *other != k).map(|other| lines[other]).collect();
                lines[k] = self.best_line(&without(envelope, &others));
            }
        }
        lines
    }

    /// The strongest line: the highest of the fine cells, then one Gauss–Newton step in frequency.
    fn best_line(&self, envelope: &[c64]) -> Line {
        let (mut best, mut height) = (0, -1.0);
        for (k, phasors) in self.fine.iter().enumerate() {
            let power = self.correlate(envelope, phasors).norm_sqr();
            if power > height {
                (best, height) = (k, power);
            }
        }
        let mut cells = best as f64 / FINE as f64 - self.half_cells as f64;
        let count = envelope.len() as f64;
        let weight: f64 = self.taper.iter().sum();
        let (mut amplitude, mut growth) = (c64::new(0.0, 0.0), 0.0);
        for _ in 0..3 {
            let (mut sum, mut slope, mut spread) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0), 0.0);
            for (j, (y, w)) in envelope.iter().zip(&self.taper).enumerate() {
                let (x, e) = (j as f64 + 0.5 - 0.5 * count, turn(-TAU * cells * j as f64 / count));
                sum += *y * e * *w;
                slope += *y * e * (*w * x);
                spread += w * x * x;
            }
            amplitude = sum / weight;
            if amplitude.norm_sqr() == 0.0 {
                break;
            }
            // y ≈ a (1 + iδ x): δ = Im(Σ w x y / a) / Σ w x², radians per value.
            let shift = (slope / amplitude).im / spread * count / TAU;
            cells += shift.clamp(-0.5, 0.5);
            growth = (slope / amplitude).re / spread * count;
        }
        Line { cells, amplitude, growth }
    }

    /// Maximum of the Whittle likelihood by turns over g, φ and k₀.
    fn fit(&self, periodogram: &[f64]) -> Fit {
        let mut best = Fit { width: 0, floor: 3, centre: 0, log_likelihood: f64::NEG_INFINITY };
        let peak = (0..periodogram.len()).max_by(|a, b| periodogram[*a].total_cmp(&periodogram[*b])).unwrap_or(0);
        let centre = (peak as isize - self.half_cells as isize) * FINE as isize;
        let limit = (self.half_cells * FINE) as isize;
        for start in [0, self.widths.len() / 2] {
            let mut fit = Fit { width: start, floor: 3, centre, log_likelihood: f64::NEG_INFINITY };
            for _ in 0..3 {
                let floors = (0..FLOORS.len()).map(|floor| Fit { floor, ..fit });
                fit = self.likeliest(floors, periodogram);
                let widths = (0..self.widths.len()).map(|width| Fit { width, ..fit });
                fit = self.likeliest(widths, periodogram);
                let centres = (-4..=4).map(|step| Fit { centre: (fit.centre + 2 * step).clamp(-limit, limit), ..fit });
                fit = self.likeliest(centres, periodogram);
            }
            if fit.log_likelihood > best.log_likelihood {
                best = fit;
            }
        }
        best
    }

    fn likeliest(&self, candidates: impl Iterator<Item = Fit>, periodogram: &[f64]) -> Fit {
        let judged = candidates.map(|fit| Fit { log_likelihood: self.log_likelihood(fit, periodogram), ..fit });
        judged.reduce(|a, b| if b.log_likelihood > a.log_likelihood { b } else { a }).expect("there are candidates")
    }

    /// `−n ln Â − Σ ln s_k`, `Â = mean(I_k / s_k)`.
    fn log_likelihood(&self, fit: Fit, periodogram: &[f64]) -> f64 {
        let (mut product, mut logs, mut scale) = (1.0, 0.0, 0.0);
        for (k, power) in periodogram.iter().enumerate() {
            let from_centre = (k as isize - self.half_cells as isize) * FINE as isize - fit.centre;
            let s = self.shapes[fit.width][from_centre.unsigned_abs()] + FLOORS[fit.floor];
            scale += power / s;
            product *= s;
            if k % 16 == 15 {
                logs += libm::log(product);
                product = 1.0;
            }
        }
        let count = periodogram.len() as f64;
        -count * libm::log((scale / count).max(f64::MIN_POSITIVE)) - logs - libm::log(product)
    }

    /// The envelope of a mode in its floor.
    fn simulate(&self, fit: Fit, random: &mut Seeded) -> Vec<c64> {
        let count = 4 * self.half_cells;
        let width = self.widths[fit.width];
        let keep = libm::exp(-TAU * width / count as f64);
        let drive = (1.0 - keep * keep).sqrt();
        let centre = fit.centre as f64 / FINE as f64 + random.uniform() - 0.5;
        // Per cell the Lorentzian has 1/(πg) of the power of the mode at its peak, the floor φ
        // times that.
        let floor = (FLOORS[fit.floor] * count as f64 / (PI * width)).sqrt();
        let mut state = random.complex_normal();
        (0..count)
            .map(|j| {
                state = state * keep + random.complex_normal() * drive;
                (state + random.complex_normal() * floor) * turn(TAU * centre * j as f64 / count as f64)
            })
            .collect()
    }
}

/// Probability of a gain beyond the largest tenth of some, which is exponential.
fn tail(gains: &mut [f64], gain: f64) -> f64 {
    gains.sort_by(f64::total_cmp);
    let upper = &gains[9 * gains.len() / 10..];
    let mean = upper.iter().map(|g| g - upper[0]).sum::<f64>() / upper.len() as f64;
    0.1 * libm::exp(-(gain - upper[0]).max(0.0) / mean)
}

/// The envelope without its lines.
fn without(envelope: &[c64], lines: &[Line]) -> Vec<c64> {
    let count = envelope.len() as f64;
    let mut rest = envelope.to_vec();
    for line in lines {
        for (j, y) in rest.iter_mut().enumerate() {
            *y -= line.amplitude * turn(TAU * line.cells * j as f64 / count);
        }
    }
    rest
}

/// Lorentzian of unit height seen through the Hann taper, `cells` from its centre.
fn tapered(width: f64, cells: f64) -> f64 {
    const PER_CELL: usize = 8;
    let (mut sum, mut total) = (0.0, 0.0);
    for k in 0..=4 * PER_CELL {
        let x = k as f64 / PER_CELL as f64 - 2.0;
        // Of the Hann window: sinc(x) / (1 − x²), squared; the same function as the gain's.
        let response = gain(x, 1);
        let offset = cells - x;
        sum += response * response * width * width / (width * width + offset * offset);
        total += response * response;
    }
    sum / total
}
