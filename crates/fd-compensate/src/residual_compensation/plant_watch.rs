//! The running test for a plant that has changed: does `r*` follow the inputs?

use fd_core::{EventKind, Events, Scalar, StateVisitor};

use super::plant_change::{ChangePolicy, PlantChange};

/// Columns that are no inputs: a constant and a trend.
const FREE: usize = 2;
/// Columns per input: as it is, and through two low-passes.
const VIEWS: usize = 3;
/// Windows per time constant of the low-passes.
const PARTS: [f64; VIEWS - 1] = [32.0, 8.0];
/// What is added to the diagonal of the normal equations, relative to it: makes them regular where inputs
/// move together, and costs a ten-thousandth of what they explain.
const RIDGE: f64 = 1e-4;

/// Normal equations of one window, and what the last one said.
#[derive(Clone, Debug)]
pub(super) struct PlantWatch<T> {
    policy: ChangePolicy,
    window: u64,
    share: T,
    growth: T,
    gains: [T; VIEWS - 1],
    /// Low-passed inputs.
    slow: Vec<T>,
    /// The columns `[1, t, u₁, …]` of the present sample.
    phi: Vec<T>,
    /// `Σ φ φᵀ`, row by row.
    gram: Vec<T>,
    /// `Σ φ r*` of each channel.
    cross: Vec<T>,
    /// `Σ r*²` of each channel.
    squares: Vec<T>,
    /// What the last window found the inputs to do to each channel.
    beta: Vec<T>,
    /// Mean squares of each channel and each input in the first window.
    healthy: Vec<T>,
    moved: Vec<T>,
    seen: u64,
    windows: u64,
    is_changed: bool,
}

impl<T: Scalar> PlantWatch<T> {
    pub(super) fn new(plan: &PlantChange, nu: usize, residual_len: usize) -> Self {
        // Nothing is kept when nobody asks.
        let (nu, channels) =
            if plan.policy == ChangePolicy::Ignore { (0, 0) } else { (nu, residual_len) };
        let (columns, zero) = (FREE + VIEWS * nu, T::zero());
        Self {
            policy: plan.policy,
            window: plan.window,
            share: T::from_design(plan.share),
            growth: T::from_design(plan.growth),
            gains: PARTS.map(|parts| T::from_design((1.0 + plan.window as f64 / parts).recip())),
            slow: vec![zero; (VIEWS - 1) * nu],
            phi: vec![zero; columns],
            gram: vec![zero; columns * columns],
            cross: vec![zero; columns * channels],
            squares: vec![zero; channels],
            beta: vec![zero; columns * channels],
            healthy: vec![zero; channels],
            moved: vec![zero; nu],
            seen: 0,
            windows: 0,
            is_changed: false,
        }
    }

    /// Watches one compensated sample, next to the largest residual of the training, and reports whether
    /// to train again.
    pub(super) fn watch(&mut self, u: &[T], r_star: &[T], peak: T, events: &mut Events) -> bool {
        // A sample without a residual shows no relation.
        if self.policy == ChangePolicy::Ignore || !r_star.iter().all(T::is_finite) {
            return false;
        }
        self.add(u, r_star);
        if self.seen < self.window {
            return false;
        }
        let was_changed = self.is_changed;
        self.sweep();
        if self.windows == 0 {
            self.take_as_healthy();
        } else {
            self.is_changed = self.has_changed(peak);
        }
        self.fit();
        self.begin_window();
        self.windows += 1;
        if self.is_changed && !was_changed {
            events.push(EventKind::CharacteristicsChanged);
        }
        self.is_changed && self.policy == ChangePolicy::Retrain
    }

    /// Whether the last whole window spoke of a change.
    pub(super) fn is_changed(&self) -> bool {
        self.is_changed
    }

    /// Adds a sample to the normal equations.
    fn add(&mut self, u: &[T], r_star: &[T]) {
        let first = self.windows == 0 && self.seen == 0;
        let t = T::from_design((self.seen as f64 + 0.5) / self.window as f64 - 0.5);
        self.phi[0] = T::one();
        self.phi[1] = t;
        let views = self.phi[FREE..].chunks_exact_mut(VIEWS);
        for ((views, slow), &u) in views.zip(self.slow.chunks_exact_mut(VIEWS - 1)).zip(u) {
            views[0] = u;
            for ((view, slow), &gain) in views[1..].iter_mut().zip(slow).zip(&self.gains) {
                let gain = if first { T::one() } else { gain };
                *slow += gain * (u - *slow);
                *view = *slow;
            }
        }
        let columns = self.phi.len();
        for (row, &phi) in self.gram.chunks_exact_mut(columns).zip(&self.phi) {
            row.iter_mut().zip(&self.phi).for_each(|(sum, &other)| *sum += phi * other);
        }
        let channels = self.cross.chunks_exact_mut(columns).zip(&mut self.squares);
        for ((cross, squares), &r) in channels.zip(r_star) {
            cross.iter_mut().zip(&self.phi).for_each(|(sum, &phi)| *sum += phi * r);
            *squares += r * r;
        }
        self.seen += 1;
    }

