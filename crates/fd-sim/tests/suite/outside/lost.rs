//! Processes that end, hang or go wrong in the middle of a run.

use std::{
    process::Command,
    time::{Duration, Instant},
};

use fd_sim::{
    outside::{OutsideError, OutsideSimulator},
    simulate::Simulator,
};

use super::{SAMPLES, inside, nominal, open, outside, process, pushed, with};

/// A file that nobody has made yet.
fn marker(directory: &tempfile::TempDir) -> String {
    directory.path().join("done").display().to_string()
}

#[test]
fn a_process_that_dies_once_is_started_again_and_the_run_repeated() {
    for by_steps in [false, true] {
        let directory = tempfile::tempdir().unwrap();
        let mut process = outside(&["die", "50", &marker(&directory)]);
        let (found, expected) = if by_steps {
            (pushed(&mut process, 0.2), pushed(&mut inside(), 0.2))
        } else {
            (nominal(&mut process).0, nominal(&mut inside()).0)
        };
        assert_eq!(found, expected);
        let counts = process.counts();
        assert_eq!((counts.deaths, counts.lost, counts.started), (1, 0, 2));
        let trouble = process.trouble().unwrap().to_string();
        assert!(trouble.contains("exit status: 3"), "{trouble}");
        assert!(trouble.contains("| out of licences\n  | at step 51"), "{trouble}");
    }
}

/// What it shows depends on how many runs it has begun.
#[test]
fn a_process_that_cannot_begin_again_is_started_for_each_run() {
    for cannot_reset in [false, true] {
        let process = process(&["leftover"]);
        let mut contract = process.contract().unwrap();
        contract.powers.resets = !cannot_reset;
        let mut process = OutsideSimulator::new(contract, process, 1).unwrap();
        let mut shown = Vec::new();
        for k in 0..4 {
            // Parameters that no run had before.
            let theta = [1.5 + 0.1 * f64::from(k), 0.8, 6.0];
            shown.push(with(&mut process, &theta).0[0] - with(&mut inside(), &theta).0[0]);
        }
        let by_steps = pushed(&mut process, 0.2)[0] - pushed(&mut inside(), 0.2)[0];
        shown.push(by_steps);
        let started = process.counts().started;
        if cannot_reset {
            // The one that is started to see whether it can be has begun a run as well.
            assert_eq!(started, 6);
            assert!(shown.iter().all(|offset| (offset - 1e-3).abs() < 1e-12), "{shown:?}");
        } else {
            assert_eq!(started, 1);
            assert!(shown.windows(2).all(|pair| pair[0] < pair[1]), "{shown:?}");
        }
    }
}

#[test]
fn three_deaths_at_the_same_parameters_are_a_divergence_there_and_nowhere_else() {
    let mut process = outside(&["die-when-light", "30"]);
    let light = [0.9, 0.8, 6.0];
    let begun = with(&mut process, &light);
    assert!(begun.0.iter().all(|y| y.is_nan()) && !begun.1);
    let counts = process.counts();
    assert_eq!((counts.deaths, counts.lost), (3, 1));
    // Nobody tries that again.
    assert!(!with(&mut process, &light).1);
    assert_eq!(process.counts().deaths, 3);
    assert_eq!(nominal(&mut process), nominal(&mut inside()));

    // By steps it goes well for thirty samples.
    process.start(&[0.8, 0.8, 6.0], &[0.1, 0.0], 0);
    let mut y = [0.0; 2];
    for k in 0..SAMPLES {
        process.step(&[1.0], &[1.0], &[], &mut y);
        assert_eq!(y.iter().all(|y| y.is_finite()), k < 30, "{k}");
    }
}

#[test]
fn a_process_that_is_killed_in_mid_run_is_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let file = marker(&directory);
    let mut process = open(process(&["tell", "0", &file]), 1).unwrap();
    let mut expected = inside();
    process.start(&[1.5, 0.8, 6.0], &[0.1, 0.0], 0);
    expected.start(&[1.5, 0.8, 6.0], &[0.1, 0.0], 0);
    let mut y = [[0.0; 2]; 2];
    for k in 0..SAMPLES {
        if k == 60 {
            let number = std::fs::read_to_string(&file).unwrap();
            assert!(Command::new("kill").args(["-9", &number]).status().unwrap().success());
        }
        process.step(&[1.0], &[1.0], &[], &mut y[0]);
        expected.step(&[1.0], &[1.0], &[], &mut y[1]);
        assert_eq!(y[0], y[1], "{k}");
    }
    let counts = process.counts();
    assert_eq!((counts.deaths, counts.lost, counts.started, counts.repeated), (1, 0, 2, 1));
    let trouble = process.trouble().unwrap().to_string();
    assert!(trouble.contains("signal: 9"), "{trouble}");
}

