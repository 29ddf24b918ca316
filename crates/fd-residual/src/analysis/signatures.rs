//! Which signatures any residual of a plant can have, and at which order.

use faer::{Mat, Scale, c64};
use fd_model::{StateSpace, TimeDomain};

use super::{signature::Signature, unknown::UnknownInputs};
use crate::{
    error::DesignError,
    parity::{NaturalPlant, NaturalWindow},
    rank::{RankDecision, RankTolerance},
};

/// Faults beyond which the enumeration of `2ⁿ` signatures is refused.
const MOST_FAULTS: usize = 16;

/// A signature that some scalar residual has.
#[derive(Clone, Debug, PartialEq)]
pub struct Achievable {
    /// Faults that the residual reacts to; it is decoupled from all others.
    pub signature: Signature,
    /// Least parity order, which is the least order of a scalar residual generator.
    pub least_order: usize,
    /// Number of independent residuals that are decoupled from the others.
    pub dimension: usize,
    /// Orders of a minimal basis of these residuals, ascending, as far as found within the
    /// longest window.
    pub basis_orders: Vec<usize>,
    /// The nearest of the decisions behind this.
    pub nearest: RankDecision,
}

/// All that was found, and how near the nearest decision was, of those against a signature too.
#[derive(Clone, Debug, PartialEq)]
pub struct Signatures {
    /// In binary order.
    pub found: Vec<Achievable>,
    /// With a tolerance changed by less than its [margin](RankDecision::margin) nothing changes.
    pub nearest: RankDecision,
}

/// What to look for, how far, and how well the model is known.
///
/// # Examples
///
/// ```
/// use faer::{Mat, mat};
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::{
///     analysis::{SignatureSearch, UnknownInputs},
///     rank::RankTolerance,
/// };
///
/// // Two leaks that differ in a part in 10⁵: is the model good enough to tell them apart?
/// let (a, b) = (mat![[-1.0, 0.0], [0.0, -2.0]], mat![[1.0], [0.0]]);
/// let tanks = StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)?;
/// let none = UnknownInputs::none(&tanks);
/// let leaks = mat![[1.0, 1.0], [1.0, 1.00001]];
/// let leaks = UnknownInputs::new("leak", leaks, Mat::zeros(2, 2))?;
/// let exact = SignatureSearch { longest: 3, ..SignatureSearch::default() };
/// let rough = SignatureSearch { tolerance: RankTolerance::new(1e-3)?, ..exact.clone() };
/// let of = |search: &SignatureSearch| search.run(&tanks, &leaks, &none);
/// assert_eq!(of(&exact)?.found.len(), 3); // 01, 10 and 11
/// assert_eq!(of(&rough)?.found.len(), 1); // 11
/// // How near it was: a tolerance a hundred times as large would still tell them apart.
/// assert!(of(&exact)?.nearest.margin() > 100.0);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignatureSearch {
    /// Frequencies (rad/s; 0 for constant faults) at each of which the faults have to pass: none for
    /// weak signatures.
    pub frequencies: Vec<f64>,
    /// Longest window less one.
    pub longest: usize,
    /// How well the model is known.
    pub tolerance: RankTolerance,
}

/// All signatures that can be had with windows of at most `longest + 1` samples, in binary order.
///
/// A signature is achievable at order `s` when a parity vector of that order annihilates the
/// state, the disturbances and the faults with a zero bit, while none of the faults with a one
/// bit is annihilated by all such vectors (a combination of vectors then reacts to all of them).
/// With `frequencies` (rad/s; 0 for constant faults), each of these faults has to pass at each
/// frequency: strong signatures instead of weak ones.
///
/// The number of vectors with orders up to `s` in a minimal basis is the increase of the null
/// space's dimension from `s − 1` to `s`. No residual needs a higher order than the plant has
/// states, plus one for each decoupled input. The algebra is that of discrete time; for
/// continuous models it holds with derivatives in place of shifts.
///
/// # Errors
///
/// Returns an error when there is no fault or more than 16, or the sizes do not fit.
///
/// # Examples
///
/// Two sensors of one lag: each alone shows the actuator's faults and its own.
///
/// ```
/// use faer::{Mat, mat};
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::analysis::{UnknownInputs, achievable_signatures};
///
/// let (b, c) = (mat![[1.0]], mat![[1.0], [1.0]]);
/// let lag = StateSpace::new(mat![[-1.0]], b, c, Mat::zeros(2, 1), Continuous)?;
/// let none = UnknownInputs::none(&lag);
/// let faults = none.clone().sensor(&lag, 0)?.sensor(&lag, 1)?.actuator(&lag, 0)?;
/// let found = achievable_signatures(&lag, &faults, &none, &[], 3)?;
/// let found: Vec<_> = found.iter().map(|a| (a.signature.to_string(), a.least_order)).collect();
/// let expected = [("011", 1), ("101", 1), ("110", 0), ("111", 1)];
/// assert_eq!(found, expected.map(|(bits, order)| (bits.to_owned(), order)));
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn achievable_signatures<D: TimeDomain>(
    model: &StateSpace<D>,
    faults: &UnknownInputs,
    disturbances: &UnknownInputs,
    frequencies: &[f64],
    longest: usize,
) -> Result<Vec<Achievable>, DesignError> {
    let search =
        SignatureSearch { frequencies: frequencies.to_vec(), longest, ..Default::default() };
    Ok(search.run(model, faults, disturbances)?.found)
}

