//! Parity vectors with a wanted fault signature.

use faer::{Mat, Scale};
use fd_core::{Shape, ShapeError};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use super::{
    design::ParityDesign,
    natural::{NaturalPlant, NaturalWindow},
};
use crate::{
    analysis::{Signature, UnknownInputs},
    error::DesignError,
    rank::{RankDecision, RankTolerance},
};

impl ParityDesign {
    /// One parity vector of the least order that reacts to the faults with a one bit in
    /// `signature` and ignores all other faults and the disturbances.
    ///
    /// Among the combinations of vectors of that order, one is taken whose least reaction is
    /// large, by correcting a sum of dominant directions where it is weakest.
    ///
    /// # Errors
    ///
    /// Returns an error when the signature has not one bit per fault or no bit set,
    /// [`DesignError::NoSignature`] when no window of up to `longest + 1` samples has it, and
    /// [`DesignError::NotAchieved`] when the vector that was made turns out not to.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     GeneratorDesign,
    ///     analysis::{Signature, UnknownInputs, weak_structure},
    ///     parity::ParityDesign,
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let (b, c) = (mat![[1.0]], mat![[1.0], [2.0]]);
    /// let lag = StateSpace::new(mat![[0.9]], b, c, Mat::zeros(2, 1), domain)?;
    /// let none = UnknownInputs::none(&lag);
    /// let faults = none.clone().sensor(&lag, 0)?.sensor(&lag, 1)?.actuator(&lag, 0)?;
    /// let wanted = Signature(vec![true, false, true]); // blind to the second sensor
    /// let design = ParityDesign::with_signature(&lag, &faults, &none, &wanted, 3)?;
    /// assert_eq!(design.order(), 1);
    /// let found = weak_structure(&design.form()?, &faults.system(&lag)?)?;
    /// assert_eq!(found, [wanted]);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn with_signature(
        model: &StateSpace<Discrete>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        signature: &Signature,
        longest: usize,
    ) -> Result<Self, DesignError> {
        let tolerance = RankTolerance::default();
        Self::with_signature_within(model, faults, disturbances, signature, longest, tolerance)
    }

    /// The same for a model that is known to a given tolerance.
    ///
    /// # Errors
    ///
    /// As [`with_signature`](Self::with_signature).
    pub fn with_signature_within(
        model: &StateSpace<Discrete>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        signature: &Signature,
        longest: usize,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        let found = least_vector(model, faults, disturbances, signature, longest, tolerance)?;
        let w = found.plant.in_model_units(found.w.as_ref());
        Ok(Self::unchecked(model, found.order, w, Some(found.nearest)))
    }
}

/// A parity vector of the least order with a wanted signature, in natural units of signals and of time.
pub(crate) struct LeastVector {
    pub plant: NaturalPlant,
    pub order: usize,
    pub w: Mat<f64>,
    /// The nearest decision behind it.
    pub nearest: RankDecision,
}

/// The vector that [`ParityDesign::with_signature_within`] is made of, on either time axis.
pub(crate) fn least_vector<D: TimeDomain>(
    model: &StateSpace<D>,
    faults: &UnknownInputs,
    disturbances: &UnknownInputs,
    signature: &Signature,
    longest: usize,
    tolerance: RankTolerance,
) -> Result<LeastVector, DesignError> {
    let expected = Shape::new(1, faults.len());
    let found = Shape::new(1, signature.0.len());
    if expected != found {
        return Err(ShapeError { role: "signature", expected, found }.into());
    }
    let count = faults.len();
    let having = |bit| (0..count).filter(|&i| signature.0[i] == bit).collect::<Vec<_>>();
    let (wanted, mut ignored) = (having(true), having(false));
    if wanted.is_empty() {
        return Err(DesignError::Empty { what: "one bit of the signature" });
    }
    ignored.extend(count..count + disturbances.len());
    let plant = NaturalPlant::of(model, &faults.and(disturbances)?)?;
    for order in 0..=longest {
        let window = plant.window(order);
        let decided = window.decoupled_from(&ignored, tolerance)?;
        let (w, kept) = (decided.annihilators(), decided.decision);
        if w.nrows() == 0 {
            continue;
        }
        let react = |z: &Mat<f64>| {
            let each = wanted.iter().map(|&fault| window.reaction(z.as_ref(), fault, &kept));
            each.collect::<Vec<_>>()
        };
        let Some(z) = reacting_combination(&react(&w), tolerance)? else { continue };
        // Once more, on the vector itself.
        let one = &z * &w;
        let bits = (0..count).map(|fault| {
            let seen = window.reaction(one.as_ref(), fault, &kept);
            NaturalWindow::reacts(seen.as_ref(), &[], tolerance)
        });
        let bits: Vec<RankDecision> = bits.collect();
        let achieved = Signature(bits.iter().map(|bit| bit.rank == 1).collect());
        let nearest = bits.into_iter().fold(kept, RankDecision::nearer);
        if &achieved != signature {
            let wanted = signature.clone();
            return Err(DesignError::NotAchieved { row: 0, wanted, achieved, nearest });
        }
        return Ok(LeastVector { plant, order, w: one, nearest });
    }
    Err(DesignError::NoSignature { signature: signature.clone(), longest })
}

/// A unit row `z` for which every `‖z M‖` is large, or `None` when one `M` is within the tolerance of zero.
fn reacting_combination(
    reactions: &[Mat<f64>],
    tolerance: RankTolerance,
) -> Result<Option<Mat<f64>>, DesignError> {
    const CORRECTIONS: usize = 50;

    let mut directions = Vec::new();
    for m in reactions {
        let failed = ModelError::NoConvergence { what: "reaction to a fault", order: m.nrows() };
        let svd = m.full_svd().map_err(|_| failed)?;
        if svd.S()[0] <= tolerance.value() {
            return Ok(None);
        }
        directions.push(svd.U().subcols(0, 1).transpose().to_owned());
    }
    let unit = |z: Mat<f64>| Scale(z.norm_l2().recip()) * z;
    let reaction = |z: &Mat<f64>, i: usize| (z * &reactions[i]).norm_l2();
    let weakest = |z: &Mat<f64>| {
        let all = (0..reactions.len()).map(|i| (i, reaction(z, i)));
        all.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let Some(mut z) = directions.first().cloned() else { return Ok(None) };
    let mut best = z.clone();
    let mut most = 0.0;
    let mut step = 1.0;
    for _ in 0..CORRECTIONS {
        let Some((i, least)) = weakest(&z) else { break };
        if most < least {
            (best, most) = (z.clone(), least);
        }
        // Towards the direction of the weakest, on the side where z already is.
        let side = if (&z * directions[i].transpose())[(0, 0)] < 0.0 { -step } else { step };
        z = unit(z + Scale(side) * &directions[i]);
        step *= 0.9;
    }
    Ok((tolerance.value() < most).then_some(best))
}
