//! Score tests: does a column that the model lacks explain its residuals?
//!
//! With residuals `r` of unit noise and columns `c`, both with the model's columns projected out,
//! `g = cᵀ r` is the score and `M = cᵀ c` its variance under the null. [`score_statistic`] relies
//! on that variance; [`long_run_score`] takes it from the products `c_t r_t` themselves, and so
//! holds for coloured residuals and unequal noise (Newey and West 1987).

/// Share by which the variance's diagonal is raised: columns that coincide share their amplitude
/// instead of failing.
const RIDGE: f64 = 1e-9;

/// `T = gᵀ M⁻¹ g`, χ² with k degrees of freedom when no column belongs in the model; `score`
/// becomes the amplitudes `M⁻¹ g`.
///
/// `score` is g (k), `variance` is M (k × k, row by row, symmetric); it becomes its Cholesky
/// factor. `None`: M is not positive definite. Cost: O(k³), no allocation.
pub fn score_statistic(score: &mut [f64], variance: &mut [f64]) -> Option<f64> {
    let k = score.len();
    assert!(variance.len() == k * k);
    (0..k).for_each(|i| variance[i * k + i] *= 1.0 + RIDGE);
    factor(variance, k)?;
    let mut statistic = 0.0;
    for i in 0..k {
        let known: f64 = (0..i).map(|j| variance[i * k + j] * score[j]).sum();
        score[i] = (score[i] - known) / variance[i * k + i];
        statistic += score[i] * score[i];
    }
    for i in (0..k).rev() {
        let known: f64 = (i + 1..k).map(|j| variance[j * k + i] * score[j]).sum();
        score[i] = (score[i] - known) / variance[i * k + i];
    }
    Some(statistic)
}

/// Lower Cholesky factor, in place.
fn factor(a: &mut [f64], k: usize) -> Option<()> {
    for i in 0..k {
        for j in 0..=i {
            let known: f64 = (0..j).map(|m| a[i * k + m] * a[j * k + m]).sum();
            let left = a[i * k + j] - known;
            a[i * k + j] = if i == j { libm::sqrt(left) } else { left / a[j * k + j] };
        }
        let positive = a[i * k + i] > 0.0; // false for NaN
        positive.then_some(())?;
    }
    Some(())
}

/// Score over the standard deviation that its own terms show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LongRunScore {
    /// Unit normal when no column belongs in the model.
    pub z: f64,
    /// Length of the window over lags.
    pub lag: usize,
}

/// Weight of lag `l` in Bartlett's window up to `lag`.
pub fn bartlett_weight(l: usize, lag: usize) -> f64 {
    1.0 - l as f64 / (lag + 1) as f64
}

/// `z = Σ s / √(Σ s² + 2 Σ w_l Σ s_t s_{t−l})` of the products `s_t = c_t r_t`; not centred, for
/// their mean is zero under the null.
///
/// No amplitude reaches more than `√(n / (lag + 1))`. Cost: O(n) and as many lags as the products
/// go on; no allocation.
pub fn long_run_score(products: &[f64]) -> LongRunScore {
    let lag = window(products);
    let own: f64 = products.iter().map(|s| s * s).sum();
    // below that where products alternate: such a window tells little
    let variance = long_run_sum(products, lag).max(0.25 * own);
    let z = if variance > 0.0 { products.iter().sum::<f64>() / libm::sqrt(variance) } else { 0.0 };
    LongRunScore { z, lag }
}

/// `Σ s² + 2 Σ w_l Σ s_t s_{t−l}` in Bartlett's window: the mean square of all sums of `lag + 1`
/// neighbours, zero beyond the ends.
fn long_run_sum(s: &[f64], lag: usize) -> f64 {
    let width = lag + 1;
    let (mut total, mut sum) = (0.0, 0.0);
    for t in 0..s.len() + lag {
        sum += s.get(t).unwrap_or(&0.0);
        sum -= t.checked_sub(width).map_or(0.0, |left| s[left]);
        total += sum * sum;
    }
    total / width as f64
}

