//! Units that are computed side by side.

use faer::{Accum, MatMut, MatRef, Par, linalg::matmul::matmul};
use fd_core::{
    StateVisitor,
    stage::{DecisionRule, Detector, Stage},
};
use fd_ident::batch::{BatchRls, SampleBlock};

use super::{
    bias::BiasRows,
    block::{PART, Samples},
    design::{FleetDesign, FleetScalar, Shared},
    error::FleetError,
    unit::{Unit, UnitStatus},
};

/// Samples that the learners wait for before they learn: they and their samples stay in a cache.
const STRETCH: usize = 32;

/// Up to [`PART`] units. Each row of numbers holds the same number of every unit.
#[derive(Clone, Debug)]
pub(super) struct Part<T: FleetScalar, D, J> {
    /// Rows `[x; u; y]`.
    now: Vec<T>,
    /// Rows `[x⁺; r]`.
    next: Vec<T>,
    /// Rows `r*`.
    r_star: Vec<T>,
    bias: BiasRows<T>,
    /// One for each channel.
    learners: Vec<BatchRls<T>>,
    /// What they have not yet learned from.
    waiting: Vec<SampleBlock<T>>,
    units: Vec<Unit<T, D, J>>,
    /// `u` and `r*` of one unit.
    gathered: Vec<T>,
    theta: Vec<T>,
}

