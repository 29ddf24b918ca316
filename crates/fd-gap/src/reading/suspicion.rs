//! From a first look to a mistake that is worth a diagnosis, and from that to a reading.

use crate::together::each;
use fd_model::Record;

use super::{
    cut_off::cut_off,
    hypotheses::{FURTHEST, Hypothesis},
    misfit::{Look, Misfit},
    mistake::Mistake,
    price::price,
    result::Reading,
    shortlist::shortlist,
    trial::Trial,
    words,
};
use crate::{
    diagnose::{Case, Diagnosis, Verdict},
    evidence::grades::{STRONG, VERY_STRONG},
    fit::{FitError, Horizon},
    quality::EXPLAINED,
};

/// Part of the spread of a column that a mended simulation may leave.
const FOLLOWS: f64 = 0.7;
/// By how much (natural logarithm) errors must shrink where they stay above the noise.
const SHRINKS: f64 = 0.5;

/// A mistake that would explain much, which a diagnosis of the mended log has to confirm.
#[derive(Clone, Debug)]
pub struct Suspicion {
    hypothesis: Hypothesis,
    also: Vec<Mistake>,
    /// The best explanation of the log as it is read, and what that costs.
    as_read: Misfit,
    price: f64,
    /// The mended log with nothing but parameters and starts fitted.
    pub(super) mended: Misfit,
}

/// How a log is explained as it is read.
pub(super) struct Explained {
    /// The best explanation …
    known: Misfit,
    /// … and what it costs.
    price: f64,
    /// That of refitted parameters.
    refit: Misfit,
    /// What parameters and starts can do; `None` where the simulation is lost.
    pub fitted: Option<Misfit>,
}

/// Looks for a mistake of reading that explains a log at least about as well as the diagnosis of the
/// log as it is read, which is `None` where the simulation as read is lost. Free of charge when that found no gap.
///
/// # Errors
///
/// Returns an error when the logs do not fit the model.
pub fn suspect(
    case: &Case<'_>,
    horizon: Horizon,
    as_read: Option<&Diagnosis>,
) -> Result<Option<Suspicion>, FitError> {
    if as_read.is_some_and(|diagnosis| diagnosis.verdict == Verdict::NoGap) {
        return Ok(None);
    }
    if let Some(suspicion) = as_read.and_then(|d| Suspicion::of_cut_off(case, horizon, d)) {
        return Ok(Some(suspicion));
    }
    match Explained::of(case, horizon, as_read)? {
        Some(explained) => explained.suspected(case, horizon),
        None => Ok(None),
    }
}

impl Explained {
    /// What there is; `None` where nothing can be compared.
    pub(super) fn of(
        case: &Case<'_>,
        horizon: Horizon,
        as_read: Option<&Diagnosis>,
    ) -> Result<Option<Self>, FitError> {
        let trial = Trial::new(case, None)?;
        let zero: Vec<Vec<f64>> = trial.zeros();
        let Some(level) = trial.misfit(&zero, Look::Close).map(|misfit| misfit.constant()) else {
            return Ok(None);
        };
        let of = |outputs: &[Vec<f64>]| trial.misfit(outputs, Look::Close);
        let refit = as_read.and_then(|d| of(&d.refit.outputs)).unwrap_or_else(|| level.clone());
        let mut known = (refit.clone(), 0.0);
        if let Some((diagnosis, best)) = as_read.and_then(|d| Some((d, of(&d.best.outputs)?))) {
            let price = price(diagnosis, best.independent());
            if price < best.advantage(&refit) {
                known = (best, price);
            }
        }
        // Mended logs may begin anywhere, and so may this one.
        let fitted = trial.fitted(horizon);
        for plain in std::iter::once(&level).chain(&fitted) {
            if known.1 < plain.advantage(&known.0) {
                known = (plain.clone(), 0.0);
            }
        }
        Ok(Some(Self { known: known.0, refit, price: known.1, fitted }))
    }

    /// The mistake that explains a log at least about as well.
    pub(super) fn suspected(
        self,
        case: &Case<'_>,
        horizon: Horizon,
    ) -> Result<Option<Suspicion>, FitError> {
        let Self { known, refit, price, .. } = self;
        let fits = each(shortlist(case)?, |hypothesis| {
            let misfit = fit(case, horizon, &hypothesis.mistake)?;
            Some((hypothesis, misfit))
        });
        let fits: Vec<(Hypothesis, Misfit)> = fits.into_iter().flatten().collect();
        let mut best: Option<(Hypothesis, Misfit)> = None;
        for fit in &fits {
            if best.as_ref().is_none_or(|best| 0.0 < beats(fit, best)) {
                best = Some(fit.clone());
            }
        }
        let Some(best) = best.map(|best| climbed(case, horizon, best)) else { return Ok(None) };
        let over_refit = best.1.advantage(&refit);
        let odds = best.1.advantage(&known) + price + best.0.log_prior;
        let is_worth = !known.is_noise(EXPLAINED)
            && SHRINKS < best.1.shrinks(&refit)
            && VERY_STRONG < over_refit;
        if !(0.0 < odds || is_worth)
            || !best.1.follows(&refit, FOLLOWS)
            || !is_determined(case, horizon, &best)
        {
            return Ok(None);
        }
        let same = |other: &Mistake| match (other, &best.0.mistake) {
            (Mistake::Clock { channel: a, .. }, Mistake::Clock { channel: b, .. }) => a == b,
            (a, b) => a == b,
        };
        let tied = fits.iter().filter(|f| !same(&f.0.mistake) && -STRONG < beats(f, &best));
        let also = tied.map(|(hypothesis, _)| hypothesis.mistake.clone()).collect();
        let (hypothesis, mended) = best;
        Ok(Some(Suspicion { hypothesis, also, as_read: known, price, mended }))
    }
}

