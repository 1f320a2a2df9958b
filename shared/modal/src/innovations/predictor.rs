//! One-step predictor with its sensitivities.

use crate::maximum_likelihood::{Evaluation, Feedthrough, Model, Outputs, exp};
use crate::record::Record;
use faer::{Mat, Side, c64};

/// Unknowns of the innovations form.
#[derive(Clone)]
pub(super) struct Predictor {
    pub poles: Vec<c64>,
    /// `z_k(0)`.
    initial: Vec<c64>,
    /// `c_ik`, per mode and channel.
    pub shapes: Vec<Vec<c64>>,
    /// `κ_kj`, per mode and channel.
    gains: Vec<Vec<c64>>,
    /// Per channel.
    direct: Vec<f64>,
    bias: Vec<f64>,
}

/// The likelihood around one set of unknowns.
pub(super) struct Step {
    /// `N/2 ln det (Σ e eᵀ/N)`.
    pub cost: f64,
    pub information: Mat<f64>,
    pub score: Vec<f64>,
    /// Channel by channel, zero where the row is absent.
    pub innovations: Vec<Vec<f64>>,
}

/// The pole over one sample, its response to the held input, and both slopes by the pole.
struct Sampled {
    e: c64,
    g: c64,
    e_slope: c64,
    g_slope: c64,
}

fn sampled(pole: c64, period: f64) -> Sampled {
    let e = exp(pole * period);
    let g = (e - 1.0) / pole;
    Sampled { e, g, e_slope: e * period, g_slope: (e * period - g) / pole }
}

impl Predictor {
    /// From residues of the input and of innovations of some `channels` as further inputs: gains
    /// and initial motion as far as the shapes of the forced motion carry them.
    pub fn of_residues(at: &Evaluation, poles: &[c64], channels: &[usize], period: f64) -> Self {
        let (pairs, l) = (at.columns.pairs, at.coefficients.len());
        let residue = |k: usize, pair: usize, i: usize| {
            let column = 2 * (k * pairs + pair);
            c64::new(at.coefficients[i][column], -at.coefficients[i][column + 1])
        };
        let fixed = 2 * pairs * poles.len();
        let shapes: Vec<Vec<c64>> = (0..poles.len()).map(|k| (0..l).map(|i| residue(k, 0, i)).collect()).collect();
        let none = c64::new(0.0, 0.0);
        let along = |k: usize, pair: usize| {
            let power: f64 = shapes[k].iter().map(c64::norm_sqr).sum();
            (0..l).map(|i| shapes[k][i].conj() * residue(k, pair, i)).fold(none, |sum, x| sum + x)
                / power.max(f64::MIN_POSITIVE)
        };
        let mut gains = vec![vec![none; l]; poles.len()];
        for (k, pole) in poles.iter().enumerate() {
            for (source, j) in channels.iter().enumerate() {
                gains[k][*j] = along(k, 1 + source) * sampled(*pole, period).g;
            }
        }
        let moves = pairs > 1 + channels.len();
        Self {
            poles: poles.to_vec(),
            initial: (0..poles.len()).map(|k| if moves { along(k, pairs - 1) } else { none }).collect(),
            gains,
            direct: at.coefficients.iter().map(|c| c[fixed]).collect(),
            bias: at.coefficients.iter().map(|c| c.get(fixed + 1 + channels.len()).copied().unwrap_or(0.0)).collect(),
            shapes,
        }
    }

    /// The predictor that hears no innovation: stable as its poles are.
    pub fn without_gains(&mut self) {
        self.gains.iter_mut().flatten().for_each(|gain| *gain = c64::new(0.0, 0.0));
    }

    /// Place of the first unknown of a mode: λ, z(0), shapes, gains; behind all modes direct terms
    /// and biases.
    pub fn first_of(&self, mode: usize) -> usize {
        mode * (4 + 4 * self.direct.len())
    }

    fn unknowns(&self) -> usize {
        self.first_of(self.poles.len()) + 2 * self.direct.len()
    }

    /// The same after a step.
    pub fn moved(&self, step: &[f64]) -> Self {
        let (mut next, l) = (self.clone(), self.direct.len());
        for k in 0..self.poles.len() {
            let of_mode = &step[self.first_of(k)..self.first_of(k + 1)];
            let pair = |at: usize| c64::new(of_mode[2 * at], of_mode[2 * at + 1]);
            next.poles[k] += pair(0);
            next.initial[k] += pair(1);
            (0..l).for_each(|i| next.shapes[k][i] += pair(2 + i));
            (0..l).for_each(|j| next.gains[k][j] += pair(2 + l + j));
        }
        let fixed = self.first_of(self.poles.len());
        (0..l).for_each(|i| next.direct[i] += step[fixed + i]);
        (0..l).for_each(|i| next.bias[i] += step[fixed + l + i]);
        next
    }

