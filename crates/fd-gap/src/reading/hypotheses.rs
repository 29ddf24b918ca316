//! The mistakes that are tried, each with its probability before the data.

use std::f64::consts::PI;

use fd_model::{
    Channel,
    unit::{Conversion, KNOWN_UNITS, Quantity, quantity},
};
use fd_sim::{model::Model, simulate::Simulator};

use super::mistake::Mistake;
use crate::evidence::grades::BEYOND_DOUBT;

/// Probability of a mistake of each class, spread over all of its kind.
const PRIOR: f64 = 0.01;
/// What is common to several channels at once is this much rarer.
const TOGETHER: f64 = 0.2;
/// Largest shift of a clock, in samples.
pub(super) const FURTHEST: i64 = 20;
/// Factors closer than this to each other are the same.
pub(super) const SAME: f64 = 5e-3;
/// Gains within this factor are honest errors of a sensor or an amplifier, not of a unit.
const HONEST: f64 = 3.0;
/// More parameters than these are no couplings that somebody wrote down.
const WRITTEN: usize = 16;
/// Times between samples that are further from that of the model are not tried.
const PACE: f64 = 120.0;
/// Standard gravity.
const GRAVITY: f64 = 9.806_65;
/// Factors that units are taken wrongly by whatever they measure.
const FACTORS: [f64; 10] = [
    180.0 / PI,
    PI / 180.0,
    60.0 / (2.0 * PI),
    2.0 * PI / 60.0,
    GRAVITY,
    1.0 / GRAVITY,
    1e3,
    1e-3,
    1e2,
    1e-2,
];
/// The same for time.
const TIMES: [f64; 8] = [1e3, 1e-3, 60.0, 1.0 / 60.0, 10.0, 0.1, 100.0, 0.01];

/// A mistake with the logarithm of its probability before the data.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hypothesis {
    pub mistake: Mistake,
    pub log_prior: f64,
}

/// All mistakes that can be made with the channels of a simulator and the parameters of a model.
pub(super) fn hypotheses(model: &Model, simulator: &dyn Simulator) -> Vec<Hypothesis> {
    let (inputs, outputs) = (simulator.inputs(), simulator.outputs());
    let channels = || inputs.iter().chain(outputs);
    let mut all = Vec::new();
    let signs = channels().map(|channel| (Mistake::sign(&channel.name), 1.0));
    class(&mut all, signs.chain(all_signs(outputs)));
    class(&mut all, channels().flat_map(units).chain(all_angles(inputs, outputs)));
    class(&mut all, [inputs, outputs].into_iter().flat_map(swaps));
    let late = || (1..=FURTHEST).flat_map(|late| [late, -late]);
    let clock =
        |channel: &Channel, late: i64| Mistake::Clock { channel: channel.name.clone(), late };
    let clocks = inputs.iter().flat_map(|c| late().map(move |late| (clock(c, late), late < 0)));
    let after = outputs.iter().flat_map(|c| late().map(move |late| (clock(c, late), 0 < late)));
    // A delay of the plant that explains as much must always win over a clock.
    let weight = |is_causal: bool| if is_causal { (-BEYOND_DOUBT).exp() } else { 1.0 };
    class(&mut all, clocks.chain(after).map(|(clock, is_causal)| (clock, weight(is_causal))));
    let pace = simulator.ts().seconds() / model.sample_time;
    let is_near = |factor: &f64| (pace / factor).max(factor / pace) < PACE;
    let times = TIMES.into_iter().filter(is_near);
    class(&mut all, times.map(|factor| (Mistake::Time { factor }, 1.0)));
    class(&mut all, parameters(model));
    all
}

/// Adds a class of mistakes with their weights.
fn class(all: &mut Vec<Hypothesis>, members: impl IntoIterator<Item = (Mistake, f64)>) {
    let members: Vec<(Mistake, f64)> = members.into_iter().collect();
    let share = PRIOR / members.len().max(1) as f64;
    let of = |(mistake, weight): (Mistake, f64)| Hypothesis {
        mistake,
        log_prior: (weight * share).ln(),
    };
    all.extend(members.into_iter().map(of));
}

/// All outputs at once have the other sign.
fn all_signs(outputs: &[Channel]) -> Option<(Mistake, f64)> {
    let channels = outputs.iter().map(|channel| channel.name.clone()).collect();
    (1 < outputs.len()).then_some((Mistake::Sign { channels }, TOGETHER))
}

/// All angles and rates at once are in degrees.
fn all_angles(inputs: &[Channel], outputs: &[Channel]) -> Option<(Mistake, f64)> {
    let is_angle = |channel: &&Channel| matches!(channel.unit.trim(), "rad" | "rad/s");
    let channels: Vec<String> =
        inputs.iter().chain(outputs).filter(is_angle).map(|c| c.name.clone()).collect();
    let factor = 180.0 / PI;
    (1 < channels.len()).then_some((Mistake::Unit { channels, factor }, 1.0))
}

/// Other units of a channel: all that measure the same, and common factors.
fn units(channel: &Channel) -> Vec<(Mistake, f64)> {
    let mut factors: Vec<f64> = Vec::new();
    let mut zeros = Vec::new();
    let same = quantity(&channel.unit);
    for (names, other, ..) in KNOWN_UNITS {
        let Ok(to) = Conversion::between(&channel.unit, names[0]) else { continue };
        let (factor, offset) = (to.apply_to_difference(1.0), to.apply(0.0));
        if same != Some(*other) {
            continue;
        }
        if (factor - 1.0).abs() < SAME && SAME < offset.abs() {
            zeros.push((Mistake::Zero { channel: channel.name.clone(), offset }, 1.0));
        } else if same != Some(Quantity::Temperature) {
            factors.push(factor);
        }
    }
    for factor in FACTORS {
        factors.push(factor);
    }
    factors.retain(|factor| HONEST < factor.max(1.0 / factor));
    factors.sort_by(f64::total_cmp);
    factors.dedup_by(|a, b| (*a / *b - 1.0).abs() < SAME);
    let of = |factor| (Mistake::unit(&channel.name, factor), 1.0);
    zeros.into_iter().chain(factors.into_iter().map(of)).collect()
}

/// Every two channels of one kind for each other.
fn swaps(channels: &[Channel]) -> Vec<(Mistake, f64)> {
    let pairs = channels.iter().enumerate().flat_map(|(i, a)| {
        let swap = move |b: &Channel| Mistake::Swap { channels: [a.name.clone(), b.name.clone()] };
        channels[i + 1..].iter().map(move |b| (swap(b), 1.0))
    });
    pairs.collect()
}

/// Every parameter that is not zero with the other sign, or in another unit.
fn parameters(model: &Model) -> Vec<(Mistake, f64)> {
    let moving = model.parameters.iter().filter(|p| 0.0 < p.value.abs());
    let moving = moving.filter(|_| model.parameters.len() <= WRITTEN);
    let of = |parameter: &fd_sim::model::Parameter| {
        let name = parameter.name.clone();
        let mistake = move |factor| (Mistake::Parameter { name: name.clone(), factor }, 1.0);
        FACTORS.into_iter().chain([-1.0]).map(mistake).collect::<Vec<_>>()
    };
    moving.flat_map(of).collect()
}
