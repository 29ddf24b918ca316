//! The estimators that share rows of memory, and their way through a block of samples.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use fd_numeric::lanes::{Aligned, LaneScalar, Machine, Registers, Simd, Work};

use super::{
    kernel::{Settings, State, update},
    layout::{Layout, Regressors},
    past::Past,
};

/// Up to this many parameters, each number has a kernel of its own.
const UNROLLED: usize = 10;

type Row<T> = <T as LaneScalar>::Row;

/// Samples that were skipped and pauses of forgetting of each lane, during one block.
pub(super) type Tally<T> = [Row<T>; 2];

/// Tiles and their samples, waiting for a machine.
pub struct Pass<'a, T: LaneScalar> {
    pub(super) layout: Layout,
    /// Whether any estimator forgets directionally.
    pub(super) is_directional: bool,
    /// Whole tiles.
    pub(super) tiles: &'a mut [Row<T>],
    /// For each tile, for each sample: rows of regressors or inputs, and one of targets.
    pub(super) samples: &'a [Row<T>],
    /// Samples per tile.
    pub(super) steps: usize,
    /// One per tile.
    pub(super) tallies: &'a mut [Tally<T>],
}

impl<T: LaneScalar> Pass<'_, T> {
    /// Takes every tile through its samples.
    pub(super) fn run(self, machine: Machine) {
        // Sizes are told apart before machines, so that each pair becomes a function of its own.
        match self.layout.n {
            1 => self.of_size::<1>(machine),
            2 => self.of_size::<2>(machine),
            3 => self.of_size::<3>(machine),
            4 => self.of_size::<4>(machine),
            5 => self.of_size::<5>(machine),
            6 => self.of_size::<6>(machine),
            7 => self.of_size::<7>(machine),
            8 => self.of_size::<8>(machine),
            9 => self.of_size::<9>(machine),
            10 => self.of_size::<10>(machine),
            11..=16 => self.of_size::<16>(machine),
            17..=20 => self.of_size::<20>(machine),
            21..=32 => self.of_size::<32>(machine),
            _ => self.of_size::<{ Layout::LARGEST }>(machine),
        }
    }

    fn of_size<const N: usize>(self, machine: Machine) {
        if self.is_directional {
            machine.run(Sized::<T, N, true>(self));
        } else {
            machine.run(Sized::<T, N, false>(self));
        }
    }
}

/// A pass of estimators with at most `N` parameters, some of which may forget directionally.
struct Sized<'a, T: LaneScalar, const N: usize, const DIRECTIONAL: bool>(Pass<'a, T>);

impl<T: LaneScalar, const N: usize, const DIRECTIONAL: bool> Work<T>
    for Sized<'_, T, N, DIRECTIONAL>
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, m: T::Registers<S>) {
        let Pass { layout, tiles, samples, steps, tallies, .. } = self.0;
        let per_tile = steps * (layout.columns() + 1);
        if per_tile == 0 {
            return;
        }
        let tiles = tiles.chunks_exact_mut(layout.rows());
        let tiles = tiles.zip(samples.chunks_exact(per_tile)).zip(tallies);
        for ((tile, samples), tally) in tiles {
            for part in 0..registers::<T, _>(m) {
                learn::<T, _, N, DIRECTIONAL>(m, layout, part, tile, samples, tally);
            }
        }
    }
}

#[inline(always)]
fn registers<T: LaneScalar, M: Registers<T>>(_: M) -> usize {
    T::WIDTH * size_of::<T>() / size_of::<M::Reg>()
}

/// Takes the estimators in one register of each row through a block of samples.
#[inline(always)]
fn learn<T: LaneScalar, M: Registers<T>, const N: usize, const DIRECTIONAL: bool>(
    m: M,
    layout: Layout,
    part: usize,
    tile: &mut [Row<T>],
    samples: &[Row<T>],
    tally: &mut Tally<T>,
) {
    // Known to the compiler, which then unrolls everything.
    let n = if N <= UNROLLED { N } else { layout.n };
    let zero = m.splat(T::zero());
    let load = |tile: &[Row<T>], row: usize| M::of(tile[row].as_ref())[part];
    let settings = Aligned(Settings {
        noise: load(tile, Layout::NOISE),
        minus_scale: load(tile, Layout::MINUS_SCALE),
        silence: load(tile, Layout::SILENCE),
        growth: load(tile, Layout::GROWTH),
        largest_trace: load(tile, Layout::LARGEST_TRACE),
        kept: load(tile, Layout::KEPT),
    });
    let mut state = Aligned(State {
        u: [[zero; N]; N],
        d: [zero; N],
        theta: [zero; N],
        trace_bound: load(tile, Layout::TRACE_BOUND),
        skipped: zero,
        bounded: zero,
    });
    for j in 0..n {
        state.d[j] = load(tile, Layout::D + j);
        state.theta[j] = load(tile, layout.theta() + j);
        for i in 0..j {
            state.u[j][i] = load(tile, layout.u(i, j));
        }
    }
    let mut past = Past::<M::Reg>::new(zero, layout);
    for (row, value) in past.rows().enumerate() {
        *value = load(tile, layout.past() + row);
    }
    let mut phi = Aligned([zero; N]);
    let columns = layout.columns();
    let is_given = layout.regressors == Regressors::Given;
    for sample in samples.chunks_exact(columns + 1) {
        let target = M::of(sample[columns].as_ref())[part];
        if is_given {
            for i in 0..n {
                phi[i] = M::of(sample[i].as_ref())[part];
            }
            update::<T, M, N, DIRECTIONAL>(m, n, &settings, &mut state, &phi, target);
        } else {
            past.push_input(columns, |i| M::of(sample[i].as_ref())[part]);
            past.regressor_into(&mut phi[..n], m.splat(T::one()));
            update::<T, M, N, DIRECTIONAL>(m, n, &settings, &mut state, &phi, target);
            past.push_bias(m.sub(zero, target));
        }
    }
    let mut store = |row: usize, value: M::Reg| M::of_mut(tile[row].as_mut())[part] = value;
    store(Layout::TRACE_BOUND, state.trace_bound);
    for j in 0..n {
        store(Layout::D + j, state.d[j]);
        store(layout.theta() + j, state.theta[j]);
        for i in 0..j {
            store(layout.u(i, j), state.u[j][i]);
        }
    }
    for (row, value) in past.rows().enumerate() {
        store(layout.past() + row, *value);
    }
    M::of_mut(tally[0].as_mut())[part] = state.skipped;
    M::of_mut(tally[1].as_mut())[part] = state.bounded;
}
