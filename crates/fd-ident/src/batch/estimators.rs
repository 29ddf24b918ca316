//! The estimators themselves.

use fd_core::{
    StateVisitor,
    stage::{GuardReport, Stage},
};
use fd_numeric::lanes::Machine;
use rayon::prelude::*;

use super::{
    design::LaneDesign,
    error::BatchError,
    layout::{Layout, Regressors},
    samples::SampleBlock,
    scalar::BatchScalar,
    tile::{Pass, Tally},
};
use crate::{arx::ArxOrders, rls::RlsDesign};

/// Samples of tiles that one core works on before it takes others: some ten microseconds, enough to
/// make the taking cheap, and few enough for no core to wait long for the last one.
const SAMPLES_PER_TASK: usize = 512;

/// Recursive least squares for many estimators of the same number of parameters.
///
/// Estimates start from zero. A frozen estimator keeps its estimate and its memory and sees no
/// samples.
///
/// # Examples
///
/// A thousand estimators of `y = 2 φ₁ − φ₂`, each with samples of its own:
///
/// ```
/// use fd_ident::{batch::{BatchRls, SampleBlock}, rls::RlsDesign};
///
/// let mut fleet = BatchRls::<f64>::new(2, 1000, &RlsDesign::default())?;
/// let mut block = SampleBlock::new(2, 1000, 3);
/// for unit in 0..1000 {
///     for (k, phi) in [[1.0, 0.0], [1.0, unit as f64], [0.0, 3.0]].into_iter().enumerate() {
///         block.set(unit, k, &phi, 2.0 * phi[0] - phi[1]);
///     }
/// }
/// fleet.update(&block)?;
/// let mut theta = [0.0; 2];
/// fleet.theta_into(999, &mut theta);
/// assert!((theta[0] - 2.0).abs() < 1e-5 && (theta[1] + 1.0).abs() < 1e-5);
/// # Ok::<(), fd_ident::batch::BatchError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BatchRls<T: BatchScalar> {
    machine: Machine,
    layout: Layout,
    /// Whether any estimator forgets directionally.
    is_directional: bool,
    tiles: Vec<T::Row>,
    tallies: Vec<Tally<T>>,
    lanes: Vec<Lane<T>>,
}

/// What no register needs to hold of an estimator.
#[derive(Clone, Copy, Debug)]
struct Lane<T> {
    prior_variance: T,
    /// Samples with `φᵀPφ` of this or less are skipped.
    silence: T,
    is_frozen: bool,
    report: GuardReport,
}

impl<T: BatchScalar> BatchRls<T> {
    /// So many estimators of `parameters` parameters, all of the same design.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of range, the kind of forgetting is not one that
    /// lanes can share, or there are no parameters or more than 64.
    pub fn new(
        parameters: usize,
        estimators: usize,
        design: &RlsDesign,
    ) -> Result<Self, BatchError> {
        Self::with_layout(
            Layout { n: parameters, regressors: Regressors::Given },
            estimators,
            design,
        )
    }

    /// So many estimators of one difference equation each, that make their regressors from the
    /// input and bias of each sample, as [`RecursiveArx`](crate::arx::RecursiveArx) does for one
    /// residual channel. Blocks then have a column per input, and the bias as target: a third of
    /// the numbers, which is what the memory of a large fleet has to deliver.
    ///
    /// The first [`ArxOrders::lag`] samples, whose past has not been seen, count as skipped, and
    /// so do those whose past is missing.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], and when the past of the equation has more than 32 values.
    ///
    /// # Examples
    ///
    /// ```
    /// use fd_ident::{arx::ArxOrders, batch::{BatchRls, SampleBlock}, rls::RlsDesign};
    ///
    /// // μ(k) = 0.5 μ(k−1) + 2 u(k), on a hundred units
    /// let design = RlsDesign::default();
    /// let mut fleet = BatchRls::<f64>::arx(ArxOrders::new(1, 1, 0), 1, 100, &design)?;
    /// let mut block = SampleBlock::new(1, 100, 8);
    /// for unit in 0..100 {
    ///     let mut mu = 0.0;
    ///     for k in 0..8 {
    ///         let u = f64::from((k * 7 + unit) % 5);
    ///         mu = 0.5 * mu + 2.0 * u;
    ///         block.set(unit as usize, k as usize, &[u], mu);
    ///     }
    /// }
    /// fleet.update(&block)?;
    /// let mut theta = [0.0; 2];
    /// fleet.theta_into(42, &mut theta);
    /// assert!((theta[0] + 0.5).abs() < 1e-6 && (theta[1] - 2.0).abs() < 1e-6);
    /// # Ok::<(), fd_ident::batch::BatchError>(())
    /// ```
    pub fn arx(
        orders: ArxOrders,
        nu: usize,
        estimators: usize,
        design: &RlsDesign,
    ) -> Result<Self, BatchError> {
        let regressors = Regressors::Past { orders, nu };
        let (inputs, bias) = regressors.past();
        let most = Layout::LONGEST;
        if inputs + bias > most {
            return Err(BatchError::Past { most, found: inputs + bias });
        }
        Self::with_layout(Layout { n: orders.parameters(nu), regressors }, estimators, design)
    }

