//! A process does what the same plant does in this process, to the bit, and is asked no more than needed.

use fd_sim::{
    equation::Expr,
    model::Parameter,
    outside::{Grade, check},
    patch::Patch,
    simulate::{Nominal, Outcome, Run, Shell, Simulator},
};

use super::{SAMPLES, inside, mass, nominal, open, outside, process, push, pushed, ts, with};

#[test]
fn the_contract_is_that_of_the_plant() {
    let (process, plant) = (outside(&[]), inside());
    assert_eq!(process.inputs(), plant.inputs());
    assert_eq!(process.outputs(), plant.outputs());
    assert_eq!(process.parameters(), plant.parameters());
    assert_eq!(process.initial(), plant.initial());
    assert_eq!(process.ports(), plant.ports());
    assert_eq!(process.contract().noise, [Some(0.001), Some(0.005)]);
    assert_eq!(process.ts(), plant.ts());
}

#[test]
fn runs_steps_forces_and_states_are_the_bits_of_the_plant() {
    for manner in ["", "steps", "runs"] {
        let (mut process, mut plant) = (outside(&[manner]), inside());
        assert_eq!(nominal(&mut process), nominal(&mut plant), "{manner}");
        assert_eq!(pushed(&mut process, 0.3), pushed(&mut plant, 0.3), "{manner}");
        if manner != "steps" {
            assert_eq!(process.state(), plant.state(), "{manner}");
        }
        let mut y = [[0.0; 2]; 2];
        let measures = process.measure(&[0.5], &mut y[0]);
        // What makes whole runs only makes one up to there.
        assert_eq!(measures, manner != "steps");
        if measures {
            plant.measure(&[0.5], &mut y[1]);
            assert_eq!(y[0], y[1]);
        }
    }
}

#[test]
fn a_copy_in_the_middle_of_a_run_goes_on_from_there() {
    let mut plant = inside();
    let expected = pushed(&mut plant, 0.0);
    // One worker for three: it is taken from each other.
    let mut process = open(process(&[]), 1).unwrap();
    process.start(&mass().nominal(), &mass().initial(), 0);
    let u = push();
    let mut row = [0.0; 2];
    for k in 0..SAMPLES {
        if k % 40 == 20 {
            let mut copies = [process.boxed(), process.boxed()];
            for (l, u) in u.iter().enumerate().skip(k) {
                for copy in &mut copies {
                    copy.step(&[*u], &[*u], &[], &mut row);
                    assert_eq!(row, expected[2 * l..2 * l + 2], "copy at {k}, sample {l}");
                }
            }
        }
        process.step(&[u[k]], &[u[k]], &[], &mut row);
        assert_eq!(row, expected[2 * k..2 * k + 2], "sample {k}");
    }
    assert_eq!(process.counts().started, 1);
}

#[test]
fn nothing_is_asked_twice_and_copies_start_nothing() {
    let mut process = outside(&[]);
    let (first, _) = nominal(&mut process);
    let counts = process.counts();
    assert_eq!((counts.asked, counts.made, counts.started), (1, 1, 1));
    let mut copies: Vec<_> = (0..300).map(|_| process.boxed()).collect();
    assert_eq!(nominal(&mut *copies[299]).0, first);
    let counts = process.counts();
    assert_eq!((counts.asked, counts.made, counts.started), (2, 1, 1));

    // A run by steps is remembered by its steps, also where it goes another way later.
    let alone = pushed(&mut process, 0.1);
    assert_eq!(pushed(&mut *copies[0], 0.1), alone);
    assert_eq!(process.counts().made, 2);
    let mut y = [0.0; 2];
    let u = push();
    copies[1].start(&mass().nominal(), &mass().initial(), 0);
    for (k, u) in u.iter().enumerate() {
        let force = if k < SAMPLES - 5 { 0.1 } else { -3.0 };
        copies[1].step(&[*u], &[*u], &[force], &mut y);
    }
    assert_ne!(y, alone[2 * SAMPLES - 2..]);
    let counts = process.counts();
    assert_eq!((counts.made, counts.repeated, counts.steps), (3, 0, 3 * SAMPLES as u64));
    assert!(counts.inside.as_nanos() > 0 && counts.deaths == 0 && counts.lost == 0);
}