fn fit(case: &Case<'_>, horizon: Horizon, mistake: &Mistake) -> Option<Misfit> {
    Trial::new(case, Some(mistake)).ok()?.fitted(horizon)
}

/// Logarithm of how much likelier one mistake is than another.
fn beats(one: &(Hypothesis, Misfit), other: &(Hypothesis, Misfit)) -> f64 {
    one.1.advantage(&other.1) + one.0.log_prior - other.0.log_prior
}

/// The first look may be off by some samples of a clock.
fn climbed(
    case: &Case<'_>,
    horizon: Horizon,
    mut best: (Hypothesis, Misfit),
) -> (Hypothesis, Misfit) {
    let Mistake::Clock { channel, late } = best.0.mistake.clone() else { return best };
    for step in [1, -1] {
        let mut late = late + step;
        while late != 0 && late.abs() <= FURTHEST {
            let mistake = Mistake::Clock { channel: channel.clone(), late };
            let Some(misfit) = fit(case, horizon, &mistake) else { break };
            let next = (Hypothesis { mistake, ..best.0.clone() }, misfit);
            if beats(&next, &best) <= 0.0 {
                break;
            }
            best = next;
            late += step;
        }
    }
    best
}

/// Whether half and twice the factor explain clearly less; of time, which beyond some factor leaves all at rest
/// between samples, a factor half way to none.
fn is_determined(case: &Case<'_>, horizon: Horizon, best: &(Hypothesis, Misfit)) -> bool {
    let with = |times: f64| match best.0.mistake.clone() {
        Mistake::Sign { channels } => Some(Mistake::Unit { channels, factor: -times }),
        Mistake::Unit { channels, factor } => {
            Some(Mistake::Unit { channels, factor: times * factor })
        }
        Mistake::Parameter { name, factor } => {
            Some(Mistake::Parameter { name, factor: times * factor })
        }
        Mistake::Time { factor } => (1.0 < times).then(|| Mistake::Time { factor: factor.sqrt() }),
        Mistake::Zero { .. }
        | Mistake::CutOff { .. }
        | Mistake::Swap { .. }
        | Mistake::Clock { .. } => None,
    };
    // A factor that is not determined, as that of an input that does nothing, is no unit.
    [0.5, 2.0].into_iter().filter_map(with).all(|control| {
        let control = fit(case, horizon, &control);
        control.is_none_or(|control| STRONG < best.1.advantage(&control))
    })
}

impl Suspicion {
    /// That an output is cut off, against the best explanation of the log as it is read, which names a bias instead.
    fn of_cut_off(case: &Case<'_>, horizon: Horizon, as_read: &Diagnosis) -> Option<Self> {
        let hypothesis = cut_off(case, as_read)?;
        let mended = fit(case, horizon, &hypothesis.mistake)?;
        let known = Trial::new(case, None).ok()?.misfit(&as_read.best.outputs, Look::Close)?;
        let price = price(as_read, known.independent());
        Some(Self { hypothesis, also: Vec::new(), as_read: known, price, mended })
    }

    /// What is suspected.
    #[must_use]
    pub fn mistake(&self) -> &Mistake {
        &self.hypothesis.mistake
    }

    /// Records with it mended; `None` when one is too short for that.
    #[must_use]
    pub fn mended(&self, records: &[Record]) -> Option<Vec<Record>> {
        records.iter().map(|record| self.mistake().mended(record)).collect()
    }

    /// The reading, if the diagnosis of the `mended` case confirms it: it explains clearly more than the best
    /// physical cause of the log as it is read.
    #[must_use]
    pub fn judged(self, mended: &Case<'_>, diagnosis: &Diagnosis) -> Option<Reading> {
        let mistake = &self.hypothesis.mistake;
        let trial = Trial::of_mended(mended, mistake).ok()?;
        let best = trial.misfit(&diagnosis.best.outputs, Look::Close)?;
        let paid = price(diagnosis, best.independent());
        let refit = trial.misfit(&diagnosis.refit.outputs, Look::Close)?;
        // Above the noise a mistake is believed for what it explains alone: with a cause beside it there are two.
        let is_alone = |paid: f64| paid <= 0.0;
        let ways = [(&best, paid), (&refit, 0.0), (&self.mended, 0.0)];
        let believed = ways.into_iter().filter(|(misfit, paid)| {
            let clearly = misfit.is_noise(EXPLAINED)
                || is_alone(*paid) && SHRINKS < misfit.shrinks(&self.as_read);
            clearly && misfit.follows(&self.as_read, FOLLOWS)
        });
        let odds = believed.map(|(misfit, paid)| misfit.advantage(&self.as_read) - paid);
        let odds = odds.max_by(f64::total_cmp)? + self.price + self.hypothesis.log_prior;
        let probability = 1.0 / (1.0 + (-odds).exp());
        if probability <= 0.5 {
            return None;
        }
        let rms = |misfit: &Misfit| misfit.columns.iter().map(|column| column.rms).collect();
        let ts = mended.logs.first()?.ts().seconds();
        let said = words::said(mistake, mended.nominal.model(), ts);
        Some(Reading {
            probability,
            statement: said.statement,
            advice: said.advice,
            lines: said.lines,
            before: rms(&self.as_read),
            after: rms(&self.mended),
            also: self.also,
            mistake: self.hypothesis.mistake,
        })
    }
}