#[test]
fn a_process_that_hangs_is_ended_after_its_limit() {
    let mut slow = process(&["hang", "20"]);
    slow.timeout = Duration::from_secs(3);
    let mut process = open(slow, 2).unwrap();
    let begun = Instant::now();
    let (y, is_complete) = nominal(&mut process);
    // Twice the limit, and starting again.
    assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
    assert!(!is_complete && y.iter().all(|y| y.is_nan()));
    assert_eq!(process.counts().deaths, 2);
    let trouble = process.trouble().unwrap();
    assert!(matches!(trouble, OutsideError::Silent { .. }), "{trouble}");
    assert!(trouble.to_string().contains("not answered to rollout within 3 s"), "{trouble}");
}

#[test]
fn a_process_that_hangs_once_is_no_loss() {
    let directory = tempfile::tempdir().unwrap();
    let mut slow = process(&["hang", "20", &marker(&directory)]);
    slow.timeout = Duration::from_secs(3);
    let mut process = open(slow, 1).unwrap();
    assert_eq!(nominal(&mut process), nominal(&mut inside()));
    assert_eq!(process.counts().deaths, 1);
}

#[test]
fn one_that_does_not_read_is_ended_too() {
    let mut deaf = process(&["deaf"]);
    deaf.timeout = Duration::from_millis(300);
    let error = open(deaf, 1).unwrap_err();
    assert!(matches!(error, OutsideError::Silent { .. }), "{error}");
}

#[test]
fn what_is_not_finite_is_a_divergence_from_there_on() {
    let mut process = outside(&["nan", "40"]);
    let expected = nominal(&mut inside()).0;
    for y in [nominal(&mut process).0, pushed(&mut process, 0.0)] {
        assert_eq!(y[..80], expected[..80]);
        assert!(y[80..].iter().all(|y| y.is_nan()));
    }
    assert_eq!(process.counts().lost, 0);
}

#[test]
fn lies_about_sizes_give_all_up_with_a_reason() {
    for (manner, found) in [
        ("count", "op 3, 1 lanes and 243 values"),
        ("huge", "op 3, 1 lanes and 4294967295 values"),
        ("op", "op 4, 1 lanes and 242 values"),
    ] {
        let mut process: OutsideSimulator = outside(&[manner]);
        assert!(!nominal(&mut process).1);
        let trouble = process.trouble().unwrap().to_string();
        assert!(trouble.contains("answered to rollout with"), "{trouble}");
        assert!(trouble.contains(found), "{trouble}");
        assert!(trouble.contains("expected op 3, 1 lane and 242 values"), "{trouble}");
        // It is not asked again.
        assert!(!with(&mut process, &[1.6, 0.8, 6.0]).1);
        assert_eq!((process.counts().deaths, process.counts().lost), (1, 2));
    }
}

#[test]
fn an_answer_that_is_cut_short_is_waited_for_with_a_limit() {
    let mut short = process(&["short"]);
    short.timeout = Duration::from_secs(3);
    let mut process = open(short, 1).unwrap();
    // The next one tells its first frame as it is.
    assert_eq!(nominal(&mut process), nominal(&mut inside()));
    assert!(matches!(process.trouble(), Some(OutsideError::Silent { .. })));
    assert_eq!((process.counts().deaths, process.counts().started), (1, 2));
}

#[test]
fn a_run_may_be_refused() {
    let mut process = outside(&["refuse"]);
    let (y, is_complete) = nominal(&mut process);
    assert!(!is_complete && y.iter().all(|y| y.is_nan()));
    // No trouble: it says so itself, and lives on.
    assert_eq!((process.counts().deaths, process.trouble()), (0, None));
}
