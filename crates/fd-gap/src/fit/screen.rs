//! What a change of the outputs could explain, once the nuisances have done what they can within their boxes.

use fd_numeric::wide::{dot, dots};

use super::{
    arrow::Arrow,
    cholesky::Cholesky,
    layout::{Layout, LeastSquares},
    levenberg::Minimum,
    within::lowest_within,
};

/// Part of a change that is taken for left once the nuisances have taken theirs; less is rounding, and much more would weigh
/// more than what is known of the nuisances.
const INVISIBLE: f64 = 1e-13;

/// What slopes promise of a change of the outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// How many times the change the residual asks for.
    pub amplitude: f64,
    /// The sum of squares that is left.
    pub left: f64,
    /// Where the nuisances go.
    pub nuisances: Vec<f64>,
}

/// A sum of squares around a place, as its slopes have it: quadratic, in the boxes of the unknowns.
#[derive(Clone, Debug)]
pub struct Surroundings<'a> {
    layout: Layout,
    at: &'a Minimum,
    equations: Arrow,
    /// How far each unknown is from its edges.
    room: Vec<[f64; 2]>,
    /// The sum of squares that is left without any change.
    left: f64,
}

/// A change of the residuals: its products with slopes, with itself and with the residuals, and the amplitudes it may have.
struct Change {
    slopes: Vec<f64>,
    itself: f64,
    residuals: f64,
    range: [f64; 2],
}

impl<'a> Surroundings<'a> {
    /// Those of a place of a problem; `None` when its equations are singular.
    ///
    /// A level and its points, of which the last one may be off:
    ///
    /// ```
    /// use std::ops::Range;
    ///
    /// use fd_gap::fit::{Layout, LeastSquares, Search, Surroundings, minimise};
    ///
    /// struct Level(Layout);
    ///
    /// impl LeastSquares for Level {
    ///     fn layout(&self) -> &Layout { &self.0 }
    ///     fn bounds(&self) -> &[[f64; 2]] { &[[-10.0, 10.0]] }
    ///     fn prior(&self) -> &[[f64; 2]] { &[[0.0, 0.0]] }
    ///     fn residuals(&mut self, z: &[f64], r: &mut [f64]) -> bool {
    ///         r.iter_mut().zip([1.0, 1.0, 4.0]).for_each(|(r, y)| *r = z[0] - y);
    ///         true
    ///     }
    ///     fn slopes(&mut self, _: &[f64], _: &[f64], _: Range<usize>, slopes: &mut [Vec<f64>]) {
    ///         slopes[0].fill(1.0);
    ///     }
    /// }
    ///
    /// let mut level = Level(Layout { shared: 1, own: 0, segments: vec![0..3] });
    /// let mean = minimise(&mut level, &[0.0], None, Search::default()).ok_or("no minimum")?;
    /// let around = Surroundings::new(&level, &mean).ok_or("singular")?;
    /// let score = around.score(&[0.0, 0.0, 1.0], [-5.0, 5.0]).ok_or("singular")?;
    /// // The level goes from 2 to 1, the last point is 3 above it, and nothing is left of 1 + 1 + 4.
    /// assert!((score.nuisances[0] - 1.0).abs() < 1e-3 && (score.amplitude - 3.0).abs() < 1e-3);
    /// assert!((around.left() - 6.0).abs() < 1e-3 && score.left < 1e-3);
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub fn new(problem: &dyn LeastSquares, at: &'a Minimum) -> Option<Self> {
        let mut equations = at.equations(problem, 1.0);
        equations.fix_idle();
        let bounds = problem.bounds().iter().zip(&at.z);
        let room = bounds.map(|([low, high], z)| [(low - z).min(0.0), (high - z).max(0.0)]);
        let (layout, room) = (problem.layout().clone(), room.collect());
        let mut here = Self { layout, at, equations, room, left: at.cost };
        here.left = here.score(&vec![0.0; at.r.len()], [0.0, 0.0])?.left;
        Some(here)
    }

    /// The place.
    #[must_use]
    pub fn at(&self) -> &Minimum {
        self.at
    }

    /// The sum of squares that is left without any change.
    #[must_use]
    pub fn left(&self) -> f64 {
        self.left
    }