    fn with_layout(
        layout: Layout,
        estimators: usize,
        design: &RlsDesign,
    ) -> Result<Self, BatchError> {
        let (most, found) = (Layout::LARGEST, layout.n);
        if found == 0 || found > most {
            return Err(BatchError::Parameters { most, found });
        }
        let tiles = estimators.div_ceil(T::WIDTH);
        let zero = T::zero();
        let lane = Lane {
            prior_variance: zero,
            silence: zero,
            is_frozen: false,
            report: GuardReport::default(),
        };
        let mut batch = Self {
            machine: Machine::detect(),
            layout,
            is_directional: false,
            tiles: vec![T::row(zero); tiles * layout.rows()],
            tallies: vec![[T::row(zero); 2]; tiles],
            lanes: vec![lane; estimators],
        };
        // Lanes that no estimator uses have the settings of the others too.
        for lane in 0..tiles * T::WIDTH {
            batch.design(lane, design)?;
        }
        Ok(batch)
    }

    /// The same estimators on other instructions of this processor, to compare them.
    #[must_use]
    pub fn on(self, machine: Machine) -> Self {
        Self { machine, ..self }
    }

    /// Number of parameters of each estimator.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.layout.n
    }

    /// Number of estimators.
    #[must_use]
    pub fn estimators(&self) -> usize {
        self.lanes.len()
    }

    /// Gives one estimator a design of its own and starts it again.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn redesign(&mut self, estimator: usize, design: &RlsDesign) -> Result<(), BatchError> {
        self.design(estimator, design)
    }

    fn design(&mut self, lane: usize, design: &RlsDesign) -> Result<(), BatchError> {
        let LaneDesign { prior_variance, settings } = LaneDesign::<T>::new(self.layout.n, design)?;
        let silence = settings.silence;
        self.is_directional |= settings.kept < T::one();
        self.put(lane, Layout::NOISE, settings.noise);
        self.put(lane, Layout::MINUS_SCALE, settings.minus_scale);
        self.put(lane, Layout::SILENCE, silence);
        self.put(lane, Layout::GROWTH, settings.growth);
        self.put(lane, Layout::LARGEST_TRACE, settings.largest_trace);
        self.put(lane, Layout::KEPT, settings.kept);
        self.restart(lane, prior_variance);
        if let Some(lane) = self.lanes.get_mut(lane) {
            let report = GuardReport::default();
            *lane = Lane { prior_variance, silence, is_frozen: false, report };
        }
        Ok(())
    }

    fn restart(&mut self, lane: usize, prior_variance: T) {
        let (layout, n) = (self.layout, self.layout.n);
        for row in Layout::D + n..layout.past() {
            self.put(lane, row, T::zero());
        }
        // A past that has not been seen is missing.
        for row in layout.past()..layout.rows() {
            self.put(lane, row, T::zero() / T::zero());
        }
        for row in Layout::D..Layout::D + n {
            self.put(lane, row, prior_variance);
        }
        self.put(lane, Layout::TRACE_BOUND, T::from_design(n as f64) * prior_variance);
    }

    fn put(&mut self, lane: usize, row: usize, value: T) {
        self.tiles[lane / T::WIDTH * self.layout.rows() + row].as_mut()[lane % T::WIDTH] = value;
    }

    fn get(&self, lane: usize, row: usize) -> T {
        self.tiles[lane / T::WIDTH * self.layout.rows() + row].as_ref()[lane % T::WIDTH]
    }

    /// Freezes one estimator, or lets it go on from where it was frozen.
    pub fn freeze(&mut self, estimator: usize, is_frozen: bool) {
        let lane = &mut self.lanes[estimator];
        lane.is_frozen = is_frozen;
        // No sample is louder than this.
        let silence = if is_frozen { T::one() / T::zero() } else { lane.silence };
        self.put(estimator, Layout::SILENCE, silence);
    }

    /// Learns from a block of samples, on this core.
    ///
    /// # Errors
    ///
    /// Returns an error when the block was made for other estimators.
    pub fn update(&mut self, block: &SampleBlock<T>) -> Result<(), BatchError> {
        self.check(block)?;
        let (layout, is_directional) = (self.layout, self.is_directional);
        let (machine, samples, steps) = (self.machine, block.rows(), block.steps());
        let (tiles, tallies) = (&mut self.tiles[..], &mut self.tallies[..]);
        let pass = Pass { layout, is_directional, tiles, samples, steps, tallies };
        T::learn(pass, machine);
        collect(tallies, &mut self.lanes, steps);
        Ok(())
    }

    /// The same on all cores of the present thread pool. The results do not depend on it.
    ///
    /// # Errors
    ///
    /// As [`Self::update`].
    pub fn update_on_all_cores(&mut self, block: &SampleBlock<T>) -> Result<(), BatchError> {
        self.check(block)?;
        let (layout, is_directional) = (self.layout, self.is_directional);
        let (machine, steps) = (self.machine, block.steps());
        let tiles_per_task = SAMPLES_PER_TASK.div_ceil(steps.max(1));
        let rows_per_task = tiles_per_task * (layout.columns() + 1) * steps;
        self.tiles
            .par_chunks_mut(tiles_per_task * layout.rows())
            .zip(block.rows().par_chunks(rows_per_task.max(1)))
            .zip(self.tallies.par_chunks_mut(tiles_per_task))
            .zip(self.lanes.par_chunks_mut(tiles_per_task * T::WIDTH))
            .for_each(|(((tiles, samples), tallies), lanes)| {
                let pass = Pass { layout, is_directional, tiles, samples, steps, tallies };
                T::learn(pass, machine);
                collect(tallies, lanes, steps);
            });
        Ok(())
    }

    fn check(&self, block: &SampleBlock<T>) -> Result<(), BatchError> {
        let compare = |what, expected, found| {
            if expected == found {
                Ok(())
            } else {
                Err(BatchError::Block { what, expected, found })
            }
        };
        compare("columns", self.layout.columns(), block.columns())?;
        compare("estimators", self.lanes.len(), block.estimators())
    }

    /// Writes the estimate of one estimator.
    pub fn theta_into(&self, estimator: usize, theta: &mut [T]) {
        for (i, theta) in theta.iter_mut().enumerate().take(self.layout.n) {
            *theta = self.get(estimator, self.layout.theta() + i);
        }
    }

    /// Replaces the estimate of one estimator, which is the prior mean before the first sample.
    pub fn set_theta(&mut self, estimator: usize, theta: &[T]) {
        for (i, &theta) in theta.iter().enumerate().take(self.layout.n) {
            self.put(estimator, self.layout.theta() + i, theta);
        }
    }

    /// Writes the variances of the parameters of one estimator, relative to a noise of variance 1.
    pub fn variance_into(&self, estimator: usize, variance: &mut [T]) {
        let n = self.layout.n;
        for (i, variance) in variance.iter_mut().enumerate().take(n) {
            *variance = self.get(estimator, Layout::D + i);
            for j in i + 1..n {
                let u = self.get(estimator, self.layout.u(i, j));
                *variance += self.get(estimator, Layout::D + j) * (u * u);
            }
        }
    }

    /// What the safeguards of one estimator have done since its last reset. Missing samples count
    /// as skipped.
    #[must_use]
    pub fn guard(&self, estimator: usize) -> GuardReport {
        self.lanes[estimator].report
    }
}

