//! Normal equations in the form of an arrow: shared unknowns, and blocks that touch only them.

use fd_numeric::wide::dots;

use super::{cholesky::Cholesky, columns::Columns, layout::Layout};

/// `H = JᵀJ + P` and `g = Jᵀr + P(z − m)`, block by block.
///
/// Normal equations square the condition of `J`; the prior of the nuisances bounds it, and
/// unknowns are scaled by what is known of them.
#[derive(Clone, Debug)]
pub(crate) struct Arrow {
    shared: usize,
    own: usize,
    segments: usize,
    /// Shared block, row by row.
    corner: Vec<f64>,
    /// Own blocks, one after the other.
    blocks: Vec<f64>,
    /// Own rows, shared columns, one after the other.
    arms: Vec<f64>,
    pub gradient: Vec<f64>,
}

impl Arrow {
    /// `JᵀJ` and `Jᵀr`.
    pub(crate) fn of_slopes(layout: &Layout, slopes: &Columns, r: &[f64]) -> Self {
        let (ns, no, segments) = (layout.shared, layout.own, layout.segments.len());
        let mut arrow = Self {
            shared: ns,
            own: no,
            segments,
            corner: vec![0.0; ns * ns],
            blocks: vec![0.0; segments * no * no],
            arms: vec![0.0; segments * no * ns],
            gradient: vec![0.0; layout.unknowns()],
        };
        let known = slopes.known();
        for (s, rows) in layout.segments.iter().enumerate() {
            let columns: Vec<&[f64]> = slopes.iter().map(|slope| &slope[rows.clone()]).collect();
            for (i, slope) in columns.iter().enumerate().take(ns + no) {
                let place = if i < ns { i } else { layout.first_own(s) + i - ns };
                // What nobody has multiplied yet, and the residuals, in one pass over this slope.
                let is_new = |j: &usize| known[i].and(known[*j]).is_none();
                let new = (0..=i).filter(is_new).map(|j| columns[j]);
                let others: Vec<&[f64]> = new.chain([&r[rows.clone()]]).collect();
                let mut products = dots(slope, &others);
                arrow.gradient[place] += products.pop().unwrap_or(0.0);
                let mut new = products.into_iter();
                for j in 0..=i {
                    let product = match (known[i], known[j]) {
                        (Some(i), Some(j)) => slopes.product(s, i, j),
                        _ => new.next().unwrap_or(0.0),
                    };
                    if i < ns {
                        arrow.corner[i * ns + j] += product;
                    } else if j < ns {
                        arrow.arms[(s * no + i - ns) * ns + j] = product;
                    } else {
                        arrow.blocks[(s * no + i - ns) * no + j - ns] = product;
                    }
                }
            }
        }
        arrow
    }

    /// Residuals and slopes multiplied by `weight`, and the prior at `z` added.
    pub(crate) fn with_prior(mut self, prior: &[[f64; 2]], z: &[f64], weight: f64) -> Self {
        let parts = [&mut self.corner, &mut self.blocks, &mut self.arms, &mut self.gradient];
        parts.into_iter().flatten().for_each(|value| *value *= weight * weight);
        for (i, [mean, precision]) in prior.iter().enumerate() {
            *self.diagonal_mut(i) += precision;
            self.gradient[i] += precision * (z[i] - mean);
        }
        self
    }

    /// A diagonal entry of `H`.
    pub(crate) fn diagonal_mut(&mut self, i: usize) -> &mut f64 {
        if i < self.shared {
            &mut self.corner[i * self.shared + i]
        } else {
            let k = i - self.shared;
            &mut self.blocks[k * self.own + k % self.own]
        }
    }

    pub(crate) fn diagonal(&self, i: usize) -> f64 {
        if i < self.shared {
            self.corner[i * self.shared + i]
        } else {
            let k = i - self.shared;
            self.blocks[k * self.own + k % self.own]
        }
    }

    /// An entry of the lower triangle of `H`.
    pub(crate) fn entry(&self, i: usize, j: usize) -> f64 {
        let (ns, no) = (self.shared, self.own);
        match (i.checked_sub(ns), j.checked_sub(ns)) {
            (None, _) => self.corner[i * ns + j],
            (Some(k), None) => self.arms[k * ns + j],
            (Some(k), Some(l)) if k / no == l / no => self.blocks[k * no + l % no],
            _ => 0.0,
        }
    }

