//! Designing each row.

use fd_core::{IoDims, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace};

use super::structure::{Structure, told_apart};
use crate::{
    analysis::{Signature, UnknownInputs, fault_effects, weak_structure},
    bank::BankDesign,
    decouple::{LeftNullSpace, refuse_what_passes},
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    least_order::LeastOrderDesign,
    matrix::spread_rows,
    observer::ErrorPoles,
    parity::ParityDesign,
    rank::{RankDecision, RankTolerance},
};

/// How the residual of a row is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RowMethod {
    /// A parity relation of the least order, over at most `longest + 1` samples.
    Parity {
        /// Longest order that is tried.
        longest: usize,
    },
    /// A filter in the left null space; smoother in noise.
    Filter {
        /// Least rate at which its modes die out, in 1/s.
        rate: f64,
    },
    /// A filter with as few states as the parity relation has lags.
    LeastOrder {
        /// Rate at which its modes die out, in 1/s.
        rate: f64,
    },
}

/// A bank with a wanted structure matrix.
#[derive(Debug)]
pub struct StructuredDesign {
    bank: BankDesign,
    signatures: Vec<Signature>,
    orders: Vec<usize>,
    decisions: Vec<RankDecision>,
    faults: usize,
}

impl StructuredDesign {
    /// One residual per row of the structure, each decoupled from the disturbances and from the
    /// faults with a zero bit.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::NoSignature`] for a row that cannot be had,
    /// [`DesignError::NotAchieved`] or [`DesignError::NotDecoupled`] for one that was designed and,
    /// looked at again over frequency, reacts to other inputs than it should, or an error when the
    /// rows do not fit the faults.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     GeneratorDesign,
    ///     analysis::{UnknownInputs, weak_structure},
    ///     structured::{RowMethod, Structure, StructuredDesign},
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let (b, c) = (mat![[1.0]], mat![[1.0], [2.0]]);
    /// let lag = StateSpace::new(mat![[0.9]], b, c, Mat::zeros(2, 1), domain)?;
    /// let none = UnknownInputs::none(&lag);
    /// let faults = none.clone().sensor(&lag, 0)?.sensor(&lag, 1)?.actuator(&lag, 0)?;
    /// let method = RowMethod::Parity { longest: 3 };
    /// let bank = StructuredDesign::new(&lag, &faults, &none, &Structure::Generalised, method)?;
    /// let found = weak_structure(&bank.form()?, &faults.system(&lag)?)?;
    /// assert_eq!(found, bank.signatures());
    /// assert!(bank.isolability().iter().all(|row| row.to_string() == "111"));
    ///
    /// // Two sensors and an actuator cannot each have a residual of their own here.
    /// let dedicated = StructuredDesign::new(&lag, &faults, &none, &Structure::Dedicated, method);
    /// assert!(dedicated.is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<Discrete>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        structure: &Structure,
        method: RowMethod,
    ) -> Result<Self, DesignError> {
        Self::within(model, faults, disturbances, structure, method, RankTolerance::default())
    }

    /// The same for a model that is known to a given tolerance.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn within(
        model: &StateSpace<Discrete>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        structure: &Structure,
        method: RowMethod,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        let mut members: Vec<Box<dyn GeneratorDesign>> = Vec::new();
        let (mut orders, mut decisions) = (Vec::new(), Vec::new());
        let mut signatures = Vec::new();
        let (gf, gd) = (faults.system(model)?, disturbances.system(model)?);
        for (row, wanted) in structure.rows(faults.len())?.into_iter().enumerate() {
            let (member, order, nearest): (Box<dyn GeneratorDesign>, _, _) = match method {
                RowMethod::Parity { longest } => {
                    let design = ParityDesign::with_signature_within(
                        model,
                        faults,
                        disturbances,
                        &wanted,
                        longest,
                        tolerance,
                    )
                    .map_err(|error| in_row(error, row))?;
                    let nearest = design.rank();
                    (Box::new(design.clone()), design.order(), nearest)
                }
                RowMethod::LeastOrder { rate } => {
                    let design = LeastOrderDesign::within(
                        model,
                        faults,
                        disturbances,
                        &wanted,
                        &ErrorPoles::Rate(rate),
                        tolerance,
                    )
                    .map_err(|error| in_row(error, row))?;
                    let (order, nearest) = (design.order(), Some(design.nearest()));
                    (Box::new(design), order, nearest)
                }
                RowMethod::Filter { rate } => {
                    let (form, nearest) =
                        filter(model, faults, disturbances, &wanted, rate, tolerance)?;
                    (Box::new(form.clone()), form.system().nx(), Some(nearest))
                }
            };
            let nearest = nearest.unwrap_or(RankDecision::clear(tolerance));
            signatures.push(achieved(
                &member.form()?,
                [&gf, &gd],
                row,
                wanted,
                disturbances,
                nearest,
            )?);
            members.push(member);
            orders.push(order);
            decisions.push(nearest);
        }
        let bank = BankDesign::new(members)?;
        Ok(Self { bank, signatures, orders, decisions, faults: faults.len() })
    }

    /// The signatures that were found in the residuals, over frequency, one per residual: those that
    /// were asked for, or there would be no design.
    #[must_use]
    pub fn signatures(&self) -> &[Signature] {
        &self.signatures
    }

    /// Orders of the residuals: window length minus one, or states.
    #[must_use]
    pub fn orders(&self) -> &[usize] {
        &self.orders
    }

    /// The nearest decision behind each residual.
    #[must_use]
    pub fn decisions(&self) -> &[RankDecision] {
        &self.decisions
    }

    /// Which faults this bank tells apart: bit `j` of row `i` is set when a residual fires for
    /// fault `i` and stays silent for fault `j`; on the diagonal, when one fires at all.
    #[must_use]
    pub fn isolability(&self) -> Vec<Signature> {
        told_apart(&self.signatures, self.faults)
    }
}

