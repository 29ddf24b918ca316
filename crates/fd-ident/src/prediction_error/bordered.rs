//! Linear least squares in which each block of rows has columns of its own beside those that all blocks share.

use faer::{Mat, MatRef};
use fd_numeric::dense::triangle;

/// The prediction errors and their slopes, block by block: rows of `[own | shared | ε]`.
#[derive(Clone, Debug)]
pub(super) struct Bordered {
    /// Columns of its own that each block has.
    pub own: usize,
    /// Columns that all blocks have.
    pub shared: usize,
    pub blocks: Vec<Mat<f64>>,
}

/// The same, each block compressed by QR with its columns scaled to length one.
///
/// The own columns of a block are orthogonal to all others, so that its QR eliminates them at once (Björck 1996,
/// section 6.3): the cost grows with the number of blocks, and not with its square.
pub(super) struct Compressed {
    of: Bordered,
    /// Column lengths: the shared ones, then the own ones of each block, as parameters are ordered.
    lengths: Vec<f64>,
}

/// What eliminating the own columns leaves.
struct Eliminated {
    /// The rows of each block that determine its own parameters.
    own: Vec<Mat<f64>>,
    /// The rows of all blocks that say something of the shared ones: `[shared | ε]`.
    shared: Mat<f64>,
}

impl Compressed {
    pub(super) fn new(of: Bordered) -> Self {
        let Bordered { own, shared, blocks } = of;
        let squares = |block: &Mat<f64>, j: usize| block.col(j).squared_norm_l2();
        let length = |square: f64| if square > 0.0 { square.sqrt() } else { 1.0 };
        let of_shared = (own..own + shared).map(|j| blocks.iter().map(|b| squares(b, j)).sum());
        let of_own = blocks.iter().flat_map(|block| (0..own).map(|j| squares(block, j)));
        let lengths: Vec<f64> = of_shared.chain(of_own).map(length).collect();
        let compressed = blocks.into_iter().enumerate().map(|(i, mut block)| {
            for j in 0..own + shared {
                let scale = match j.checked_sub(own) {
                    None => lengths[shared + i * own + j],
                    Some(j) => lengths[j],
                };
                block.col_as_slice_mut(j).iter_mut().for_each(|entry| *entry /= scale);
            }
            triangle(block)
        });
        let blocks = compressed.collect();
        Self { of: Bordered { own, shared, blocks }, lengths }
    }

    /// Damping adds a row to each column.
    fn eliminate(&self, damping: f64) -> Eliminated {
        let (own, width) = (self.of.own, self.of.shared + 1);
        let damped = self.of.blocks.iter().map(|block| {
            if damping > 0.0 && own > 0 {
                triangle(with_rows(block, own, damping))
            } else {
                block.clone()
            }
        });
        let blocks: Vec<Mat<f64>> = damped.collect();
        let below = |block: &Mat<f64>| block.nrows().saturating_sub(own);
        let mut rest = Mat::zeros(blocks.iter().map(below).sum(), width);
        let mut at = 0;
        for block in &blocks {
            let rows = block.get(block.nrows() - below(block).., own..);
            rest.get_mut(at..at + rows.nrows(), ..).copy_from(rows);
            at += rows.nrows();
        }
        let rest = if damping > 0.0 { with_rows(&rest, self.of.shared, damping) } else { rest };
        Eliminated { own: blocks, shared: triangle(rest) }
    }

    /// By how much the linear problem lowers a cost, relative to it.
    pub(super) fn promise(&self, cost: f64) -> f64 {
        let Eliminated { own, shared } = self.eliminate(0.0);
        let last = |rows: &Mat<f64>, count: usize| -> f64 {
            let column = rows.ncols() - 1;
            (0..count.min(rows.nrows())).map(|i| rows[(i, column)].powi(2)).sum()
        };
        let of_own: f64 = own.iter().map(|block| last(block, self.of.own)).sum();
        (of_own + last(&shared, self.of.shared)) / cost
    }

    /// The step `s` that minimises `‖ε + J s‖² + λ ‖diag(J) s‖²`, the shared parameters first.
    pub(super) fn step(&self, damping: f64) -> Vec<f64> {
        let Eliminated { own, shared } = self.eliminate(damping);
        let n = self.of.shared;
        let target: Vec<f64> = (0..n).map(|i| -shared[(i, n)]).collect();
        let of_shared = back_substituted(shared.as_ref(), target);
        let mut step = of_shared.clone();
        for block in &own {
            let target = (0..self.of.own).map(|i| {
                let known: f64 = of_shared
                    .iter()
                    .enumerate()
                    .map(|(j, s)| block[(i, self.of.own + j)] * s)
                    .sum();
                -block[(i, self.of.own + n)] - known
            });
            step.extend(back_substituted(block.as_ref(), target.collect()));
        }
        step.iter().zip(&self.lengths).map(|(s, length)| s / length).collect()
    }

    /// Rows `[shared | ε]` with the normal equations of the shared parameters, the own ones eliminated.
    pub(super) fn shared_rows(&self) -> Mat<f64> {
        let rows = self.eliminate(0.0).shared;
        let n = self.of.shared;
        let scale = |j: usize| if j < n { self.lengths[j] } else { 1.0 };
        Mat::from_fn(rows.nrows(), n + 1, |i, j| rows[(i, j)] * scale(j))
    }
}

/// `√damping` in as many first columns, below.
fn with_rows(rows: &Mat<f64>, columns: usize, damping: f64) -> Mat<f64> {
    let n = rows.nrows();
    Mat::from_fn(n + columns, rows.ncols(), |i, j| match i.checked_sub(n) {
        None => rows[(i, j)],
        Some(i) if i == j => damping.sqrt(),
        Some(_) => 0.0,
    })
}

/// Solves the upper triangle of as many rows as the target has.
fn back_substituted(r: MatRef<'_, f64>, mut x: Vec<f64>) -> Vec<f64> {
    for i in (0..x.len()).rev() {
        let known: f64 = (i + 1..x.len()).map(|j| r[(i, j)] * x[j]).sum();
        x[i] = (x[i] - known) / r[(i, i)];
    }
    x
}
