//! Power of a gap over frequency, against the floor and the inputs.

use std::f64::consts::TAU;

use fd_numeric::fourier::{Complex64, Fourier};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{
    bench::{Bench, Rows},
    result::{Band, Spectrum},
};
use crate::{diagnose::Diagnosis, quality::Autoregression};

/// Bands.
const BANDS: usize = 8;
/// Lines of the spectrum below the first edge.
const LOWEST_LINES: f64 = 4.0;
/// Probability of any false claim in all bands and outputs together.
const FALSE_CLAIMS: f64 = 0.05;
/// Power above the floor from which a band matters, as a multiple of it.
const MATTERS: f64 = 1.2;
/// Independent lines per line under Hann's window: `1/Σρ²` with ρ² = 1, 4/9, 1/36 at 0, 1, 2 lines.
const INDEPENDENT: f64 = 1.0 / (1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0));
/// Least stretches that a coherence is averaged over.
const LEAST_STRETCHES: usize = 8;
/// Least samples of such a stretch.
const LEAST_STRETCH: usize = 32;
/// Spectra of all outputs; `before` and `after` are residuals in sigma per output and log.
pub(super) fn spectra(
    bench: &Bench,
    diagnosis: &Diagnosis,
    before: &[Rows],
    after: &[Rows],
) -> Vec<Spectrum> {
    let edges = edges(bench);
    let alpha = FALSE_CLAIMS / (BANDS * bench.ny()) as f64;
    let spectrum = |c: usize| {
        let colour = if diagnosis.is_coloured {
            let signals: Vec<&[f64]> = after[c].iter().map(Vec::as_slice).collect();
            Autoregression::fit(&signals, Autoregression::HIGHEST_ORDER)
        } else {
            Autoregression::white()
        };
        let floor = Floor::new(&colour, diagnosis.floor[c].powi(2), bench.ts());
        let refit = Power::of(&before[c], &edges, bench.ts(), &floor);
        let left = Power::of(&after[c], &edges, bench.ts(), &floor);
        let excess = |b: usize| (refit.signal[b] - refit.floor[b]).max(0.0);
        let total: f64 = (0..BANDS).map(excess).sum();
        let coherence: Vec<Vec<Option<f64>>> = (0..bench.simulator.inputs().len())
            .map(|i| coherence(bench, &before[c], i, &edges))
            .collect();
        let band = |b: usize| Band {
            low_hz: if b == 0 { 0.0 } else { edges[b - 1] },
            high_hz: edges[b],
            refit: refit.signal[b],
            after: left.signal[b],
            floor: refit.floor[b],
            share: if 0.0 < total { excess(b) / total } else { 0.0 },
            is_above_floor: refit.is_above(b, alpha),
            is_above_floor_after: left.is_above(b, alpha),
            coherence: coherence.iter().map(|bands| bands[b]).collect(),
        };
        let output = bench.simulator.outputs()[c].name.clone();
        let bands: Vec<Band> = (0..BANDS).map(band).collect();
        let inputs: Vec<&str> =
            bench.simulator.inputs().iter().map(|input| input.name.as_str()).collect();
        Spectrum { statement: words(&output, &bands, &inputs), output, bands }
    };
    (0..bench.ny()).map(spectrum).collect()
}

/// Upper ends of the bands, in Hz: a few lines of the longest log, then even factors up to half the
/// sample rate.
fn edges(bench: &Bench) -> [f64; BANDS] {
    let longest = bench.logs.iter().map(|log| log.samples).max().unwrap_or(1) as f64;
    let highest = 0.5 / bench.ts();
    let lowest = (LOWEST_LINES / (longest * bench.ts())).min(0.5 * highest);
    let factor = highest / lowest;
    std::array::from_fn(|b| lowest * factor.powf(b as f64 / (BANDS - 1) as f64))
}

fn band_of(frequency: f64, edges: &[f64; BANDS]) -> usize {
    edges.iter().position(|edge| frequency <= edge * (1.0 + 1e-9)).unwrap_or(BANDS - 1)
}

/// Spectral density of the noise.
struct Floor {
    /// `1, −a₁, …, −a_p`, divided by the spread of the innovations.
    filter: Vec<f64>,
    variance: f64,
    ts: f64,
}

