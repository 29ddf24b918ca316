//! How far a simulation is from a log, as a likelihood of the logged numbers.
//!
//! A reading changes what the logged numbers mean, so that errors are brought back into the units of
//! the columns before they are compared. Errors of a wrong model are slow: neighbours say the same,
//! and samples count as many as there are autocorrelation times.

use super::mistake::Mistake;
use crate::fit::Log;

/// Correlation at which errors have forgotten each other.
const FORGOTTEN: f64 = 0.05;

/// How closely errors are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// At their size only.
    Rough,
    /// At how long they remember, too.
    Close,
}

/// What a simulation leaves of a column of the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColumnMisfit {
    /// Number of measured values.
    count: f64,
    /// Root mean square of the errors, in the unit of the channel.
    pub rms: f64,
    /// The same about their mean.
    about_mean: f64,
    /// Standard deviation of what was measured, in the unit of the channel.
    spread: f64,
    /// The least noise that is believed, in the unit of the channel.
    floor: f64,
    /// Unit of the column over that of the channel.
    scale: f64,
    /// Samples that are worth an independent one.
    time: f64,
}

/// What a simulation leaves of a log, column by column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Misfit {
    pub columns: Vec<ColumnMisfit>,
}

impl Misfit {
    /// `simulated` has the outputs of each log row by row; `floors` are those of the channels.
    pub(super) fn of(
        mistake: Option<&Mistake>,
        names: &[&str],
        logs: &[Log],
        simulated: &[Vec<f64>],
        floors: &[f64],
        look: Look,
    ) -> Option<Self> {
        let mut columns = vec![None; names.len()];
        for (c, name) in names.iter().enumerate() {
            let column = mistake.map_or(*name, |mistake| mistake.column(name));
            let place = names.iter().position(|known| *known == column)?;
            let turn = logs.first().and_then(|log| log.circles[c].turn());
            // On a circle no error is above half a turn, whatever the unit of the column: one that makes a turn small there
            // earns nothing by that.
            let scale = match (turn, mistake) {
                (None, Some(mistake)) => mistake.scale(name),
                _ => 1.0,
            };
            let mut measured = Vec::new();
            let mut errors: Vec<Vec<f64>> = Vec::new();
            for (log, y) in logs.iter().zip(simulated) {
                let own = log.y.iter().skip(c).step_by(log.ny);
                let pairs = own.clone().zip(y.iter().skip(c).step_by(log.ny));
                errors.push(pairs.map(|(m, y)| log.circles[c].difference(*y, *m)).collect());
                measured.extend(own.copied());
            }
            // What was measured, and was not simulated, has diverged.
            let count =
                |values: &mut dyn Iterator<Item = &f64>| values.filter(|v| v.is_finite()).count();
            if count(&mut measured.iter()) != count(&mut errors.iter().flatten()) {
                return None;
            }
            let found = ColumnMisfit::of(&measured, &errors, floors[c], scale, look);
            // What points anywhere is that far from whatever it is compared with.
            let anywhere = turn.map_or(f64::INFINITY, |turn| turn / 12.0_f64.sqrt());
            columns[place] = Some(ColumnMisfit { spread: found.spread.min(anywhere), ..found });
        }
        Some(Self { columns: columns.into_iter().collect::<Option<_>>()? })
    }

    /// As a level of each column explains the log: what every explanation has to beat.
    pub(super) fn constant(&self) -> Self {
        let level = |c: &ColumnMisfit| ColumnMisfit {
            rms: c.spread,
            about_mean: c.spread,
            time: c.count.sqrt(),
            ..*c
        };
        Self { columns: self.columns.iter().map(level).collect() }
    }

    /// Sum of the logarithms of the errors about their means, for a first look.
    pub(super) fn rough(&self) -> f64 {
        self.sizes(|column| column.about_mean)
    }

    /// The same about zero, for mistakes that move nothing but the mean.
    pub(super) fn rough_about_zero(&self) -> f64 {
        self.sizes(|column| column.rms)
    }

    fn sizes(&self, size: impl Fn(&ColumnMisfit) -> f64) -> f64 {
        self.columns.iter().map(|c| (size(c).max(c.floor) * c.scale).ln()).sum()
    }

    /// By how much the logged numbers are likelier (natural logarithm) than with another misfit.
    pub(super) fn advantage(&self, over: &Self) -> f64 {
        self.columns.iter().zip(&over.columns).map(|(own, other)| own.advantage(other)).sum()
    }