    /// Takes an unknown out: its row and column become those of the unit matrix.
    pub(crate) fn fix(&mut self, i: usize) {
        self.gradient[i] = 0.0;
        let (ns, no) = (self.shared, self.own);
        if i < ns {
            for j in 0..ns {
                self.corner[i * ns + j] = 0.0;
                self.corner[j * ns + i] = 0.0;
            }
            self.arms.iter_mut().skip(i).step_by(ns).for_each(|v| *v = 0.0);
        } else {
            let k = i - ns;
            let first = k / no * no;
            for j in 0..no {
                self.blocks[k * no + j] = 0.0;
                self.blocks[(first + j) * no + k % no] = 0.0;
            }
            self.arms[k * ns..(k + 1) * ns].fill(0.0);
        }
        *self.diagonal_mut(i) = 1.0;
    }

    /// Takes out the unknowns that no residual depends on and nothing is known of, and says which these are.
    pub(crate) fn fix_idle(&mut self) -> Vec<bool> {
        let unknowns = 0..self.gradient.len();
        let idle: Vec<bool> = unknowns.map(|i| self.diagonal(i) <= 0.0).collect();
        (0..idle.len()).filter(|i| idle[*i]).for_each(|i| self.fix(i));
        idle
    }

    /// Factors `H`, block by block; `None` when it is not positive definite.
    pub(crate) fn factor(&self) -> Option<Factor> {
        let (ns, no) = (self.shared, self.own);
        let mut corner = self.corner.clone();
        let mut blocks = Vec::with_capacity(self.segments);
        // Columns of L⁻¹ arm, one after the other.
        let mut arms = vec![0.0; self.segments * no * ns];
        for s in 0..self.segments {
            let block = Cholesky::new(&self.blocks[s * no * no..(s + 1) * no * no], no)?;
            for j in 0..ns {
                let column = &mut arms[(s * ns + j) * no..(s * ns + j + 1) * no];
                for (i, value) in column.iter_mut().enumerate() {
                    *value = self.arms[(s * no + i) * ns + j];
                }
                block.forward(column);
            }
            let column = |j: usize| &arms[(s * ns + j) * no..(s * ns + j + 1) * no];
            for i in 0..ns {
                for j in 0..=i {
                    corner[i * ns + j] -= fd_numeric::dot(column(i), column(j));
                }
            }
            blocks.push(block);
        }
        let corner = Cholesky::new(&corner, ns)?;
        Some(Factor { shared: ns, own: no, corner, blocks, arms })
    }
}

/// The factored `H = L Lᵀ`, own unknowns first.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    shared: usize,
    own: usize,
    corner: Cholesky,
    blocks: Vec<Cholesky>,
    arms: Vec<f64>,
}

impl Factor {
    fn arm(&self, s: usize, j: usize) -> &[f64] {
        let first = (s * self.shared + j) * self.own;
        &self.arms[first..first + self.own]
    }

    /// `b ← L⁻¹ b`, in the order of the unknowns.
    pub(crate) fn forward(&self, b: &mut [f64]) {
        let (shared, own) = b.split_at_mut(self.shared);
        for (s, block) in self.blocks.iter().enumerate() {
            let part = &mut own[s * self.own..(s + 1) * self.own];
            block.forward(part);
            for (j, value) in shared.iter_mut().enumerate() {
                *value -= fd_numeric::dot(self.arm(s, j), part);
            }
        }
        self.corner.forward(shared);
    }

    /// `b ← H⁻¹ b`.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        self.forward(b);
        let (shared, own) = b.split_at_mut(self.shared);
        self.corner.backward(shared);
        for (s, block) in self.blocks.iter().enumerate() {
            let part = &mut own[s * self.own..(s + 1) * self.own];
            for (j, value) in shared.iter().enumerate() {
                part.iter_mut().zip(self.arm(s, j)).for_each(|(b, a)| *b -= a * value);
            }
            block.backward(part);
        }
    }

    /// `ln det H`.
    pub(crate) fn log_determinant(&self) -> f64 {
        let blocks = self.blocks.iter().map(Cholesky::log_determinant).sum::<f64>();
        blocks + self.corner.log_determinant()
    }

    /// Variance of a shared unknown, the diagonal entry of `H⁻¹`.
    pub(crate) fn variance(&self, i: usize) -> f64 {
        let mut unit = vec![0.0; self.shared];
        unit[i] = 1.0;
        self.corner.forward(&mut unit);
        unit.iter().map(|v| v * v).sum()
    }
}