#[test]
fn threads_share_two_workers() {
    let process = outside(&[]);
    let results: Vec<_> = std::thread::scope(|scope| {
        let run = |i: usize| {
            let mut copy = process.boxed();
            scope.spawn(move || {
                let theta = [1.5 + 0.01 * i as f64, 0.8, 6.0];
                (with(&mut *copy, &theta), pushed(&mut *copy, 0.1 * i as f64))
            })
        };
        let threads: Vec<_> = (0..8).map(run).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    for (i, (run, forced)) in results.into_iter().enumerate() {
        assert_eq!(run, with(&mut inside(), &[1.5 + 0.01 * i as f64, 0.8, 6.0]));
        assert_eq!(forced, pushed(&mut inside(), 0.1 * i as f64));
    }
    assert!(process.counts().started <= 2);
}

/// Effects before, in and after the plant: a late command, friction at the port, a slow sensor.
#[test]
fn a_shell_around_the_process_gives_the_bits_of_one_around_the_plant() {
    let shell = |simulator: Box<dyn Simulator>| {
        let shell = Shell::new("mass", simulator).unwrap();
        shell.with_motion("rail", Some("place"), Some("speed")).unwrap()
    };
    let (process, plant) = (outside(&[]), shell(Box::new(inside())));
    let around = shell(process.boxed());
    let mut late = Patch::of(plant.model());
    late.add_parameter(Parameter::new("w", "N", 0.3));
    late.wrap_input("force", "dead", Expr::parse("force - clamp(force, -w, w)").unwrap()).unwrap();
    let mut rubbed = Patch::of(plant.model());
    rubbed.add_parameter(Parameter::new("w", "N", 0.05));
    let friction = Expr::parse("-w*tanh(speed_raw/0.01)").unwrap();
    rubbed.add_force("rail", "friction", friction).unwrap();
    let mut slow = Patch::of(plant.model());
    slow.add_parameter(Parameter::new("w", "1", 1.1));
    slow.wrap_output("speed", "shown", Expr::parse("w*shown").unwrap()).unwrap();

    for (what, patch) in [("late", late), ("rubbed", rubbed), ("slow", slow)] {
        let model = patch.finish().unwrap();
        let mut pair = [&around, &plant].map(|shell| shell.patched(&model, ts()).unwrap());
        let (u, x0) = (push(), mass().initial());
        let thetas = [0.0, 1e-3, 0.1].map(|w| [1.5, 0.8, 6.0, w + model.parameters[3].value]);
        let runs = pair.each_mut().map(|simulator| {
            let mut outputs = vec![vec![0.0; 2 * SAMPLES]; 3];
            let runs = thetas.iter().zip(&mut outputs).map(|(theta, y)| Run::new(theta, &x0, y));
            let mut runs: Vec<Run<'_>> = runs.collect();
            simulator.simulate_many(0, &u, &mut runs);
            assert!(runs.iter().all(|run| run.outcome == Outcome::Complete));
            outputs
        });
        assert_eq!(runs[0], runs[1], "{what}");
        assert_ne!(runs[0][0], runs[0][2], "{what}");
        // Alone and step by step, too.
        let mut alone = vec![0.0; 2 * SAMPLES];
        pair[1].start(&thetas[1], &x0, 0);
        for (u, row) in u.iter().zip(alone.chunks_exact_mut(2)) {
            pair[1].step(&[*u], &[*u], &[], row);
        }
        assert_eq!(runs[0][1], alone, "{what}");
    }
    // Three runs each; only friction needs steps, which it is asked for one by one.
    assert_eq!((process.counts().asked, process.counts().repeated), (9, 0));

    let (u, n) = (push(), SAMPLES);
    let [a, b] = [&around, &plant].map(|shell| shell.scales(ts(), &u, n).unwrap());
    assert_eq!(a, b);
}

#[test]
fn what_is_in_order_is_said_to_be() {
    for (manner, worst) in [
        ("", Grade::Fine),
        ("steps", Grade::Fine),
        ("single", Grade::Doubt),
        ("leftover", Grade::Broken),
    ] {
        let mut process = outside(&[manner]).without_memory();
        let found = check(&mut process, SAMPLES, 1.0);
        println!("{manner}: {found:?}");
        assert_eq!(found.worst(), worst, "{manner}: {:?}", found.findings);
        assert!(0.0 < found.run && 0.0 < found.steps);
        if manner == "single" {
            // Rounding to 2^-24 of values that are smaller than the largest.
            assert!((1e-8..2e-7).contains(&found.precision), "{}", found.precision);
        }
    }
}
