//! The loop: inputs from old ones, and a watch over what becomes of them.

use std::{
    collections::HashSet,
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus as Random;

use super::{
    mutate::{mutated, words},
    targets::Target,
};

/// Longest time that an input may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);
/// Most inputs that are kept because something new became of them.
const POOL: usize = 4000;

/// Tries inputs until a number of them or a time is reached, and returns how many and how many outcomes there were.
/// An input that fails is written into the folder of temporary files, to be kept in `found`.
pub fn fuzz(target: &Target) -> (u64, usize) {
    let (name, seeds) = (target.name, [&*target.seeds, &*target.corpus].concat());
    let setting = |key: &str| std::env::var(key).ok().and_then(|text| text.parse::<u64>().ok());
    let seconds = setting("FDIAG_FUZZ_SECONDS");
    let inputs = setting("FDIAG_FUZZ_INPUTS").unwrap_or(2000);
    let mut random = Random::seed_from_u64(setting("FDIAG_FUZZ_SEED").unwrap_or(1));
    assert!(!seeds.is_empty(), "{name}: no seeds");

    let (words, mut pool) = (words(&seeds), seeds);
    let watched = watch(name);
    let mut outcomes = HashSet::new();
    for input in &pool {
        outcomes.insert(digest(&tried(target, input, &watched)));
    }
    let (begun, mut tries) = (Instant::now(), 0);
    let goes_on = |tries: u64| match seconds {
        Some(seconds) => begun.elapsed().as_secs() < seconds,
        None => tries < inputs,
    };
    while goes_on(tries) {
        let input = mutated(&mut random, &pool, &words);
        let outcome = tried(target, &input, &watched);
        tries += 1;
        // Something new became of it: what is near to it may be new again.
        if outcomes.insert(digest(&outcome)) && pool.len() < POOL {
            pool.push(input);
        }
    }
    *watched.lock().unwrap() = None;
    println!(
        "{name}: {tries} inputs, {} outcomes, {:.0} s",
        outcomes.len(),
        begun.elapsed().as_secs_f64()
    );
    (tries, outcomes.len())
}

type Watched = Arc<Mutex<Option<(Instant, Vec<u8>)>>>;

fn tried(target: &Target, input: &[u8], watched: &Watched) -> String {
    *watched.lock().unwrap() = Some((Instant::now(), input.to_vec()));
    let outcome = catch_unwind(AssertUnwindSafe(|| (target.run)(input))).ok();
    let name = target.name;
    outcome.unwrap_or_else(|| panic!("{name}: a panic, of the input {}", kept(name, input)))
}

/// Words without numbers and names in quotes, so that the same outcome is the same.
fn digest(outcome: &str) -> String {
    let mut digest = String::new();
    let mut is_quoted = false;
    for character in outcome.chars() {
        is_quoted ^= character == '`';
        if !is_quoted && !character.is_ascii_digit() && digest.len() < 200 {
            digest.push(character);
        }
    }
    digest
}

fn kept(name: &str, input: &[u8]) -> String {
    let path = std::env::temp_dir().join(format!("fuzz-{name}-{}", std::process::id()));
    fs::write(&path, input).unwrap();
    path.display().to_string()
}

/// Ends everything when an input takes too long: a test that hangs says nothing.
fn watch(name: &str) -> Watched {
    let watched: Watched = Arc::default();
    let (seen, name) = (Arc::downgrade(&watched), name.to_owned());
    std::thread::spawn(move || {
        while let Some(watched) = seen.upgrade() {
            if let Some((since, input)) = &*watched.lock().unwrap()
                && PATIENCE < since.elapsed()
            {
                eprintln!("{name}: longer than {PATIENCE:?}, of the input {}", kept(&name, input));
                std::process::abort();
            }
            drop(watched);
            std::thread::sleep(Duration::from_millis(500));
        }
    });
    watched
}