impl GeneratorDesign for StructuredDesign {
    fn io(&self) -> IoDims {
        self.bank.io()
    }

    fn residual_len(&self) -> usize {
        self.bank.residual_len()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        self.bank.form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        self.bank.build()
    }
}

/// The signature of one residual, if it is the wanted one and no disturbance passes.
fn achieved(
    form: &ResidualForm,
    [gf, gd]: [&StateSpace<Discrete>; 2],
    row: usize,
    wanted: Signature,
    disturbances: &UnknownInputs,
    nearest: RankDecision,
) -> Result<Signature, DesignError> {
    let achieved = weak_structure(form, gf)?.swap_remove(0);
    if achieved != wanted {
        return Err(DesignError::NotAchieved { row, wanted, achieved, nearest });
    }
    refuse_what_passes(form, disturbances, gd, row, nearest)?;
    Ok(achieved)
}

/// The error of a row that was designed alone.
fn in_row(error: DesignError, row: usize) -> DesignError {
    match error {
        DesignError::NotAchieved { wanted, achieved, nearest, .. } => {
            DesignError::NotAchieved { row, wanted, achieved, nearest }
        }
        other => other,
    }
}

/// The combination in the null space whose weakest wanted fault is strongest.
fn filter(
    model: &StateSpace<Discrete>,
    faults: &UnknownInputs,
    disturbances: &UnknownInputs,
    signature: &Signature,
    rate: f64,
    tolerance: RankTolerance,
) -> Result<(ResidualForm, RankDecision), DesignError> {
    let having = |bit| (0..faults.len()).filter(|&i| signature.0[i] == bit).collect::<Vec<_>>();
    let (wanted, ignored) = (having(true), having(false));
    if wanted.is_empty() {
        return Err(DesignError::Empty { what: "one bit of the signature" });
    }
    let unachievable =
        || DesignError::NoSignature { signature: signature.clone(), longest: model.nx() };
    let unknown = disturbances.and(&faults.select(&ignored)?)?;
    let space = match LeftNullSpace::within(model, &unknown, tolerance) {
        Err(DesignError::NothingLeft { .. }) => return Err(unachievable()),
        space => space?,
    };
    if &space.detects(faults)? != signature {
        return Err(unachievable());
    }
    let nearest = space.reactions(faults)?.into_iter().fold(space.nearest(), RankDecision::nearer);
    let gf = faults.select(&wanted)?.system(model)?;
    let mut best = None;
    let mut strongest = 0.0;
    for row in spread_rows(space.residual_len()) {
        let form = space.combined(row.as_ref())?.placed(&ErrorPoles::Rate(rate))?;
        let effects = fault_effects(&form, &gf)?;
        let weakest = effects.iter().map(|e| if e.detectable { e.peak.norm } else { 0.0 });
        let weakest = weakest.fold(f64::INFINITY, f64::min);
        if strongest < weakest {
            (best, strongest) = (Some(form), weakest);
        }
    }
    best.map(|form| (form, nearest)).ok_or_else(unachievable)
}