impl Floor {
    fn new(colour: &Autoregression, variance: f64, ts: f64) -> Self {
        // The whitening filter, seen in its response to an impulse after enough zeros.
        let order = colour.order();
        let mut impulse = vec![0.0; 2 * order + 1];
        impulse[order] = 1.0;
        let mut response = impulse.clone();
        colour.whiten(&impulse, &mut response);
        Self { filter: response[order..].to_vec(), variance, ts }
    }

    /// Density relative to that of white noise, times the variance.
    fn at(&self, frequency: f64) -> f64 {
        let terms = self.filter.iter().enumerate();
        let sum: Complex64 = terms
            .map(|(k, w)| Complex64::from_polar(*w, -TAU * frequency * self.ts * k as f64))
            .sum();
        self.variance / sum.norm_sqr()
    }
}

/// Power per band, of a signal and of the floor, and how many lines made it.
struct Power {
    signal: [f64; BANDS],
    floor: [f64; BANDS],
    lines: [f64; BANDS],
}

impl Power {
    /// Periodograms under Hann's window, one per log, the mean apart (it counts for the lowest
    /// band).
    fn of(signals: &Rows, edges: &[f64; BANDS], ts: f64, floor: &Floor) -> Self {
        let mut fourier = Fourier::new();
        let mut all = Self { signal: [0.0; BANDS], floor: [0.0; BANDS], lines: [0.0; BANDS] };
        let total = signals.iter().flatten().filter(|v| v.is_finite()).count() as f64;
        for signal in signals {
            let n = signal.len();
            let finite = || signal.iter().filter(|v| v.is_finite());
            let count = finite().count() as f64;
            if n < 4 || count <= 0.0 {
                continue;
            }
            let mean = finite().sum::<f64>() / count;
            let window = hann(n);
            let energy: f64 =
                signal.iter().zip(&window).filter(|(v, _)| v.is_finite()).map(|(_, w)| w * w).sum();
            let centred = |(v, w): (&f64, &f64)| if v.is_finite() { (v - mean) * w } else { 0.0 };
            let mut windowed: Vec<f64> = signal.iter().zip(&window).map(centred).collect();
            let lines = fourier.lines(&mut windowed);
            // The share of this log in the mean square, spread over its lines.
            let weight = count / total;
            let share = weight * 2.0 / (n as f64 * energy);
            all.signal[0] += weight * mean * mean;
            for (k, line) in lines.iter().enumerate().skip(1) {
                let frequency = k as f64 / (n as f64 * ts);
                let b = band_of(frequency, edges);
                // Half of the line at half the sample rate belongs to the other side.
                let part = if 2 * k == n { 0.5 } else { 1.0 };
                all.signal[b] += part * share * line.norm_sqr();
                all.floor[b] += part * share * energy * floor.at(frequency);
                all.lines[b] += part;
            }
        }
        all
    }

    /// Whether there is more in a band than noise makes with probability `alpha`.
    fn is_above(&self, band: usize, alpha: f64) -> bool {
        let freedom = (2.0 * self.lines[band] * INDEPENDENT).max(1.0);
        let Ok(distribution) = ChiSquared::new(freedom) else { return false };
        let limit = distribution.inverse_cdf(1.0 - alpha) / freedom;
        limit.max(MATTERS) * self.floor[band] < self.signal[band]
    }
}

fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|k| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos()).collect()
}

