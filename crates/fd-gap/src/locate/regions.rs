//! Where in the space of inputs, states and outputs a gap is, and what it depends on.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{
    bench::{Bench, Rows},
    channels::Short,
    motion::Motion,
    places::{EVIDENT, name},
    result::{Bin, PlaceEvidence, Region, RegionOf, RegionOn},
};

/// Bins of a signal.
const BINS: usize = 8;
/// Fewest samples in a bin.
const FEWEST: usize = 10;
/// Circular shifts.
const SHIFTS: usize = 199;
/// A shift is at least this part of the data.
const LEAST_SHIFT: f64 = 0.05;
/// Probability of any false claim, over all signals together.
const FALSE_CLAIMS: f64 = 0.05;
/// Share from which a dependence matters.
const MATTERS: f64 = 0.05;
/// How much better many bins must be than two to be preferred to them.
const SIMPLER: f64 = 1.1;
const SEED: u64 = 0x5_EED5;

/// A signal on all samples, log after log, with what it is.
struct Axis {
    on: RegionOn,
    unit: String,
    /// Bin of each sample; `None` where the signal has no value.
    bins: Vec<Option<usize>>,
    limits: Vec<[f64; 2]>,
}

/// A quantity that may depend on an axis.
struct Target {
    of: RegionOf,
    values: Vec<f64>,
}

/// Dependences of the residuals, and of the free signal at the most probable place, on all signals.
pub(super) fn regions(
    bench: &Bench,
    motion: &Motion,
    places: &[PlaceEvidence],
    residuals: &[Rows],
) -> Vec<Region> {
    let axes = axes(bench, motion);
    let mut targets: Vec<Target> = (residuals.iter().zip(bench.simulator.outputs()))
        .map(|(rows, output)| Target {
            of: RegionOf::Residual(output.name.clone()),
            values: rows.concat(),
        })
        .collect();
    if let Some((site, values)) = missing_signal(places) {
        targets.push(Target { of: RegionOf::Signal(site), values });
    }
    let pairs: Vec<(&Target, &Axis)> =
        targets.iter().flat_map(|target| axes.iter().map(move |axis| (target, axis))).collect();
    let observed: Vec<[f64; 2]> = pairs.iter().map(|(t, a)| shares(&t.values, a, 0)).collect();
    let n = targets.first().map_or(0, |target| target.values.len());
    let chance: Vec<Vec<[f64; 2]>> = shifts(n)
        .map(|shift| pairs.iter().map(|(t, a)| shares(&t.values, a, shift)).collect())
        .collect();
    let p_values = p_values(&observed, &chance);
    let mut regions: Vec<Region> = pairs
        .iter()
        .zip(observed)
        .zip(p_values)
        .map(|(((target, axis), [level_share, size_share]), p_value)| {
            let share = level_share.max(size_share);
            let is_significant = p_value <= FALSE_CLAIMS && MATTERS <= share;
            let bins = bins(&target.values, axis);
            let mut region = Region {
                of: target.of.clone(),
                on: axis.on.clone(),
                unit: axis.unit.clone(),
                bins,
                level_share,
                size_share,
                p_value,
                is_significant,
                statement: String::new(),
            };
            region.statement = words(&region);
            region
        })
        .collect();
    let strength = |region: &Region| {
        let share = region.level_share.max(region.size_share);
        let preferred = if region.bins.len() == 2 { SIMPLER * share } else { share };
        // What is missing is of more interest than what is left of it in an output.
        (region.is_significant, matches!(region.of, RegionOf::Signal(_)), preferred)
    };
    regions.sort_by(|a, b| {
        let (a, b) = (strength(a), strength(b));
        b.0.cmp(&a.0).then(b.1.cmp(&a.1)).then(b.2.total_cmp(&a.2))
    });
    regions
}

/// The free signal at the first place that has an evident one.
fn missing_signal(places: &[PlaceEvidence]) -> Option<(fd_effect::SiteRef, Vec<f64>)> {
    let evident = places.iter().find_map(|place| {
        let free = place.free.as_ref().filter(|free| EVIDENT < free.log_evidence)?;
        Some((place, free))
    });
    evident.map(|(place, free)| (place.site.clone(), free.values.concat()))
}