    /// Score of a change of the residuals by an amplitude within `range`: the least that `‖r + JΔ + a d‖²` and the prior leave,
    /// `J` being the slopes and `d` the change.
    #[must_use]
    pub fn score(&self, change: &[f64], range: [f64; 2]) -> Option<Score> {
        let ns = self.layout.shared;
        let mut seen = vec![0.0; self.layout.unknowns()];
        for (s, rows) in self.layout.segments.iter().enumerate() {
            let slopes = self.at.slopes.iter().map(|slope| &slope[rows.clone()]);
            let slopes: Vec<&[f64]> = slopes.collect();
            for (i, product) in dots(&change[rows.clone()], &slopes).into_iter().enumerate() {
                let place = if i < ns { i } else { self.layout.first_own(s) + i - ns };
                seen[place] += product;
            }
        }
        let itself = (1.0 + INVISIBLE) * dot(change, change);
        let change = Change { slopes: seen, itself, residuals: dot(change, &self.at.r), range };
        // Own unknowns are many, and few of them come to their edges.
        let mut bounded = Vec::new();
        loop {
            let (step, amplitude, left) = self.lowest(&change, &bounded)?;
            let is_out = |i: &usize| !(self.room[*i][0]..=self.room[*i][1]).contains(&step[*i]);
            let own = (ns..step.len()).filter(|i| !bounded.contains(i));
            let out: Vec<usize> = own.filter(is_out).collect();
            if out.is_empty() {
                let nuisances = self.at.z.iter().zip(step).map(|(z, step)| z + step).collect();
                return Some(Score { amplitude, left: left.max(0.0), nuisances });
            }
            bounded.extend(out);
        }
    }

    /// The step of the unknowns and the amplitude of a change that leave least, and what they leave, in the boxes of the shared
    /// unknowns and of those own ones that are `bounded`.
    fn lowest(&self, change: &Change, bounded: &[usize]) -> Option<(Vec<f64>, f64, f64)> {
        let (ns, no) = (self.layout.shared, self.layout.own);
        let known: Vec<usize> = (0..ns).chain(bounded.iter().copied()).collect();
        let n = known.len();
        let entry = |i: usize, j: usize| self.equations.entry(i.max(j), i.min(j));
        let mut a = vec![0.0; (n + 1) * (n + 1)];
        for (i, row) in a.chunks_mut(n + 1).enumerate() {
            for (j, value) in row.iter_mut().enumerate().take(i + 1) {
                *value = match (known.get(i), known.get(j)) {
                    (Some(i), Some(j)) => entry(*i, *j),
                    (_, Some(j)) => change.slopes[*j],
                    _ => change.itself,
                };
            }
        }
        let mut g: Vec<f64> = known.iter().map(|i| self.equations.gradient[*i]).collect();
        g.push(change.residuals);
        let mut left = self.at.cost;
        // The free unknowns of each segment, their factor, and what they have to do with the others, the amplitude and the
        // gradient, of which the last two have every segment.
        let mut eliminated = Vec::with_capacity(self.layout.segments.len());
        for s in 0..self.layout.segments.len() {
            let first = self.layout.first_own(s);
            let free: Vec<usize> = (first..first + no).filter(|i| !bounded.contains(i)).collect();
            let block = free.iter().flat_map(|i| free.iter().map(|j| entry(*i, *j)));
            let factor = Cholesky::new(&block.collect::<Vec<f64>>(), free.len())?;
            let with = |column: &dyn Fn(usize) -> f64| {
                let mut column: Vec<f64> = free.iter().map(|i| column(*i)).collect();
                factor.forward(&mut column);
                column
            };
            let is_near = |j: &usize| *j < ns || (first..first + no).contains(j);
            let near = known.iter().enumerate().filter(|(_, j)| is_near(j));
            let mut columns: Vec<(usize, Vec<f64>)> =
                near.map(|(at, j)| (at, with(&|i| entry(i, *j)))).collect();
            columns.push((n, with(&|i| change.slopes[i])));
            let gradient = with(&|i| self.equations.gradient[i]);
            for (k, (i, column)) in columns.iter().enumerate() {
                for (j, other) in &columns[..=k] {
                    a[i * (n + 1) + j] -= fd_numeric::dot(column, other);
                }
                g[*i] -= fd_numeric::dot(column, &gradient);
            }
            left -= fd_numeric::dot(&gradient, &gradient);
            eliminated.push((free, factor, columns, gradient));
        }
        let room = known.iter().map(|i| self.room[*i]).chain([change.range]);
        let x = lowest_within(&a, &g, &room.collect::<Vec<_>>())?;
        let curved = |i: usize| {
            let row = &a[i * (n + 1)..];
            x[i] * ((0..i).map(|j| row[j] * x[j]).sum::<f64>() + 0.5 * row[i] * x[i])
        };
        left += 2.0 * (fd_numeric::dot(&g, &x) + (0..=n).map(curved).sum::<f64>());
        let mut step = vec![0.0; self.room.len()];
        known.iter().zip(&x).for_each(|(i, x)| step[*i] = *x);
        for (free, factor, columns, mut own) in eliminated {
            for (j, column) in columns {
                own.iter_mut().zip(column).for_each(|(own, entry)| *own += entry * x[j]);
            }
            factor.backward(&mut own);
            free.into_iter().zip(own).for_each(|(i, own)| step[i] = -own);
        }
        Some((step, x[n], left))
    }
}
