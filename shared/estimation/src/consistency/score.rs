//! Score tests: does a column that the model lacks explain its residuals?
//!
//! With residuals `r` of unit noise and columns `c`, both with the model's columns projected out,
//! `g = cᵀ r` is the score and `M = cᵀ c` its variance under the null.

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

/// Weight of lag `l` in Bartlett's window up to `lag`.
pub fn bartlett_weight(l: usize, lag: usize) -> f64 {
    1.0 - l as f64 / (lag + 1) as f64
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
}
