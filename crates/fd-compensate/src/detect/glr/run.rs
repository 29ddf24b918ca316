//! The running generalised likelihood ratio.

use fd_core::{
    HeapMap, LinMap, Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use super::design::{Course, GlrDesign};
use crate::detect::{
    error::{DetectorError, positive},
    whiten::Whitener,
};

/// `g(k) = max l(k, t)`: twice the logarithm of the generalised likelihood ratio, see the
/// [module](super).
#[derive(Clone, Debug)]
pub struct Glr<T: Scalar> {
    whitener: Whitener<T>,
    patterns: Vec<Running<T>>,
    window: u64,
    threshold: T,
    /// Samples since the last reset, as far as they matter: at most the window.
    seen: u64,
    /// Ring slot of the oldest onset, where the next one goes.
    next: u64,
    change: Option<Change>,
    size: Vec<T>,
}

/// The most likely change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// How it develops.
    pub course: Course,
    /// Index of its signature; `None` for any direction.
    pub signature: Option<usize>,
    /// Samples that it has lasted, the present one included.
    pub age: u64,
}

/// Run-time form of one course along one signature or all directions.
#[derive(Clone, Debug)]
struct Running<T: Scalar> {
    course: Course,
    signature: Option<usize>,
    /// `F(t)ᵀ`.
    effect: Vec<HeapMap<T>>,
    root: Vec<HeapMap<T>>,
    sizes: usize,
    /// `c` of each onset, in a ring.
    correlation: Vec<T>,
    scaled: Vec<T>,
}

impl<T: Scalar> Glr<T> {
    /// The detector of a design, with a threshold for `2 ln Λ`.
    ///
    /// ```
    /// use fd_compensate::{
    ///     SampleRows,
    ///     detect::{Glr, glr::{Course, GlrDesign}, whiten::WhitenerDesign},
    /// };
    /// use fd_core::stage::Detector;
    ///
    /// let healthy: Vec<f64> = (0..500).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
    /// let whitener = WhitenerDesign::from_fault_free(SampleRows::new(1, &healthy)?, 0)?;
    /// let design = GlrDesign::any_direction(whitener, &[Course::Step], 20)?;
    /// let mut detector = Glr::new(&design, 30.0)?;
    /// let alarms = (0..20).filter(|_| detector.update(&[], &[2.0]).alarm()).count();
    /// assert!(alarms > 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the threshold is not positive and finite.
    pub fn new(design: &GlrDesign, threshold: f64) -> Result<Self, DetectorError> {
        positive("threshold", threshold)?;
        let patterns: Vec<Running<T>> = design
            .patterns
            .iter()
            .map(|pattern| {
                let sizes = pattern.effect.first().map_or(0, faer::Mat::ncols);
                let frozen = |m: &faer::Mat<f64>, transposed: bool| {
                    let (rows, cols) =
                        if transposed { (m.ncols(), m.nrows()) } else { (m.nrows(), m.ncols()) };
                    HeapMap::from_fn(rows, cols, |i, j| {
                        T::from_design(if transposed { m[(j, i)] } else { m[(i, j)] })
                    })
                };
                Running {
                    course: pattern.course,
                    signature: pattern.signature,
                    effect: pattern.effect.iter().map(|m| frozen(m, true)).collect(),
                    root: pattern.root.iter().map(|m| frozen(m, false)).collect(),
                    sizes,
                    correlation: vec![T::zero(); sizes * design.window],
                    scaled: vec![T::zero(); sizes],
                }
            })
            .collect();
        let sizes = patterns.iter().map(|p| p.sizes).max().unwrap_or(0);
        Ok(Self {
            whitener: Whitener::new(&design.whitener),
            patterns,
            window: design.window as u64,
            threshold: T::from_design(threshold),
            seen: 0,
            next: 0,
            change: None,
            size: vec![T::zero(); sizes],
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

    /// The change that the last statistic belongs to; `None` before the first sample.
    #[must_use]
    pub fn change(&self) -> Option<Change> {
        self.change
    }

    /// The most likely size `θ̂` of that change, one number along a signature, one for each channel in any
    /// direction.
    #[must_use]
    pub fn size(&self) -> &[T] {
        let is_one = self.change.is_none_or(|change| change.signature.is_some());
        &self.size[..if is_one { 1.min(self.size.len()) } else { self.size.len() }]
    }
}

impl<T: Scalar> Stage<T> for Glr<T> {
    fn reset(&mut self) {
        self.whitener.reset();
        for pattern in &mut self.patterns {
            pattern.correlation.fill(T::zero());
        }
        self.seen = 0;
        self.next = 0;
        self.change = None;
        self.size.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.whitener.visit_state(visitor);
        for pattern in &mut self.patterns {
            visitor.reals("glr correlations", &mut pattern.correlation);
        }
        let mut counts = [self.seen, self.next];
        visitor.counts("glr seen, next", &mut counts);
        // A foreign snapshot must not point beyond the ring.
        [self.seen, self.next] = [counts[0].min(self.window), counts[1] % self.window];
    }
}

impl<T: Scalar> Detector<T> for Glr<T> {
    fn residual_len(&self) -> usize {
        self.whitener.channels()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        let white = self.whitener.update(r);
        let start = self.next;
        self.next = (self.next + 1) % self.window;
        self.seen = (self.seen + 1).min(self.window);
        let mut statistic = T::zero();
        self.change = None;
        for pattern in &mut self.patterns {
            let Running { sizes, .. } = *pattern;
            for age in 0..self.seen {
                // Ring slots and ages are below the length of a `Vec`, so they fit.
                let slot = usize::try_from((start + self.window - age) % self.window).unwrap_or(0);
                let at = usize::try_from(age).unwrap_or(0);
                let sums = &mut pattern.correlation[slot * sizes..(slot + 1) * sizes];
                if age == 0 {
                    sums.fill(T::zero());
                }
                pattern.effect[at].mul_add_into(white, sums);
                pattern.root[at].mul_into(sums, &mut pattern.scaled);
                let ratio = pattern.scaled.iter().fold(T::zero(), |sum, &v| sum + v * v);
                if self.change.is_none() || ratio > statistic {
                    statistic = ratio;
                    let (course, signature) = (pattern.course, pattern.signature);
                    self.change = Some(Change { course, signature, age: age + 1 });
                    // θ̂ = J⁻¹ c = L⁻ᵀ (L⁻¹ c).
                    let root = &pattern.root[at];
                    for (i, size) in self.size[..sizes].iter_mut().enumerate() {
                        let column = (0..sizes).map(|j| root[(j, i)] * pattern.scaled[j]);
                        *size = column.fold(T::zero(), |sum, v| sum + v);
                    }
                }
            }
        }
        Verdict { statistic, threshold: self.threshold }
    }
}
