//! Sylvester equations by Schur forms.

use faer::{Mat, MatRef};

use crate::{error::ModelError, linalg::schur::RealSchur};

/// Solves `A X + X B = C` for Schur forms of `A` and `B`.
///
/// R. H. Bartels and G. W. Stewart, "Solution of the matrix equation AX + XB = C", Comm. ACM
/// 15(9), 1972.
///
/// # Errors
///
/// Returns an error when an eigenvalue of `A` is to rounding the negative of one of `B`.
pub(crate) fn sylvester(
    a: &RealSchur,
    b: &RealSchur,
    c: MatRef<'_, f64>,
) -> Result<Mat<f64>, ModelError> {
    let mut y = a.q.transpose() * c * &b.q;
    let (rows, cols) = (a.blocks(), b.blocks());
    let smallest_pivot = f64::EPSILON * a.t.norm_max().max(b.t.norm_max());
    for &(j, width) in &cols {
        // Columns j… of Y, once those before are known: T Y_j + Y_j S_jj = F_j − Σ Y_k S_kj.
        let known = y.subcols(0, j) * b.t.submatrix(0, j, j, width);
        for k in 0..width {
            for i in 0..y.nrows() {
                y[(i, j + k)] -= known[(i, k)];
            }
        }
        for &(i, height) in rows.iter().rev() {
            let mut block = Block::new(a, (i, height), b, (j, width));
            for (position, (row, col)) in block.entries().enumerate() {
                block.right[position] = y[(i + row, j + col)];
            }
            let solution = block.solve(smallest_pivot)?;
            for (position, (row, col)) in block.entries().enumerate() {
                let value = solution[position];
                y[(i + row, j + col)] = value;
                // What this entry means for the rows above.
                for above in 0..i {
                    y[(above, j + col)] -= a.t[(above, i + row)] * value;
                }
            }
        }
    }
    Ok(&a.q * y * b.q.transpose())
}

/// Equations of one block of at most 2×2 unknowns, numbered column by column.
struct Block {
    height: usize,
    size: usize,
    left: [[f64; 4]; 4],
    right: [f64; 4],
}

impl Block {
    fn new(
        a: &RealSchur,
        (i, height): (usize, usize),
        b: &RealSchur,
        (j, width): (usize, usize),
    ) -> Self {
        let mut block = Self { height, size: height * width, left: [[0.0; 4]; 4], right: [0.0; 4] };
        for (equation, (row, col)) in block.entries().enumerate() {
            for (unknown, (r, c)) in block.entries().enumerate() {
                let from_a = if c == col { a.t[(i + row, i + r)] } else { 0.0 };
                let from_b = if r == row { b.t[(j + c, j + col)] } else { 0.0 };
                block.left[equation][unknown] = from_a + from_b;
            }
        }
        block
    }

    /// Row and column of each unknown within the block.
    fn entries(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let height = self.height;
        (0..self.size).map(move |position| (position % height, position / height))
    }

    /// Gaussian elimination with row pivoting.
    fn solve(&self, smallest_pivot: f64) -> Result<[f64; 4], ModelError> {
        let (n, mut left, mut x) = (self.size, self.left, self.right);
        for k in 0..n {
            let pivot =
                (k..n).fold(
                    k,
                    |best, row| {
                        if left[best][k].abs() < left[row][k].abs() { row } else { best }
                    },
                );
            left.swap(k, pivot);
            x.swap(k, pivot);
            if left[k][k].abs() <= smallest_pivot {
                return Err(ModelError::Singular { role: "the Sylvester operator X ↦ AX + XB" });
            }
            for row in k + 1..n {
                let factor = left[row][k] / left[k][k];
                let pivot_row = left[k];
                for (entry, pivot) in left[row].iter_mut().zip(pivot_row) {
                    *entry -= factor * pivot;
                }
                x[row] -= factor * x[k];
            }
        }
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|col| left[k][col] * x[col]).sum();
            x[k] = (x[k] - known) / left[k][k];
        }
        Ok(x)
    }
}
