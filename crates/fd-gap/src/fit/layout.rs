//! The shape of a fit: unknowns that all segments share, and unknowns of each segment.

use std::ops::Range;

/// Sizes of a least-squares problem. Its unknowns are one vector: first those that all segments
/// share (parameters), then, segment by segment, those of its own (initial states).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Unknowns that every residual may depend on.
    pub shared: usize,
    /// Unknowns of each segment, of which only the residuals of that segment depend.
    pub own: usize,
    /// The residuals of each segment, in order and without gaps.
    pub segments: Vec<Range<usize>>,
}

impl Layout {
    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.shared + self.own * self.segments.len()
    }

    /// Number of residuals.
    #[must_use]
    pub fn residuals(&self) -> usize {
        self.segments.last().map_or(0, |rows| rows.end)
    }

    /// Place of the first unknown of a segment.
    #[must_use]
    pub fn first_own(&self, segment: usize) -> usize {
        self.shared + segment * self.own
    }
}

/// A sum of squares to be minimised, in scaled unknowns.
///
/// A simulator against logs is one ([`Problem`](super::Problem)); anything else with residuals and slopes
/// is another. Here a line through points, whose slope may not exceed 1.5:
///
/// ```
/// use std::ops::Range;
///
/// use fd_gap::fit::{Layout, LeastSquares, Search, minimise};
///
/// struct Line {
///     layout: Layout,
///     points: Vec<[f64; 2]>,
/// }
///
/// impl LeastSquares for Line {
///     fn layout(&self) -> &Layout { &self.layout }
///     fn bounds(&self) -> &[[f64; 2]] { &[[-10.0, 10.0], [-1.5, 1.5]] }
///     fn prior(&self) -> &[[f64; 2]] { &[[0.0, 0.0]; 2] }
///
///     fn residuals(&mut self, z: &[f64], r: &mut [f64]) -> bool {
///         for (r, [x, y]) in r.iter_mut().zip(&self.points) {
///             *r = z[0] + z[1] * x - y;
///         }
///         true
///     }
///
///     fn slopes(&mut self, _: &[f64], _: &[f64], columns: Range<usize>, slopes: &mut [Vec<f64>]) {
///         for column in columns {
///             for (slope, [x, _]) in slopes[column].iter_mut().zip(&self.points) {
///                 *slope = if column == 0 { 1.0 } else { *x };
///             }
///         }
///     }
/// }
///
/// let points = vec![[0.0, 0.0], [1.0, 2.0], [2.0, 4.0]];
/// let layout = Layout { shared: 2, own: 0, segments: vec![0..3] };
/// let minimum = minimise(&mut Line { layout, points }, &[0.0, 0.0], None, Search::default());
/// let z = minimum.map(|minimum| minimum.z).unwrap_or_default();
/// // At the edge of the box; the best level there takes half of the rest: mean(y) − 1.5 mean(x).
/// assert!((z[1] - 1.5).abs() < 1e-6 && (z[0] - 0.5).abs() < 1e-4, "{z:?}");
/// ```
pub trait LeastSquares {
    /// Sizes.
    fn layout(&self) -> &Layout;

    /// Lowest and highest value of each unknown.
    fn bounds(&self) -> &[[f64; 2]];

    /// Mean and precision of a Gaussian prior of each unknown, which adds
    /// `precision (z − mean)²` to the sum of squares.
    fn prior(&self) -> &[[f64; 2]];

    /// Writes the residuals; returns `false` when they are not finite.
    fn residuals(&mut self, z: &[f64], r: &mut [f64]) -> bool;

    /// Writes the slopes of the residuals `r` at `z`: one column per shared unknown from
    /// `columns.start` on, then one per own unknown, in which each segment has its own slope.
    /// Column numbers run over both kinds.
    fn slopes(&mut self, z: &[f64], r: &[f64], columns: Range<usize>, slopes: &mut [Vec<f64>]);

    /// Residuals and slopes of some columns at several places; `None` where the residuals are not
    /// finite. A problem that can look at several places at once overrides this.
    fn linearize(
        &mut self,
        places: &[Vec<f64>],
        columns: Range<usize>,
    ) -> Vec<Option<Linearization>> {
        let rows = self.layout().residuals();
        let mut all = Vec::with_capacity(places.len());
        for z in places {
            let mut r = vec![0.0; rows];
            let is_finite = self.residuals(z, &mut r);
            all.push(is_finite.then(|| {
                let mut slopes = vec![vec![0.0; rows]; columns.end];
                self.slopes(z, &r, columns.clone(), &mut slopes);
                slopes.drain(..columns.start);
                Linearization { r, slopes }
            }));
        }
        all
    }
}

/// Residuals at a place and how they change there.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// Residuals.
    pub r: Vec<f64>,
    /// Slopes, column by column, of the columns that were asked for.
    pub slopes: Vec<Vec<f64>>,
}
