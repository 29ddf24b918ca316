//! FMUs that crash or print, through the command line. There must be a C compiler, `cc` or what `CC` says.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::{
    fmt::Write as _,
    fs,
    path::Path,
    process::{Command, Output, Stdio},
};

use tempfile::TempDir;

const MODEL: &str = r#"
version = 1
kind = "fmu"
fmu = "."
sample_time = 0.02
inputs = { force = {} }
parameters = { d = { tolerance = 0.1 } }
outputs = { place = { noise = 0.001 }, speed = { noise = 0.002 } }
"#;

/// The sprung mass of the tests of `fd-sim`, unpacked, with these macros, a model file and a log that it explains.
fn mass(macros: &[&str], model: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fd-sim/tests/suite/fmu");
    let binaries = folder.path().join("binaries/linux64");
    fs::create_dir_all(&binaries).unwrap();
    fs::copy(source.join("mass.xml"), folder.path().join("modelDescription.xml")).unwrap();
    let built = Command::new(std::env::var("CC").unwrap_or_else(|_| "cc".to_owned()))
        .args(["-shared", "-fPIC", "-O1", "-DVERSION=\"2.0\"", "-DFAULT=3", "-o"])
        .arg(binaries.join("mass.so"))
        .args(macros.iter().map(|text| format!("-D{text}")))
        .arg(source.join("mass.c"))
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    fs::write(folder.path().join("model.toml"), model).unwrap();
    fs::write(folder.path().join("log.csv"), log()).unwrap();
    folder
}

/// What `mass.c` does, measured.
fn log() -> String {
    let (mut x, mut v, mut seed) = (0.1, 0.0, 1_u64);
    let mut noise = || {
        seed = seed * 48_271 % 2_147_483_647;
        (seed as f64 / 2_147_483_647.0 - 0.5) * 12.0_f64.sqrt()
    };
    let mut text = "time,force,place,speed\n".to_owned();
    for k in 0..400 {
        let force = [1.0, -0.5, 0.25][k / 40 % 3];
        let (place, speed) = (x + 0.001 * noise(), v + 0.002 * noise());
        writeln!(text, "{:.2},{force},{place:.6},{speed:.6}", 0.02 * k as f64).unwrap();
        for _ in 0..4 {
            v += 0.005 * (force - 0.8 * v - 6.0 * x) / 1.5;
            x += 0.005 * v;
        }
    }
    text
}

fn fdiag(folder: &TempDir, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fdiag"))
        .args(line.split_whitespace())
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn told(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn an_fmu_that_crashes_is_named_with_its_signal() {
    // From 1.01 s on.
    let fault = "{ d = { tolerance = 0.1 }, fault = { value = 1.01, tolerance = 0.0 } }";
    let model = MODEL.replace("{ d = { tolerance = 0.1 } }", fault);
    for (dies, signal) in [("abort()", "SIGABRT"), ("*(volatile int *)0 = 1", "SIGSEGV")] {
        let folder = mass(&[&format!("DIE={dies}")], &model);
        let check = fdiag(&folder, "simulator check model.toml");
        let said = told(&check.stdout);
        assert_eq!(check.status.code(), Some(1), "{said}");
        for part in ["BROKEN: `./.` has ended (signal: ", signal] {
            assert!(said.contains(part), "`{part}` is not in {said}");
        }
        let gap = fdiag(&folder, "gap --model model.toml --log log.csv --out made");
        let said = told(&gap.stderr);
        assert_eq!(gap.status.code(), Some(4), "{said}");
        assert!(said.contains("`./.` has ended (signal: ") && said.contains(signal), "{said}");
    }
}

#[test]
fn what_an_fmu_prints_is_not_in_the_json() {
    let folder = mass(&["TALK"], MODEL);
    let gap = fdiag(&folder, "gap --model model.toml --log log.csv --out made --json");
    let said = told(&gap.stdout);
    assert!(gap.status.success(), "{}", told(&gap.stderr));
    let result: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert!(result.is_object() && !said.contains("a step of the mass"), "{said}");
    // The other way it is.
    fs::write(folder.path().join("model.toml"), format!("in_process = true\n{MODEL}")).unwrap();
    let check = fdiag(&folder, "simulator check model.toml");
    assert!(told(&check.stdout).contains("a step of the mass"));
}

#[test]
fn an_fmu_is_served_to_whoever_asks() {
    let folder = mass(&["TALK"], MODEL);
    let own = env!("CARGO_BIN_EXE_fdiag");
    for served in ["model.toml", ". --step 0.02"] {
        let check = fdiag(&folder, &format!("simulator check -- {own} simulator serve {served}"));
        let said = told(&check.stdout);
        assert!(check.status.success() && said.contains("In order."), "{served}: {said}");
    }
}
