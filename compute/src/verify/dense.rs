//! The discrete radiosity equation solved as what it is: a dense system of linear equations.
//!
//! # Theory
//! (I - rho F) B = E, one system a channel, since reflectances differ. Gaussian elimination needs no
//! pivoting: the rows of F sum to at most 1 and reflectances are below 1, so the matrix is
//! strictly diagonally dominant (Golub and Van Loan, "Matrix Computations", section 4.1).
//!
//! Shooting takes what patch i receives from patch j from j's own row, F_ij = F_ji A_j / A_i, which
//! is the same where the rows are reciprocal and only there; so it has a system of its own. It is
//! dominant by columns instead.

/// Solves `matrix` x = `right` by Gaussian elimination without pivoting. `matrix` has one row per
/// unknown and is diagonally dominant by rows or by columns.
pub fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        let (done, below) = matrix.split_at_mut(k + 1);
        let pivot_row = &done[k];
        for (offset, row) in below.iter_mut().enumerate() {
            let factor = row[k] / pivot_row[k];
            if factor != 0.0 {
                for (value, pivot) in row[k..].iter_mut().zip(&pivot_row[k..]) {
                    *value -= factor * pivot;
                }
                right[k + 1 + offset] -= factor * right[k];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::solve;

    #[test]
    fn the_solution_solves_the_equations() {
        let n = 20;
        let matrix: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| {
                        let off = ((i * 7 + j * 13) % 11) as f64 / 11.0 / n as f64;
                        if i == j { 1.0 } else { -off }
                    })
                    .collect()
            })
            .collect();
        let right: Vec<f64> = (0..n).map(|i| (i % 3) as f64).collect();
        let solution = solve(matrix.clone(), right.clone());
        for (row, b) in matrix.iter().zip(right) {
            let product: f64 = row.iter().zip(&solution).map(|(a, x)| a * x).sum();
            assert!((product - b).abs() < 1e-12);
        }
    }
}
