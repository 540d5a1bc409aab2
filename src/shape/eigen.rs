//! Eigenvectors of a symmetric 3×3 matrix in f64 (parry's come in f32 only).

use glam::{DMat3, DVec3};

/// Eigenvalues in ascending order and their orthonormal eigenvectors, by cyclic Jacobi rotations (Golub and Van Loan,
/// *Matrix Computations*, §8.5): as accurate for equal eigenvalues as for distinct ones.
pub(super) fn symmetric_eigen(matrix: DMat3) -> [(f64, DVec3); 3] {
    let mut a = matrix;
    let mut vectors = DMat3::IDENTITY;
    // Convergence is quadratic: six sweeps reach the last bit from anywhere.
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a.col(q)[p];
            if off == 0.0 || !off.is_finite() {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * off);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = (t * t + 1.0).sqrt().recip();
            let s = t * c;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = c;
            turn.col_mut(q)[q] = c;
            turn.col_mut(q)[p] = s;
            turn.col_mut(p)[q] = -s;
            a = turn.transpose() * a * turn;
            vectors *= turn;
        }
    }
    let mut pairs = [0, 1, 2].map(|i| (a.col(i)[i], vectors.col(i)));
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagonalizes() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.9);
        for values in
            [DVec3::new(1.0, 2.0, 5.0), DVec3::new(2.0, 2.0, 7.0), DVec3::splat(3.0), DVec3::new(0.0, 0.0, 1.0)]
        {
            let matrix = turn * DMat3::from_diagonal(values) * turn.transpose();
            for (i, (value, vector)) in symmetric_eigen(matrix).into_iter().enumerate() {
                // Rounding of a handful of f64 products.
                assert!((value - values[i]).abs() < 1e-12, "{values}: {value}");
                assert!((matrix * vector - value * vector).length() < 1e-12 && (vector.length() - 1.0).abs() < 1e-12);
            }
        }
    }
}