    /// Innovations, channel by channel; `None` if the predictor is not stable.
    fn innovations(&self, record: &Record, model: Model, outputs: &Outputs) -> Option<Vec<Vec<f64>>> {
        let l = self.direct.len();
        let mut all = vec![vec![0.0; outputs.samples]; l];
        let steps: Vec<Sampled> = self.poles.iter().map(|pole| sampled(*pole, 1.0 / record.sample_rate_hz)).collect();
        let mut z = self.initial.clone();
        let mut present = outputs.present.iter().enumerate().peekable();
        let mut e = vec![0.0; l];
        for t in 0..outputs.samples {
            let row = present.next_if(|(_, at)| **at == t).map(|(row, _)| row);
            self.error(record, model, outputs, &z, (t, row), &mut e);
            all.iter_mut().zip(&e).for_each(|(channel, e)| channel[t] = *e);
            for (k, step) in steps.iter().enumerate() {
                let heard = self.gains[k].iter().zip(&e).fold(c64::new(0.0, 0.0), |sum, (gain, e)| sum + gain * *e);
                z[k] = step.e * z[k] + step.g * record.input[t] + heard;
            }
            if !z.iter().all(|z| z.norm_sqr().is_finite()) {
                return None;
            }
        }
        Some(all)
    }

    /// Error of the prediction of one row; zero of an absent one.
    fn error(
        &self,
        record: &Record,
        model: Model,
        outputs: &Outputs,
        z: &[c64],
        at: (usize, Option<usize>),
        e: &mut [f64],
    ) {
        let Some(row) = at.1 else { return e.fill(0.0) };
        for (i, e) in e.iter_mut().enumerate() {
            let modes: f64 = z.iter().zip(&self.shapes).map(|(z, c)| c[i].re * z.re - c[i].im * z.im).sum();
            *e = outputs.channels[i][row] - modes - self.direct[i] * felt(record, model, at.0) - self.bias[i];
        }
    }

    /// `N/2 ln det (Σ e eᵀ/N)`.
    pub fn cost(&self, record: &Record, model: Model, outputs: &Outputs) -> Option<f64> {
        if self.poles.iter().any(|pole| pole.im <= 0.0) {
            return None;
        }
        let factor = covariance_factor(&self.innovations(record, model, outputs)?, outputs)?;
        Some(half_log_determinant(&factor, outputs))
    }

    /// Cost, information and score.
    pub fn linearised(&self, record: &Record, model: Model, outputs: &Outputs) -> Option<Step> {
        let innovations = self.innovations(record, model, outputs)?;
        let factor = covariance_factor(&innovations, outputs)?;
        let (l, m, p) = (self.direct.len(), self.poles.len(), self.unknowns());
        let steps: Vec<Sampled> = self.poles.iter().map(|pole| sampled(*pole, 1.0 / record.sample_rate_hz)).collect();
        let mut z = self.initial.clone();
        // ∂z_k/∂p as [re; im] per mode, ∂e_i/∂p per channel.
        let mut slopes = vec![[vec![0.0; p], vec![0.0; p]]; m];
        for k in 0..m {
            slopes[k][0][self.first_of(k) + 2] = 1.0;
            slopes[k][1][self.first_of(k) + 3] = 1.0;
        }
        let mut rows = vec![vec![0.0; p]; l];
        let mut gram = vec![0.0; p * p];
        let mut score = vec![0.0; p];
        let mut present = outputs.present.iter().peekable();
        for t in 0..outputs.samples {
            let u = record.input[t];
            let e: Vec<f64> = innovations.iter().map(|e| e[t]).collect();
            if present.next_if(|at| **at == t).is_some() {
                self.sensitivities(&z, felt(record, model, t), &slopes, &mut rows);
                accumulate(&factor, &rows, &e, &mut gram, &mut score);
            } else {
                rows.iter_mut().for_each(|row| row.fill(0.0));
            }
            for (k, step) in steps.iter().enumerate() {
                self.advance(k, step, (z[k], u), &e, &rows, &mut slopes[k]);
                let heard = self.gains[k].iter().zip(&e).fold(c64::new(0.0, 0.0), |sum, (gain, e)| sum + gain * *e);
                z[k] = step.e * z[k] + step.g * u + heard;
            }
        }
        let information = Mat::from_fn(p, p, |a, b| gram[a.min(b) * p + a.max(b)]);
        Some(Step { cost: half_log_determinant(&factor, outputs), information, score, innovations })
    }

