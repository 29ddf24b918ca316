//! Changes of an input: what typing errors, broken disks and ill will do to a file.

use rand::{RngExt, seq::IndexedRandom};
use rand_xoshiro::Xoshiro256PlusPlus as Random;

/// Numbers at which things go wrong.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "-0.0",
    "1e308",
    "-1e308",
    "1e309",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "0.1",
    "255",
    "65536",
    "2147483648",
    "4294967295",
    "9007199254740993",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "-9223372036854775809",
    "1e6",
    "1e-9",
    "0x10",
    "1_000",
    "00",
    ".5",
    "5.",
    "1e",
    "--1",
];
/// Texts at which things go wrong.
const TEXTS: &[&str] = &[
    "\"", "'", "\\", "\n", "\r\n", "\0", "\u{feff}", "\u{202e}", "é", "∞", "[", "]", "{", "}", "(",
    ")", ",", ";", "=", "#", "..", "/", "%", "&lt;", "<!--", "<", ">", "\"\"\"", "[[", "]]",
    "null", "true", "NaN", "time", "t", "x",
];
/// Longest input that is made.
const LONGEST: usize = 1 << 16;

/// Texts between signs, which are put elsewhere.
pub fn words(inputs: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_.-".contains(byte);
    let mut words: Vec<Vec<u8>> = inputs
        .iter()
        .flat_map(|input| input.split(|byte| !is_word(byte)))
        .filter(|word| (2..=40).contains(&word.len()))
        .map(<[u8]>::to_vec)
        .collect();
    words.sort_unstable();
    words.dedup();
    words
}

/// A changed copy of one of the inputs.
pub fn mutated(random: &mut Random, pool: &[Vec<u8>], words: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = pool.choose(random).cloned().unwrap_or_default();
    for _ in 0..1 << random.random_range(0..4) {
        change(random, &mut bytes, pool, words);
    }
    bytes.truncate(LONGEST);
    bytes
}

fn change(random: &mut Random, bytes: &mut Vec<u8>, pool: &[Vec<u8>], words: &[Vec<u8>]) {
    let n = bytes.len();
    let at = random.random_range(0..=n);
    let end = (at + random.random_range(0..=64_usize.min(n - at))).min(n);
    match random.random_range(0..14) {
        0 if at < n => bytes[at] ^= 1 << random.random_range(0..8),
        1 if at < n => bytes[at] = random.random(),
        2 => {
            bytes.drain(at..end);
        }
        3 => {
            let copy = bytes[at..end].to_vec();
            let to = random.random_range(0..=n);
            insert(bytes, to, &copy);
        }
        4 => {
            // Again and again: what is nested, long, or the same name twice.
            let copy = bytes[at..end].repeat(1 << random.random_range(1..9));
            insert(bytes, at, &copy);
        }
        5 => insert(bytes, at, choose(random, TEXTS)),
        6 | 7 => {
            // Another number in the place of one.
            let is_number = |byte: &u8| byte.is_ascii_digit() || b".+-eE".contains(byte);
            let starts: Vec<usize> = (0..n)
                .filter(|&i| bytes[i].is_ascii_digit() && (i == 0 || !is_number(&bytes[i - 1])))
                .collect();
            if let Some(&start) = starts.choose(random) {
                let length = bytes[start..].iter().take_while(|byte| is_number(byte)).count();
                bytes.splice(start..start + length, choose(random, NUMBERS).iter().copied());
            }
        }
        8 | 9 => {
            if let Some(word) = words.choose(random) {
                let is_instead = random.random();
                bytes.splice(
                    at..if is_instead { (at + word.len()).min(n) } else { at },
                    word.iter().copied(),
                );
            }
        }
        10 => {
            // The beginning of this one and the end of another.
            if let Some(other) = pool.choose(random) {
                let from = random.random_range(0..=other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
        }
        11 => bytes.truncate(at),
        12 => {
            // Lines in another order.
            let mut lines: Vec<Vec<u8>> =
                bytes.split_inclusive(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
            if 1 < lines.len() {
                let (a, b) =
                    (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
                lines.swap(a, b);
                *bytes = lines.concat();
            }
        }
        _ => {
            // A length or a count of a binary file.
            let word: u32 = *[0, 1, 0x7fff_ffff, 0xffff_ffff, 0x0100_0000, random.random()]
                .choose(random)
                .unwrap();
            for (i, byte) in word.to_le_bytes().into_iter().enumerate() {
                if let Some(there) = bytes.get_mut(at + i) {
                    *there = byte;
                }
            }
        }
    }
}

fn choose<'a>(random: &mut Random, texts: &'a [&'a str]) -> &'a [u8] {
    texts.choose(random).map_or(b"", |text| text.as_bytes())
}

fn insert(bytes: &mut Vec<u8>, at: usize, new: &[u8]) {
    if bytes.len() + new.len() <= LONGEST {
        bytes.splice(at..at, new.iter().copied());
    }
}
