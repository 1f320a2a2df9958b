//! Orthogonal projection of columns: the linear half of every fit.

/// A column that keeps less than this part of its length beside the columns before it is dependent
/// on them.
const DEPENDENT: f64 = 1e-11;

/// Scalar product with eight partial sums, so that it runs as vectors.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let mut sums = [0.0; 8];
    let (a_8, b_8) = (a.chunks_exact(8), b.chunks_exact(8));
    let mut sum: f64 = a_8.remainder().iter().zip(b_8.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_8.zip(b_8) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().for_each(|part| sum += part);
    sum
}

/// `y ← y + factor · x`.
pub(crate) fn add(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// `Φ = Q R` without dependent columns (their coefficients are zero).
pub(crate) struct Basis {
    rows: usize,
    count: usize,
    /// Orthonormal columns; a dependent one is zero.
    q: Vec<f64>,
    /// Upper triangle, `r[j · count + k]`, j ≤ k.
    r: Vec<f64>,
}

impl Basis {
    /// Modified Gram–Schmidt, twice. Cost: 4 · rows · count² multiply-adds.
    pub fn new(columns: Vec<f64>, rows: usize) -> Self {
        let count = columns.len() / rows;
        let mut basis = Self { rows, count, q: columns, r: vec![0.0; count * count] };
        for k in 0..count {
            let (done, rest) = basis.q.split_at_mut(k * rows);
            let column = &mut rest[..rows];
            let before = dot(column, column).sqrt();
            for _ in 0..2 {
                for (j, q) in done.chunks_exact(rows).enumerate() {
                    let along = dot(q, column);
                    add(column, -along, q);
                    basis.r[j * count + k] += along;
                }
            }
            let length = dot(column, column).sqrt();
            if length > DEPENDENT * before {
                column.iter_mut().for_each(|x| *x /= length);
                basis.r[k * count + k] = length;
            } else {
                column.fill(0.0);
            }
        }
        basis
    }

    /// Number of independent columns.
    pub fn rank(&self) -> usize {
        (0..self.count).filter(|k| self.r[k * self.count + k] > 0.0).count()
    }

    /// Takes the part along the basis out of `column` and gives it, `Qᵀ column`.
    pub fn project_out(&self, column: &mut [f64]) -> Vec<f64> {
        let mut parts = Vec::with_capacity(self.count);
        for q in self.q.chunks_exact(self.rows) {
            let along = dot(q, column);
            add(column, -along, q);
            parts.push(along);
        }
        parts
    }

    /// `Qᵀ column`.
    pub fn along(&self, column: &[f64]) -> Vec<f64> {
        self.q.chunks_exact(self.rows).map(|q| dot(q, column)).collect()
    }

    /// Share of every row that the columns take up: the diagonal of `Q Qᵀ`.
    pub fn leverage(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.rows];
        for q in self.q.chunks_exact(self.rows) {
            sums.iter_mut().zip(q).for_each(|(sum, q)| *sum += q * q);
        }
        sums
    }

    /// Coefficients `R⁻¹ parts` of the columns.
    pub fn coefficients(&self, mut parts: Vec<f64>) -> Vec<f64> {
        for k in (0..self.count).rev() {
            let pivot = self.r[k * self.count + k];
            parts[k] = if pivot > 0.0 { parts[k] / pivot } else { 0.0 };
            for j in 0..k {
                parts[j] -= parts[k] * self.r[j * self.count + k];
            }
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_repeated_changes_neither_projection_nor_fit() {
        let column = |phase: f64| (0..37).map(|n| libm::sin(0.3 * f64::from(n) + phase)).collect::<Vec<f64>>();
        let (a, b) = (column(0.0), column(1.0));
        let basis = Basis::new([a.clone(), b.clone(), a.clone()].concat(), 37);
        assert_eq!(basis.rank(), 2);
        let mut y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
        let parts = basis.project_out(&mut y);
        assert!(dot(&y, &y) < 1e-24); // rounding of numbers near one
        let found = basis.coefficients(parts);
        assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] + 3.0).abs() < 1e-12 && found[2] == 0.0, "{found:?}");
    }
}
