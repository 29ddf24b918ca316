//! The running whitening filter.

use fd_core::{HeapMap, LinMap, Scalar, StateVisitor};

use super::design::WhitenerDesign;

/// Whitens one residual after the other, see the [module](super).
#[derive(Clone, Debug)]
pub struct Whitener<T: Scalar> {
    mean: Vec<T>,
    /// `a_ci`, those of the nearest sample first, within it channel by channel.
    coefficients: Vec<T>,
    across: HeapMap<T>,
    /// Past `r − m`, nearest sample first.
    past: Vec<T>,
    errors: Vec<T>,
    white: Vec<T>,
}

impl<T: Scalar> Whitener<T> {
    /// The filter of a design.
    #[must_use]
    pub fn new(design: &WhitenerDesign) -> Self {
        let (channels, order) = (design.channels(), design.order());
        let coefficients = (0..order * channels)
            .map(|at| T::from_design(design.coefficients[at % channels][at / channels]))
            .collect();
        Self {
            mean: design.mean.iter().map(|&m| T::from_design(m)).collect(),
            coefficients,
            across: HeapMap::from_fn(channels, channels, |i, j| {
                T::from_design(design.across[(i, j)])
            }),
            past: vec![T::zero(); order * channels],
            errors: vec![T::zero(); channels],
            white: vec![T::zero(); channels],
        }
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.mean.len()
    }

    /// Takes one residual and returns it whitened.
    pub fn update(&mut self, r: &[T]) -> &[T] {
        let channels = self.mean.len();
        for (c, (error, (&r, &mean))) in
            self.errors.iter_mut().zip(r.iter().zip(&self.mean)).enumerate()
        {
            let own = |at: &[T]| at[c];
            let pairs =
                self.coefficients.chunks_exact(channels).zip(self.past.chunks_exact(channels));
            *error = pairs.fold(r - mean, |error, (a, past)| error - own(a) * own(past));
        }
        if !self.past.is_empty() {
            let kept = self.past.len() - channels;
            self.past.copy_within(..kept, channels);
            for (past, (&r, &mean)) in self.past.iter_mut().zip(r.iter().zip(&self.mean)) {
                *past = r - mean;
            }
        }
        self.across.mul_into(&self.errors, &mut self.white);
        &self.white
    }

    /// Forgets all samples.
    pub fn reset(&mut self) {
        self.past.fill(T::zero());
    }

    /// Shows the memory.
    pub fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("whitener past", &mut self.past);
    }
}
