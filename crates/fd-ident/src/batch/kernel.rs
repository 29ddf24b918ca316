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
    pub noise: R,
    /// `−s`, where `P` grows by `s` per sample: `1/λ` or 1.
    pub minus_scale: R,
    /// Samples with `φᵀPφ` of this or less are skipped.
    pub silence: R,
    /// At least what the trace of `P` grows by per sample.
    pub growth: R,
    /// Largest trace of `P` that forgetting may lead to.
    pub largest_trace: R,
    /// `λ` of directional forgetting, 1 where forgetting is of another kind.
    pub kept: R,
}

/// What the estimators of some lanes remember.
pub(super) struct State<R, const N: usize> {
    /// Strict upper triangle of `U`, column by column; the rest is not touched.
    pub u: [[R; N]; N],
    pub d: [R; N],
    pub theta: [R; N],
    /// At least the trace of `P`.
    pub trace_bound: R,
    /// Samples skipped so far.
    pub skipped: R,
    /// How often forgetting paused.
    pub bounded: R,
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
    let [fours, twos] = if N < MANY { [0, 0] } else { [n - n % TOGETHER, n - n % 2] };
    for first in (0..fours).step_by(TOGETHER) {
        transposed_times::<T, M, N, TOGETHER>(m, first, u, phi, &mut f);
    }
    for first in (fours..twos).step_by(2) {
        transposed_times::<T, M, N, 2>(m, first, u, phi, &mut f);
    }
    for first in twos..n {
        transposed_times::<T, M, N, 1>(m, first, u, phi, &mut f);
    }
    let mut energy = zero;
    for j in 0..n {
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

    let mut sums = Sums { before: noise, minus_inverse: noise };
    for first in (0..fours).step_by(TOGETHER) {
        columns::<T, M, N, TOGETHER>(m, first, minus_scale, &mut sums, u, d, &f, &mut v);
    }
    for first in (fours..twos).step_by(2) {
        columns::<T, M, N, 2>(m, first, minus_scale, &mut sums, u, d, &f, &mut v);
    }
    for first in twos..n {
        columns::<T, M, N, 1>(m, first, minus_scale, &mut sums, u, d, &f, &mut v);
    }
    let gain = m.mul(error, sums.minus_inverse);
    for i in 0..n {
        theta[i] = m.mul_add(v[i], gain, theta[i]);
    }
}

/// Columns that are gone through together where there are as many: several sums at once hide the latency of an
/// addition, and a number that all of them need is loaded once.
const TOGETHER: usize = 4;
/// Fewer parameters than these fit into the registers, column by column.
const MANY: usize = 8;

/// `K` elements of `f = Uᵀφ`.
#[inline(always)]
fn transposed_times<T: LaneScalar, M: Registers<T>, const N: usize, const K: usize>(
    m: M,
    first: usize,
    u: &[[M::Reg; N]; N],
    phi: &[M::Reg; N],
    f: &mut [M::Reg; N],
) {
    let mut sums = [phi[first]; K];
    sums.copy_from_slice(&phi[first..first + K]);
    for i in 0..first {
        for k in 0..K {
            sums[k] = m.mul_add(u[first + k][i], phi[i], sums[k]);
        }
    }
    for i in 0..K {
        for k in i + 1..K {
            sums[k] = m.mul_add(u[first + k][first + i], phi[first + i], sums[k]);
        }
    }
    f[first..first + K].copy_from_slice(&sums);
}

/// What goes from column to column.
struct Sums<R> {
    /// `a` of the column before.
    before: R,
    /// `−1/a`.
    minus_inverse: R,
}

/// Column by column, `K` of them: `u_j += factor_j v`, and then `v += g_j u_j` with the `u_j` there was. What a column
/// is multiplied with does not depend on the columns before it.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "registers, by name")]
fn columns<T: LaneScalar, M: Registers<T>, const N: usize, const K: usize>(
    m: M,
    first: usize,
    minus_scale: M::Reg,
    sums: &mut Sums<M::Reg>,
    u: &mut [[M::Reg; N]; N],
    d: &mut [M::Reg; N],
    f: &[M::Reg; N],
    v: &mut [M::Reg; N],
) {
    let minus_one = m.splat(-T::one());
    let (mut g, mut factors) = ([minus_one; K], [minus_one; K]);
    for k in 0..K {
        let j = first + k;
        g[k] = v[j];
        let a = m.mul_add(f[j], g[k], sums.before);
        factors[k] = m.mul(f[j], sums.minus_inverse);
        sums.minus_inverse = m.div(minus_one, a);
        d[j] = m.mul(m.mul(d[j], minus_scale), m.mul(sums.before, sums.minus_inverse));
        sums.before = a;
    }
    for i in 0..first {
        let mut sum = v[i];
        for k in 0..K {
            step::<T, M>(m, [factors[k], g[k]], &mut u[first + k][i], &mut sum);
        }
        v[i] = sum;
    }
    for k in 1..K {
        for i in first..first + k {
            step::<T, M>(m, [factors[k], g[k]], &mut u[first + k][i], &mut v[i]);
        }
    }
}

#[inline(always)]
fn step<T: LaneScalar, M: Registers<T>>(
    m: M,
    [factor, g]: [M::Reg; 2],
    u: &mut M::Reg,
    v: &mut M::Reg,
) {
    let old = *u;
    *u = m.mul_add(factor, *v, old);
    *v = m.mul_add(old, g, *v);
}