    /// Takes one column out of all others, by elimination.
    fn eliminate(&mut self, j: usize) {
        let n = self.phi.len();
        let pivot = self.gram[j * n + j];
        // An input that did not move.
        if pivot <= T::zero() {
            return;
        }
        let (above, below) = self.gram.split_at_mut((j + 1) * n);
        let row = &above[j * n..];
        for (i, other) in (j + 1..n).zip(below.chunks_exact_mut(n)) {
            let factor = other[j] / pivot;
            other.iter_mut().zip(row).for_each(|(other, &entry)| *other -= factor * entry);
            for cross in self.cross.chunks_exact_mut(n) {
                let taken = factor * cross[j];
                cross[i] -= taken;
            }
        }
    }

    /// Takes constant and trend out of everything.
    fn sweep(&mut self) {
        let n = self.phi.len();
        for j in 0..FREE {
            let pivot = self.gram[j * n + j];
            for (squares, cross) in self.squares.iter_mut().zip(self.cross.chunks_exact(n)) {
                *squares -= cross[j] * cross[j] / pivot;
            }
            self.eliminate(j);
        }
    }

    fn take_as_healthy(&mut self) {
        self.healthy.copy_from_slice(&self.squares);
        let motions = motions(&self.gram, self.phi.len());
        self.moved.iter_mut().zip(motions).for_each(|(moved, motion)| *moved = motion);
    }

    /// Whether any channel has grown and follows the inputs as it did in the last window.
    fn has_changed(&self, peak: T) -> bool {
        let n = self.phi.len();
        // What rounding leaves of the residual is no change, however it grows.
        let least = T::default_epsilon() * peak * peak * T::from_design(self.window as f64);
        let motions = motions(&self.gram, n).zip(&self.moved);
        let livelier = motions.fold(T::one(), |most, (motion, &moved)| most.max(motion / moved));
        let growth = self.growth * self.growth * livelier;
        let channels = self.squares.iter().zip(&self.healthy);
        let relations = self.cross.chunks_exact(n).zip(self.beta.chunks_exact(n));
        channels.zip(relations).any(|((&squares, &healthy), (cross, beta))| {
            // 2 βᵀ Zᵀr − βᵀ ZᵀZ β: by how much the old relation lowers the sum of squares.
            let mut explained = T::zero();
            let rows = self.gram.chunks_exact(n).skip(FREE);
            for ((row, &cross), &own) in rows.zip(&cross[FREE..]).zip(&beta[FREE..]) {
                let row = row[FREE..].iter().zip(&beta[FREE..]);
                let image = row.fold(T::zero(), |sum, (&g, &b)| sum + g * b);
                explained += own * (cross + cross - image);
            }
            // An input that did not move before leaves nothing to compare with: growth is infinite.
            squares > least && squares >= growth * healthy && explained >= self.share * squares
        })
    }

    /// What the inputs do to each channel in this window; the normal equations are used up.
    fn fit(&mut self) {
        let n = self.phi.len();
        let ridge = T::one() + T::from_design(RIDGE);
        for j in FREE..n {
            self.gram[j * n + j] *= ridge;
        }
        for j in FREE..n {
            self.eliminate(j);
        }
        for (beta, cross) in self.beta.chunks_exact_mut(n).zip(self.cross.chunks_exact(n)) {
            for j in (FREE..n).rev() {
                let row = &self.gram[j * n..(j + 1) * n];
                let known = row[j + 1..].iter().zip(&beta[j + 1..]);
                let rest = known.fold(cross[j], |rest, (&g, &b)| rest - g * b);
                beta[j] = if row[j] > T::zero() { rest / row[j] } else { T::zero() };
            }
        }
    }

    fn begin_window(&mut self) {
        self.gram.fill(T::zero());
        self.cross.fill(T::zero());
        self.squares.fill(T::zero());
        self.seen = 0;
    }

    pub(super) fn reset(&mut self) {
        self.begin_window();
        for values in [&mut self.slow, &mut self.beta, &mut self.healthy, &mut self.moved] {
            values.fill(T::zero());
        }
        self.windows = 0;
        self.is_changed = false;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        if self.policy == ChangePolicy::Ignore {
            return;
        }
        visitor.reals("plant watch slow inputs", &mut self.slow);
        visitor.reals("plant watch normal equations", &mut self.gram);
        visitor.reals("plant watch cross products", &mut self.cross);
        visitor.reals("plant watch squares", &mut self.squares);
        visitor.reals("plant watch relation", &mut self.beta);
        visitor.reals("plant watch healthy squares", &mut self.healthy);
        visitor.reals("plant watch input squares", &mut self.moved);
        let mut counts = [self.seen, self.windows, u64::from(self.is_changed)];
        visitor.counts("plant watch seen, windows, changed", &mut counts);
        [self.seen, self.windows, _] = counts;
        self.is_changed = counts[2] != 0;
    }
}

/// Sum of squares of each input as it is, without constant and trend.
fn motions<T: Scalar>(gram: &[T], n: usize) -> impl Iterator<Item = T> {
    (FREE..n).step_by(VIEWS).map(move |column| gram[column * n + column])
}