/// Adds what happened in a block of this many samples to the reports.
fn collect<T: BatchScalar>(tallies: &[Tally<T>], lanes: &mut [Lane<T>], steps: usize) {
    if steps == 0 {
        return;
    }
    for (tally, lanes) in tallies.iter().zip(lanes.chunks_mut(T::WIDTH)) {
        let [skipped, bounded] = tally.each_ref().map(AsRef::as_ref);
        for ((lane, &skipped), &bounded) in lanes.iter_mut().zip(skipped).zip(bounded) {
            if !lane.is_frozen {
                lane.report.skipped += count(skipped);
                lane.report.bounded += count(bounded);
            }
        }
    }
}

/// Small whole numbers are exact in any scalar.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of samples in a block"
)]
fn count<T: BatchScalar>(value: T) -> u64 {
    value.to_report() as u64
}

impl<T: BatchScalar> Stage<T> for BatchRls<T> {
    /// All estimators, also those that are frozen, which stay frozen.
    fn reset(&mut self) {
        for lane in 0..self.lanes.len() {
            self.restart(lane, self.lanes[lane].prior_variance);
            self.lanes[lane].report = GuardReport::default();
        }
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        for tile in self.tiles.chunks_exact_mut(self.layout.rows()) {
            visitor.reals("silence", tile[Layout::SILENCE].as_mut());
            for row in &mut tile[Layout::TRACE_BOUND..] {
                visitor.reals_with_holes("trace bound, D, estimate, U, past", row.as_mut());
            }
        }
        for lane in &mut self.lanes {
            let GuardReport { skipped, bounded } = lane.report;
            let mut counts = [u64::from(lane.is_frozen), skipped, bounded];
            visitor.counts("frozen, skipped, bounded", &mut counts);
            lane.is_frozen = counts[0] != 0;
            [lane.report.skipped, lane.report.bounded] = [counts[1], counts[2]];
        }
    }
}