impl SignatureSearch {
    /// All signatures that can be had with windows of at most `longest + 1` samples.
    ///
    /// # Errors
    ///
    /// As [`achievable_signatures`].
    pub fn run<D: TimeDomain>(
        &self,
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
    ) -> Result<Signatures, DesignError> {
        let count = faults.len();
        if count == 0 {
            return Err(DesignError::Empty { what: "fault" });
        }
        if MOST_FAULTS < count {
            return Err(DesignError::Index { what: "fault", index: count - 1, count: MOST_FAULTS });
        }
        let plant = NaturalPlant::of(model, &faults.and(disturbances)?)?;
        let wave = |omega: f64, order: usize| {
            let point = model.domain().point(omega) / plant.rate();
            let mut wave = Mat::from_fn(order + 1, 1, |_, _| c64::new(1.0, 0.0));
            for i in 1..=order {
                wave[(i, 0)] = wave[(i - 1, 0)] * point;
            }
            Scale(c64::new(wave.norm_l2().recip(), 0.0)) * wave
        };
        let sights: Vec<_> = (0..=self.longest)
            .map(|order| Sight {
                window: plant.window(order),
                waves: self.frequencies.iter().map(|&omega| wave(omega, order)).collect(),
                disturbances: (count..count + disturbances.len()).collect(),
                tolerance: self.tolerance,
            })
            .collect();
        let mut nearest = RankDecision::clear(self.tolerance);
        let mut found = Vec::new();
        for code in 1..1_usize << count {
            let bits: Vec<bool> = (0..count).rev().map(|bit| code >> bit & 1 == 1).collect();
            found.extend(achieve(&sights, Signature(bits), &mut nearest)?);
        }
        Ok(Signatures { found, nearest })
    }
}

fn achieve(
    sights: &[Sight],
    signature: Signature,
    nearest_of_all: &mut RankDecision,
) -> Result<Option<Achievable>, DesignError> {
    let mut least_order = None;
    let (mut size, mut dimension) = (0, 0);
    let mut basis_orders = Vec::new();
    let mut nearest: Option<RankDecision> = None;
    let mut note = |decision: RankDecision| {
        nearest = Some(nearest.map_or(decision, |nearest| nearest.nearer(decision)));
        *nearest_of_all = nearest_of_all.nearer(decision);
    };
    for (order, sight) in sights.iter().enumerate() {
        let (kept, w) = sight.decoupled_from(&signature)?;
        note(kept);
        // Each vector of lower order appears once more, shifted; the surplus is new.
        let increase = w.nrows().saturating_sub(size);
        basis_orders.extend(std::iter::repeat_n(order, increase.saturating_sub(dimension)));
        (size, dimension) = (w.nrows(), increase);
        if least_order.is_none() && sight.all_react(&w, &kept, &signature, &mut note) {
            least_order = Some(order);
        }
    }
    let found = least_order.zip(nearest);
    Ok(found.map(|(least_order, nearest)| Achievable {
        signature,
        least_order,
        dimension,
        basis_orders,
        nearest,
    }))
}

/// What a window of one order sees of the state, the faults (first) and the disturbances.
struct Sight {
    window: NaturalWindow,
    /// Powers of each point of the frequency axis, `[1; p; …; pˢ]`, as unit columns.
    waves: Vec<Mat<c64>>,
    disturbances: Vec<usize>,
    tolerance: RankTolerance,
}

impl Sight {
    fn decoupled_from(
        &self,
        signature: &Signature,
    ) -> Result<(RankDecision, Mat<f64>), DesignError> {
        let mut ignored: Vec<_> = (0..signature.0.len()).filter(|&j| !signature.0[j]).collect();
        ignored.extend(&self.disturbances);
        let decided = self.window.decoupled_from(&ignored, self.tolerance)?;
        Ok((decided.decision, decided.annihilators()))
    }

    fn all_react(
        &self,
        w: &Mat<f64>,
        kept: &RankDecision,
        signature: &Signature,
        note: &mut impl FnMut(RankDecision),
    ) -> bool {
        let mut wanted = (0..signature.0.len()).filter(|&j| signature.0[j]);
        0 < w.nrows()
            && wanted.all(|fault| {
                let reaction = self.window.reaction(w.as_ref(), fault, kept);
                let reacts = NaturalWindow::reacts(reaction.as_ref(), &self.waves, self.tolerance);
                note(reacts);
                reacts.rank == 1
            })
    }
}
