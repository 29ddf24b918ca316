//! What a diagnosis must not depend on: names and units.

use fd_sim::{
    equation::Expr,
    model::{Definition, Model},
};

use crate::cases::{Case, PLANTS, name};

const SAMPLES: usize = 100;

/// The model with every name replaced by one that sorts and reads differently.
fn renamed(model: &Model) -> Model {
    let mut draft = model.clone().into_draft();
    let names: Vec<String> = (model.parameters.iter().map(|p| p.name.clone()))
        .chain(model.inputs.iter().map(|i| i.name.clone()))
        .chain(model.states.iter().map(|s| s.name.clone()))
        .chain(model.outputs.iter().map(|o| o.name.clone()))
        .chain(model.definitions.iter().map(|d| d.name.clone()))
        .chain(model.sites.iter().map(|s| s.name.clone()))
        .chain(model.tables.iter().map(|t| t.name.clone()))
        .collect();
    for (i, from) in names.iter().enumerate() {
        draft.rename(from, &format!("name_{}", names.len() - i));
    }
    Model::try_from(draft).unwrap()
}

/// The model with all channels in units that are 1024 times smaller.
fn in_smaller_units(model: &Model) -> Model {
    let factor = || Expr::Number(1024.0);
    let mut draft = model.clone().into_draft();
    for output in &mut draft.outputs {
        output.value = factor() * output.value.clone();
        output.noise = output.noise.map(|noise| 1024.0 * noise);
    }
    let inputs: Vec<String> = draft.inputs.iter().map(|input| input.name.clone()).collect();
    for (i, input) in inputs.iter().enumerate() {
        let command = format!("{input}_small");
        draft.rename(input, &command);
        for expr in draft.plant_expressions_mut() {
            *expr = expr.rename(&command, input);
        }
        let value = Expr::name(&command) / factor();
        draft.definitions.push(Definition { name: input.clone(), value });
        for limit in draft.inputs[i].saturation.iter_mut().flatten() {
            *limit = factor() * limit.clone();
        }
    }
    Model::try_from(draft).unwrap()
}

#[test]
fn names_change_no_bit() {
    for plant in PLANTS {
        let case = Case::new(plant, SAMPLES);
        let mut other = Case::of(renamed(&case.model), SAMPLES);
        other.u.clone_from(&case.u);
        let (here, there) = (case.simulated(), other.simulated());
        assert_eq!(here.len(), there.len());
        for (a, b) in here.iter().zip(&there) {
            assert_eq!(a.starts, b.starts, "{}", name(a));
            let y = case.apply(a, &a.starts[0]).1;
            assert_eq!(other.apply(b, &b.starts[0]).1, y, "{plant}: {}", name(a));
        }
    }
}

#[test]
fn units_change_nothing_but_units() {
    for plant in PLANTS.into_iter().filter(|plant| *plant != "dc_drive_closed_loop") {
        let case = Case::new(plant, SAMPLES);
        let small = in_smaller_units(&case.model);
        let u: Vec<f64> = case.u.iter().map(|u| 1024.0 * u).collect();
        let other = Case::with_input(small, u, SAMPLES);
        let (here, there) = (case.simulated(), other.simulated());
        assert_eq!(here.len(), there.len());
        for (a, b) in here.iter().zip(&there) {
            assert_eq!(a.starts.len(), b.starts.len(), "{}", name(a));
            for (start, other_start) in a.starts.iter().zip(&b.starts) {
                let y: Vec<f64> = case.apply(a, start).1.iter().map(|y| 1024.0 * y).collect();
                // A power of 2 changes no digit, but powers with a real exponent and divisions by
                // sums may round differently by an ulp, which the plant may carry along.
                let distance = other.distance(&other.apply(b, other_start).1, &y);
                assert!(distance < 1e-9, "{plant}: {}: {distance}", name(a));
            }
        }
    }
}

/// A store may name its level, and its rate beside it; a block its velocity, and its position beside it.
#[test]
fn a_site_is_the_same_however_it_is_declared() {
    type Labels<'l> = &'l dyn Fn(&str) -> bool;
    let room = r#"
version = 1
kind = "equations"
name = "room"
sample_time = 60.0
inputs = { heat = { unit = "W" } }
definitions = { warming = "(heat - (T - 12)/R)/C" }
outputs = { T_m = { unit = "K", value = "T" } }
[parameters]
R = { unit = "K/W", value = 0.01 }
C = { unit = "J/K", value = 2e5 }
[states]
T = { unit = "K", initial = 20.0, derivative = "warming" }
[sites]
air = { unit = "W", enters = { T = "1/C" } }
"#;
    let block = r#"
version = 1
kind = "equations"
name = "block"
sample_time = 0.02
inputs = { push = { unit = "N" } }
outputs = { place = { unit = "m", value = "x" } }
[parameters]
m = { unit = "kg", value = 1.5 }
[states]
x = { unit = "m", initial = 0.1, derivative = "v" }
v = { unit = "m/s", initial = 0.0, derivative = "(push - 3*x - 0.2*v)/m" }
[sites]
rail = { unit = "N", enters = { v = "1/m" }, velocity = "v" }
"#;
    let also = |text: &str, more: &str| text.replace("\"1/C\" }", &format!("\"1/C\" }}{more}"));
    let with_place = block.replace("velocity = \"v\"", "velocity = \"v\", position = \"x\"");
    let with_level = also(room, ", position = \"T\"");
    let with_both = also(room, ", position = \"T\", velocity = \"warming\"");
    let bare = room.to_owned();
    // What a bare site calls its velocity is the level of a store.
    let any = |_: &str| true;
    let is_of_store = |label: &str| ["hidden-store", "overflow", "constant-load"].contains(&label);
    // Without a place, what a hidden store follows is the velocity.
    let is_of_block = |label: &str| label != "hidden-store";
    let pairs: [(_, _, Labels<'_>); 4] = [
        (&bare, &with_level, &is_of_store),
        (&bare, &with_both, &is_of_store),
        (&with_level, &with_both, &any),
        (&block.to_owned(), &with_place, &is_of_block),
    ];
    let mut seen = 0;
    for (text, other, is_compared) in pairs {
        let [case, other] = [text, other].map(|text| Case::of(text.parse().unwrap(), SAMPLES));
        let theirs = other.simulated();
        for a in case.simulated().iter().filter(|a| is_compared(a.label)) {
            let is_it =
                |b: &&fd_effect::Candidate| (b.label, b.law, &b.site) == (a.label, a.law, &a.site);
            let Some(b) = theirs.iter().find(is_it) else { continue };
            // Where the scale of a level is another, so are the starts.
            let [ours, theirs] = [case.apply(a, &a.starts[0]).1, other.apply(b, &a.starts[0]).1];
            for (here, there) in ours.iter().zip(&theirs) {
                assert!((here - there).abs() <= 1e-9 * here.abs().max(1.0), "{}", name(a));
            }
            seen += 1;
        }
    }
    assert!(seen > 30, "{seen}");
}