    /// `∂e_i/∂p` at one row.
    fn sensitivities(&self, z: &[c64], felt: f64, slopes: &[[Vec<f64>; 2]], rows: &mut [Vec<f64>]) {
        let (l, fixed) = (rows.len(), self.first_of(z.len()));
        for (i, row) in rows.iter_mut().enumerate() {
            row.fill(0.0);
            for (k, [re, im]) in slopes.iter().enumerate() {
                let c = self.shapes[k][i];
                for ((row, re), im) in row.iter_mut().zip(re).zip(im) {
                    *row -= c.re * re - c.im * im;
                }
                let own = self.first_of(k) + 4 + 2 * i;
                row[own] -= z[k].re;
                row[own + 1] += z[k].im;
            }
            row[fixed + i] -= felt;
            row[fixed + l + i] -= 1.0;
        }
    }

    /// `∂z_k/∂p` from one sample to the next.
    fn advance(
        &self,
        k: usize,
        step: &Sampled,
        (z, u): (c64, f64),
        e: &[f64],
        rows: &[Vec<f64>],
        slope: &mut [Vec<f64>; 2],
    ) {
        let [re, im] = slope;
        for (re, im) in re.iter_mut().zip(im.iter_mut()) {
            (*re, *im) = (step.e.re * *re - step.e.im * *im, step.e.re * *im + step.e.im * *re);
        }
        for (gain, row) in self.gains[k].iter().zip(rows) {
            for ((re, im), row) in re.iter_mut().zip(im.iter_mut()).zip(row) {
                *re += gain.re * row;
                *im += gain.im * row;
            }
        }
        let (first, l) = (self.first_of(k), e.len());
        let by_pole = step.e_slope * z + step.g_slope * u;
        // i ∂/∂Re λ = ∂/∂Im λ, and so for the gains.
        (re[first], im[first]) = (re[first] + by_pole.re, im[first] + by_pole.im);
        (re[first + 1], im[first + 1]) = (re[first + 1] - by_pole.im, im[first + 1] + by_pole.re);
        for (j, e) in e.iter().enumerate() {
            let at = first + 4 + 2 * (l + j);
            re[at] += e;
            im[at + 1] += e;
        }
    }
}

/// The input of the direct term at a row.
fn felt(record: &Record, model: Model, t: usize) -> f64 {
    match model.feedthrough {
        Feedthrough::SameSample => record.input[t],
        Feedthrough::NextSample => record.input[t.saturating_sub(1)],
    }
}

/// Lower Cholesky factor of the innovations' covariance.
fn covariance_factor(innovations: &[Vec<f64>], outputs: &Outputs) -> Option<Mat<f64>> {
    let n = outputs.present.len() as f64;
    let l = innovations.len();
    let covariance = Mat::from_fn(l, l, |a, b| crate::projection::dot(&innovations[a], &innovations[b]) / n);
    if !(0..l).all(|i| covariance[(i, i)].is_finite() && covariance[(i, i)] > 0.0) {
        return None;
    }
    Some(covariance.llt(Side::Lower).ok()?.L().to_owned())
}

fn half_log_determinant(factor: &Mat<f64>, outputs: &Outputs) -> f64 {
    outputs.present.len() as f64 * (0..factor.nrows()).map(|i| libm::log(factor[(i, i)])).sum::<f64>()
}

/// Adds `Sᵀ Σ⁻¹ S` and `−Sᵀ Σ⁻¹ e` of one row, S whitened in place by `Σ = L Lᵀ`.
fn accumulate(factor: &Mat<f64>, rows: &[Vec<f64>], e: &[f64], gram: &mut [f64], score: &mut [f64]) {
    let p = score.len();
    let (mut white, mut errors): (Vec<Vec<f64>>, Vec<f64>) = (Vec::with_capacity(e.len()), Vec::with_capacity(e.len()));
    for i in 0..e.len() {
        let (mut row, mut error) = (rows[i].clone(), e[i]);
        for j in 0..i {
            row.iter_mut().zip(&white[j]).for_each(|(x, w)| *x -= factor[(i, j)] * w);
            error -= factor[(i, j)] * errors[j];
        }
        row.iter_mut().for_each(|x| *x /= factor[(i, i)]);
        white.push(row);
        errors.push(error / factor[(i, i)]);
    }
    for (row, error) in white.iter().zip(&errors) {
        for a in 0..p {
            score[a] -= row[a] * error;
            let factor = row[a];
            gram[a * p + a..(a + 1) * p].iter_mut().zip(&row[a..]).for_each(|(g, x)| *g += factor * x);
        }
    }
}
