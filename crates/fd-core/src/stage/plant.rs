//! Models that can be stepped.

use std::fmt::Debug;

use crate::{dims::IoDims, scalar::Scalar};

/// A discrete-time system `x⁺ = f(x, u)`, `y = h(x, u)`.
///
/// A plant is a model that can be run: linear or not, five states or fifty, four matrices (`fd_model::Lti`) or
/// a jet engine that is integrated from one sample to the next (`fd-jetengine`). Observers, simulations and
/// linearisations need exactly this of a model, so each is written once and works with any plant.
///
/// # The contract
///
/// A plant is a *value without memory*. The caller owns the state `x` and passes it in; the plant maps it and
/// keeps no copy. `advance` and `output` take `&self`: the same arguments give the same result, always, from
/// any thread. One plant can therefore serve an observer, a simulator and a finite-difference Jacobian at the
/// same time, none of which disturbs the others.
///
/// The sizes are fixed for the life of the plant, and every slice has the length that
/// [`nx`](Self::nx) and [`io`](Self::io) announce. One call to `advance` is one sample time; a plant
/// that integrates a differential equation holds its step inside, and its input is constant over the
/// sample (zero-order hold).
///
/// # Who calls it, and when
///
/// A run alternates the two, output first:
///
/// ```text
/// output(x(k), u(k)) → y(k),   advance(x(k), u(k)) → x(k+1),   output(x(k+1), u(k+1)) → …
/// ```
///
/// The order matters when `h` depends on `u`. An observer adds its correction to the state between
/// `advance` and the next `output`; that is why the state is the caller's.
///
/// # What an implementor must not do
///
/// * *Fail.* A plant that leaves its region of validity (an engine in surge, a diverging integration, the
///   logarithm of zero) writes NaN, from then on and in every affected output. The caller checks for that. Do
///   not clamp to the last valid value: a plausible wrong number is worse than NaN.
/// * *Allocate.* Scratch space for an integration goes on the stack.
/// * *Remember.* No counters, no caches that change results, no random numbers. Noise and faults are added
///   outside, by the simulation.
/// * *Alias.* `x` and `x_next` are different slices, and `x_next` must be written whole.
///
/// # How it composes
///
/// `Box<P>` is a plant when `P` is, also for `P = dyn Plant`, so a model chosen at run time can be used
/// wherever a static one can. Generators and simulations take a plant by value as a type parameter.
///
/// # When not to implement it
///
/// For a linear model: make an `fd_model::StateSpace`, which supports analysis, reduction and design, and
/// `freeze` it into a plant. For a model whose memory the caller cannot own (a co-simulation, a licence
/// server): implement `fd_sim::Simulator` instead.
///
/// # Example
///
/// A tank of 2 m² that empties through a hole (Torricelli), integrated by Euler's method every 0.5 s:
///
/// ```
/// use fd_core::{IoDims, stage::Plant};
///
/// #[derive(Debug)]
/// struct Tank {
///     /// Hole in m².
///     hole: f64,
/// }
///
/// impl Plant for Tank {
///     fn nx(&self) -> usize {
///         1
///     }
///
///     fn io(&self) -> IoDims {
///         IoDims { nu: 1, ny: 1 }
///     }
///
///     /// Level in m, inflow in m³/s. Below an empty tank the root is NaN, as it should be.
///     fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
///         let outflow = self.hole * (2.0 * 9.81 * x[0]).sqrt();
///         x_next[0] = x[0] + 0.5 / 2.0 * (u[0] - outflow);
///     }
///
///     fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
///         y[0] = x[0];
///     }
/// }
///
/// // Filled at a constant rate it settles where inflow and outflow agree.
/// let tank = Tank { hole: 0.01 };
/// let (mut x, mut next, mut y) = ([0.1], [0.0], [0.0]);
/// for _ in 0..5000 {
///     tank.advance(&x, &[0.04], &mut next);
///     x = next;
/// }
/// tank.output(&x, &[0.04], &mut y);
/// let level = (0.04_f64 / 0.01).powi(2) / (2.0 * 9.81);
/// assert!((y[0] - level).abs() < 1e-9);
///
/// // Without memory there is nothing to restore after a finite difference ∂x⁺/∂x.
/// let mut slope = |x: f64| {
///     let step = 1e-6;
///     let [high, low] = [x + step, x - step].map(|x| {
///         tank.advance(&[x], &[0.04], &mut next);
///         next[0]
///     });
///     (high - low) / (2.0 * step)
/// };
/// assert!(slope(level) < 1.0, "the steady level is stable");
///
/// tank.advance(&[-0.1], &[0.0], &mut next);
/// assert!(next[0].is_nan(), "there is no level below the bottom");
/// ```
pub trait Plant<T: Scalar = f64>: Debug + Send + Sync {
    /// Number of states.
    fn nx(&self) -> usize;

    /// Numbers of inputs and outputs.
    fn io(&self) -> IoDims;

    /// Writes the next state.
    fn advance(&self, x: &[T], u: &[T], x_next: &mut [T]);

    /// Writes the output.
    fn output(&self, x: &[T], u: &[T], y: &mut [T]);
}
