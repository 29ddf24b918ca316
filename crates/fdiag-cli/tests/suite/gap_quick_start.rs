//! The quick start works as the README prints it, on logs that this file makes.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a failure here is a failed test"
)]

use std::path::{Path, PathBuf};

use fdiag::{
    effect::SiteRef,
    gap::diagnose::Verdict,
    gap_study::{GapStudy, HeldOutChoice, Request, words},
    log::{LogMap, read_log},
    model::{Channel, Record, SampleTime},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Dry friction of the rail, in N: what the model does not know.
const FRICTION: f64 = 0.35;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/gap/quick-start")
}

fn channels() -> [Vec<Channel>; 2] {
    [vec![Channel::new("force", "N")], vec![Channel::new("speed", "m/s")]]
}

/// A run of the real cart: another mass and drag than the model has, dry friction that holds the
/// cart until the force exceeds it (Karnopp 1985, not a law of the library), integrated a hundred
/// times finer than sampled, and white noise of the tacho.
fn run(seed: u64) -> Record {
    let (samples, fine, ts) = (1000, 100, 0.01);
    let (mass, drag, standing) = (1.215, 1.43, 1e-4);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut force, mut left, mut v) = (0.0, 0, 0.0_f64);
    let mut rows = Vec::new();
    for _ in 0..samples {
        if left == 0 {
            force = (random.random_range(-2.4..2.4_f64) * 1e3).round() / 1e3;
            left = random.random_range(15..70);
        }
        left -= 1;
        // Twelve uniform numbers make a nearly Gaussian one.
        let noise = 0.004 * ((0..12).map(|_| random.random_range(0.0..1.0)).sum::<f64>() - 6.0);
        rows.push(([force], [((v + noise) * 1e5).round() / 1e5]));
        for _ in 0..fine {
            let push: f64 = force - drag * v;
            let net = if v.abs() < standing {
                push - push.clamp(-FRICTION, FRICTION)
            } else {
                push - FRICTION * v.signum()
            };
            let next = v + net / mass * ts / f64::from(fine);
            // Friction stops the cart; it does not push it back.
            v = if v * next < 0.0 { 0.0 } else { next };
        }
    }
    let [inputs, outputs] = channels();
    Record::from_rows(inputs, outputs, rows, SampleTime::new(ts).unwrap()).unwrap()
}

/// The committed logs are those of this file.
#[test]
fn the_logs_are_what_they_are_said_to_be() {
    let [inputs, outputs] = channels();
    let map = LogMap::for_channels(&inputs, &outputs);
    for (file, seed) in [("monday.csv", 1), ("friday.csv", 2)] {
        let (log, made) = (read_log(folder().join(file), &map).unwrap().record, run(seed));
        assert_eq!(log.len(), made.len());
        for k in 0..log.len() {
            // The last of five digits may be rounded the other way on another machine.
            assert!((log.u(k)[0] - made.u(k)[0]).abs() < 1e-9, "{file} {k}");
            assert!((log.y(k)[0] - made.y(k)[0]).abs() < 1.5e-5, "{file} {k}");
        }
    }
}

#[test]
fn the_friction_of_the_cart_is_found() {
    let mut request = Request::new(folder().join("model.toml"), [folder().join("monday.csv")]);
    request.held_out = HeldOutChoice::Logs(vec![folder().join("friday.csv")]);
    let report = GapStudy::run(&request, &()).unwrap().report;
    println!("{}", report.headline);
    let first = &report.diagnosis.causes[0];
    assert_eq!((report.diagnosis.verdict, first.label), (Verdict::Cause, "coulomb-friction"));
    assert_eq!(first.site, SiteRef::Force(0, "rail".to_owned()));
    assert!(0.9 < first.probability);
    // The plain law, without a breakaway that the rail does not have, as exactly as the log says.
    let [strength] = &first.parameters[..] else { panic!("{}", words::strength(first)) };
    let error = (strength.value - FRICTION).abs();
    assert!(error < strength.standard_error, "{}", words::strength(first));
    let closed = report.diagnosis.held_out[0].closed_of_refit.unwrap();
    assert!(0.9 < closed.fraction && closed.interval[0] < closed.fraction, "{closed:?}");
}
