//! The running generalised likelihood ratio.

use faer::Mat;
use fd_core::{
    Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use super::design::{Course, GlrDesign, Pattern};
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
///
/// Everything that depends on the age of an onset lies with the ages next to each other, so that one
/// sample is a few passes over short rows of equal work, one element for each onset.
#[derive(Clone, Debug)]
struct Running<T: Scalar> {
    course: Course,
    signature: Option<usize>,
    sizes: usize,
    window: usize,
    /// `F(t)ᵀ`, age by age up to [`Self::settled`], sizes by channels.
    effect: Vec<T>,
    /// Age from which `F` stays as it is; at most the last of the window.
    settled: usize,
    /// Rows of the lower triangle of `L⁻¹`, entry by entry, over the ages.
    root: Vec<T>,
    /// Components of `c`, over the ages.
    correlation: Vec<T>,
    /// A row of `L⁻¹ c`, and `l(k, t)`, over the ages.
    scaled: Vec<T>,
    ratio: Vec<T>,
}

impl<T: Scalar> Running<T> {
    fn new(pattern: &Pattern, window: usize) -> Self {
        let sizes = pattern.effect.first().map_or(0, Mat::ncols);
        let last = pattern.effect.last();
        let stays = |age: &usize| pattern.effect[*age..].iter().all(|f| Some(f) == last);
        let settled = (0..window).find(stays).unwrap_or(window - 1);
        let by_size = |f: &Mat<f64>| -> Vec<T> {
            (0..sizes)
                .flat_map(|i| (0..f.nrows()).map(move |c| T::from_design(f[(c, i)])))
                .collect()
        };
        let triangle = (0..sizes).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let root = triangle.flat_map(|at| pattern.root.iter().map(move |m| T::from_design(m[at])));
        Self {
            course: pattern.course,
            signature: pattern.signature,
            sizes,
            window,
            effect: pattern.effect[..=settled].iter().flat_map(by_size).collect(),
            settled,
            root: root.collect(),
            correlation: vec![T::zero(); sizes * window],
            scaled: vec![T::zero(); window],
            ratio: vec![T::zero(); window],
        }
    }

    /// Row `i`, column `j <= i` of `L⁻¹` over the ages.
    fn root(&self, i: usize, j: usize) -> &[T] {
        let entry = i * (i + 1) / 2 + j;
        &self.root[entry * self.window..(entry + 1) * self.window]
    }

    /// Makes all onsets one sample older, begins one, and adds `F(t)ᵀ e` to each of the `seen`.
    fn add(&mut self, white: &[T], seen: usize) {
        let per_age = self.sizes * white.len();
        for (i, sums) in self.correlation.chunks_exact_mut(self.window).enumerate() {
            sums.copy_within(..self.window - 1, 1);
            sums[0] = T::zero();
            let row = i * white.len()..(i + 1) * white.len();
            let step = |effect: &[T]| {
                effect[row.clone()].iter().zip(white).fold(T::zero(), |s, (&f, &e)| s + f * e)
            };
            let young = seen.min(self.settled);
            for (sum, effect) in sums[..young].iter_mut().zip(self.effect.chunks_exact(per_age)) {
                *sum += step(effect);
            }
            let settled = step(&self.effect[self.settled * per_age..]);
            sums[young..seen].iter_mut().for_each(|sum| *sum += settled);
        }
    }

    /// The most likely age of an onset, and its ratio.
    fn most_likely(&mut self, seen: usize) -> (usize, T) {
        self.ratio[..seen].fill(T::zero());
        let mut entries = self.root.chunks_exact(self.window);
        for i in 0..self.sizes {
            self.scaled[..seen].fill(T::zero());
            let sums = self.correlation.chunks_exact(self.window);
            for (root, sums) in entries.by_ref().take(i + 1).zip(sums) {
                let terms = root.iter().zip(sums);
                for (scaled, (&root, &sum)) in self.scaled[..seen].iter_mut().zip(terms) {
                    *scaled += root * sum;
                }
            }
            for (ratio, &scaled) in self.ratio[..seen].iter_mut().zip(&self.scaled) {
                *ratio += scaled * scaled;
            }
        }
        let first = (0, self.ratio[0]);
        (1..seen).fold(
            first,
            |best, age| {
                if self.ratio[age] > best.1 { (age, self.ratio[age]) } else { best }
            },
        )
    }

    /// `θ̂ = J⁻¹ c = L⁻ᵀ (L⁻¹ c)` of an onset.
    fn size_into(&self, age: usize, size: &mut [T]) {
        size.fill(T::zero());
        for i in 0..self.sizes {
            let scaled = (0..=i).fold(T::zero(), |sum, j| {
                sum + self.root(i, j)[age] * self.correlation[j * self.window + age]
            });
            for (j, size) in size.iter_mut().enumerate().take(i + 1) {
                *size += self.root(i, j)[age] * scaled;
            }
        }
    }
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
        let running = |pattern| Running::new(pattern, design.window);
        let patterns: Vec<Running<T>> = design.patterns.iter().map(running).collect();
        let sizes = patterns.iter().map(|p| p.sizes).max().unwrap_or(0);
        Ok(Self {
            whitener: Whitener::new(&design.whitener),
            patterns,
            window: design.window as u64,
            threshold: T::from_design(threshold),
            seen: 0,
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
        self.change = None;
        self.size.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.whitener.visit_state(visitor);
        for pattern in &mut self.patterns {
            visitor.reals("glr correlations", &mut pattern.correlation);
        }
        visitor.counts("glr seen", std::slice::from_mut(&mut self.seen));
        // A foreign snapshot must not point beyond the window.
        self.seen = self.seen.min(self.window);
    }
}

impl<T: Scalar> Detector<T> for Glr<T> {
    fn residual_len(&self) -> usize {
        self.whitener.channels()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        let white = self.whitener.update(r);
        self.seen = (self.seen + 1).min(self.window);
        // At most the window, which is the length of a `Vec`.
        let seen = usize::try_from(self.seen).unwrap_or(0);
        let mut likeliest: Option<(usize, usize, T)> = None;
        for (at, pattern) in self.patterns.iter_mut().enumerate() {
            pattern.add(white, seen);
            let (age, ratio) = pattern.most_likely(seen);
            if likeliest.is_none_or(|(_, _, most)| ratio > most) {
                likeliest = Some((at, age, ratio));
            }
        }
        let mut statistic = T::zero();
        self.change = None;
        if let Some((at, age, ratio)) = likeliest {
            let pattern = &self.patterns[at];
            statistic = ratio;
            let (course, signature) = (pattern.course, pattern.signature);
            self.change = Some(Change { course, signature, age: age as u64 + 1 });
            pattern.size_into(age, &mut self.size[..pattern.sizes]);
        }
        Verdict { statistic, threshold: self.threshold }
    }
}