    /// Mean over the columns that gain of the logarithm of the other error over this one.
    pub(super) fn shrinks(&self, over: &Self) -> f64 {
        let pairs = self.columns.iter().zip(&over.columns);
        let gaining = pairs.filter(|(own, other)| 1.0 < own.advantage(other));
        let logs: Vec<f64> = gaining.map(|(own, other)| own.ratio(other)).collect();
        logs.iter().sum::<f64>() / logs.len().max(1) as f64
    }

    /// Whether the columns that gain follow the simulation, instead of lying still beside it.
    pub(super) fn follows(&self, over: &Self, share: f64) -> bool {
        let mut pairs = self.columns.iter().zip(&over.columns);
        pairs.all(|(own, other)| {
            own.advantage(other) < 1.0 || own.rms < share * own.spread.max(own.floor)
        })
    }

    /// Whether no column is further off than so many times the least noise that is believed.
    pub(super) fn is_noise(&self, times: f64) -> bool {
        self.columns.iter().all(|c| c.rms <= times * c.floor)
    }

    /// Independent samples of all columns.
    pub(super) fn independent(&self) -> f64 {
        self.columns.iter().map(|c| c.count / c.time).sum()
    }
}

impl ColumnMisfit {
    fn of(measured: &[f64], errors: &[Vec<f64>], floor: f64, scale: f64, look: Look) -> Self {
        let (count, _, spread) = moments(measured.iter());
        let (_, mean, about_mean) = moments(errors.iter().flatten());
        let rms = mean.hypot(about_mean);
        let time = match look {
            Look::Rough => 1.0,
            Look::Close => autocorrelation_time(errors, rms),
        };
        Self { count, rms, about_mean, spread, floor, scale, time }
    }

    fn advantage(&self, over: &Self) -> f64 {
        let independent = self.count.min(over.count) / self.time.max(over.time);
        independent * self.ratio(over)
    }

    fn ratio(&self, over: &Self) -> f64 {
        let size = |c: &Self| c.rms.max(c.floor) * c.scale;
        (size(over) / size(self)).ln()
    }
}

/// Count, mean and standard deviation of what is finite.
fn moments<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> (f64, f64, f64) {
    let values = values.copied().filter(|v| v.is_finite());
    let n = values.clone().count().max(1) as f64;
    let [mean, deviation] = fd_numeric::mean_and_deviation(values);
    (n, mean, deviation)
}

/// `1 + 2 Σ ρ(k)`, up to where errors have forgotten each other.
fn autocorrelation_time(errors: &[Vec<f64>], rms: f64) -> f64 {
    let n: usize = errors.iter().map(Vec::len).sum();
    let power = n as f64 * rms * rms;
    let correlation = |lag: usize| -> f64 {
        let products = errors.iter().flat_map(|e| e.iter().zip(e.iter().skip(lag)));
        products.map(|(a, b)| a * b).filter(|p| p.is_finite()).sum::<f64>() / power
    };
    let lags = (1..n / 5).map(correlation).take_while(|rho| FORGOTTEN < *rho);
    (1.0 + 2.0 * lags.sum::<f64>()).max(1.0)
}

#[cfg(test)]
mod tests {
    use fd_model::Record;
    use fd_sim::{model::Model, simulate::EquationSimulator};

    use super::*;

    const COMPASS: &str = r#"
version = 1
kind = "equations"
name = "compass"
sample_time = 1.0
inputs = { r = { unit = "deg/s" } }
outputs = { heading = { unit = "deg", value = "x", noise = 0.2, wraps = true } }
states = { x = { unit = "deg", initial = 0.0, derivative = "r" } }
"#;

    /// Errors of a degree, and those of a heading in thousandths of a degree, which are anywhere on the circle.
    #[test]
    fn a_unit_that_makes_a_turn_small_earns_nothing() {
        let model: Model = COMPASS.parse().unwrap();
        let simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let heading = |k: u32| f64::from(7 * k) + f64::from(k).sin();
        let rows = (0..500).map(|k| ([7.0], [heading(k)]));
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        let ts = model.sample_time().unwrap();
        let record = Record::from_rows(inputs, outputs, rows, ts).unwrap();
        let simulated = [(0..500_u32).map(|k| f64::from(7 * k)).collect()];
        let misfit = |mistake: Option<&Mistake>| {
            let record = mistake.map_or(record.clone(), |known| known.mended(&record).unwrap());
            let logs = Log::all(&[record], &simulator, &[]).unwrap();
            Misfit::of(mistake, &["heading"], &logs, &simulated, &[0.2], Look::Close).unwrap()
        };
        let (as_read, small) = (misfit(None), misfit(Some(&Mistake::unit("heading", 1e-3))));
        assert!(small.advantage(&as_read) < 0.0, "{small:?} {as_read:?}");
    }
}
