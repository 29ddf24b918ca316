//! Running the observer and learning its parameters.

use fd_core::{
    Frame, HeapMap, IoDims, LinMap, Scalar, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

/// How fast parameters are learned, and how far they may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterNoise {
    /// Standard deviation of each parameter before the first sample.
    pub prior: f64,
    /// Variance of the step that each parameter takes per sample.
    pub drift: f64,
    /// Variance of the noise on each output, in the squared (scaled) unit of the output.
    pub output: f64,
    /// Largest magnitude of a parameter.
    pub bound: f64,
}

/// What one parameter does to the model.
#[derive(Clone, Debug)]
pub(super) struct Direction<T: Scalar> {
    pub a: HeapMap<T>,
    pub b: HeapMap<T>,
}

/// An observer that learns parameters; all memory is taken at construction.
#[derive(Clone, Debug)]
pub struct AdaptiveObserver<T: Scalar> {
    closed: HeapMap<T>,
    b: HeapMap<T>,
    gain: HeapMap<T>,
    c: HeapMap<T>,
    d: HeapMap<T>,
    directions: Vec<Direction<T>>,
    prior: T,
    drift: T,
    noise: T,
    bound: T,
    x: Vec<T>,
    theta: Vec<T>,
    /// Sensitivities `Υ_i` of the state, one after the other.
    slopes: Vec<T>,
    /// Covariance of the parameters, row by row.
    p: Vec<T>,
    scratch: Scratch<T>,
}

/// Memory that does not outlive a sample.
#[derive(Clone, Debug)]
struct Scratch<T> {
    x: Vec<T>,
    slope: Vec<T>,
    /// Regressors `C Υ_i` by parameter and output.
    regressors: Vec<T>,
    /// `P h` for one output.
    reach: Vec<T>,
    /// Change of the parameters in this sample.
    step: Vec<T>,
    /// `φ_i`.
    force: Vec<T>,
}

impl<T: Scalar> AdaptiveObserver<T> {
    pub(super) fn new(
        [closed, b, gain, c, d]: [HeapMap<T>; 5],
        directions: Vec<Direction<T>>,
        noise: ParameterNoise,
    ) -> Self {
        let (n, ny, count) = (closed.nrows(), c.nrows(), directions.len());
        let zeros = |len: usize| vec![T::zero(); len];
        let scratch = Scratch {
            x: zeros(n),
            slope: zeros(n),
            regressors: zeros(count * ny),
            reach: zeros(count),
            step: zeros(count),
            force: zeros(n),
        };
        let mut observer = Self {
            closed,
            b,
            gain,
            c,
            d,
            directions,
            prior: T::from_design(noise.prior),
            drift: T::from_design(noise.drift),
            noise: T::from_design(noise.output),
            bound: T::from_design(noise.bound),
            x: zeros(n),
            theta: zeros(count),
            slopes: zeros(count * n),
            p: zeros(count * count),
            scratch,
        };
        observer.reset();
        observer
    }

    /// The parameters, as relative as their shifts are.
    #[must_use]
    pub fn theta(&self) -> &[T] {
        &self.theta
    }

    /// Estimate of the state at the next sample.
    #[must_use]
    pub fn state(&self) -> &[T] {
        &self.x
    }

    /// One Kalman step per output for `θ`, which fills `scratch.step` with its change.
    fn learn(&mut self, r: &[T]) {
        let (n, ny, count) = (self.x.len(), r.len(), self.theta.len());
        let Scratch { regressors, reach, step, .. } = &mut self.scratch;
        for i in 0..count {
            let slope = &self.slopes[i * n..(i + 1) * n];
            self.c.mul_into(slope, &mut regressors[i * ny..(i + 1) * ny]);
        }
        step.fill(T::zero());
        for (j, &r) in r.iter().enumerate() {
            let h = |i: usize| regressors[i * ny + j];
            let dot = |v: &[T]| v.iter().enumerate().fold(T::zero(), |sum, (i, &v)| sum + h(i) * v);
            for (i, reach) in reach.iter_mut().enumerate() {
                *reach = dot(&self.p[i * count..(i + 1) * count]);
            }
            let weight = (self.noise + dot(reach)).recip();
            let error = (r - dot(step)) * weight;
            for i in 0..count {
                step[i] += reach[i] * error;
                for k in 0..count {
                    // The product first: it rounds alike for (i, k) and (k, i).
                    self.p[i * count + k] -= (reach[i] * reach[k]) * weight;
                }
            }
        }
        for (i, (step, &theta)) in step.iter_mut().zip(&self.theta).enumerate() {
            let variance = &mut self.p[i * count + i];
            // Without excitation nothing else stops the growth.
            if *variance < self.prior * self.prior {
                *variance += self.drift;
            }
            *step = (theta + *step).clamp(-self.bound, self.bound) - theta;
        }
    }
}

impl<T: Scalar> Stage<T> for AdaptiveObserver<T> {
    fn reset(&mut self) {
        let count = self.theta.len();
        self.x.fill(T::zero());
        self.theta.fill(T::zero());
        self.slopes.fill(T::zero());
        self.p.fill(T::zero());
        for i in 0..count {
            self.p[i * count + i] = self.prior * self.prior;
        }
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("observer state", &mut self.x);
        visitor.reals("plant parameters", &mut self.theta);
        visitor.reals("sensitivities of the state", &mut self.slopes);
        visitor.reals("covariance of the parameters", &mut self.p);
    }
}

impl<T: Scalar> ResidualGenerator<T> for AdaptiveObserver<T> {
    fn io(&self) -> IoDims {
        IoDims { nu: self.b.ncols(), ny: self.c.nrows() }
    }

    fn residual_len(&self) -> usize {
        self.c.nrows()
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let (u, y) = (frame.u(), frame.y());
        let n = self.x.len();
        self.c.mul_into(&self.x, r);
        self.d.mul_add_into(u, r);
        for (r, &y) in r.iter_mut().zip(y) {
            *r = y - *r;
        }
        self.learn(r);

        let Scratch { x: next, slope, step, force, .. } = &mut self.scratch;
        // x̂⁺ = (A − L C) x̂ + (B − L D) u + L y + Σ θ_i φ_i + Σ Υ_i⁺ Δθ_i.
        self.closed.mul_into(&self.x, next);
        self.b.mul_add_into(u, next);
        self.gain.mul_add_into(y, next);
        for (i, own) in self.slopes.chunks_exact_mut(n.max(1)).enumerate() {
            self.closed.mul_into(own, slope);
            for (direction, &theta) in self.directions.iter().zip(&self.theta) {
                direction.a.mul_into(own, force);
                add_scaled(slope, theta, force);
            }
            self.directions[i].a.mul_into(&self.x, force);
            self.directions[i].b.mul_add_into(u, force);
            add_scaled(next, self.theta[i], force);
            add_scaled(slope, T::one(), force);
            add_scaled(next, step[i], slope);
            own.copy_from_slice(slope);
        }
        std::mem::swap(&mut self.x, next);
        add_scaled(&mut self.theta, T::one(), step);
    }
}

/// `sum ← sum + factor · v`.
fn add_scaled<T: Scalar>(sum: &mut [T], factor: T, v: &[T]) {
    for (sum, &v) in sum.iter_mut().zip(v) {
        *sum += factor * v;
    }
}