/// Inputs, states, outputs and directions that move.
fn axes(bench: &Bench, motion: &Motion) -> Vec<Axis> {
    let column = |rows: &Rows, i: usize, width: usize| -> Vec<f64> {
        rows.iter().flat_map(|rows| rows.iter().skip(i).step_by(width).copied()).collect()
    };
    let mut axes = Vec::new();
    let inputs: Rows = bench.logs.iter().map(|log| log.u.clone()).collect();
    let nu = bench.simulator.inputs().len();
    for (i, channel) in bench.simulator.inputs().iter().enumerate() {
        let values = column(&inputs, i, nu);
        let (name, unit) = (channel.name.clone(), &channel.unit);
        axes.extend(Axis::of(RegionOn::Input(name.clone()), unit, &values));
        axes.extend(Axis::of(RegionOn::InputAmplitude(name), unit, &magnitude(&values)));
    }
    let width = bench.ny() + motion.velocities.len();
    let mut known: Vec<Vec<f64>> = Vec::new();
    let initial = bench.simulator.initial();
    for (i, state) in initial.iter().enumerate() {
        let values = column(&motion.states, i, initial.len());
        let (name, unit) = (state.channel.name.clone(), &state.channel.unit);
        axes.extend(Axis::of(RegionOn::State(name.clone()), unit, &values));
        axes.extend(Axis::of(RegionOn::StateAmplitude(name), unit, &magnitude(&values)));
        known.push(values);
    }
    for (i, channel) in bench.simulator.outputs().iter().enumerate() {
        let values = column(&motion.outputs, i, width);
        // An output that shows a state is that state.
        if !known.iter().any(|state| is_same(state, &values)) {
            axes.extend(Axis::of(RegionOn::Output(channel.name.clone()), &channel.unit, &values));
        }
    }
    for (i, (site, unit)) in motion.velocities.iter().enumerate() {
        let velocity = column(&motion.outputs, bench.ny() + i, width);
        axes.extend(Axis::direction(site, unit, &velocity));
    }
    axes
}

fn magnitude(values: &[f64]) -> Vec<f64> {
    let finite = || values.iter().filter(|v| v.is_finite());
    let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
    values.iter().map(|v| (v - mean).abs()).collect()
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    let size = a.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * size || (a.is_nan() && b.is_nan()))
}

impl Axis {
    /// Bins of about as many samples each; `None` when the signal has fewer than two levels.
    fn of(on: RegionOn, unit: &str, values: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        let mut edges: Vec<f64> = (1..BINS).map(|i| sorted[i * sorted.len() / BINS]).collect();
        edges.dedup();
        edges.retain(|edge| first < *edge);
        if edges.is_empty() || sorted.len() < 2 * FEWEST {
            return None;
        }
        let lows: Vec<f64> = std::iter::once(first).chain(edges.iter().copied()).collect();
        let highs = edges.iter().copied().chain([last]);
        let limits = lows.iter().copied().zip(highs).map(|(low, high)| [low, high]).collect();
        let bin = |v: &f64| v.is_finite().then(|| edges.partition_point(|edge| edge <= v));
        let bins = values.iter().map(bin).collect();
        Some(Self { on, unit: unit.to_owned(), bins, limits })
    }

    /// Backward and forward.
    fn direction(site: &str, unit: &str, velocity: &[f64]) -> Option<Self> {
        let limits = velocity.iter().filter(|v| v.is_finite());
        let [low, high] = limits.fold([0.0_f64; 2], |l, v| [l[0].min(*v), l[1].max(*v)]);
        let bin = |v: &f64| (v.abs() > 0.0).then(|| usize::from(0.0 < *v));
        let bins: Vec<Option<usize>> = velocity.iter().map(bin).collect();
        let count = |side| bins.iter().filter(|bin| **bin == Some(side)).count();
        (FEWEST <= count(0) && FEWEST <= count(1)).then(|| Self {
            on: RegionOn::Direction(site.to_owned()),
            unit: unit.to_owned(),
            bins,
            limits: vec![[low, 0.0], [0.0, high]],
        })
    }
}

/// Corrected correlation ratios of values, shifted in a circle, and of their squares with bins:
/// `1 − (1 − η²)(n − 1)/(n − m)`, not below zero.
fn shares(values: &[f64], axis: &Axis, shift: usize) -> [f64; 2] {
    let m = axis.limits.len();
    let mut sums = [[0.0; 3]; BINS];
    let (mut fourth, mut n) = (0.0, 0.0);
    let (tail, head) = values.split_at(values.len() - shift.min(values.len()));
    for (value, bin) in head.iter().chain(tail).zip(&axis.bins) {
        let Some(bin) = bin.filter(|_| value.is_finite()) else { continue };
        let square = value * value;
        let sum = &mut sums[bin];
        sum[0] += 1.0;
        sum[1] += value;
        sum[2] += square;
        fourth += square * square;
        n += 1.0;
    }
    if n <= m as f64 + 1.0 {
        return [0.0; 2];
    }
    let share = |moment: usize, squares: f64| {
        let total: f64 = sums.iter().map(|sum| sum[moment]).sum();
        let all = squares - total * total / n;
        let filled = sums.iter().filter(|sum| 0.0 < sum[0]);
        let between =
            filled.map(|sum| sum[moment] * sum[moment] / sum[0]).sum::<f64>() - total * total / n;
        if all <= 0.0 {
            return 0.0;
        }
        (1.0 - (1.0 - between / all) * (n - 1.0) / (n - m as f64)).max(0.0)
    };
    [share(1, sums.iter().map(|sum| sum[2]).sum()), share(2, fourth)]
}

