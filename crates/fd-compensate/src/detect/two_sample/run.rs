//! The running two-sample test.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use super::design::{SampleTest, check};
use crate::{
    detect::error::{DetectorError, positive},
    rows::SampleRows,
};

/// A sliding window of each channel against its fault-free samples, see the [module](super).
#[derive(Clone, Debug)]
pub struct TwoSample<T> {
    test: SampleTest,
    references: Vec<Reference<T>>,
    window: usize,
    threshold: T,
    /// The last samples, in a ring, channel by channel.
    recent: Vec<T>,
    /// The same in ascending order.
    ascending: Vec<T>,
    /// Samples so far, at most the window.
    seen: u64,
    next: u64,
}

/// What is known of one fault-free channel.
#[derive(Clone, Debug)]
struct Reference<T> {
    mean: T,
    /// Sum of squared deviations.
    squares: T,
    sorted: Vec<T>,
}

impl<T: Scalar> TwoSample<T> {
    /// The test of windows of `window` samples against fault-free residuals.
    ///
    /// ```
    /// use fd_compensate::{SampleRows, detect::{TwoSample, two_sample::SampleTest}};
    /// use fd_core::stage::Detector;
    ///
    /// let healthy = [-1.0, 0.0, 1.0, -1.0, 0.0, 1.0];
    /// let healthy = SampleRows::new(1, &healthy)?;
    /// let mut detector = TwoSample::new(SampleTest::Mean, healthy, 3, 3.0)?;
    /// assert!(!(0..3).any(|_| detector.update(&[], &[0.1]).alarm()));
    /// assert!((0..3).any(|_| detector.update(&[], &[5.0]).alarm()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when window or reference have fewer than two samples, a channel is constant, or the
    /// threshold is not positive and finite.
    pub fn new(
        test: SampleTest,
        healthy: SampleRows<'_>,
        window: usize,
        threshold: f64,
    ) -> Result<Self, DetectorError> {
        positive("threshold", threshold)?;
        check(window, healthy.len())?;
        let references: Vec<Reference<T>> = (0..healthy.channels())
            .map(|channel| {
                let mut sorted: Vec<f64> = healthy.channel(channel).collect();
                sorted.sort_unstable_by(f64::total_cmp);
                let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
                let squares: f64 = sorted.iter().map(|v| (v - mean) * (v - mean)).sum();
                if squares <= 0.0 {
                    let samples = sorted.len();
                    return Err(DetectorError::ConstantChannel { channel, samples });
                }
                Ok(Reference {
                    mean: T::from_design(mean),
                    squares: T::from_design(squares),
                    sorted: sorted.into_iter().map(T::from_design).collect(),
                })
            })
            .collect::<Result<_, _>>()?;
        let zeros = vec![T::zero(); window * references.len()];
        Ok(Self {
            test,
            references,
            window,
            threshold: T::from_design(threshold),
            recent: zeros.clone(),
            ascending: zeros,
            seen: 0,
            next: 0,
        })
    }

    /// The same statistic with another threshold.
    ///
    /// # Errors
    ///
    /// Returns an error when the threshold is not positive and finite.
    pub fn with_threshold(mut self, threshold: f64) -> Result<Self, DetectorError> {
        positive("threshold", threshold)?;
        self.threshold = T::from_design(threshold);
        Ok(self)
    }
}

impl<T: Scalar> Reference<T> {
    fn statistic(&self, test: SampleTest, recent: &[T], ascending: &[T]) -> T {
        match test {
            SampleTest::Mean => self.student(recent),
            SampleTest::Variance => self.fisher(recent),
            SampleTest::Distribution => self.kolmogorov(ascending),
        }
    }

    fn student(&self, recent: &[T]) -> T {
        let (n, reference, one) = (count(recent.len()), count(self.sorted.len()), T::one());
        let (mean, squares) = moments(recent);
        let pooled = (squares + self.squares) / (n + reference - one - one);
        (mean - self.mean).abs() / (pooled * (one / n + one / reference)).sqrt()
    }