impl<T, D, J> Part<T, D, J>
where
    T: FleetScalar,
    D: Detector<T> + Clone,
    J: DecisionRule<T> + Clone,
{
    pub(super) fn new(
        design: &FleetDesign<D, J>,
        shared: &Shared<T>,
        units: usize,
    ) -> Result<Self, FleetError> {
        let FleetDesign { orders, learning, detector, rule, .. } = design;
        let (nu, channels) = (shared.io.nu, shared.channels);
        let expects = [
            ("detector", "residual", channels, detector.residual_len()),
            ("rule", "residual", channels, rule.residual_len()),
            ("detector", "input", nu, detector.nu().unwrap_or(nu)),
        ];
        for (stage, signal, expected, found) in expects {
            if expected != found {
                return Err(FleetError::Stage { stage, signal, expected, found });
            }
        }
        let learner = BatchRls::arx(*orders, nu, PART, learning)?;
        let rows = |count: usize| vec![T::from_design(0.0); count * PART];
        Ok(Self {
            now: rows(shared.columns()),
            next: rows(shared.rows()),
            r_star: rows(channels),
            bias: BiasRows::new(*orders, nu, channels),
            theta: vec![T::from_design(0.0); learner.parameters()],
            learners: vec![learner; channels],
            waiting: vec![SampleBlock::new(nu, PART, STRETCH); channels],
            units: vec![Unit::new(detector.clone(), rule.clone()); units],
            gathered: vec![T::from_design(0.0); nu + channels],
        })
    }

    /// Takes all units through some samples.
    pub(super) fn update(
        &mut self,
        shared: &Shared<T>,
        samples: Samples<'_, T>,
    ) -> Result<(), FleetError> {
        let mut first = 0;
        while first < samples.len() {
            let steps = self.stretch(shared, samples.len() - first);
            // Nobody is frozen within a stretch, nor learns after the last one was.
            let is_learning = self.units.iter().any(|unit| !unit.is_frozen);
            if is_learning {
                self.waiting.iter_mut().for_each(|block| block.restart(steps));
            }
            for step in 0..steps {
                self.step(shared, samples.sample(first + step), is_learning.then_some(step));
            }
            if is_learning {
                self.learn(shared)?;
            }
            first += steps;
        }
        Ok(())
    }

    /// Samples until some unit may have learned enough, so that it is frozen in time.
    fn stretch(&self, shared: &Shared<T>, left: usize) -> usize {
        let learning = self.units.iter().filter(|unit| !unit.is_frozen);
        let soonest = learning.map(|unit| shared.training.saturating_sub(unit.learned)).min();
        let soonest = usize::try_from(soonest.unwrap_or(0)).unwrap_or(usize::MAX);
        left.min(STRETCH).min(soonest.max(1))
    }

    /// One sample of each unit; while any of them learns, `waiting` is its place among those that wait
    /// to be learned from.
    fn step(&mut self, shared: &Shared<T>, sample: &[T], waiting: Option<usize>) {
        let Shared { io, nx, .. } = *shared;
        let complete = self.hold(nx, sample);
        let (columns, rows) = (shared.columns(), shared.rows());
        matmul(
            MatMut::from_row_major_slice_mut(&mut self.next, rows, PART),
            Accum::Replace,
            shared.matrix(),
            MatRef::from_row_major_slice(&self.now, columns, PART),
            T::from_design(1.0),
            Par::Seq,
        );
        let (state, residual) = self.next.split_at(nx * PART);
        self.now[..nx * PART].copy_from_slice(state);

        // Units that have settled and whose sample is complete learn from it.
        let mut learns = [false; PART];
        for ((unit, &complete), learns) in self.units.iter_mut().zip(&complete).zip(&mut learns) {
            *learns = complete && !unit.is_frozen && unit.settled >= shared.settling;
            unit.settled = (unit.settled + u64::from(complete)).min(shared.settling);
            unit.missing += u64::from(!complete);
            unit.offered += u64::from(!unit.is_frozen);
        }
        let u = &self.now[nx * PART..(nx + io.nu) * PART];
        let mu_hat = self.bias.simulate(u);
        self.r_star.copy_from_slice(residual);
        // Parameters are zero until they are frozen, and so is the bias.
        self.r_star.iter_mut().zip(mu_hat).for_each(|(r, &mu)| *r -= mu);
        let missing = T::from_design(f64::NAN);
        for (channel, r) in residual.chunks_exact(PART).enumerate() {
            let r_star = &self.r_star[channel * PART..];
            if let Some(step) = waiting {
                let targets: [T; PART] =
                    std::array::from_fn(|i| if learns[i] { r[i] } else { missing });
                self.waiting[channel].set_all(step, u, &targets);
            }
            let mut mu = [T::from_design(0.0); PART];
            for (i, unit) in self.units.iter().enumerate() {
                mu[i] = if unit.is_frozen { r[i] - r_star[i] } else { r[i] };
            }
            self.bias.push(channel, &mu);
        }
        self.judge(shared, &complete);
    }

    /// Takes over what is there of a sample; the rest stays as it was.
    fn hold(&mut self, nx: usize, sample: &[T]) -> [bool; PART] {
        let mut complete = [true; PART];
        let held = self.now[nx * PART..].chunks_exact_mut(PART);
        for (held, row) in held.zip(sample.chunks_exact(PART)) {
            for ((held, &value), complete) in held.iter_mut().zip(row).zip(&mut complete) {
                let is_there = value.is_finite();
                *held = if is_there { value } else { *held };
                *complete &= is_there;
            }
        }
        complete
    }

    fn judge(&mut self, shared: &Shared<T>, complete: &[bool; PART]) {
        let first = shared.nx * PART;
        let (u, r_star) = self.gathered.split_at_mut(shared.io.nu);
        for (i, unit) in self.units.iter_mut().enumerate() {
            if unit.is_frozen && complete[i] {
                let inputs = self.now[first..].chunks_exact(PART);
                u.iter_mut().zip(inputs).for_each(|(u, row)| *u = row[i]);
                let residuals = self.r_star.chunks_exact(PART);
                r_star.iter_mut().zip(residuals).for_each(|(r, row)| *r = row[i]);
                unit.judge(u, r_star);
            }
            unit.samples += 1;
        }
    }

    /// Learns from the waiting samples and freezes the units that have learned enough.
    fn learn(&mut self, shared: &Shared<T>) -> Result<(), FleetError> {
        for (learner, block) in self.learners.iter_mut().zip(&self.waiting) {
            learner.update(block)?;
        }
        for (i, unit) in self.units.iter_mut().enumerate().filter(|(_, unit)| !unit.is_frozen) {
            let skipped = self.learners.iter().map(|learner| learner.guard(i).skipped).max();
            unit.learned = unit.offered.saturating_sub(skipped.unwrap_or(0));
            if unit.learned >= shared.training {
                unit.is_frozen = true;
                for (channel, learner) in self.learners.iter_mut().enumerate() {
                    learner.theta_into(i, &mut self.theta);
                    learner.freeze(i, true);
                    self.bias.load(i, channel, &self.theta);
                }
            }
        }
        Ok(())
    }

    pub(super) fn status(&self, unit: usize) -> UnitStatus<T> {
        self.units[unit].status()
    }

    pub(super) fn theta_into(&self, unit: usize, theta: &mut [T]) {
        if self.units[unit].is_frozen {
            theta.iter_mut().zip(self.bias.theta(unit)).for_each(|(to, theta)| *to = theta);
        } else {
            let per_channel = theta.chunks_exact_mut(self.theta.len());
            for (learner, theta) in self.learners.iter().zip(per_channel) {
                learner.theta_into(unit, theta);
            }
        }
    }

    pub(super) fn compensated_into(&self, unit: usize, r_star: &mut [T]) {
        let rows = self.r_star.chunks_exact(PART);
        r_star.iter_mut().zip(rows).for_each(|(r, row)| *r = row[unit]);
    }

    pub(super) fn reset(&mut self) {
        for rows in [&mut self.now, &mut self.next, &mut self.r_star] {
            rows.fill(T::from_design(0.0));
        }
        self.bias.reset();
        for learner in &mut self.learners {
            (0..self.units.len()).for_each(|i| learner.freeze(i, false));
            learner.reset();
        }
        self.units.iter_mut().for_each(Unit::reset);
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("fleet state and held samples", &mut self.now);
        visitor.reals("fleet compensated residuals", &mut self.r_star);
        self.bias.visit_state(visitor);
        for learner in &mut self.learners {
            learner.visit_state(visitor);
        }
        for unit in &mut self.units {
            unit.visit_state(visitor);
        }
    }
}
