//! FMUs as simulators, with one that is compiled from C. There must be a C compiler, `cc` or what `CC` says.
#![allow(clippy::float_cmp, reason = "the bits are what is compared")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

#[cfg(unix)]
mod hosted;

use std::{fs, path::Path, process::Command, thread::sleep, time::Duration};

use fd_sim::{
    outside::{Fmu, Grade, OutsideError, OutsideFile, OutsideSimulator, Stated, check},
    simulate::{Nominal, Simulator},
};
use tempfile::TempDir;

const SAMPLES: usize = 100;
const TS: f64 = 0.02;

/// An unpacked FMU, with these macros in its source.
fn fmu(macros: &[&str]) -> TempDir {
    fmu_of(2, macros)
}

/// The same of another version of the standard.
fn fmu_of(version: u8, macros: &[&str]) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/fmu");
    let (xml, c, said) = match version {
        2 => ("mass.xml", "mass.c", "VERSION=\"2.0\""),
        _ => ("mass3.xml", "mass3.c", "VERSION=\"3.0\""),
    };
    fs::copy(here.join(xml), directory.path().join("modelDescription.xml")).unwrap();
    let platform = match (version, std::env::consts::OS, std::env::consts::ARCH) {
        (2, "linux", "x86_64") => "linux64",
        (3, "linux", "x86_64") => "x86_64-linux",
        (_, "linux", "aarch64") => "aarch64-linux",
        (2, "macos", _) => "darwin64",
        (3, "macos", "x86_64") => "x86_64-darwin",
        (3, "macos", "aarch64") => "aarch64-darwin",
        other => panic!("the test does not know where FMUs keep the library of {other:?}"),
    };
    let binaries = directory.path().join("binaries").join(platform);
    fs::create_dir_all(&binaries).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    // The last one counts.
    let usual = [said, "FAULT=3"];
    let defines = usual.iter().chain(macros).flat_map(|text| {
        let name = text.split('=').next().unwrap_or_default();
        [format!("-U{name}"), format!("-D{text}")]
    });
    let built = Command::new(&compiler)
        // No fused products: the test computes the same bits.
        .args(["-shared", "-fPIC", "-O1", "-ffp-contract=off", "-o"])
        .arg(binaries.join(format!("mass{}", std::env::consts::DLL_SUFFIX)))
        .args(defines)
        .arg(here.join(c))
        .output()
        .unwrap_or_else(|e| panic!("this test needs a C compiler, and `{compiler}` gives: {e}"));
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    directory
}

const FILE: &str = r#"
version = 1
kind = "fmu"
fmu = "."
sample_time = 0.02
workers = 2
[parameters]
m = { variable = "body.m", tolerance = 0.05 }
d = { tolerance = 0.1 }
k = {}
[states]
place = { tolerance = 0.02 }
speed = {}
[outputs]
place = { noise = 0.001 }
speed = {}
[ports]
push = { position = "place", velocity = "speed" }
"#;

/// A model file; in a process of its own, unless it says otherwise.
fn file(directory: &TempDir, text: &str) -> OutsideFile {
    #[cfg(unix)]
    fd_sim::outside::host_fmus([env!("CARGO_BIN_EXE_awkward-simulator"), "fmu"]);
    OutsideFile::parse(&directory.path().join("model.toml"), text).unwrap()
}

/// The same text twice: for an FMU in a process of its own, and for one in this process.
fn both(text: &str) -> [String; 2] {
    [text.to_owned(), format!("in_process = true\n{text}")]
}

fn open(directory: &TempDir) -> OutsideSimulator {
    file(directory, FILE).open().unwrap()
}

/// What `mass.c` does: outputs of each sample, then on by four steps of the semi-implicit Euler method.
fn expected([m, d, k]: [f64; 3], [mut x, mut v]: [f64; 2], push: f64) -> Vec<f64> {
    let mut y = Vec::new();
    for force in forces() {
        y.extend([x, v]);
        for _ in 0..4 {
            let a = (force + push - d * v - k * x) / m;
            v += 0.25 * TS * a;
            x += 0.25 * TS * v;
        }
    }
    y
}

fn forces() -> Vec<f64> {
    (0..SAMPLES).map(|k| [1.0, -0.5, 0.25][k / 12 % 3]).collect()
}

fn run(simulator: &mut dyn Simulator, theta: &[f64], x0: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; 2 * SAMPLES];
    simulator.simulate(theta, x0, &forces(), &mut y);
    y
}

#[test]
fn an_fmu_is_the_plant_that_it_was_made_of() {
    for version in [2, 3] {
        let directory = fmu_of(version, &[]);
        for text in both(FILE) {
            is_the_plant_that_it_was_made_of(file(&directory, &text).open().unwrap());
        }
    }
}

