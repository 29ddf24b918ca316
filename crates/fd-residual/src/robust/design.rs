//! Choosing the rows.

use faer::Mat;
use fd_core::{IoDims, Shape, ShapeError};
use fd_model::{Discrete, TimeDomain};

use super::{
    moments::{FaultShape, Moments},
    search::{best_rows, energy, worst_case},
};
use crate::{
    analysis::UnknownInputs, error::DesignError, form::design_by_part, model_detection::PlantModel,
    parity::ParityDesign, simulation::check_stable,
};

/// The window that is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobustWindow {
    /// Its length minus one.
    pub order: usize,
    /// What the faults look like in it.
    pub shape: FaultShape,
}

/// The worst case over the models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstCase {
    /// Least energy of a fault over largest variance of a healthy residual, that the row achieves.
    pub achieved: f64,
    /// What no row of this window exceeds.
    pub bound: f64,
}

/// A residual for many models; runs as [`Parity`](crate::parity::Parity).
#[derive(Clone, Debug)]
pub struct RobustDesign {
    window: ParityDesign,
    healthy_rms: Vec<f64>,
    fault_rms: Vec<f64>,
    worst: Option<WorstCase>,
}

impl RobustDesign {
    /// The `count` rows whose faults stand farthest above the healthy residuals on average over the models; `faults`
    /// holds those of each model, in their order.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no model, one is unstable, they have other channels or sample times, or `count`
    /// is zero or more than the window has values.
    ///
    /// # Examples
    ///
    /// A lag whose pole is somewhere between 0.7 and 0.9, with a sensor that drifts:
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     analysis::UnknownInputs,
    ///     model_detection::PlantModel,
    ///     robust::{FaultShape, RobustDesign, RobustWindow},
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = |a: f64| StateSpace::new(mat![[a]], mat![[1.0 - a]], mat![[1.0]], mat![[0.0]], domain);
    /// let (mut models, mut faults) = (Vec::new(), Vec::new());
    /// for pole in [0.7, 0.8, 0.9] {
    ///     let plant = lag(pole)?;
    ///     faults.push(UnknownInputs::none(&plant).sensor(&plant, 0)?);
    ///     models.push(PlantModel::new("lag", plant));
    /// }
    /// let window = RobustWindow { order: 3, shape: FaultShape::Lasting };
    /// let average = RobustDesign::average(&models, &faults, window, 1)?;
    /// let worst = RobustDesign::worst(&models, &faults, window)?;
    /// let of = |design: &RobustDesign| design.worst_over_models();
    /// assert!(of(&average) <= of(&worst) * (1.0 + 1e-9));
    /// let case = worst.worst_case().unwrap();
    /// assert!(case.achieved <= case.bound * (1.0 + 1e-9));
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn average(
        models: &[PlantModel<Discrete>],
        faults: &[UnknownInputs],
        window: RobustWindow,
        count: usize,
    ) -> Result<Self, DesignError> {
        let all = moments(models, faults, window)?;
        let width = all.first().map_or(0, |moments| moments.healthy.nrows());
        if count == 0 {
            return Err(DesignError::Empty { what: "robust residual" });
        }
        if width < count {
            let (what, index) = ("robust residual", count - 1);
            return Err(DesignError::Index { what, index, count: width });
        }
        let even = vec![(all.len() as f64).recip(); all.len()];
        let (w, _) = best_rows(&all, [&even, &even], count)?;
        Ok(Self::of(models, &all, window, &w, None))
    }

    /// The row whose faults stand farthest above the healthy residuals in the worst model of each.
    ///
    /// # Errors
    ///
    /// As [`average`](Self::average).
    pub fn worst(
        models: &[PlantModel<Discrete>],
        faults: &[UnknownInputs],
        window: RobustWindow,
    ) -> Result<Self, DesignError> {
        let all = moments(models, faults, window)?;
        let found = worst_case(&all)?;
        let case = WorstCase { achieved: found.achieved, bound: found.bound };
        Ok(Self::of(models, &all, window, &found.w, Some(case)))
    }

    fn of(
        models: &[PlantModel<Discrete>],
        all: &[Moments],
        window: RobustWindow,
        w: &Mat<f64>,
        worst: Option<WorstCase>,
    ) -> Self {
        // Of unit variance in the worst healthy model, so that rows of one design are alike.
        let loudest =
            |row: usize| all.iter().map(|m| energy(w, row, &m.healthy)).fold(0.0, f64::max).sqrt();
        let size: Vec<f64> = (0..w.nrows()).map(loudest).collect();
        let w = Mat::from_fn(w.nrows(), w.ncols(), |i, j| {
            if 0.0 < size[i] { w[(i, j)] / size[i] } else { w[(i, j)] }
        });
        let rms = |of: fn(&Moments) -> &Mat<f64>| {
            let one =
                |m: &Moments| (0..w.nrows()).map(|i| energy(&w, i, of(m))).sum::<f64>().sqrt();
            all.iter().map(one).collect()
        };
        let (healthy_rms, fault_rms) = (rms(|m| &m.healthy), rms(|m| &m.faulty));
        let plant = models[0].plant();
        let outputs = (window.order + 1) * plant.ny();
        let inputs = w.ncols() - outputs;
        let io = IoDims { nu: plant.nu(), ny: plant.ny() };
        let from_y = w.subcols(0, outputs).to_owned();
        let from_u = w.subcols(outputs, inputs).to_owned();
        let window = ParityDesign::given(io, window.order, plant.domain(), from_y, from_u);
        Self { window, healthy_rms, fault_rms, worst }
    }

    /// Root mean square of the healthy residual of each model, for inputs and noise of unit size; the largest is one
    /// for a scalar residual.
    #[must_use]
    pub fn healthy_rms(&self) -> &[f64] {
        &self.healthy_rms
    }

    /// The same of what faults of unit size add.
    #[must_use]
    pub fn fault_rms(&self) -> &[f64] {
        &self.fault_rms
    }

    /// Least energy of the faults over largest variance of the healthy residual, over all models.
    #[must_use]
    pub fn worst_over_models(&self) -> f64 {
        let least = self.fault_rms.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = self.healthy_rms.iter().copied().fold(0.0, f64::max);
        (least / largest).powi(2)
    }

    /// What a worst-case design achieves, and what no row could; `None` for a design of the average case.
    #[must_use]
    pub fn worst_case(&self) -> Option<WorstCase> {
        self.worst
    }
}

// Eq. (5) does not hold: the inputs pass as far as the models differ.
design_by_part!(RobustDesign, window);

fn moments(
    models: &[PlantModel<Discrete>],
    faults: &[UnknownInputs],
    window: RobustWindow,
) -> Result<Vec<Moments>, DesignError> {
    let Some(first) = models.first() else {
        return Err(DesignError::Empty { what: "model" });
    };
    if faults.len() != models.len() {
        let what = "lists of faults, one per model";
        return Err(DesignError::Count { what, expected: models.len(), found: faults.len() });
    }
    let expected = Shape::new(first.plant().ny(), first.plant().nu());
    let of =
        |(model, faults): (&PlantModel<Discrete>, &UnknownInputs)| -> Result<Moments, DesignError> {
            let plant = model.plant();
            first.plant().domain().join(plant.domain())?;
            let found = Shape::new(plant.ny(), plant.nu());
            if found != expected {
                return Err(ShapeError { role: "model of the sample", expected, found }.into());
            }
            if faults.is_empty() {
                return Err(DesignError::Empty { what: "fault" });
            }
            check_stable("a robust residual", plant)?;
            Moments::of(model, faults, window.order, window.shape)
        };
    models.iter().zip(faults).map(of).collect()
}
