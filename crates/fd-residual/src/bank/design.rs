//! Stacking designs.

use faer::Mat;
use fd_core::{IoDims, Shape, ShapeError, stage::ResidualGenerator};
use fd_model::{StateSpace, TimeDomain};

use super::run::Bank;
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::blocks,
};

/// Designs whose residuals are stacked in order.
#[derive(Debug)]
pub struct BankDesign {
    io: IoDims,
    members: Vec<Box<dyn GeneratorDesign>>,
}

impl BankDesign {
    /// A bank of at least one design.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no design, or when they are for different plants.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     GeneratorDesign, bank::BankDesign, parity::ParityDesign, simulation::SimulationDesign,
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let bank = BankDesign::new(vec![
    ///     Box::new(SimulationDesign::new(&lag)?),
    ///     Box::new(ParityDesign::all(&lag, 1)?),
    /// ])?;
    /// assert_eq!(bank.residual_len(), 2);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(members: Vec<Box<dyn GeneratorDesign>>) -> Result<Self, DesignError> {
        let Some(first) = members.first() else {
            return Err(DesignError::Empty { what: "member of the bank" });
        };
        let (io, domain) = (first.io(), first.form()?.system().domain());
        for member in &members {
            if member.io() != io {
                let expected = Shape::new(io.ny, io.nu);
                let found = Shape::new(member.io().ny, member.io().nu);
                return Err(ShapeError { role: "plant of a bank member", expected, found }.into());
            }
            domain.join(member.form()?.system().domain())?;
        }
        Ok(Self { io, members })
    }
}

impl GeneratorDesign for BankDesign {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.members.iter().map(GeneratorDesign::residual_len).sum()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        // Members side by side, fed with one and the same [u; y].
        let width = self.io.nu + self.io.ny;
        let mut all: Option<StateSpace<_>> = None;
        for member in &self.members {
            let system = member.form()?.system().clone();
            all = Some(match all {
                Some(before) => before.append(&system)?,
                None => system,
            });
        }
        let Some(all) = all else {
            return Err(DesignError::Empty { what: "member of the bank" });
        };
        let copies = vec![Mat::<f64>::identity(width, width); self.members.len()];
        let rows: Vec<_> = copies.iter().map(|copy| [copy.as_ref()]).collect();
        let rows: Vec<_> = rows.iter().map(<[_; 1]>::as_slice).collect();
        let spread = StateSpace::gain(blocks(&rows), all.domain())?;
        ResidualForm::new(self.io, spread.series(&all)?)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        let members: Result<Vec<_>, _> = self.members.iter().map(GeneratorDesign::build).collect();
        Ok(Box::new(Bank::new(members?)?))
    }
}
