//! Running the statistics.

use fd_core::{
    Frame, HeapMap, IoDims, LinMap, Scalar, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

use crate::window::SlidingWindow;

/// How far a window is from what is normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics<T> {
    /// T² of the scores.
    pub t2: T,
    /// T² of what is left, where there is one.
    pub rest: Option<T>,
    /// Squared prediction error.
    pub q: T,
}

/// The largest values of the statistics that are normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of T².
    pub t2: f64,
    /// Of the T² of what is left; none where there is no such statistic.
    pub rest: Option<f64>,
    /// Of Q; zero when the scores explain the windows to rounding, so that there is no Q.
    pub q: f64,
}

/// One of the statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// T² of the scores.
    T2,
    /// T² of what is left.
    Rest,
    /// Squared prediction error.
    Q,
}

/// A map to whitened scores, the scores, and from them to `M^½ w`.
#[derive(Clone, Debug)]
struct Scores<T: Scalar> {
    map: HeapMap<T>,
    root: HeapMap<T>,
    values: Vec<T>,
}

impl<T: Scalar> Scores<T> {
    fn new((map, root): (HeapMap<T>, HeapMap<T>)) -> Self {
        let values = vec![T::zero(); map.dims().rows];
        Self { map, root, values }
    }

    fn square(&mut self, w: &[T]) -> T {
        self.map.mul_into(w, &mut self.values);
        square(&self.values)
    }
}

/// T² and Q of the last samples. As a residual generator its channels are the statistics, each divided by
/// its limit; they are zero until the window is full.
#[derive(Clone, Debug)]
pub struct Monitor<T: Scalar> {
    io: IoDims,
    window: SlidingWindow<T>,
    mean: Vec<T>,
    per_scale: Vec<T>,
    scores: Scores<T>,
    rest: Option<Scores<T>>,
    back: HeapMap<T>,
    limits: Statistics<T>,
    /// Centred window, prediction error, and room for contributions.
    w: Vec<T>,
    error: Vec<T>,
    parts: Vec<T>,
}

impl<T: Scalar> Monitor<T> {
    pub(super) fn new(
        (io, order): (IoDims, usize),
        (mean, scale): (&[f64], &[f64]),
        scores: (HeapMap<T>, HeapMap<T>),
        back: HeapMap<T>,
        rest: Option<(HeapMap<T>, HeapMap<T>)>,
        limits: Limits,
    ) -> Self {
        let zeros = vec![T::zero(); mean.len()];
        // A statistic without a limit is rounding only; it stays as it is.
        let or_one = |limit: f64| T::from_design(if limit > 0.0 { limit } else { 1.0 });
        Self {
            io,
            window: SlidingWindow::new(io, order),
            mean: mean.iter().map(|&m| T::from_design(m)).collect(),
            per_scale: scale.iter().map(|&s| T::from_design(1.0 / s)).collect(),
            scores: Scores::new(scores),
            rest: rest.map(Scores::new),
            back,
            limits: Statistics {
                t2: or_one(limits.t2),
                rest: limits.rest.map(or_one),
                q: or_one(limits.q),
            },
            w: zeros.clone(),
            error: zeros.clone(),
            parts: zeros,
        }
    }

    /// Takes one sample; none until the window is full.
    pub fn observe(&mut self, frame: Frame<'_, T>) -> Option<Statistics<T>> {
        let window = self.window.push(frame)?;
        let centred = window.iter().zip(&self.mean).zip(&self.per_scale);
        for (w, ((value, mean), per_scale)) in self.w.iter_mut().zip(centred) {
            *w = (*value - *mean) * *per_scale;
        }
        let t2 = self.scores.square(&self.w);
        let rest = self.rest.as_mut().map(|rest| rest.square(&self.w));
        self.back.mul_into(&self.scores.values, &mut self.error);
        for (error, w) in self.error.iter_mut().zip(&self.w) {
            *error = *w - *error;
        }
        Some(Statistics { t2, rest, q: square(&self.error) })
    }

    /// Divides a statistic of the last sample among the channels, inputs first: `to` gets one number per
    /// channel, and zeros where there is no such statistic. Together they are the statistic. A restored monitor has
    /// none before its next sample.
    pub fn contributions(&mut self, of: Statistic, to: &mut [T]) {
        let scores = match of {
            Statistic::T2 => Some(&self.scores),
            Statistic::Rest => self.rest.as_ref(),
            Statistic::Q => None,
        };
        match (scores, of) {
            (Some(scores), _) => scores.root.mul_into(&scores.values, &mut self.parts),
            (None, Statistic::Q) => self.parts.copy_from_slice(&self.error),
            (None, _) => self.parts.fill(T::zero()),
        }
        let width = (self.io.nu + self.io.ny).max(1);
        to.fill(T::zero());
        for sample in self.parts.chunks(width) {
            for (to, part) in to.iter_mut().zip(sample) {
                *to += *part * *part;
            }
        }
    }
}

fn square<T: Scalar>(values: &[T]) -> T {
    fd_numeric::dot(values, values)
}

impl<T: Scalar> Stage<T> for Monitor<T> {
    fn reset(&mut self) {
        self.window.reset();
        // What contributions are asked of after a reset: nothing.
        self.scores.values.fill(T::zero());
        self.rest.iter_mut().for_each(|rest| rest.values.fill(T::zero()));
        self.error.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.window.visit(visitor);
    }
}

impl<T: Scalar> ResidualGenerator<T> for Monitor<T> {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        2 + usize::from(self.rest.is_some())
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let limits = self.limits;
        let Some(statistics) = self.observe(frame) else {
            r.fill(T::zero());
            return;
        };
        let rest = statistics.rest.map(|rest| rest / limits.rest.unwrap_or(T::one()));
        let all = [Some(statistics.t2 / limits.t2), rest, Some(statistics.q / limits.q)];
        for (r, value) in r.iter_mut().zip(all.into_iter().flatten()) {
            *r = value;
        }
    }
}
