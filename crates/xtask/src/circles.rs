//! No circles of files: within a crate, files use each other in one direction only, but for pairs that are one concept.
//!
//! What a file uses is found by its paths, those of `use` declarations and those in its code; methods that are called on
//! values are not seen. A name that a module only passes on is followed to the file that declares it. Tests may use what
//! they like.

mod file;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use self::file::{File, Place};
use crate::sources::{Faults, read, rust_files};

/// Circles that stay: the crate, the files, and why.
const ALLOWED: &[(&str, &[&str], &str)] = &[
    ("fd-gap", &["diagnose/result", "diagnose/result/held_out"], "a result and a part of it"),
    ("fd-gap", &["fit/descent", "fit/levenberg"], "one method: a step down, and when to stop"),
    ("fd-gap", &["shrink/another_run", "shrink/forecast"], "a forecast, and what begins in it"),
    ("fd-model", &["domain", "state_space"], "a time axis and the models on it"),
    ("fd-python", &["hosted", "simulator"], "a simulator and its host, which makes others like it"),
    ("fd-sim", &["simulate/one_by_one", "simulate/simulator"], "a trait and its default methods"),
];

/// Files that use each other, and by what: `a -> b (X)`.
struct Circle {
    files: Vec<String>,
    by: Vec<String>,
}

/// Checks every crate below `root`.
pub(crate) fn check(root: &Path) -> Faults {
    let crates = root.join("crates");
    let (mut faults, mut gone) = (Vec::new(), (0..ALLOWED.len()).collect::<BTreeSet<_>>());
    for entry in fs::read_dir(&crates).map_err(|e| format!("{}: {e}", crates.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for circle in circles(&texts(&path.join("src"))?).map_err(|e| format!("{name}: {e}"))? {
            let is_it = |(of, files, _): &(&str, &[&str], &str)| {
                *of == name && circle.files.iter().eq(*files)
            };
            match ALLOWED.iter().position(is_it) {
                Some(known) => _ = gone.remove(&known),
                None => faults.push(format!("{name}: a circle of files: {}", circle.by.join(", "))),
            }
        }
    }
    faults.extend(gone.into_iter().map(|i| {
        let (of, files, _) = ALLOWED[i];
        format!("{of}: the allowed circle is no more, take it off the list: {}", files.join(", "))
    }));
    Ok(faults)
}

/// Names and texts of the files of a library, or of a program without one.
fn texts(src: &Path) -> Result<Vec<(String, String)>, String> {
    let (mut paths, mut texts) = (Vec::new(), Vec::new());
    rust_files(src, &mut paths)?;
    let has_library = src.join("lib.rs").is_file();
    for path in paths {
        let name = path.strip_prefix(src).unwrap_or(&path).with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        if !(name.starts_with("bin/") || has_library && name == "main") {
            texts.push((name, read(&path)?));
        }
    }
    texts.sort();
    Ok(texts)
}

/// The circles of a crate, by the names (`fit/mod`) and texts of its files.
fn circles(texts: &[(String, String)]) -> Result<Vec<Circle>, String> {
    let files = texts.iter().map(|(name, text)| File::read(name, text));
    let mut files = files.collect::<Result<Vec<_>, _>>()?;
    let tests: BTreeSet<Place> = files.iter().flat_map(|file| file.tests.clone()).collect();
    files.retain(|file| !tests.iter().any(|test| file.module.starts_with(test)));
    files.sort_by(|a, b| a.name.cmp(&b.name));
    let all = Crate { files };
    let uses: Vec<BTreeMap<usize, String>> = (0..all.files.len()).map(|i| all.uses(i)).collect();
    let reached: Vec<BTreeSet<usize>> = (0..uses.len()).map(|i| reached(&uses, i)).collect();
    let mut circles = Vec::new();
    for (i, from) in reached.iter().enumerate().filter(|(i, from)| from.contains(i)) {
        let members: Vec<usize> =
            from.iter().copied().filter(|&j| reached[j].contains(&i)).collect();
        if members[0] != i {
            continue;
        }
        let name = |i: usize| all.files[i].name.clone();
        let by = members.iter().flat_map(|&i| {
            let inside = uses[i].iter().filter(|(j, _)| members.contains(j));
            inside.map(move |(&j, item)| format!("{} -> {} ({item})", name(i), name(j)))
        });
        circles
            .push(Circle { by: by.collect(), files: members.iter().map(|&i| name(i)).collect() });
    }
    Ok(circles)
}

/// All that is used from a file on, by way of others.
fn reached(uses: &[BTreeMap<usize, String>], from: usize) -> BTreeSet<usize> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(i) = open.pop() {
        open.extend(uses[i].keys().copied().filter(|&j| reached.insert(j)));
    }
    reached
}

