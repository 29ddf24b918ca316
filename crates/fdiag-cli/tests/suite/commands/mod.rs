//! Every command of the help texts, of README.md and of docs/*.md does what it says: it is run, in a folder that has
//! the files it names. What would take minutes, or needs what is not here, is only parsed, by the tests of the program.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a failure here is a failed test"
)]

mod desk;

use std::{process::Command, time::Duration};

use desk::Desk;
use fd_console::documented::{Shown, of_documents, of_help};

/// The beginning of a line that is not run, and why.
const PARSED: [(&str, &str); 10] = [
    ("fdiag watch --replay", "the folder of a monitor that has run; its test is in `fd-watch`"),
    ("fdiag log info pusht", "LeRobot is read with the feature `parquet` only"),
    (
        "fdiag simulator check -- python3",
        "a Python that may not be there; its test is in `simulator`",
    ),
    ("fdiag simulator check cart.toml", "the same"),
    (
        "fdiag simulator check -- fdiag simulator serve plant.fmu",
        "an FMU, which needs a compiler; its test is in `fmus`",
    ),
    ("fdiag gap --model examples/process", "a Python that may not be there"),
    (
        "fdiag watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig --state state --mqtt",
        "a broker",
    ),
    (
        "fdiag gap --model examples/gap/engine/engine.toml",
        "takes half a minute; its test is in `gap`",
    ),
    ("fdiag gap --model examples/gap/engine/linear.toml", "the same"),
    (
        "fdiag gap --model cart.toml --log monday.csv --exclude input-delay@force --calibrate",
        "takes minutes",
    ),
];

fn all(desk: &Desk) -> Vec<Shown> {
    let mut all: Vec<Shown> = of_documents("fdiag");
    // Those of the results say how figures were made that took hours.
    all.retain(|shown| !shown.place.starts_with("docs/results"));
    let mut paths = vec![String::new()];
    while let Some(path) = paths.pop() {
        let help = desk.help(&path);
        let below = help.split_once("\nCommands:\n").map_or("", |(_, below)| below);
        let names = below.lines().take_while(|line| !line.is_empty());
        let names = names.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
        let names = names.filter_map(|line| line.split_whitespace().next());
        paths.extend(names.filter(|name| *name != "help").map(|name| format!("{path} {name}")));
        all.extend(of_help("fdiag", path.trim(), &help));
    }
    all
}

#[test]
fn every_command_that_is_shown_runs() {
    let desk = Desk::new();
    let all = all(&desk);
    let count = |place: &str| all.iter().filter(|shown| shown.place.starts_with(place)).count();
    assert!(3 <= count("README.md") && 10 <= count("docs/") && 20 <= count("fdiag "), "{all:#?}");
    let mut faults = Vec::new();
    for Shown { place, line } in &all {
        let squeezed = line.split_whitespace().collect::<Vec<_>>().join(" ");
        if let Some((_, why)) = PARSED.iter().find(|(start, _)| squeezed.starts_with(start)) {
            println!("{place}: `{squeezed}` is parsed only: {why}");
            continue;
        }
        // That page speaks of a model of equations.
        let is_of_equations = line.contains("simulator serve model.toml");
        let line =
            if is_of_equations { line.replace("model.toml", "cart.toml") } else { line.clone() };
        faults.extend(desk.runs(place, &line).err());
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn shells_and_man_know_the_commands() {
    let desk = Desk::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = desk.stdout(&["completions", shell]);
        for word in ["watch", "held-out", "time-limit"] {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    // A shell that is everywhere reads its script.
    std::fs::write(desk.path("fdiag.bash"), desk.stdout(&["completions", "bash"])).unwrap();
    let read = Command::new("bash").arg("-n").arg(desk.path("fdiag.bash")).status();
    assert!(read.is_ok_and(|status| status.success()));
    desk.stdout(&["man", desk.path("pages/man1").to_str().unwrap()]);
    for (page, word) in
        [("fdiag", "residual"), ("fdiag-gap", "held\\-out"), ("fdiag-gap", "time\\-limit")]
    {
        let text = std::fs::read_to_string(desk.path(&format!("pages/man1/{page}.1"))).unwrap();
        assert!(text.contains(".TH") && text.contains(word), "{page}: {text}");
    }
}

/// A linear model that states no sample time is served when somebody else states it.
#[test]
fn a_continuous_model_is_served_at_a_step() {
    let desk = Desk::new();
    let (code, error) = desk.fails(&["simulator", "serve", "model.toml"], Duration::from_secs(60));
    assert_eq!(code, Some(3), "{error}");
    assert!(error.contains("model.toml") && error.contains("--step"), "{error}");
    desk.stdout(&["simulator", "serve", "model.toml", "--step", "0.1"]);
}