/// Squared coherence of a residual with an input per band, weighted with the power of the residual,
/// less what unrelated signals show (Carter 1987: one over the number of stretches).
fn coherence(
    bench: &Bench,
    residual: &Rows,
    input: usize,
    edges: &[f64; BANDS],
) -> Vec<Option<f64>> {
    let total: usize = bench.logs.iter().map(|log| log.samples).sum();
    // So that half-overlapping stretches make at least `LEAST_STRETCHES`.
    let length = (2 * total / (LEAST_STRETCHES + 1)).clamp(1, 1024);
    if length < LEAST_STRETCH {
        return vec![None; BANDS];
    }
    let mut fourier = Fourier::new();
    let window = hann(length);
    let lines = length / 2 + 1;
    let (mut rr, mut uu) = (vec![0.0; lines], vec![0.0; lines]);
    let mut ru = vec![Complex64::new(0.0, 0.0); lines];
    let mut stretches = 0.0_f64;
    for (log, signal) in bench.logs.iter().zip(residual) {
        let u: Vec<f64> = (0..log.samples).map(|k| log.input(k)[input]).collect();
        let mut from = 0;
        while from + length <= log.samples {
            let mut part = |signal: &[f64]| {
                let signal = &signal[from..from + length];
                let finite = || signal.iter().filter(|v| v.is_finite());
                let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
                let centred =
                    |(v, w): (&f64, &f64)| if v.is_finite() { (v - mean) * w } else { 0.0 };
                let mut windowed: Vec<f64> = signal.iter().zip(&window).map(centred).collect();
                fourier.lines(&mut windowed)
            };
            let (r, u) = (part(signal), part(&u));
            for k in 0..lines {
                rr[k] += r[k].norm_sqr();
                uu[k] += u[k].norm_sqr();
                ru[k] += r[k] * u[k].conj();
            }
            stretches += 1.0;
            from += length / 2;
        }
    }
    if stretches < LEAST_STRETCHES as f64 {
        return vec![None; BANDS];
    }
    let chance = 1.0 / stretches;
    let largest = uu.iter().copied().fold(0.0, f64::max);
    let mut sums = [[0.0; 2]; BANDS];
    for k in 1..lines {
        let band = band_of(k as f64 / (length as f64 * bench.ts()), edges);
        // Where the input has no power, rounding is coherent with nothing.
        let is_driven = 1e-12 * largest < uu[k] && 0.0 < rr[k];
        let squared = if is_driven { ru[k].norm_sqr() / (rr[k] * uu[k]) } else { chance };
        sums[band][0] += squared * rr[k];
        sums[band][1] += rr[k];
    }
    let share = |[coherent, all]: [f64; 2]| {
        (0.0 < all).then(|| ((coherent / all - chance) / (1.0 - chance)).clamp(0.0, 1.0))
    };
    sums.map(share).to_vec()
}

/// Share of the excess that is called most of it.
const MOST: f64 = 0.5;
/// Coherence from which a gap is said to follow an input.
const FOLLOWS: f64 = 0.5;

fn words(output: &str, bands: &[Band], inputs: &[&str]) -> String {
    use super::channels::Short;

    let hertz = |hz: f64| format!("{:.2}", Short(hz));
    let claimed: Vec<usize> = (0..bands.len()).filter(|&b| bands[b].is_above_floor).collect();
    let (Some(&first), Some(&last)) = (claimed.first(), claimed.last()) else {
        return format!("{output}: no band is above the noise floor");
    };
    let largest =
        claimed.iter().copied().max_by(|a, b| bands[*a].share.total_cmp(&bands[*b].share));
    let top = &bands[largest.unwrap_or(first)];
    let place = if MOST < top.share {
        format!(
            "{:.0} % of the gap is between {} and {} Hz",
            100.0 * top.share,
            hertz(top.low_hz),
            hertz(top.high_hz)
        )
    } else {
        let share: f64 = bands[first..=last].iter().map(|band| band.share).sum();
        format!(
            "{:.0} % of the gap is spread from {} to {} Hz",
            100.0 * share,
            hertz(bands[first].low_hz),
            hertz(bands[last].high_hz)
        )
    };
    let coherent = (top.coherence.iter().zip(inputs))
        .filter_map(|(coherence, input)| Some(((*coherence)?, input)))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let follows = match coherent {
        Some((share, input)) if FOLLOWS < share => {
            format!("; {:.0} % of it there follows `{input}` linearly", 100.0 * share)
        }
        Some(_) => "; it does not follow an input linearly".to_owned(),
        None => String::new(),
    };
    let left: Vec<&Band> = bands.iter().filter(|band| band.is_above_floor_after).collect();
    let left = match (left.first(), left.last()) {
        (Some(first), Some(last)) => format!(
            "; with the best explanation, {} to {} Hz remain above the floor",
            hertz(first.low_hz),
            hertz(last.high_hz)
        ),
        _ => String::new(),
    };
    format!("{output}: {place}{follows}{left}")
}
