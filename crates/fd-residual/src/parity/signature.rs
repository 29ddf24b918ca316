//! Parity vectors with a wanted fault signature.

use faer::{Mat, Scale};
use fd_core::{Shape, ShapeError};
use fd_model::{Discrete, ModelError, StateSpace};

use super::{design::ParityDesign, window::input_map};
use crate::{
    analysis::{Signature, UnknownInputs},
    error::DesignError,
};

/// A fault whose relative reaction is below this counts as unseen.
const UNSEEN: f64 = 1e-8;

impl ParityDesign {
    /// One parity vector of the least order that reacts to the faults with a one bit in
    /// `signature` and ignores all other faults and the disturbances.
    ///
    /// Among the combinations of vectors of that order, one is taken whose least reaction is
    /// large, by correcting a sum of dominant directions where it is weakest.
    ///
    /// # Errors
    ///
    /// Returns an error when the signature has not one bit per fault or no bit set, and
    /// [`DesignError::NoSignature`] when no window of up to `longest + 1` samples has it.
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
        let expected = Shape::new(1, faults.len());
        let found = Shape::new(1, signature.0.len());
        if expected != found {
            return Err(ShapeError { role: "signature", expected, found }.into());
        }
        let having = |bit| (0..faults.len()).filter(|&i| signature.0[i] == bit).collect::<Vec<_>>();
        let (wanted, ignored) = (having(true), having(false));
        if wanted.is_empty() {
            return Err(DesignError::Empty { what: "one bit of the signature" });
        }
        let unknown = disturbances.and(&faults.select(&ignored)?)?;
        for order in 0..=longest {
            let design = match Self::decoupled(model, order, &unknown) {
                Err(DesignError::NoParity { .. }) => continue,
                design => design?,
            };
            let reactions = wanted.iter().map(|&fault| {
                let entry = faults.select(&[fault])?.system(model)?;
                let map = input_map(entry.a(), entry.b(), entry.c(), entry.d(), order);
                Ok(Scale(map.norm_l2().max(f64::MIN_POSITIVE).recip()) * (design.vectors() * map))
            });
            let reactions = reactions.collect::<Result<Vec<_>, DesignError>>()?;
            if let Some(z) = reacting_combination(&reactions)? {
                let w = z * design.vectors();
                return Ok(Self::unchecked(model, order, w, design.rank()));
            }
        }
        Err(DesignError::NoSignature { signature: signature.clone(), longest })
    }
}

/// A unit row `z` for which every `‖z M‖` is large, or `None` when one `M` is zero.
fn reacting_combination(reactions: &[Mat<f64>]) -> Result<Option<Mat<f64>>, DesignError> {
    const CORRECTIONS: usize = 50;

    let mut directions = Vec::new();
    for m in reactions {
        let failed = ModelError::NoConvergence { what: "reaction to a fault", order: m.nrows() };
        let svd = m.svd().map_err(|_| failed)?;
        if svd.S()[0] <= UNSEEN {
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
    Ok((UNSEEN < most).then_some(best))
}
