//! Nothing comes near the noise: forecasts judge instead of evidence.
//!
//! Real logs end at 6 to 230 times the noise, whatever single effect is added. Then
//! * models are fitted in windows if the free run is lost with every law ([`through_windows`](super::through_windows)),
//! * the noise has no colour: what a wrong model leaves is no noise,
//! * laws compete in forecasts at three horizons, on the logs of the fit and on those held out; what to believe is how often
//!   they win, up to the share of the variance that they surely explain there ([`contest`]); curves and paths draw what is
//!   missing and do not compete.

use super::{
    contest::{Contested, contest},
    judged::{Judged, NamedPairs},
    ties::ties,
    verdict::verdict,
};
use crate::{
    diagnose::{context::Context, result::Regime, settings::Settings, weigh::Weighed},
    fit::{FitError, Horizon, Log},
    quality::noise_floor,
    shrink::Rules,
};

/// Judges by forecasts. Pairs are not named: what is left is the work of many small errors, and two
/// effects would always take more of it than one.
pub(super) fn by_forecasts<'a>(
    weighed: Weighed<'a>,
    held_out: &[Log],
    horizons: Vec<Horizon>,
    windows: Option<Horizon>,
    context: &Context<'a>,
) -> Result<Judged<'a>, FitError> {
    let settings = context.settings;
    let simulator = weighed.singles.base.simulator().boxed();
    let Weighed { singles, best, lack_of_fit, .. } = weighed;
    let Settings { replicas, seed, .. } = *settings;
    let rules = Rules { floor: floor(&best.errors), replicas, seed };
    let Contested { others: probabilities, singles } =
        contest(&*simulator, singles, held_out, &horizons, &rules, settings.finalists)?;
    let in_doubt = singles.causes.iter().take_while(|ranked| 0.0 < ranked.cause.probability);
    let ties = ties(&singles.causes[..in_doubt.count()], &singles.searched, settings);
    let (best, lack_of_fit) = match singles.first_answer() {
        Some(first) => {
            let lack_of_fit = singles.lack_of_fit(&first);
            (first, lack_of_fit)
        }
        None => (best, lack_of_fit),
    };
    let pairs = NamedPairs::default();
    Ok(Judged {
        verdict: verdict(probabilities, &singles.causes, &ties, &pairs),
        regime: Regime::AboveTheFloor,
        probabilities,
        singles,
        ties,
        pairs,
        best,
        lack_of_fit,
        horizons,
        windows,
    })
}

/// The noise floor below errors, in sigma, over all outputs.
fn floor(errors: &[Vec<Vec<f64>>]) -> f64 {
    let floors = errors.iter().map(|signals| noise_floor(&signals.join(&f64::NAN), None));
    let squares: f64 = floors.map(|floor| floor.unwrap_or(1.0).powi(2)).sum();
    f64::sqrt(squares / errors.len().max(1) as f64)
}
