//! The past values of a delayed expression.

use fd_core::{Scalar, StateVisitor};

use crate::equation::Value;

/// Longest delay, in integration steps; a longer one is cut.
const LONGEST: f64 = 1_048_576.0;

/// An expression during an integration step: at its start, in its middle and at its end, before inputs jump. A parabola
/// goes through these.
pub(super) type Course<V> = [V; 3];

/// What integrates a polynomial of degree five over the unit interval exactly: places and weights (Gauss).
const GAUSS: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_31, 5.0 / 18.0],
    [0.5, 8.0 / 18.0],
    [0.887_298_334_620_741_7, 5.0 / 18.0],
];

/// A ring of the courses that an expression took during integration steps.
#[derive(Clone, Debug)]
pub(super) struct DelayLine<V> {
    past: Vec<Course<V>>,
    /// Place of the course of this step.
    now: usize,
    /// Whole steps of the delay of each lane.
    whole: Vec<usize>,
    /// What is left, as a fraction of a step.
    fraction: V,
    /// What three numbers of the older course and three of the newer one give to each of [`Self::course`].
    weights: Course<[V; 6]>,
    /// Number of values so far.
    age: u64,
}

impl DelayLine<f64> {
    /// Shows the past values and the place in the ring.
    pub(super) fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals_with_holes("past values of a delay", self.past.as_flattened_mut());
        let mut counts = [self.now as u64, self.age];
        visitor.counts("place and age of a delay", &mut counts);
        // A number from a file is brought into range.
        self.now = usize::try_from(counts[0]).unwrap_or(0) % self.past.len().max(1);
        self.age = counts[1];
    }
}

impl<V: Value> DelayLine<V> {
    pub(super) fn new() -> Self {
        let zero = V::constant(0.0);
        let whole = vec![0; V::LANES];
        Self { past: Vec::new(), now: 0, whole, fraction: zero, weights: [[zero; 6]; 3], age: 0 }
    }

    /// Forgets the past and sets the delay, in integration steps. Allocates only for a delay that
    /// is longer than any before.
    pub(super) fn start(&mut self, steps: V) {
        for (lane, to) in self.whole.iter_mut().enumerate() {
            let steps = steps.lane(lane);
            let whole = steps.to_report().clamp(0.0, LONGEST).floor();
            let is_cut = whole >= LONGEST;
            let left =
                if is_cut { Scalar::from_design(0.0) } else { steps - Scalar::from_design(whole) };
            self.fraction.set_lane(lane, left);
            for (to, weights) in self.weights.iter_mut().zip(weights(left)) {
                to.iter_mut().zip(weights).for_each(|(to, weight)| to.set_lane(lane, weight));
            }
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped; NaN is 0"
            )]
            let whole = whole as usize;
            *to = whole;
            self.past.resize(self.past.len().max(whole + 2), [V::constant(0.0); 3]);
        }
        self.age = 0;
    }

    /// Moves on to the next step, at the start of which the expression has this value.
    pub(super) fn push(&mut self, value: V) {
        self.now = if self.now + 1 < self.past.len() { self.now + 1 } else { 0 };
        self.age += 1;
        self.correct(value);
    }

    /// Replaces the value at the start of this step, which it is taken to keep.
    pub(super) fn correct(&mut self, value: V) {
        if self.age == 1 {
            // Before the run, nothing moved.
            self.past.fill([value; 3]);
        } else {
            self.past[self.now] = [value; 3];
        }
    }

    /// Says where the expression went in this step.
    pub(super) fn finish(&mut self, middle: V, end: V) {
        let [_, to_middle, to_end] = &mut self.past[self.now];
        (*to_middle, *to_end) = (middle, end);
    }

    /// The delayed value at the start of this step; the mean over the step of an expression that is held for steps.
    pub(super) fn value(&self) -> V {
        let [older, newer] = self.courses();
        let chord =
            newer[0].zip3(older[0], self.fraction, |newer, older, f| newer + (older - newer) * f);
        let two = V::Lane::from_design(2.0);
        let bend = older[1]
            .zip3(older[0], older[2], |middle, start, end| two * (two * middle - start - end));
        let one = V::Lane::from_design(1.0);
        chord.zip3(bend, self.fraction, |chord, bend, f| chord + bend * f * (one - f))
    }

    /// For an expression that is held for steps: what arrives before it jumps in this step, what arrives after, and where
    /// that is, as a fraction of the step; 0 in a lane in which it does not jump.
    pub(super) fn jump(&self) -> [V; 3] {
        let [older, newer] = self.courses().map(|course| course[0]);
        let at = self.fraction.zip3(older, newer, |at, older, newer| {
            if older == newer { V::Lane::from_design(0.0) } else { at }
        });
        [older, newer, at]
    }

    /// The delayed value over this step: the parabola that is nearest to it, with its mean.
    pub(super) fn course(&self) -> Course<V> {
        let [older, newer] = self.courses();
        self.weights.map(|weights| {
            let all = older.into_iter().chain(newer).zip(weights);
            all.fold(V::constant(0.0), |sum, (value, weight)| {
                sum.zip3(value, weight, |sum, value, weight| sum + value * weight)
            })
        })
    }

    /// The two courses that the delayed value goes through in this step.
    fn courses(&self) -> [Course<V>; 2] {
        // At most as many steps ago as the ring is long.
        let ago = |steps: usize| {
            let wrapped = if steps <= self.now { 0 } else { self.past.len() };
            &self.past[self.now + wrapped - steps]
        };
        let mut both = [[V::constant(0.0); 3]; 2];
        for (lane, whole) in self.whole.iter().enumerate() {
            for (course, from) in both.iter_mut().zip([ago(*whole + 1), ago(*whole)]) {
                course.iter_mut().zip(from).for_each(|(to, v)| to.set_lane(lane, v.lane(lane)));
            }
        }
        both
    }
}