/// Newey and West's rule, longer where the products themselves go on.
fn window(s: &[f64]) -> usize {
    let n = s.len();
    let rule = 4.0 * libm::pow(n as f64 / 100.0, 2.0 / 9.0);
    let mean = s.iter().sum::<f64>() / n as f64;
    let own: f64 = s.iter().map(|x| (x - mean) * (x - mean)).sum();
    let rho = |l: usize| -> f64 {
        let cross = product(&s[l..], s, mean);
        if own > 0.0 { cross / own } else { 0.0 }
    };
    let significant = 2.0 / libm::sqrt(n as f64);
    let mut reach = 0;
    while reach < n / 20 && rho(reach + 1) > significant {
        reach += 1;
    }
    (rule as usize).max(3 * reach).min(n / 10).max(1)
}

/// Sums that are taken side by side: each alone waits for its own last.
const LANES: usize = 8;

/// `Σ (a − mean) (b − mean)` over the shorter.
fn product(a: &[f64], b: &[f64], mean: f64) -> f64 {
    let (a, b) = (a.chunks_exact(LANES), b[..a.len().min(b.len())].chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| (a - mean) * (b - mean)).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += (a - mean) * (b - mean);
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn the_statistic_and_its_amplitudes_are_those_of_a_solved_system() {
        let mut noise = SeededNoise::new(3);
        for _ in 0..50 {
            let root = Matrix3::from_fn(|_, _| noise.normal());
            let (m, g) = (root * root.transpose() + Matrix3::identity(), Vector3::from_fn(|_, _| noise.normal()));
            let mut amplitude: [f64; 3] = g.into();
            let mut variance: [f64; 9] = core::array::from_fn(|i| m[(i / 3, i % 3)]);
            let statistic = score_statistic(&mut amplitude, &mut variance).expect("positive definite");
            let solved = m.lu().solve(&g).expect("regular");
            // the ridge moves the solution by 1e-9 of it times the condition number, at most 100
            // here
            assert!((Vector3::from(amplitude) - solved).norm() < 2e-7 * solved.norm());
            assert!((statistic / g.dot(&solved) - 1.0).abs() < 2e-7);
        }
    }

    #[test]
    fn columns_that_coincide_share_the_amplitude_and_an_indefinite_variance_is_refused() {
        let mut amplitude = [2.0, 2.0];
        assert!((score_statistic(&mut amplitude, &mut [4.0; 4]).expect("ridge") - 1.0).abs() < 1e-6); // g²/M
        assert!((amplitude[0] + amplitude[1] - 0.5).abs() < 1e-6, "{amplitude:?}"); // g/M
        assert_eq!(score_statistic(&mut [1.0, 1.0], &mut [1.0, 2.0, 2.0, 1.0]), None);
        assert_eq!(score_statistic(&mut [1.0], &mut [f64::NAN]), None);
    }

    #[test]
    fn a_long_run_score_is_unit_normal_for_white_and_for_coloured_products() {
        // (memory, band of the mean square over 400 series: four sigmas are 0.28; Bartlett's window
        // is short by up to a quarter at this memory)
        for (memory, low, high) in [(0.0, 0.75, 1.3), (0.7, 0.75, 1.6)] {
            let (mut noise, mut square) = (SeededNoise::new(11), 0.0);
            for _ in 0..400 {
                let mut state = 0.0;
                let s: [f64; 1000] = core::array::from_fn(|_| {
                    state = memory * state + noise.normal();
                    state
                });
                let score = long_run_score(&s);
                square += score.z * score.z / 400.0;
            }
            // believed white, the coloured one would have (1 + 0.7)/(1 − 0.7) = 5.7
            assert!((low..high).contains(&square), "memory {memory}: {square}");
        }
    }

    #[test]
    fn sums_of_neighbours_are_the_weighted_lags() {
        let mut noise = SeededNoise::new(5);
        let s: [f64; 60] = core::array::from_fn(|_| noise.normal());
        for lag in [0, 1, 7, 59] {
            let at = |l: usize| s[l..].iter().zip(&s).map(|(later, earlier)| later * earlier).sum::<f64>();
            let lags: f64 = at(0) + (1..=lag).map(|l| 2.0 * bartlett_weight(l, lag) * at(l)).sum::<f64>();
            assert!((long_run_sum(&s, lag) - lags).abs() < 1e-11, "{lag}");
        }
    }

    #[test]
    fn no_amplitude_of_a_brief_effect_passes_the_ceiling() {
        let mut s = [0.0; 1000];
        s[500..520].fill(1e6);
        let score = long_run_score(&s);
        assert!(score.z <= libm::sqrt(1000.0 / (score.lag + 1) as f64) && score.z > 0.0, "{score:?}");
    }
}
