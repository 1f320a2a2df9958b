//! Mode shapes as features: the part of the plant's shape that is orthogonal to the measured one.
//!
//! A shape has no size and no phase of its own. With u the measured shape (complex, one component
//! per channel, length 1) and p the plant's, of length 1 and turned so that `uᴴ p` is real and
//! positive, the residual of least squares over one complex factor is the part of p across u:
//! `z = Qᴴ p`, Q (channels × channels − 1) an orthonormal basis of what is across u.
//! `|z|² = 1 − MAC`, z is zero for the same shape, and small changes of p move it in proportion.
//! Its real and imaginary parts are the features, two less than the numbers measured: the factor
//! has taken two.

use nalgebra::{Complex, DMatrix, DVector};

type Shape = DVector<Complex<f64>>;

/// Orthogonal complement of a measured shape.
#[derive(Clone, Debug)]
pub(super) struct Across {
    along: Shape,
    across: DMatrix<Complex<f64>>,
    /// Of each real feature.
    pub sigma: f64,
}

impl Across {
    /// `None` for a shape of less than two channels, or without size; `sigma` per component.
    pub fn new(measured: &[Complex<f64>], sigma: &[f64]) -> Option<Self> {
        let n = measured.len();
        let shape = Shape::from_row_slice(measured);
        let size = shape.norm();
        if n < 2 || !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let along = shape / Complex::new(size, 0.0);
        // Gram–Schmidt, twice for rounding, over the unit vectors but that of the largest
        // component, which u replaces
        let largest = (0..n).max_by(|a, b| along[*a].norm_sqr().total_cmp(&along[*b].norm_sqr()))?;
        let mut basis = vec![along.clone()];
        for k in (0..n).filter(|k| *k != largest) {
            let mut column = Shape::from_fn(n, |i, _| Complex::new(f64::from(u8::from(i == k)), 0.0));
            for _ in 0..2 {
                for other in &basis {
                    let part = other.dotc(&column);
                    column -= other * part;
                }
            }
            let length = column.norm();
            basis.push(column / Complex::new(length, 0.0));
        }
        let across = DMatrix::from_columns(&basis[1..]);
        // one number for all components: their mean square, in units of the shape's length
        let sigma = identification::statistics::rms(sigma) / size;
        Some(Self { along, across, sigma })
    }

    /// Real and imaginary parts of z, `2 (channels − 1)` of them.
    pub fn features(&self, plant: &[Complex<f64>]) -> Vec<f64> {
        let shape = Shape::from_row_slice(plant);
        let cross = self.along.dotc(&shape);
        let (size, phase) = (shape.norm(), cross.norm());
        if size.is_nan() || size == 0.0 {
            return vec![f64::NAN; 2 * self.across.ncols()];
        }
        // across altogether: no phase is better than another
        let turn = if phase > 0.0 { cross.conj() / Complex::new(phase, 0.0) } else { Complex::new(1.0, 0.0) };
        let z = self.across.adjoint() * shape * (turn / Complex::new(size, 0.0));
        z.iter().flat_map(|z| [z.re, z.im]).collect()
    }

    /// Modal assurance criterion with the plant's shape: 1 for the same, 0 for one across it.
    pub fn mac(&self, plant: &[Complex<f64>]) -> f64 {
        let shape = Shape::from_row_slice(plant);
        let size = shape.norm_squared();
        if size > 0.0 { self.along.dotc(&shape).norm_sqr() / size } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    fn random(draw: &mut Noise, n: usize) -> Vec<Complex<f64>> {
        (0..n).map(|_| Complex::new(draw.normal(), draw.normal())).collect()
    }

    #[test]
    fn the_features_of_a_shape_are_what_least_squares_over_one_factor_leaves_whatever_its_size_and_phase() {
        let mut draw = Noise::new(1);
        for n in 2..8 {
            let (measured, plant) = (random(&mut draw, n), random(&mut draw, n));
            let across = Across::new(&measured, &vec![0.1; n]).unwrap();
            let z = across.features(&plant);
            assert_eq!(z.len(), 2 * (n - 1));
            // independent: min over a of |u − a p|² for |u| = 1, from the normal equation a = pᴴu /
            // pᴴp
            let size: f64 = measured.iter().map(Complex::norm_sqr).sum();
            let dot: Complex<f64> = plant.iter().zip(&measured).map(|(p, u)| p.conj() * u).sum();
            let a = dot / plant.iter().map(Complex::norm_sqr).sum::<f64>();
            let left: f64 = plant.iter().zip(&measured).map(|(p, u)| (u - a * p).norm_sqr()).sum::<f64>() / size;
            assert!((z.iter().map(|z| z * z).sum::<f64>() - left).abs() < 1e-12); // rounding
            assert!((1.0 - across.mac(&plant) - left).abs() < 1e-12);
            let turned: Vec<Complex<f64>> = plant.iter().map(|p| p * Complex::new(-0.3, 2.0)).collect();
            assert!(across.features(&turned).iter().zip(&z).all(|(a, b)| (a - b).abs() < 1e-12));
            assert!(across.features(&measured).iter().all(|z| z.abs() < 1e-12));
        }
    }

    #[test]
    fn noise_on_the_components_leaves_features_of_the_stated_deviation() {
        let mut draw = Noise::new(2);
        let truth: Vec<Complex<f64>> = [1.0, 0.8, -0.5, 0.3].map(|x| Complex::new(x, 0.0)).into();
        let mut z = Vec::new();
        for _ in 0..200 {
            let noisy: Vec<Complex<f64>> =
                truth.iter().map(|x| x + Complex::new(0.01 * draw.normal(), 0.01 * draw.normal())).collect();
            let across = Across::new(&noisy, &[0.01; 4]).unwrap();
            z.extend(across.features(&truth).iter().map(|feature| feature / across.sigma));
        }
        // 1200 squares: standard deviation of their mean 0.04
        let square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
        assert!((square - 1.0).abs() < 0.17, "{square}");
    }
}
