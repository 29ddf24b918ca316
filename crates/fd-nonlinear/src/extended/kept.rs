//! Slopes of the state equations that are kept from sample to sample and renewed in turns.

use fd_core::StateVisitor;

use super::slopes::{STEP, slope};
use crate::{gaussian::Estimate, model::StateEquations};

/// `F = ∂f/∂x`, of which each sample renews some columns by central differences along the states.
#[derive(Clone, Debug)]
pub(super) struct KeptSlopes {
    /// Number of states.
    nx: usize,
    /// Samples in which every column has had its turn.
    samples: usize,
    /// Row by row.
    slopes: Vec<f64>,
    /// The column whose turn is next.
    next: usize,
    /// Whether every column has had a turn since the estimate began.
    is_known: bool,
}

impl KeptSlopes {
    pub(super) fn new(nx: usize, samples: usize) -> Self {
        Self { nx, samples, slopes: vec![0.0; nx * nx], next: 0, is_known: false }
    }

    /// Forgets all slopes: the next sample has them all.
    pub(super) fn forget(&mut self) {
        self.slopes.fill(0.0);
        (self.next, self.is_known) = (0, false);
    }

    /// Renews the columns whose turn it is at an estimate, and writes `F S`.
    pub(super) fn along_the_factor(
        &mut self,
        equations: &mut dyn StateEquations,
        (estimate, inputs): (&Estimate, [&[f64]; 2]),
        (asked, ends): (&mut [f64], &mut [Vec<f64>; 2]),
        to: &mut [f64],
    ) {
        let (nx, (sample, _)) = (self.nx, estimate.at());
        let turns = if self.is_known { nx.div_ceil(self.samples) } else { nx };
        for _ in 0..turns {
            let column = self.next;
            self.next = (column + 1) % nx.max(1);
            let row = &estimate.s[column * nx..(column + 1) * nx];
            let spread = fd_numeric::dot(row, row).sqrt();
            let step = STEP * estimate.x[column].abs().max(spread);
            let step = (step > 0.0).then_some(step);
            if let Some(step) = step {
                for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
                    asked.copy_from_slice(&estimate.x);
                    asked[column] += sign * step;
                    let [before, u] = inputs;
                    equations.advance(sample - 1, asked, before, u, &mut end[..nx]);
                }
            }
            for i in 0..nx {
                self.slopes[i * nx + column] = slope(ends, i, step);
            }
        }
        self.is_known = true;
        for (to, row) in to.chunks_exact_mut(nx.max(1)).zip(self.slopes.chunks_exact(nx.max(1))) {
            to.fill(0.0);
            // The factor is lower triangular: row `k` ends at its diagonal.
            for (k, (slope, factor)) in row.iter().zip(estimate.s.chunks_exact(nx)).enumerate() {
                to.iter_mut().zip(&factor[..=k]).for_each(|(to, s)| *to += slope * s);
            }
        }
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("slopes of the filter", &mut self.slopes);
        let mut counts = [self.next as u64, u64::from(self.is_known)];
        visitor.counts("next slope, slopes are known", &mut counts);
        // What is no column begins anew.
        let next = usize::try_from(counts[0]).ok();
        self.next = next.filter(|next| *next < self.nx).unwrap_or(0);
        self.is_known = counts[1] != 0;
    }
}