fn is_the_plant_that_it_was_made_of(mut simulator: OutsideSimulator) {
    let contract = simulator.contract();
    let names = |channels: &[fd_model::Channel]| -> Vec<String> {
        channels.iter().map(|c| format!("{} {}", c.name, c.unit)).collect()
    };
    assert_eq!(names(&contract.inputs), ["force N"]);
    assert_eq!(names(&contract.outputs), ["place m", "speed m/s"]);
    assert_eq!(contract.parameters[0].unit, "kg");
    let nominal = contract.parameters.iter().map(|p| p.value).collect::<Vec<_>>();
    assert_eq!(nominal, [1.5, 0.8, 6.0]);

    let found = run(&mut simulator, &nominal, &[0.1, 0.0]);
    assert_eq!(found, expected([1.5, 0.8, 6.0], [0.1, 0.0], 0.0));
    // Other parameters, another start, and what was set before is gone.
    let found = run(&mut simulator, &[2.0, 0.4, 5.0], &[-0.2, 0.3]);
    assert_eq!(found, expected([2.0, 0.4, 5.0], [-0.2, 0.3], 0.0));
    assert_eq!(
        run(&mut simulator, &nominal, &[0.1, 0.0])[..4],
        expected([1.5, 0.8, 6.0], [0.1, 0.0], 0.0)[..4]
    );

    let mut copy = simulator.boxed();
    copy.start(&nominal, &[0.1, 0.0], 0);
    let mut y = [0.0; 4];
    let expected = expected([1.5, 0.8, 6.0], [0.1, 0.0], 0.5);
    for (k, u) in forces().iter().enumerate() {
        let (before, after) = y.split_at_mut(2);
        assert!(copy.measure(&[*u], before));
        copy.step(&[*u], &[*u], &[0.5], after);
        assert_eq!((&y[..2], &y[2..]), (&expected[2 * k..2 * k + 2], &expected[2 * k..2 * k + 2]));
        if k + 1 < SAMPLES {
            assert_eq!(copy.state(), &expected[2 * k + 2..2 * k + 4]);
        }
    }
}

#[test]
fn it_is_in_order_and_can_be_put_into_a_shell() {
    let directory = fmu(&[]);
    for text in both(FILE) {
        is_in_order(&file(&directory, &text));
    }
}

fn is_in_order(file: &OutsideFile) {
    let found = check(&mut file.open().unwrap().without_memory(), SAMPLES, 1.0);
    assert_eq!(found.worst(), Grade::Fine, "{:?}", found.findings);
    let simulator = file.open().unwrap();
    let shell = file.shell(&simulator).unwrap();
    assert!(shell.model().sites[0].velocity.is_some() && shell.model().outputs[0].noise.is_some());
    let mut around = shell.simulator(simulator.ts()).unwrap();
    let found = run(&mut *around, &[1.5, 0.8, 6.0], &[0.1, 0.0]);
    assert_eq!(found, expected([1.5, 0.8, 6.0], [0.1, 0.0], 0.0));
}

#[test]
fn one_that_cannot_be_reset_is_made_anew() {
    let directory = fmu(&["NO_RESET"]);
    for text in both(FILE) {
        let mut simulator = file(&directory, &text).open().unwrap().without_memory();
        for m in [1.5, 2.0, 1.5] {
            let found = run(&mut simulator, &[m, 0.8, 6.0], &[0.1, 0.0]);
            assert_eq!(found, expected([m, 0.8, 6.0], [0.1, 0.0], 0.0));
        }
    }
}

/// As `../shared/data/people/p02-fmu-reset`, after exports of a tool that does so.
#[test]
fn one_whose_reset_resets_nothing_is_seen_and_made_anew() {
    let without_states = FILE.replace("[states]\nplace = { tolerance = 0.02 }\nspeed = {}\n", "");
    let without_resets = without_states.clone() + "[powers]\nresets = false\n";
    let [other, own] = both(&without_states);
    for (macros, text, keeps) in [
        (&["EMPTY_RESET"][..], &other, true),
        (&["EMPTY_RESET"], &own, true),
        (&["EMPTY_RESET"], &without_resets, false),
        (&[], &other, false),
        (&[], &own, false),
    ] {
        let directory = fmu(macros);
        let mut simulator = file(&directory, text).open().unwrap().without_memory();
        // No two of them begin alike until it has to be known.
        for m in [1.5, 2.0, 1.0, 1.5, 1.5] {
            let found = run(&mut simulator, &[m, 0.8, 6.0], &[]);
            assert_eq!(found, expected([m, 0.8, 6.0], [0.1, 0.0], 0.0), "{macros:?}");
        }
        // What a process tells is read by another thread, which may be late.
        let late = || keeps && simulator.note().is_none();
        (0..500).take_while(|_| late()).for_each(|_| sleep(Duration::from_millis(10)));
        assert_eq!(simulator.note().is_some(), keeps);
        let forces = forces();
        assert!(simulator.measure_spread(0, &forces, forces.len()).is_none(), "{macros:?}");
    }
}

