//! Our plants against the simulator of the diagnosis, and all laws at work.

use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};

mod people;

use super::{
    conditions::Conditions,
    excitation::Shape,
    kind::CaseKind,
    laws::{Mechanism, Needs, catalogue},
    plants::{ALL, Plant, plant},
    strength::Yardstick,
    truth::{Effect, Scene, Truth},
};

const SAMPLES: usize = 300;

fn truth(plant: &Plant, model: &Model) -> Truth {
    Truth {
        case: "test".to_owned(),
        kind: CaseKind::None,
        plant: plant.name.to_owned(),
        excitation: Shape::Steps,
        samples: SAMPLES,
        coloured: false,
        noise_factor: 1.0,
        seed: 5,
        parameters: model.nominal(),
        effects: Vec::new(),
        conditions: Conditions::default(),
        oracle: None,
    }
}

#[test]
fn plants_are_those_of_their_model_files() {
    // What is unstable is only compared where a controller holds it.
    let elsewhere = ["servo", "two-filters"].map(|name| plant(name).unwrap());
    for plant in ALL.iter().chain(elsewhere) {
        let model = plant.model().unwrap();
        let truth = truth(plant, &model);
        let scene = Scene::new(&truth, &model).unwrap();
        let x0 = scene.initial(0);
        let own = scene.outputs(&[], &truth.parameters, &x0, 0, false).unwrap().unwrap();
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let mut all_x0 = model.initial();
        all_x0[..x0.len()].copy_from_slice(&x0);
        let mut theirs = vec![0.0; own.len()];
        let u = scene.excitation(0);
        let _ = Simulator::simulate(&mut simulator, &model.nominal(), &all_x0, &u, &mut theirs);
        let ny = model.outputs.len();
        let worst = own
            .iter()
            .zip(&theirs)
            .enumerate()
            .map(|(k, (a, b))| (a - b).abs() / model.outputs[k % ny].noise.unwrap());
        let worst = worst.fold(0.0, f64::max);
        // Both integrate with order 4; the engine has 17 states and its model three modes.
        let allowed = if plant.name == "engine17" { 1.0 } else { 0.05 };
        assert!(worst < allowed, "{}: {worst} sigma", plant.name);
    }
}

#[test]
fn noise_is_as_strong_as_stated() {
    let plant = &ALL[0];
    let model = plant.model().unwrap();
    for coloured in [false, true] {
        let truth = Truth { coloured, samples: 4000, ..truth(plant, &model) };
        let scene = Scene::new(&truth, &model).unwrap();
        let (noisy, clean) =
            (scene.log(0, true).unwrap().unwrap(), scene.log(0, false).unwrap().unwrap());
        let e: Vec<f64> = noisy.output(0).zip(clean.output(0)).map(|(a, b)| a - b).collect();
        let power = e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64;
        let next = e.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / e.len() as f64;
        let sigma = model.outputs[0].noise.unwrap();
        // The colour has (1 + .64)/(1 - .64) = 4.6 times fewer independent samples: 4 of their
        // standard deviations are 0.19 of the variance.
        assert!((power / (sigma * sigma) - 1.0).abs() < 0.19, "{power}");
        let expected = if coloured { 0.8 } else { 0.0 };
        assert!((next / power - expected).abs() < 0.07, "{}", next / power);
    }
}

#[test]
fn every_law_vanishes_with_its_strength_and_acts_at_it() {
    let (mut missing, mut lasting): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for law in catalogue().iter().filter(|law| law.needs != Needs::Measurement) {
        let mut acts = false;
        for plant in &ALL {
            let model = plant.model().unwrap();
            let truth = truth(plant, &model);
            let scene = Scene::new(&truth, &model).unwrap();
            let Some(place) = super::draw::places(&scene, law).first().copied() else { continue };
            let yardstick = Yardstick::new(&scene).unwrap().unwrap();
            let effect = |strength: f64| Effect {
                label: law.label.to_owned(),
                law: law.name.to_owned(),
                family: law.family.to_owned(),
                origin: law.origin,
                place: law.place,
                site: String::new(),
                index: place.0,
                partner: None,
                partner_index: place.1.unwrap_or(place.0),
                strength,
                shape: [0.7, 0.4, 0.6],
                seed: 3,
                distance: 0.0,
            };
            let [low, high] = law.range;
            let strong = yardstick.distance(&effect(low.powf(0.2) * high.powf(0.8))).unwrap();
            let weak = yardstick.distance(&effect(1e-9 * low)).unwrap();
            // Between samples a plant goes a little further than its largest sample, where stops
            // and brims begin; a wall takes all the speed that is left there.
            let allowed = match (law.family, law.name) {
                ("limit", "wall") => 100.0,
                ("limit", _) => 9.0,
                _ => 1e-2,
            };
            if allowed <= weak {
                lasting.push(format!("{} {} on {}: {weak}", law.label, law.name, plant.name));
            }
            assert!(matches!(
                scene.inject(&effect(low), 0).map(|i| i.mechanism),
                Some(
                    Mechanism::Input(_)
                        | Mechanism::Force { .. }
                        | Mechanism::HeldForce(_)
                        | Mechanism::Stick(_)
                        | Mechanism::Brim { .. }
                        | Mechanism::Wall { .. }
                        | Mechanism::Sensor(_)
                        | Mechanism::Factor(_)
                        | Mechanism::Inside(_)
                )
            ));
            acts |= 9.0 < strong;
            if acts {
                break;
            }
        }
        if !acts {
            missing.push(format!("{} {}", law.label, law.name));
        }
    }
    assert!(lasting.is_empty(), "do not vanish: {lasting:?}");
    assert!(missing.is_empty(), "never visible: {missing:?}");
}
