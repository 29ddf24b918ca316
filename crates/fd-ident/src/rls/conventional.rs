//! The covariance as a plain symmetric matrix, for comparison with the factorised form.

#![expect(
    clippy::inline_always,
    reason = "inlined loops over indices are unrolled where the storage has a fixed size"
)]

use fd_core::{Buffer, Heap, Scalar, Shape, ShapeError, StateVisitor};
use fd_numeric::dot;

use crate::rls::{
    covariance::Covariance,
    storage::{Grid, RlsStorage},
};

/// `P` itself, changed by `(v vᵀ)·c`, so that it stays exactly symmetric.
///
/// The order of the product matters: `(v_i c) v_j` rounds differently above and below the
/// diagonal, and with forgetting the difference grows as `λ⁻ᵏ` until the estimate explodes.
///
/// # When not to use it
///
/// In `f32`, or for inputs of few frequencies: `P` then loses definiteness within some thousand
/// samples. Use [`Ud`](crate::rls::Ud), which costs the same.
#[derive(Clone, Debug)]
pub struct Conventional<T: Scalar, S: RlsStorage<T> = Heap> {
    p: S::Square,
    /// `Pφ` of the remembered direction.
    v: S::Parameters,
    energy: T,
}

impl<T: Scalar, S: RlsStorage<T>> Conventional<T, S> {
    /// Computes `P ← s (P + c v vᵀ)`.
    #[inline(always)]
    fn add_rank_one(&mut self, c: T, scale: T, p_phi: &mut [T]) {
        let v = self.v.as_ref();
        let n = v.len();
        for (i, row) in self.p.as_mut_slice().chunks_exact_mut(n).enumerate() {
            for (p, &vj) in row.iter_mut().zip(v) {
                *p = (*p + (v[i] * vj) * c) * scale;
            }
        }
        p_phi.copy_from_slice(v);
    }

    fn diagonal(&self) -> impl Iterator<Item = T> + '_ {
        let n = self.v.as_ref().len();
        self.p.as_slice().iter().copied().step_by(n + 1)
    }
}

impl<T: Scalar, S: RlsStorage<T>> Covariance<T> for Conventional<T, S> {
    type Parameters = S::Parameters;

    fn isotropic(n: usize, variance: T) -> Result<Self, ShapeError> {
        let mut p = Self {
            p: S::Square::zeros("covariance P", Shape::new(n, n))?,
            v: S::Parameters::zeros("projected regressor", n)?,
            energy: T::zero(),
        };
        p.restart(variance);
        Ok(p)
    }

    fn restart(&mut self, variance: T) {
        let n = self.v.as_ref().len();
        self.p.as_mut_slice().fill(T::zero());
        self.p.as_mut_slice().iter_mut().step_by(n + 1).for_each(|p| *p = variance);
    }

    fn energy(&mut self, phi: &[T]) -> T {
        let v = self.v.as_mut();
        for (v, row) in v.iter_mut().zip(self.p.as_slice().chunks_exact(phi.len())) {
            *v = dot(row, phi);
        }
        self.energy = dot(phi, v);
        self.energy
    }

    #[inline(always)]
    fn learn(&mut self, weight: T, noise: T, scale: T, p_phi: &mut [T]) -> T {
        let inverse = T::one() / (noise + weight * self.energy);
        self.add_rank_one(-(weight * inverse), scale, p_phi);
        inverse
    }

    fn release(&mut self, weight: T, remainder: T, p_phi: &mut [T]) {
        self.add_rank_one(weight / remainder, T::one(), p_phi);
    }

    fn scale(&mut self, factor: T) {
        self.p.as_mut_slice().iter_mut().for_each(|p| *p *= factor);
    }

    fn trace(&self) -> T {
        self.diagonal().fold(T::zero(), |trace, p| trace + p)
    }

    fn diagonal_into(&self, diagonal: &mut [T]) {
        for (out, p) in diagonal.iter_mut().zip(self.diagonal()) {
            *out = p;
        }
    }

    fn visit(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("covariance P", self.p.as_mut_slice());
    }
}
