//! FMUs in processes of their own: what crashes, prints, ends or hangs there.

use std::fs;

use fd_sim::{
    outside::{Grade, OutsideError, OutsideFile, check},
    simulate::Simulator as _,
};

use super::{FILE, expected, file, fmu, run};

const NOMINAL: [f64; 3] = [1.5, 0.8, 6.0];
const X0: [f64; 2] = [0.1, 0.0];

fn with_fault() -> String {
    FILE.replace("k = {}", "k = {}\nfault = { tolerance = 0.0 }")
}

#[test]
fn a_crash_is_a_lost_run_with_a_reason() {
    for (dies, signal) in
        [("DIE=abort()", "signal: 6"), ("DIE=*(volatile int *)0 = 1", "signal: 11")]
    {
        let directory = fmu(&[dies]);
        let mut simulator = file(&directory, &with_fault()).open().unwrap();
        let lost = run(&mut simulator, &[1.5, 0.8, 6.0, 1.01], &X0);
        assert!(lost.iter().all(|y| y.is_nan()), "{dies}");
        let trouble = simulator.trouble().unwrap();
        assert!(matches!(trouble, OutsideError::Ended { .. }), "{trouble}");
        let trouble = trouble.to_string();
        let name = format!("`{}", directory.path().display());
        assert!(trouble.starts_with(&name) && trouble.contains(signal), "{trouble}");
        // Other runs are not concerned.
        let found = run(&mut simulator, &[1.5, 0.8, 6.0, 0.0], &X0);
        assert_eq!(found, expected(NOMINAL, X0, 0.0), "{dies}");
    }
}

/// As `../shared/data/people/p02-fmu-reset/roomcrash.fmu`, after one that is public.
#[test]
fn one_that_crashes_in_its_reset_gets_fresh_instances() {
    let directory = fmu(&["DIE_IN_RESET"]);
    let mut simulator = file(&directory, FILE).open().unwrap().without_memory();
    for m in [1.5, 2.0, 1.0, 1.5, 1.5, 1.5, 1.5] {
        assert_eq!(run(&mut simulator, &[m, 0.8, 6.0], &X0), expected([m, 0.8, 6.0], X0, 0.0));
    }
    assert!(simulator.note().is_some_and(|note| note.contains("when it was reset")));
    assert_eq!(simulator.counts().deaths, 1);
}

#[test]
fn a_crash_at_the_start_is_said() {
    let directory = fmu(&["FAULT=3"]);
    let description = directory.path().join("modelDescription.xml");
    let text = fs::read_to_string(&description).unwrap();
    fs::write(&description, text.replace("{mass}", "mass")).unwrap();
    let error = file(&directory, FILE).open().unwrap_err().to_string();
    assert!(error.contains("has ended (exit status: 1) when asked for hello"), "{error}");
    assert!(error.contains("another guid"), "{error}");
}

#[test]
fn what_it_prints_is_no_answer() {
    let directory = fmu(&["TALK"]);
    let mut simulator = file(&directory, FILE).open().unwrap();
    assert_eq!(run(&mut simulator, &NOMINAL, &X0), expected(NOMINAL, X0, 0.0));
    assert_eq!(simulator.trouble(), None);
}

#[test]
fn one_that_hangs_is_ended() {
    let directory = fmu(&["DIE=for (;;)"]);
    let text = format!("timeout = 0.5\n{}", with_fault());
    let mut simulator = file(&directory, &text).open().unwrap();
    let lost = run(&mut simulator, &[1.5, 0.8, 6.0, 1.01], &X0);
    assert!(lost.iter().all(|y| y.is_nan()));
    let trouble = simulator.trouble().unwrap().to_string();
    assert!(trouble.contains("within 0.5 s"), "{trouble}");
    assert_eq!(run(&mut simulator, &[1.5, 0.8, 6.0, 0.0], &X0), expected(NOMINAL, X0, 0.0));
}

/// One that may have a single instance in a process has as many as there are processes.
#[test]
fn instances_beside_each_other_make_the_same_runs() {
    let directory = fmu(&[]);
    let description = directory.path().join("modelDescription.xml");
    let text = fs::read_to_string(&description).unwrap();
    let single = "modelIdentifier=\"mass\" canBeInstantiatedOnlyOncePerProcess=\"true\"";
    fs::write(&description, text.replace("modelIdentifier=\"mass\"", single)).unwrap();
    let simulator = file(&directory, FILE).open().unwrap();
    assert_eq!(simulator.workers(), 2);
    std::thread::scope(|scope| {
        for m in [1.0, 1.5, 2.0, 2.5] {
            let mut copy = simulator.boxed();
            scope.spawn(move || {
                assert_eq!(run(&mut *copy, &[m, 0.8, 6.0], &X0), expected([m, 0.8, 6.0], X0, 0.0));
            });
        }
    });
    let found = check(&mut file(&directory, FILE).open().unwrap(), 50, 1.0);
    assert_eq!(found.worst(), Grade::Fine, "{:?}", found.findings);
}

#[test]
fn only_an_fmu_can_be_in_this_process() {
    let text = "version = 1\nkind = \"process\"\ncommand = [\"a\"]\nin_process = true\n";
    let error = OutsideFile::parse("a.toml".as_ref(), text).unwrap_err().to_string();
    assert_eq!(error, "a.toml: in_process: expected none, for a process, found one");
}