/// Seeded shifts, none of them short.
fn shifts(n: usize) -> impl Iterator<Item = usize> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below n")]
    let least = ((LEAST_SHIFT * n as f64) as usize).max(1);
    let count = if 2 * least + 1 < n { SHIFTS } else { 0 };
    (0..count).map(move |_| {
        let shift = random.random_range(least as u64..(n - least) as u64);
        usize::try_from(shift).unwrap_or(least)
    })
}

/// Probabilities of shares as large as observed anywhere: shares are measured in standard
/// deviations of what the shifts give, and compared with the largest one of each shift (Westfall
/// and Young 1993).
fn p_values(observed: &[[f64; 2]], chance: &[Vec<[f64; 2]>]) -> Vec<f64> {
    let count = chance.len() as f64;
    if chance.is_empty() {
        return vec![1.0; observed.len()];
    }
    let scales: Vec<[[f64; 2]; 2]> = (0..observed.len())
        .map(|i| {
            [0, 1].map(|kind| {
                let all = || chance.iter().map(|shift| shift[i][kind]);
                let mean = all().sum::<f64>() / count;
                let variance = all().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
                // Shares below a thousandth are all the same.
                [mean, variance.sqrt().max(1e-3)]
            })
        })
        .collect();
    let score = |values: &[[f64; 2]], i: usize| {
        [0, 1]
            .map(|kind| (values[i][kind] - scales[i][kind][0]) / scales[i][kind][1])
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let largest = |values: &Vec<[f64; 2]>| {
        (0..values.len()).map(|i| score(values, i)).fold(f64::NEG_INFINITY, f64::max)
    };
    let tops: Vec<f64> = chance.iter().map(largest).collect();
    let p_value = |i: usize| {
        let own = score(observed, i);
        let above = tops.iter().filter(|top| own <= **top).count();
        (1.0 + above as f64) / (1.0 + count)
    };
    (0..observed.len()).map(p_value).collect()
}

fn bins(values: &[f64], axis: &Axis) -> Vec<Bin> {
    let bin = |(place, [low, high]): (usize, &[f64; 2])| {
        let (mut count, mut sum, mut squares) = (0, 0.0, 0.0);
        for (value, bin) in values.iter().zip(&axis.bins) {
            if *bin == Some(place) && value.is_finite() {
                count += 1;
                sum += value;
                squares += value * value;
            }
        }
        let n = f64::from(u32::try_from(count.max(1)).unwrap_or(u32::MAX));
        Bin { low: *low, high: *high, count, mean: sum / n, rms: f64::sqrt(squares / n) }
    };
    axis.limits.iter().enumerate().map(bin).collect()
}

fn words(region: &Region) -> String {
    let of = match &region.of {
        RegionOf::Residual(output) => format!("the residual of `{output}`"),
        RegionOf::Signal(site) => format!("what is missing at {}", name(site)),
    };
    let on = match &region.on {
        RegionOn::Input(name) => format!("input `{name}`"),
        RegionOn::InputAmplitude(name) => format!("the magnitude of input `{name}`"),
        RegionOn::State(name) => format!("`{name}`"),
        RegionOn::StateAmplitude(name) => format!("the magnitude of `{name}`"),
        RegionOn::Output(name) => format!("output `{name}`"),
        RegionOn::Direction(site) => format!("the direction of motion at `{site}`"),
    };
    if !region.is_significant {
        return format!("{of} does not depend significantly on {on}");
    }
    let share = 100.0 * region.level_share.max(region.size_share);
    if region.size_share <= region.level_share {
        return format!("{of} depends on {on}: it explains {share:.0} % of it");
    }
    let top = region.bins.iter().max_by(|a, b| a.rms.total_cmp(&b.rms));
    let place = top.map_or_else(String::new, |bin| {
        format!(
            ", and is largest from {:.3} to {:.3} {}",
            Short(bin.low),
            Short(bin.high),
            region.unit
        )
    });
    format!("the size of {of} depends on {on}: it explains {share:.0} % of it{place}")
}
