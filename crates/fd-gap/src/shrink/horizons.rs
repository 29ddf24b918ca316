//! How far to forecast: the memory of the plant settles it.

use faer::Mat;
use fd_numeric::dense::DenseReal;
use fd_numeric::upper_median;
use fd_sim::simulate::{Outcome, Simulator, walk};

use crate::fit::{Horizon, Log, shortest_window};

/// Instants of a log at which a plant is linearised.
const INSTANTS: usize = 9;
/// Change of a state, in its range over the log, for a difference quotient: errors of rounding and
/// of curvature are both about 1e-6 of the slope.
const STEP: f64 = 1e-5;
/// A time constant that is longer than this part of the shortest log is cut to it: what is slower
/// looks like an integrator to the log.
const LONGEST: f64 = 0.1;
/// The middle horizon, in time constants.
const MIDDLE: f64 = 5.0;

/// The slowest time constant, in samples, with which a plant forgets: `−1/ln|μ|` of the largest
/// eigenvalue `μ` inside the unit circle of its transition over one sample, `∂x(k+1)/∂x(k)`.
/// Eigenvalues on or outside the circle (integrators, unstable points) have none.
///
/// The transition is taken by differences at nine instants of a simulation with parameters `theta`
/// from the state `x0`; the median counts, as a nonlinear plant has others at each. Use the refitted
/// parameters: nominal ones can be wrong by far more than a horizon may be.
///
/// `None` when the plant has no states, nothing decays, or the simulation diverges.
///
/// # Panics
///
/// May panic when the numbers of values are wrong, as the simulator does.
#[must_use]
pub fn dominant_time_constant(
    simulator: &dyn Simulator,
    theta: &[f64],
    x0: &[f64],
    log: &Log,
) -> Option<f64> {
    // What makes whole runs only cannot be asked where it goes from a state.
    if !simulator.makes_steps() {
        return None;
    }
    let mut simulator = simulator.boxed();
    let mut y = vec![0.0; simulator.outputs().len()];
    let mut states: Vec<Vec<f64>> = Vec::with_capacity(log.samples);
    let (mut all, note) = (vec![0.0; log.samples * log.ny], |_, x: &[f64]| states.push(x.to_vec()));
    if walk(&mut *simulator, theta, x0, 0, &log.u, &mut all, note) != Outcome::Complete {
        return None;
    }
    let ranges: Vec<f64> = (0..x0.len())
        .map(|i| {
            let values = || states.iter().map(|x| x[i]);
            let width =
                values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
            let size = values().fold(0.0_f64, |size, x| size.max(x.abs()));
            width.max(1e-3 * size).max(1e-9)
        })
        .collect();
    let mut times: Vec<f64> = (0..INSTANTS)
        .filter_map(|i| {
            let k = (2 * i + 1) * log.samples / (2 * INSTANTS);
            let mut run = |x: &[f64]| {
                simulator.start(theta, x, k as u64);
                simulator.step(log.input(k), log.input(k + 1), &[], &mut y);
                simulator.state()[..x.len()].to_vec()
            };
            slowest_decay(&mut run, &states[k], &ranges)
        })
        .collect();
    upper_median(&mut times)
}

/// Time constant of the slowest decay at one instant, in samples.
fn slowest_decay(
    run: &mut dyn FnMut(&[f64]) -> Vec<f64>,
    x: &[f64],
    ranges: &[f64],
) -> Option<f64> {
    let here = run(x);
    // States in their ranges: a change of units does not change the eigenvalues.
    let mut transition = Mat::zeros(x.len(), x.len());
    let mut moved = x.to_vec();
    for (j, range) in ranges.iter().enumerate() {
        moved[j] = x[j] + STEP * range;
        for (i, there) in run(&moved).iter().enumerate() {
            transition[(i, j)] = (there - here[i]) / (STEP * ranges[i]);
        }
        moved[j] = x[j];
    }
    let finite = (0..x.len()).all(|j| (0..x.len()).all(|i| f64::is_finite(transition[(i, j)])));
    let eigenvalues = finite.then(|| transition.modes().ok())??;
    // A difference quotient cannot tell an integrator from a decay over 1e5 samples.
    let decays = eigenvalues.iter().map(|mu| mu.norm()).filter(|mu| *mu < 1.0 - 1e-5);
    let slowest = decays.fold(0.0, f64::max);
    (0.0 < slowest).then(|| -1.0 / slowest.ln())
}

/// Horizons at which forecasts are scored: windows of one and of five time constants (in samples),
/// and the free run. Without a time constant, or with one that is long against the shortest log,
/// the window is a tenth of that log. Equal horizons appear once.
///
/// ```
/// use fd_gap::{fit::Horizon::{FreeRun, Windows}, shrink::horizons};
///
/// let all = horizons(Some(20.0), 2, 1000);
/// assert_eq!(all, [Windows { samples: 20 }, Windows { samples: 100 }, FreeRun]);
/// assert_eq!(horizons(Some(2.0), 2, 1000)[..2], [Windows { samples: 8 }, Windows { samples: 10 }]);
/// assert_eq!(horizons(None, 2, 200)[0], Windows { samples: 20 });
/// ```
#[must_use]
pub fn horizons(time_constant: Option<f64>, states: usize, shortest_log: usize) -> Vec<Horizon> {
    let longest = LONGEST * shortest_log as f64;
    let time_constant = time_constant.map_or(longest, |t| t.min(longest));
    let least = shortest_window(states);
    let window = |factor: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below a log")]
        let samples = ((factor * time_constant).round() as usize).max(least);
        if 2 * samples <= shortest_log { Horizon::Windows { samples } } else { Horizon::FreeRun }
    };
    let mut all = vec![window(1.0), window(MIDDLE), Horizon::FreeRun];
    all.dedup();
    all
}
