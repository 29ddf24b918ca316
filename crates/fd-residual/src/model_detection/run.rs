//! Running the bank, and deciding for a model sample by sample.

use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{ResidualGenerator, Stage},
};
use fd_model::ModelError;

use crate::{bank::Bank, error::DesignError, form::FormGenerator};

/// How long residuals are remembered when models are compared:
/// `θ_i(k) = γ θ_i(k−1) + (1 − γ) |r_i(k)|²` with `γ = 1 − 1/samples` (Narendra and Balakrishnan 1997).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// Time constant of the forgetting, in samples.
    pub samples: f64,
    /// A model takes over only when its `θ` is that many times smaller than that of the present one.
    pub margin: f64,
}

/// Twenty samples, and twice as small.
impl Default for Memory {
    fn default() -> Self {
        Self { samples: 20.0, margin: 2.0 }
    }
}

/// A bank of residuals and the model that explains them best.
///
/// Neither allocates nor fails per sample.
#[derive(Clone, Debug)]
pub struct ModelDetector {
    bank: Bank<FormGenerator<f64>>,
    /// Channels of each member.
    widths: Vec<usize>,
    memory: Memory,
    levels: Vec<f64>,
    best: u64,
}

impl ModelDetector {
    /// A detector from the residual generators of the models.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no generator, they have other channels, or the memory is shorter than one
    /// sample or its margin below one.
    pub fn new(members: Vec<FormGenerator<f64>>, memory: Memory) -> Result<Self, DesignError> {
        let check = |role, range, value: f64, least: f64| {
            if least <= value && value.is_finite() {
                Ok(())
            } else {
                Err(ModelError::OutOfRange { role, range, value })
            }
        };
        check("the memory of a model detector, in samples,", "[1, inf)", memory.samples, 1.0)?;
        check("the margin of a model detector", "[1, inf)", memory.margin, 1.0)?;
        let widths: Vec<_> = members.iter().map(ResidualGenerator::residual_len).collect();
        let levels = vec![0.0; widths.len()];
        let bank = Bank::new::<f64>(members)?;
        Ok(Self { bank, widths, memory, levels, best: 0 })
    }

    /// The model that the plant is most like; the first one to begin with.
    #[must_use]
    pub fn best(&self) -> usize {
        usize::try_from(self.best).unwrap_or(0)
    }

    /// Root mean square of each model's residual, with fading memory.
    pub fn levels(&self) -> impl Iterator<Item = f64> {
        self.levels.iter().map(|level| level.sqrt())
    }

    fn judge(&mut self, r: &[f64]) {
        let keep = 1.0 - self.memory.samples.recip();
        let mut from = 0;
        for (level, width) in self.levels.iter_mut().zip(&self.widths) {
            let size: f64 = r[from..from + width].iter().map(|r| r * r).sum();
            *level = keep * *level + (1.0 - keep) * size;
            from += width;
        }
        let (mut least, mut smallest) = (0, f64::INFINITY);
        for (i, &level) in self.levels.iter().enumerate() {
            if level < smallest {
                (least, smallest) = (i, level);
            }
        }
        let margin = self.memory.margin * self.memory.margin;
        if margin * smallest < self.levels[self.best()] {
            self.best = least as u64;
        }
    }
}

impl Stage for ModelDetector {
    fn reset(&mut self) {
        Stage::<f64>::reset(&mut self.bank);
        self.levels.fill(0.0);
        self.best = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        self.bank.visit_state(visitor);
        visitor.reals("levels of the models", &mut self.levels);
        visitor.counts("model", std::slice::from_mut(&mut self.best));
        // A foreign snapshot must not point beyond the list.
        self.best %= self.levels.len().max(1) as u64;
    }
}

impl ResidualGenerator for ModelDetector {
    fn io(&self) -> IoDims {
        ResidualGenerator::<f64>::io(&self.bank)
    }

    fn residual_len(&self) -> usize {
        ResidualGenerator::<f64>::residual_len(&self.bank)
    }

    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        self.bank.step(frame, r);
        self.judge(r);
    }
}