    fn fisher(&self, recent: &[T]) -> T {
        let degrees = |n: usize| count::<T>(n) - T::one();
        // A dead signal has no variance at all; the logarithm stays finite.
        let squares = moments(recent).1.max(self.squares * T::from_design(1e-30));
        let ratio = squares / degrees(recent.len()) * degrees(self.sorted.len()) / self.squares;
        ratio.ln().abs()
    }

    fn kolmogorov(&self, ascending: &[T]) -> T {
        let (n, reference) = (count::<T>(ascending.len()), count::<T>(self.sorted.len()));
        let steps = ascending.iter().enumerate().map(|(i, &v)| {
            let below = count::<T>(self.sorted.partition_point(|&s| s < v)) / reference;
            let up_to = count::<T>(self.sorted.partition_point(|&s| s <= v)) / reference;
            // The window's own distribution steps from i/n to (i+1)/n here; of equal values only the ends
            // of their common step count.
            let begins = i == 0 || ascending[i - 1] < v;
            let ends = i + 1 == ascending.len() || v < ascending[i + 1];
            let over = if ends { count::<T>(i + 1) / n - up_to } else { T::zero() };
            let under = if begins { below - count::<T>(i) / n } else { T::zero() };
            over.max(under)
        });
        let largest = steps.fold(T::zero(), T::max);
        largest * (n * reference / (n + reference)).sqrt()
    }
}

fn count<T: Scalar>(n: usize) -> T {
    T::from_design(n as f64)
}

/// Mean and sum of squared deviations.
fn moments<T: Scalar>(values: &[T]) -> (T, T) {
    let mean = values.iter().fold(T::zero(), |sum, &v| sum + v) / count(values.len());
    (mean, values.iter().fold(T::zero(), |sum, &v| sum + (v - mean) * (v - mean)))
}

/// Puts `new` in the place of `old` in an ascending list.
fn exchange<T: Scalar>(ascending: &mut [T], old: T, new: T) {
    let mut at = ascending.partition_point(|&v| v < old).min(ascending.len() - 1);
    ascending[at] = new;
    while at > 0 && ascending[at] < ascending[at - 1] {
        ascending.swap(at, at - 1);
        at -= 1;
    }
    while at + 1 < ascending.len() && ascending[at + 1] < ascending[at] {
        ascending.swap(at, at + 1);
        at += 1;
    }
}

impl<T: Scalar> Stage<T> for TwoSample<T> {
    fn reset(&mut self) {
        self.recent.fill(T::zero());
        self.ascending.fill(T::zero());
        self.seen = 0;
        self.next = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("two-sample window", &mut self.recent);
        visitor.reals("two-sample ascending", &mut self.ascending);
        let mut counts = [self.seen, self.next];
        visitor.counts("two-sample seen, next", &mut counts);
        // A foreign snapshot must not point beyond the ring.
        let window = self.window as u64;
        [self.seen, self.next] = [counts[0].min(window), counts[1] % window];
    }
}

impl<T: Scalar> Detector<T> for TwoSample<T> {
    fn residual_len(&self) -> usize {
        self.references.len()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        // Below the length of a `Vec`, so it fits.
        let slot = usize::try_from(self.next).unwrap_or(0);
        let window = self.window as u64;
        self.next = (self.next + 1) % window;
        self.seen = (self.seen + 1).min(window);
        let is_full = self.seen == window;
        let mut statistic = T::zero();
        let recent = self.recent.chunks_exact_mut(self.window);
        let ascending = self.ascending.chunks_exact_mut(self.window);
        for (((reference, recent), ascending), &r) in
            self.references.iter().zip(recent).zip(ascending).zip(r)
        {
            exchange(ascending, recent[slot], r);
            recent[slot] = r;
            if is_full {
                statistic = statistic.max(reference.statistic(self.test, recent, ascending));
            }
        }
        Verdict { statistic, threshold: self.threshold }
    }
}