#[test]
fn a_library_of_another_name_is_found() {
    let directory = fmu(&[]);
    let folder = fs::read_dir(directory.path().join("binaries")).unwrap().next().unwrap().unwrap();
    let library = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    fs::rename(&library, library.with_file_name(format!("other{}", std::env::consts::DLL_SUFFIX)))
        .unwrap();
    let found = run(&mut open(&directory), &[1.5, 0.8, 6.0], &[0.1, 0.0]);
    assert_eq!(found, expected([1.5, 0.8, 6.0], [0.1, 0.0], 0.0));
}

#[test]
fn an_error_in_a_step_is_a_divergence_from_there_and_a_fatal_one_the_end() {
    let each = [("FAULT=2", false), ("FAULT=3", false), ("FAULT=4", true)];
    let each = each.map(|(fault, is_fatal)| (2, fault, is_fatal)).into_iter().chain([
        // An FMU of version 3 may end the simulation.
        (3, "FAULT=1", false),
        (3, "FAULT=2", false),
        (3, "FAULT=4", true),
    ]);
    for (version, fault, is_fatal) in each {
        let directory = fmu_of(version, &[fault]);
        for text in both(&FILE.replace("k = {}", "k = {}\nfault = { tolerance = 0.0 }")) {
            let simulator = file(&directory, &text).open().unwrap();
            ends_with_an_error(simulator, version, is_fatal);
        }
    }
}

fn ends_with_an_error(mut simulator: OutsideSimulator, version: u8, is_fatal: bool) {
    let healthy = expected([1.5, 0.8, 6.0], [0.1, 0.0], 0.0);
    // From 1.01 s on; the step that fails begins at sample 51.
    let found = run(&mut simulator, &[1.5, 0.8, 6.0, 1.01], &[0.1, 0.0]);
    if is_fatal {
        assert!(found.iter().all(|y| y.is_nan()));
        let trouble = simulator.trouble().unwrap().to_string();
        let expected = match version {
            2 => "fmi2DoStep: fatal (4) the spring has %s",
            _ => "fmi3DoStep: fatal (4) the spring has broken",
        };
        assert!(trouble.contains(expected), "{trouble}");
    } else {
        assert_eq!(found[..102], healthy[..102]);
        assert!(found[102..].iter().all(|y| y.is_nan()));
        assert_eq!(run(&mut simulator, &[1.5, 0.8, 6.0, 0.0], &[0.1, 0.0]), healthy);
        assert_eq!(simulator.trouble(), None);
    }
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let directory = fmu(&[]);
    let refused = |text: &str| file(&directory, text).open().unwrap_err().to_string();
    for (from, to, part) in [
        (
            "k = {}",
            "kk = {}",
            "parameters.kk: expected the name of a real variable of causality parameter, found `kk`; did you mean `k`?",
        ),
        (
            "k = {}",
            "force = {}",
            "parameters.force: expected the name of a real variable of causality parameter, found `force` (input)",
        ),
        ("speed = {}\n[ports]", "energie = {}\n[ports]", "did you mean `energy`?"),
        ("sample_time = 0.02", "", "sample_time: expected seconds, found none"),
        ("velocity = \"speed\"", "velocity = \"v\"", "expected an output out of `place`, `speed`"),
        ("fmu = \".\"", "fmu = \"other.fmu\"", "the file: expected to be readable"),
    ] {
        assert!(FILE.contains(from), "{from}");
        let error = refused(&FILE.replace(from, to));
        assert!(error.contains(part), "{error}");
    }
    let old = fmu(&["VERSION=\"1.0\""]);
    let error = file(&old, FILE).open().unwrap_err().to_string();
    assert!(error.contains("the functions of FMI 2.0, found its version is not 2.0"), "{error}");
    let later = fmu_of(3, &["VERSION=\"4.0\""]);
    let error = file(&later, FILE).open().unwrap_err().to_string();
    assert!(error.contains("the functions of FMI 3.0, found its version is not 3.0"), "{error}");
    let foreign = fmu(&[]);
    let description = foreign.path().join("modelDescription.xml");
    let text = fs::read_to_string(&description).unwrap();
    fs::write(&description, text.replace("{mass}", "mass")).unwrap();
    let error = file(&foreign, FILE).open().unwrap_err().to_string();
    assert!(
        error.contains("its function to instantiate: expected an instance, found another guid: %s"),
        "{error}"
    );
    fs::write(&description, text).unwrap();
    fs::remove_dir_all(foreign.path().join("binaries")).unwrap();
    let error = Fmu::load(foreign.path(), &Stated::default()).unwrap_err();
    assert!(matches!(&error, OutsideError::Fmu { what, .. } if what == "binaries"), "{error}");
}
