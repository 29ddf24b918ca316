//! Which sensor it was: the one whose signature explains the residual after an alarm best.

use fd_compensate::SampleRows;
use nalgebra::{DMatrix, DVector};

/// Steady signatures of the sensors and what residuals scatter by.
pub(super) struct Isolation {
    /// `S⁻¹ g / √(gᵀ S⁻¹ g)` of each sensor; none for one that leaves no trace.
    matched: Vec<Option<DVector<f64>>>,
    channels: usize,
}

impl Isolation {
    /// From the signature of each sensor and fault-free residuals. `None` when a single residual
    /// channel leaves nothing to tell, or the residual does not scatter in all directions.
    pub(super) fn new(signatures: &[Vec<f64>], healthy: SampleRows<'_>) -> Option<Self> {
        let channels = healthy.channels();
        if channels < 2 {
            return None;
        }
        let mut scatter = DMatrix::<f64>::zeros(channels, channels);
        let mut samples = 0_usize;
        for row in healthy.iter() {
            let r = DVector::from_column_slice(row);
            scatter.ger(1.0, &r, &r, 1.0);
            samples += 1;
        }
        let scale = scatter.trace() / channels as f64;
        // Parity relations may be exact multiples of one another; a little scatter in all
        // directions keeps the matrix regular and costs nothing in the others.
        let ridge = DMatrix::identity(channels, channels) * (1e-9 * scale);
        let inverse = ((scatter + ridge) / samples.max(1) as f64).cholesky()?.inverse();
        let matched = signatures.iter().map(|g| {
            let g = DVector::from_column_slice(g);
            let weighted = &inverse * &g;
            let length = g.dot(&weighted).sqrt();
            (length > 0.0 && length.is_finite()).then(|| weighted / length)
        });
        Some(Self { matched: matched.collect(), channels })
    }

    /// The sensor that a residual points to, averaged over its last `window` samples. Largest
    /// reduction of the weighted square, which is the likelihood ratio for an unknown size.
    pub(super) fn name(&self, residual: &[f64], window: usize) -> Option<usize> {
        let rows = residual.len() / self.channels;
        let mut mean = DVector::<f64>::zeros(self.channels);
        for row in residual.chunks_exact(self.channels).skip(rows.saturating_sub(window)) {
            mean += DVector::from_column_slice(row);
        }
        let gains = self.matched.iter().map(|g| g.as_ref().map(|g| g.dot(&mean).abs()));
        let best = gains.enumerate().filter_map(|(i, gain)| gain.map(|gain| (i, gain)));
        best.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signature_that_fits_wins_and_scatter_counts() {
        // Channel 0 scatters ten times as much as channel 1.
        let healthy = [10.0, 1.0, -10.0, 1.0, 10.0, -1.0, -10.0, -1.0];
        let rows = SampleRows::new(2, &healthy).unwrap();
        let signatures = [vec![1.0, 0.0], vec![0.0, 1.0], vec![0.0, 0.0]];
        let isolation = Isolation::new(&signatures, rows).unwrap();
        assert_eq!(isolation.name(&[0.0, 0.0, 5.0, 1.0], 1), Some(1));
        assert_eq!(isolation.name(&[0.0, 0.0, 50.0, 1.0], 1), Some(0));
        let single = SampleRows::new(1, &healthy).unwrap();
        assert!(Isolation::new(&[vec![1.0]], single).is_none());
    }
}
