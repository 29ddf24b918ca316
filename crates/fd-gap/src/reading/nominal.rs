//! A simulator with a parameter mended.

use fd_model::SampleTime;
use fd_sim::{
    model::Model,
    simulate::{Nominal, SimulateError, Simulator},
};

use super::mistake::Mistake;

/// A simulator whose model has a parameter mended.
///
/// ```
/// use fd_gap::reading::{Mended, Mistake};
/// use fd_sim::{model::Model, simulate::Nominal};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "spring"
/// sample_time = 0.1
/// parameters = { k = { unit = "1/s", value = -2.0 } }
/// outputs = { x = { unit = "m", value = "q" } }
/// states = { q = { unit = "m", initial = 1.0, derivative = "-k*q" } }
/// "#.parse()?;
/// let wrong = Mistake::Parameter { name: "k".into(), factor: -1.0 };
/// let mended = Mended::of(&model, &wrong).ok_or("a parameter of that name")?;
/// assert_eq!(mended.model().parameters[0].value, 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mended<'a> {
    nominal: &'a dyn Nominal,
    model: Model,
}

impl<'a> Mended<'a> {
    /// The simulator as it is really meant; `None` when that makes no valid model.
    #[must_use]
    pub fn of(nominal: &'a dyn Nominal, mistake: &Mistake) -> Option<Self> {
        Some(Self { nominal, model: mistake.mended_model(nominal.model())? })
    }
}

impl Nominal for Mended<'_> {
    fn model(&self) -> &Model {
        &self.model
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.nominal.patched(model, ts)
    }
}
