//! One step of recursive least squares on `U D Uᵀ`, in the lanes of a register.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]
#![expect(clippy::needless_range_loop, reason = "the indices are those of the algebra")]

use fd_numeric::lanes::{Aligned, LaneScalar, Registers};

use crate::rls::rounding;

/// What the estimators of some lanes are told: one register each, or one number of one estimator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings<R> {
    /// Variance `ρ` that the noise of a sample counts with: `λ`, `α` of eq. (18), or 1.
    pub(super) noise: R,
    /// `−s`, where `P` grows by `s` per sample: `1/λ` or 1.
    pub(super) minus_scale: R,
    /// Samples with `φᵀPφ` of this or less are skipped.
    pub(super) silence: R,
    /// At least what the trace of `P` grows by per sample.
    pub(super) growth: R,
    /// Largest trace of `P` that forgetting may lead to.
    pub(super) largest_trace: R,
    /// `λ` of directional forgetting, 1 where forgetting is of another kind.
    pub(super) kept: R,
}

/// What the estimators of some lanes remember.
pub(super) struct State<R, const N: usize> {
    /// Strict upper triangle of `U`, column by column; the rest is not touched.
    pub(super) u: [[R; N]; N],
    pub(super) d: [R; N],
    pub(super) theta: [R; N],
    /// At least the trace of `P`.
    pub(super) trace_bound: R,
    /// Samples skipped so far.
    pub(super) skipped: R,
    /// How often forgetting paused.
    pub(super) bounded: R,
}

/// Learns from one sample in each lane. What directional forgetting costs is left out when no lane
/// asks for it.
///
/// The algebra is that of [`Ud`](crate::rls::Ud) under [`Rls`](crate::rls::Rls), with
/// `a_j = ρ + Σ_{i≤j} f_i d_i f_i` in place of `a_j/ρ`, which saves products. The divisions are
/// by `−a_j`, so that nothing has to be negated later.
///
/// Directional forgetting changes the information along `φ` by `w φφᵀ`, `w = λ − (1−λ)/φᵀPφ`,
/// which may be negative: `a_j = 1 + w Σ_{i≤j} f_i d_i f_i` then falls from 1 to `λ (1 + φᵀPφ)`,
/// which is at least `λ`. Without cancellation there, the update of Bierman serves for both signs.
#[inline(always)]
pub(super) fn update<T: LaneScalar, M: Registers<T>, const N: usize, const DIRECTIONAL: bool>(
    m: M,
    n: usize,
    settings: &Settings<M::Reg>,
    state: &mut State<M::Reg, N>,
    phi: &[M::Reg; N],
    target: M::Reg,
) {
    let State { u, d, theta, trace_bound, .. } = state;
    let zero = m.splat(T::zero());
    // Uᵀφ, and D Uᵀφ which becomes Pφ.
    let (mut f, mut v) = (Aligned([zero; N]), Aligned([zero; N]));
    // φᵀθ − y
    let mut error = m.mul(phi[0], theta[0]);
    for i in 1..n {
        error = m.mul_add(phi[i], theta[i], error);
    }
    error = m.sub(error, target);
    let mut energy = zero;
    for j in 0..n {
        f[j] = phi[j];
        for i in 0..j {
            f[j] = m.mul_add(u[j][i], phi[i], f[j]);
        }
        v[j] = m.mul(d[j], f[j]);
        energy = m.mul_add(v[j], f[j], energy);
    }

    let one = m.splat(T::one());
    let (mut noise, mut minus_scale) = (settings.noise, settings.minus_scale);
    // Not a number when the error is not finite.
    let checked = m.add(energy, m.sub(error, error));
    let loud = m.both(
        m.less(settings.silence, checked),
        m.at_most(checked, m.splat(T::max_value().unwrap_or_else(T::one))),
    );
    // What information along φ, and the error, count with: 1 to the bit in lanes that forget in
    // another way.
    let (mut weight, mut share) = (one, one);
    // Lanes that take no part, or whose 1 − λ is 0, may have no energy to divide by.
    let divisor = m.select(m.both(loud, m.less(zero, energy)), energy, one);
    if DIRECTIONAL {
        share = settings.kept;
        weight = m.sub(share, m.div(m.sub(one, share), divisor));
    }
    *trace_bound = m.mul(*trace_bound, settings.growth);
    let free = m.at_most(*trace_bound, settings.largest_trace);
    if !m.all(m.both(loud, free)) {
        // The bound may be too large: look at the trace itself.
        let mut trace = zero;
        for j in 0..n {
            let mut column = one;
            for i in 0..j {
                column = m.mul_add(u[j][i], u[j][i], column);
            }
            trace = m.mul_add(d[j], column, trace);
        }
        let mut largest_trace = settings.largest_trace;
        let directional = m.less(settings.kept, one);
        if DIRECTIONAL {
            // Where information grows, nothing has to pause.
            let unlimited = m.splat(T::one() / T::zero());
            let grows = m.both(directional, m.at_most(zero, weight));
            largest_trace = m.select(grows, unlimited, largest_trace);
        }
        let may_forget = m.at_most(trace, m.mul(largest_trace, settings.noise));
        if DIRECTIONAL {
            // In a pause the estimate moves, and information stays.
            let paused = m.div(one, m.add(one, divisor));
            weight = m.select(may_forget, weight, m.select(directional, zero, weight));
            share = m.select(may_forget, share, m.select(directional, paused, share));
        }
        let forgets = m.both(loud, may_forget);
        noise = m.select(forgets, noise, one);
        minus_scale = m.select(forgets, minus_scale, m.splat(-T::one()));
        *trace_bound = m.select(forgets, m.mul(trace, settings.growth), trace);
        // A skipped sample has no direction and no error, and so changes nothing. Near
        // the largest trace a direction counts only where it is more than rounding.
        let rounding = m.select(free, zero, m.splat(rounding::<T>(n)));
        for j in 0..n {
            let mut size = m.abs(phi[j]);
            for i in 0..j {
                size = m.add(size, m.abs(m.mul(u[j][i], phi[i])));
            }
            let counts = m.both(loud, m.less(m.mul(rounding, size), m.abs(f[j])));
            f[j] = m.select(counts, f[j], zero);
            v[j] = m.select(counts, v[j], zero);
        }
        error = m.select(loud, error, zero);
        state.skipped = m.add(state.skipped, m.select(loud, zero, one));
        let bounded = m.select(may_forget, zero, m.select(loud, one, zero));
        state.bounded = m.add(state.bounded, bounded);
    }

    if DIRECTIONAL {
        for j in 0..n {
            f[j] = m.mul(weight, f[j]);
        }
        // 1 + w φᵀPφ = λ (1 + φᵀPφ)
        error = m.mul(share, error);
    }

    let minus_one = m.splat(-T::one());
    let mut before = noise;
    let mut minus_inverse = noise;
    for j in 0..n {
        let g = v[j];
        let a = m.mul_add(f[j], g, before);
        let factor = m.mul(f[j], minus_inverse);
        minus_inverse = m.div(minus_one, a);
        d[j] = m.mul(m.mul(d[j], minus_scale), m.mul(before, minus_inverse));
        for i in 0..j {
            let old = u[j][i];
            u[j][i] = m.mul_add(factor, v[i], old);
            v[i] = m.mul_add(old, g, v[i]);
        }
        before = a;
    }
    let gain = m.mul(error, minus_inverse);
    for i in 0..n {
        theta[i] = m.mul_add(v[i], gain, theta[i]);
    }
}
