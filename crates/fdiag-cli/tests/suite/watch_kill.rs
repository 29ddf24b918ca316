//! `kill -9` at any moment: the union of what all runs said is what an undisturbed run says.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{collections::BTreeMap, io::Write, time::Duration};

use crate::watching::{Plant, promised, text};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const WATCH: &str = "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig";

/// Kills so many monitors while a stream is replayed to each from its beginning, then lets one finish.
/// Returns how many of the runs had said something, and how many messages were said more than once.
fn survives(kills: u32, seed: u64) -> (u32, usize) {
    let plant = Plant::new();
    let stream = Plant::stream(2000);
    let undisturbed = plant.run(WATCH, &stream);
    assert!(undisturbed.status.success(), "{}", text(&undisturbed.stderr));
    let mut expected = BTreeMap::new();
    promised(&text(&undisturbed.stdout), &mut expected).unwrap();
    assert!(30 <= expected.len(), "{} messages", expected.len());

    let line = format!("{WATCH} --state state --save-every 0");
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut found, mut spoke, mut said) = (BTreeMap::new(), 0, 0);
    for _ in 0..kills {
        let mut child = plant.spawn(&line);
        let mut stdin = child.stdin.take().unwrap();
        let end = random.random_range(0..=stream.len());
        let wait = Duration::from_micros(random.random_range(0..60_000));
        let part = stream[..end].to_owned();
        let feeder = std::thread::spawn(move || {
            // In pieces, so that there is something to be saved between them; a killed reader ends it.
            for piece in part.as_bytes().chunks(3000) {
                if stdin.write_all(piece).is_err() {
                    return;
                }
            }
            // Its end must not be taken for the end of the stream.
            std::thread::sleep(wait);
        });
        std::thread::sleep(Duration::from_micros(random.random_range(10_000..200_000)));
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        feeder.join().unwrap();
        let out = text(&output.stdout);
        spoke += u32::from(!out.is_empty());
        said += out.lines().filter(|line| !line.starts_with(r#"{"type":"event""#)).count();
        promised(&out, &mut found)
            .unwrap_or_else(|two| panic!("one message says two things:\n{two}"));
    }
    let last = plant.run(&line, &stream);
    assert!(last.status.success(), "{}", text(&last.stderr));
    let out = text(&last.stdout);
    said += out.lines().filter(|line| !line.starts_with(r#"{"type":"event""#)).count();
    promised(&out, &mut found).unwrap_or_else(|two| panic!("one message says two things:\n{two}"));
    assert_eq!(found, expected);
    (spoke, said - expected.len())
}

/// `FDIAG_KILLS=200` with `--nocapture` gives the figures of `docs/results/watch.md`.
#[test]
fn what_killed_monitors_said_is_what_one_would_have_said() {
    let kills = std::env::var("FDIAG_KILLS").map_or(12, |kills| kills.parse().unwrap());
    let (spoke, again) = survives(kills, 1);
    println!("{kills} kills, {spoke} after something was said, {again} messages said again");
    assert!(0 < spoke, "none of the killed runs had come to say anything");
}