/// The value of a course at a place in its step.
pub(super) fn along<V: Value>(course: &Course<V>, at: V) -> V {
    let of = V::Lane::from_design;
    let (one, two, four) = (of(1.0), of(2.0), of(4.0));
    let start = course[0].zip(at, |start, s| start * (one - s) * (one - two * s));
    let middle = course[1].zip(at, |middle, s| four * s * (one - s) * middle);
    let end = course[2].zip(at, |end, s| s * (two * s - one) * end);
    start.zip3(middle, end, |start, middle, end| start + middle + end)
}

/// What older and newer courses weigh in the start, the middle and the end of a delayed one, whose first `f` of a step is
/// the last `f` of the older one. It is the projection to parabolas, by Legendre polynomials: the mean is kept, also where
/// an expression jumps from one step to the next.
fn weights<T: Scalar>(f: T) -> [[T; 6]; 3] {
    let of = T::from_design;
    let (zero, one, two) = (of(0.0), of(1.0), of(2.0));
    let mut moments = [[zero; 6]; 3];
    for (piece, from, length, shift) in [(0, zero, f, one - f), (3, f, one - f, zero - f)] {
        for [place, weight] in GAUSS {
            let s = from + length * of(place);
            let (at, x) = (s + shift, two * s - one);
            let parabola =
                [(one - at) * (one - two * at), of(4.0) * at * (one - at), at * (two * at - one)];
            let legendre = [one, of(3.0) * x, of(2.5) * (of(3.0) * x * x - one)];
            for (moment, legendre) in moments.iter_mut().zip(legendre) {
                for (to, value) in moment[piece..].iter_mut().zip(parabola) {
                    *to += of(weight) * length * legendre * value;
                }
            }
        }
    }
    let [mean, slope, bend] = moments;
    let at = |slopes: T, bends: T| -> [T; 6] {
        std::array::from_fn(|i| mean[i] + slopes * slope[i] + bends * bend[i])
    };
    [at(zero - one, one), at(zero, of(-0.5)), at(one, one)]
}
