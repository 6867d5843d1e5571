//! Symmetric linear systems of a few hundred unknowns.
//!
//! Purpose: the normal equations of all cameras at once. Source: Cholesky's factorization (G. H. Golub and C. F. Van Loan, *Matrix
//! Computations*, 4.2). A crate for linear algebra would take longer to compile than everything that is solved here takes to run,
//! and the order of its sums would depend on the machine.

/// A symmetric matrix, row-major, with a right-hand side. Its lower triangle counts.
#[derive(Clone)]
pub(crate) struct NormalEquations {
    size: usize,
    matrix: Vec<f64>,
    pub(crate) right: Vec<f64>,
}

impl NormalEquations {
    /// Nothing known of `size` unknowns.
    pub(crate) fn new(size: usize) -> Self {
        Self { size, matrix: vec![0.0; size * size], right: vec![0.0; size] }
    }

    /// Unknowns.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// Adds to an entry, and with it to its mirror image.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        let (row, column) = (row.max(column), row.min(column));
        self.matrix[row * self.size + column] += value;
    }

    /// Adds a measurement with this weight: by how much the first of two unknowns exceeds the second.
    pub(crate) fn add_difference(&mut self, [a, b]: [usize; 2], difference: f64, weight: f64) {
        self.add(a, a, weight);
        self.add(b, b, weight);
        self.add(a, b, -weight);
        self.right[a] += weight * difference;
        self.right[b] -= weight * difference;
    }

    /// The factor, or `None` where the matrix is not positive definite.
    pub(crate) fn factor(&self) -> Option<Factor> {
        let n = self.size;
        let mut lower = self.matrix.clone();
        for row in 0..n {
            let (above, current) = lower.split_at_mut(row * n);
            let current = &mut current[..=row];
            for column in 0..row {
                let other = &above[column * n..][..=column];
                let known = dot(&current[..column], &other[..column]);
                current[column] = (current[column] - known) / other[column];
            }
            let rest = current[row] - dot(&current[..row], &current[..row]);
            if !(rest > 0.0 && rest.is_finite()) {
                return None;
            }
            current[row] = rest.sqrt();
        }
        Some(Factor { size: n, lower })
    }
}

/// `L` of `L·Lᵀ`, row-major.
pub(crate) struct Factor {
    size: usize,
    lower: Vec<f64>,
}

impl Factor {
    /// The unknowns for a right-hand side.
    pub(crate) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut x = right.to_vec();
        for row in 0..n {
            let factors = &self.lower[row * n..][..=row];
            x[row] = (x[row] - dot(&factors[..row], &x[..row])) / factors[row];
        }
        for row in (0..n).rev() {
            let factors = &self.lower[row * n..][..=row];
            x[row] /= factors[row];
            let known = x[row];
            for (value, factor) in x[..row].iter_mut().zip(factors) {
                *value -= factor * known;
            }
        }
        x
    }

    /// The column of the inverse that belongs to one unknown.
    pub(crate) fn inverse_column(&self, unknown: usize) -> Vec<f64> {
        let mut unit = vec![0.0; self.size];
        unit[unknown] = 1.0;
        self.solve(&unit)
    }

    /// The block of the inverse that belongs to the unknowns from `start` on, `N` of them.
    pub(crate) fn inverse_block<const N: usize>(&self, start: usize) -> [[f64; N]; N] {
        let mut block = [[0.0; N]; N];
        for (column, values) in block.iter_mut().enumerate() {
            values.copy_from_slice(&self.inverse_column(start + column)[start..start + N]);
        }
        block
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Eigenvalues of a symmetric matrix with their unit vectors, by Jacobi's rotations.
pub(crate) fn eigen<const N: usize>(mut matrix: [[f64; N]; N]) -> [(f64, [f64; N]); N] {
    const SWEEPS: usize = 30;
    let mut vectors: [[f64; N]; N] =
        std::array::from_fn(|row| std::array::from_fn(|column| f64::from(u8::from(row == column))));
    for _ in 0..SWEEPS {
        for p in 0..N {
            for q in p + 1..N {
                if matrix[p][q] == 0.0 {
                    continue;
                }
                let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
                let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = tangent * cosine;
                for k in 0..N {
                    let (a, b) = (matrix[k][p], matrix[k][q]);
                    (matrix[k][p], matrix[k][q]) = (cosine * a - sine * b, sine * a + cosine * b);
                }
                for k in 0..N {
                    let (a, b) = (matrix[p][k], matrix[q][k]);
                    (matrix[p][k], matrix[q][k]) = (cosine * a - sine * b, sine * a + cosine * b);
                    let (a, b) = (vectors[p][k], vectors[q][k]);
                    (vectors[p][k], vectors[q][k]) = (cosine * a - sine * b, sine * a + cosine * b);
                }
            }
        }
    }
    std::array::from_fn(|index| (matrix[index][index], vectors[index]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_solved_and_an_indefinite_one_refused() {
        let mut equations = NormalEquations::new(3);
        for (row, column, value) in
            [(0, 0, 4.0), (1, 0, 2.0), (1, 1, 5.0), (2, 0, 1.0), (2, 1, 3.0), (2, 2, 6.0)]
        {
            equations.add(row, column, value);
        }
        let factor = equations.factor().unwrap();
        let x = factor.solve(&[7.0, 10.0, 10.0]);
        for (value, expected) in x.iter().zip([1.0, 1.0, 1.0]) {
            assert!((value - expected).abs() < 1e-12, "{x:?}");
        }
        let inverse = factor.inverse_block::<2>(0);
        let unit: f64 = 4.0 * inverse[0][0] + 2.0 * inverse[0][1] + factor.solve(&[1.0, 0.0, 0.0])[2];
        assert!((unit - 1.0).abs() < 1e-12);
        equations.add(2, 2, -6.0);
        assert!(equations.factor().is_none());
    }

    #[test]
    fn eigenvectors_are_stretched_by_their_eigenvalues() {
        let matrix = [[2.0, 1.0, 0.5], [1.0, 3.0, -0.25], [0.5, -0.25, 1.0]];
        for (value, vector) in eigen(matrix) {
            for row in 0..3 {
                let stretched: f64 = (0..3).map(|k| matrix[row][k] * vector[k]).sum();
                assert!((stretched - value * vector[row]).abs() < 1e-12);
            }
        }
    }
}
