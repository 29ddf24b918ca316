//! Whether the effects that people's systems have are found, six cases of each, with what they are confused with.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "it prints what was found")]

#[path = "../tests/suite/diagnosis/peoples_systems.rs"]
mod peoples_systems;

use peoples_systems::{curves, dependences, events, transmissions};

fn main() {
    let all = [dependences(), events(), transmissions(), curves()];
    for system in all.iter().flatten() {
        let (is_found, said) = system.is_found();
        println!("{} {said}", if is_found { "right" } else { "WRONG" });
    }
}