/// The files of a crate.
struct Crate {
    files: Vec<File>,
}

impl Crate {
    /// What a file uses of others: the files, each with one of its items.
    fn uses(&self, i: usize) -> BTreeMap<usize, String> {
        let file = &self.files[i];
        let is_meant = |name: &String| file.paths.iter().any(|path| path[0] == *name);
        // What is imported and not passed on is used, if only for its methods; rustc sees to that.
        let is_used = |name: &String, is_passed_on: bool| !is_passed_on || is_meant(name);
        let imports = file.imports.iter().filter(|(name, (_, passed))| is_used(name, *passed));
        let mut uses = BTreeMap::new();
        for place in imports.map(|(_, (place, _))| place).chain(&file.paths) {
            let Some(place) = self.absolute(file, place) else { continue };
            let Some(other) = self.declares(&place, 0).filter(|&other| other != i) else {
                continue;
            };
            // A module by itself is only a way to what is in it.
            if let Some(item) = place.last().filter(|_| self.files[other].module != place) {
                uses.entry(other).or_insert_with(|| item.clone());
            }
        }
        uses
    }

    /// A path as seen from the root of the crate; none where it leads out of it, or is a name of the file itself.
    fn absolute(&self, file: &File, path: &[String]) -> Option<Place> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([&file.module, rest].concat()),
            "super" => {
                let ups = path.iter().take_while(|name| *name == "super").count();
                let depth = file.module.len().checked_sub(ups)?;
                Some([&file.module[..depth], &path[ups..]].concat())
            }
            name => {
                let child = [&file.module[..], &path[..1]].concat();
                if self.files.iter().any(|file| file.module == child) {
                    return Some([&file.module, path].concat());
                }
                let (place, _) = file.imports.get(name).filter(|(place, _)| place[0] != *name)?;
                Some([&self.absolute(file, place)?, rest].concat())
            }
        }
    }

    /// The file that declares what is at a place, behind as many re-exports as there are.
    fn declares(&self, place: &[String], depth: usize) -> Option<usize> {
        let within = self.files.iter().enumerate().filter(|(_, f)| place.starts_with(&f.module));
        let (i, file) = within.max_by_key(|(_, file)| file.module.len())?;
        let inside = &place[file.module.len()..];
        let Some((import, _)) = inside.first().and_then(|name| file.imports.get(name)) else {
            return Some(i);
        };
        let behind = [&self.absolute(file, import)?, &inside[1..]].concat();
        // Longer chains go round.
        if depth < 16 { self.declares(&behind, depth + 1) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
        let texts: Vec<_> = files.iter().map(|(n, t)| ((*n).to_owned(), (*t).to_owned())).collect();
        circles(&texts).unwrap().into_iter().map(|circle| circle.files).collect()
    }

    #[test]
    fn files_that_use_each_other_are_found_behind_re_exports() {
        let found = of(&[
            ("lib", "mod room; mod other; pub use self::room::Bed;"),
            ("other", "fn sleep() { let _ = crate::Bed; } pub struct Lamp;"),
            ("room/mod", "mod bed; pub use self::bed::Bed;"),
            ("room/bed", "use crate::other::Lamp; pub struct Bed(Lamp);"),
        ]);
        assert_eq!(found, [["other", "room/bed"]]);
    }

    #[test]
    fn passing_on_visibility_and_tests_are_no_use() {
        let found = of(&[
            ("lib", "mod a; #[cfg(test)] mod tests; pub use self::a::A; pub struct B;"),
            ("a", "pub(in crate::a) struct A(crate::B); #[cfg(test)] mod tests { use crate::A; }"),
            ("tests", "use crate::a::A; fn f(_: A) {}"),
        ]);
        assert!(found.is_empty(), "{found:?}");
    }

    #[test]
    fn macros_and_children_are_seen() {
        let found = of(&[
            ("lib", "mod a; pub struct L; fn f() { vec![a::A::new()]; }"),
            ("a", "use super::L; pub struct A(L);"),
        ]);
        assert_eq!(found, [["a", "lib"]]);
    }
}
