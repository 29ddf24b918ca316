//! The gap of each output.

use super::{
    bench::Bench,
    result::{ChannelGap, Size},
};
use crate::diagnose::Diagnosis;

/// `ln(rms/floor)` from which a gap is one.
const CLEAR: f64 = 0.2;

pub(super) fn channels(bench: &Bench, diagnosis: &Diagnosis) -> Vec<ChannelGap> {
    let outputs = bench.simulator.outputs().iter().enumerate();
    let gap = |(c, output): (usize, &fd_model::Channel)| {
        let size = |sigma: f64| Size { value: sigma * diagnosis.sigma[c], sigma };
        let [nominal, refit, after] = [&diagnosis.nominal, &diagnosis.refit, &diagnosis.best]
            .map(|explanation| size(explanation.gap[c]));
        let floor = size(diagnosis.floor[c]);
        let statement = words(output, refit, after, floor);
        ChannelGap { output: output.clone(), nominal, refit, after, floor, statement }
    };
    outputs.map(gap).collect()
}

fn words(output: &fd_model::Channel, refit: Size, after: Size, floor: Size) -> String {
    let (name, unit) = (&output.name, &output.unit);
    let is_clear = |size: Size| CLEAR < (size.sigma / floor.sigma).ln();
    let before = format!(
        "{name}: {:.3} {unit} remain with parameters refitted, {:.1} times the noise floor",
        Short(refit.value),
        refit.sigma / floor.sigma
    );
    if !is_clear(refit) {
        format!("{name}: no gap above the noise floor of {:.3} {unit}", Short(floor.value))
    } else if is_clear(after) {
        let left = after.sigma / floor.sigma;
        format!("{before}; {:.3} {unit} ({left:.1} times) with the cause", Short(after.value))
    } else {
        format!("{before}; with the cause only the noise remains")
    }
}

/// A number in words, with as many significant digits as its precision warrants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Short(pub(crate) f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(3);
        let exponent = self.0.abs().log10().floor();
        if !self.0.is_finite() || self.0 == 0.0 {
            return write!(f, "{}", self.0);
        }
        if !(-4.0..6.0).contains(&exponent) {
            return write!(f, "{:.*e}", digits.saturating_sub(1), self.0);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 12")]
        let places = (digits as f64 - 1.0 - exponent).max(0.0) as usize;
        write!(f, "{:.places$}", self.0)
    }
}
