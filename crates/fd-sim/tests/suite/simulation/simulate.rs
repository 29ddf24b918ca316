//! Simulators: order of the integration, exactness, closed loops, divergence, sensitivities.

use std::path::Path;

use fd_core::IoDims;
use fd_core::stage::Plant;
use fd_model::{Channel, SampleTime};
use fd_sim::{
    model::Model,
    simulate::{
        BlackBox, EquationSimulator, OperatingPoint, Outcome, SimulateError, Simulator, linearize,
        linearize_discrete,
    },
};

fn example(name: &str) -> Model {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models");
    Model::load(&root.join(name)).unwrap()
}

fn model(body: &str) -> Model {
    let text = format!("version = 1\nkind = \"equations\"\nname = \"test\"\n{body}");
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

fn simulate(simulator: &mut dyn Simulator, u: &[f64], samples: usize) -> Vec<f64> {
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|x| x.value).collect();
    let mut y = vec![0.0; samples * simulator.outputs().len()];
    assert_eq!(simulator.simulate(&theta, &x0, u, &mut y), Outcome::Complete);
    y
}

#[test]
fn halving_the_step_divides_the_error_by_sixteen() {
    // x' = x cos t, x = exp(sin t): smooth, nonlinear in time.
    let model = model(
        r#"sample_time = 0.5
        step = 0.5
        states = { x = { unit = "1", initial = 1.0, derivative = "x*cos(t)" } }
        outputs = { y = { unit = "1", value = "x" } }"#,
    );
    let coarse = EquationSimulator::<f64>::new(&model).unwrap();
    let error = |factor: usize| {
        let y = simulate(&mut coarse.refined(factor), &[], 21);
        (y[20] - 10.0_f64.sin().exp()).abs()
    };
    // From steps of 1/16 s on, the leading term of the error dominates.
    for factor in [8, 16] {
        let order = (error(factor) / error(2 * factor)).log2();
        assert!((order - 4.0).abs() < 0.3, "order {order} at {factor}");
    }
}

#[test]
fn linear_inputs_are_followed_exactly() {
    // The integral of a straight line is exact in Runge-Kutta; held inputs give a staircase.
    let text = r#"sample_time = 0.5
        hold = "linear"
        inputs = { u = { unit = "1" } }
        states = { x = { unit = "1", initial = 0.0, derivative = "u" } }
        outputs = { y = { unit = "1", value = "x" } }"#;
    let u = [0.0, 1.0, 3.0, -1.0];
    let linear = simulate(&mut EquationSimulator::new(&model(text)).unwrap(), &u, 4);
    assert_eq!(linear, [0.0, 0.25, 1.25, 1.75]);
    let zero = model(&text.replace("linear", "zero"));
    assert_eq!(simulate(&mut EquationSimulator::new(&zero).unwrap(), &u, 4), [0.0, 0.0, 0.5, 2.0]);
}

#[test]
fn equations_and_linear_models_agree() {
    let model = example("mass_spring_damper.toml");
    let ts = model.sample_time().unwrap();
    let linear = linearize(&model, &OperatingPoint::initial(&model)).unwrap();
    let mut exact =
        BlackBox::continuous(&linear, model.external_inputs(), model.output_channels(), ts)
            .unwrap();
    let u: Vec<f64> = (0..500).map(|k| 5.0 * (0.003 * f64::from(k * k % 997)).sin()).collect();
    let expected = simulate(&mut exact, &u, 500);
    let found = simulate(&mut EquationSimulator::new(&model).unwrap(), &u, 500);
    let worst = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let size = expected.iter().fold(0.0_f64, |size, y| size.max(y.abs()));
    // At h|λ| < 0.3 the phase error is (h|λ|)^4/120 = 7e-5 per radian, damped within some radians.
    assert!(worst < 2e-4 * size, "{worst} of {size}");
}

#[test]
fn updates_are_discrete_models() {
    let model = model(
        r#"sample_time = 0.1
        inputs = { u = { unit = "1" } }
        [states]
        a = { unit = "1", initial = 1.0, update = "0.5*a + b" }
        b = { unit = "1", initial = 0.0, update = "0.25*b + u" }
        [outputs]
        y = { unit = "1", value = "a + 2*u" }"#,
    );
    let linear = linearize_discrete(&model, &OperatingPoint::initial(&model)).unwrap();
    let mut plant =
        BlackBox::discrete(&linear, model.external_inputs(), model.output_channels()).unwrap();
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    assert_eq!(simulator.substeps(), 1);
    let u = [1.0, -1.0, 0.5, 0.0, 2.0];
    let (mut y, mut expected) = (vec![0.0; 5], vec![0.0; 5]);
    Simulator::simulate(&mut simulator, &[], &[1.0, 0.0], &u, &mut y);
    plant.simulate(&[], &[1.0, 0.0], &u, &mut expected);
    assert_eq!(y, expected);
    let error = linearize(&model, &OperatingPoint::initial(&model)).unwrap_err();
    assert!(matches!(error, SimulateError::Kind { state, .. } if state == "a"));
}

#[test]
fn updates_inside_a_continuous_model_see_the_start_of_the_step() {
    // Play of half-width 0.5 in front of an integrator: the exact answer is known.
    let model = model(
        r#"sample_time = 0.1
        inputs = { u = { unit = "1" } }
        [states]
        play = { unit = "1", initial = 0.0, update = "shown" }
        x = { unit = "1", initial = 0.0, derivative = "shown" }
        [definitions]
        shown = "clamp(play, u - 0.5, u + 0.5)"
        [outputs]
        y = { unit = "1", value = "x" }
        p = { unit = "1", value = "shown" }"#,
    );
    let y = simulate(&mut EquationSimulator::new(&model).unwrap(), &[0.0, 2.0, 1.5, 0.0, 0.0], 5);
    let expected = [0.0, 0.0, 0.0, 1.5, 0.15, 1.5, 0.3, 0.5, 0.35, 0.5];
    for (found, expected) in y.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{y:?}");
    }
}

#[test]
fn a_sampled_controller_acts_at_its_instants() {
    // A pure integrator under a sampled proportional controller: x[k+1] = x + T (r - x).
    let text = |period: f64| {
        format!(
            r#"sample_time = 0.1
        inputs = {{ u = {{ unit = "1/s" }} }}
        states = {{ x = {{ unit = "1", initial = 0.0, derivative = "u" }} }}
        outputs = {{ y = {{ unit = "1", value = "x" }}, v = {{ unit = "1/s", value = "u" }} }}
        [controller]
        sample_time = {period:?}
        references = {{ r = {{ unit = "1" }} }}
        [controller.states]
        count = {{ unit = "1", initial = 0.0, update = "count + 1" }}
        [controller.signals]
        u = "r - y + 0*count""#
        )
    };
    for (period, every) in [(0.1, 1), (0.3, 3)] {
        let model = model(&text(period));
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let y = simulate(&mut simulator, &[1.0; 13], 13);
        let (mut x, mut u) = (0.0, 0.0);
        for k in 0..13 {
            if k % every == 0 {
                u = 1.0 - x;
            }
            assert!((y[2 * k] - x).abs() < 1e-12 && (y[2 * k + 1] - u).abs() < 1e-12, "{k}: {y:?}");
            x += 0.1 * u;
        }
        assert_eq!(
            simulator.state()[1],
            f64::from(u32::try_from(13_usize.div_ceil(every)).unwrap())
        );
    }
    // A run that starts between two actions holds what the controller would have sent.
    let mut simulator = EquationSimulator::<f64>::new(&model(&text(0.3))).unwrap();
    let mut y = [0.0; 2];
    simulator.start(&[], &[0.4, 7.0], 1);
    simulator.step(&[1.0], &[1.0], &[], &mut y);
    assert_eq!((y, simulator.state()[1]), ([0.4, 0.6], 7.0));
    // Four actions per sample.
    let fast = EquationSimulator::<f64>::new(&model(&text(0.025))).unwrap();
    assert_eq!(fast.substeps() % 4, 0);
    let y = simulate(&mut fast.clone(), &[1.0; 11], 11);
    assert!((y[20] - (1.0 - 0.975_f64.powi(40))).abs() < 1e-12);
    let error = EquationSimulator::<f64>::new(&model(&text(0.07))).unwrap_err();
    assert_eq!(error, SimulateError::ControllerRate { controller: 0.07, ts: 0.1 });
}

#[test]
fn a_continuous_controller_closes_the_loop_of_the_linear_model_too() {
    let model = model(
        r#"sample_time = 0.01
        inputs = { u = { unit = "1", saturation = [-10, 10] }, w = { unit = "1" } }
        states = { x = { unit = "1", initial = 0.0, derivative = "-x + u + w" } }
        outputs = { y = { unit = "1", value = "2*x" } }
        [controller]
        references = { r = { unit = "1" } }
        states = { i = { unit = "1", initial = 0.0, derivative = "r - y" } }
        [controller.signals]
        u = "3*(r - y) + 4*i""#,
    );
    assert_eq!(
        model.external_inputs().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
        ["w", "r"]
    );
    let linear = linearize(&model, &OperatingPoint::initial(&model)).unwrap();
    let a: Vec<f64> = (0..4).map(|i| linear.a()[(i / 2, i % 2)]).collect();
    let b: Vec<f64> = (0..4).map(|i| linear.b()[(i / 2, i % 2)]).collect();
    assert_eq!((a, b), (vec![-7.0, 4.0, -2.0, 0.0], vec![1.0, 3.0, 0.0, 1.0]));
}

#[test]
fn equations_see_saturated_inputs_and_tables() {
    let model = model(
        r#"sample_time = 0.5
        parameters = { low = { unit = "1", value = -1.0 } }
        inputs = { u = { unit = "1", saturation = ["2*low", 1] } }
        states = { x = { unit = "1", initial = 0.0, derivative = "0" } }
        outputs = { y = { unit = "1", value = "u" }, z = { unit = "1", value = "curve(u) + slope(curve, u)" } }
        tables = { curve = { x = [-2, 0, 1], y = [4, 0, 3] } }"#,
    );
    let y = simulate(&mut EquationSimulator::new(&model).unwrap(), &[5.0, 0.5, -9.0], 3);
    // Outside its points the table holds; the last point counts as outside.
    assert_eq!(y, [1.0, 3.0, 0.5, 4.5, -2.0, 2.0]);
}

#[test]
fn divergence_is_an_outcome() {
    let model = model(
        r#"sample_time = 0.1
        states = { x = { unit = "1", initial = 1.0, derivative = "x^2" } }
        outputs = { y = { unit = "1", value = "1" } }"#,
    );
    // x = 1/(1 - t) has no value beyond t = 1 s.
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let mut y = vec![0.0; 40];
    let outcome = Simulator::simulate(&mut simulator, &[], &[1.0], &[], &mut y);
    let Outcome::Diverged { sample } = outcome else { panic!("{outcome:?}") };
    assert!((10..20).contains(&sample), "{sample}");
    assert!(y[..sample].iter().all(|y| *y == 1.0) && y[sample..].iter().all(|y| y.is_nan()));
    // The next run is not harmed.
    assert_eq!(Simulator::simulate(&mut simulator, &[], &[0.1], &[], &mut y), Outcome::Complete);
}

#[test]
fn models_without_a_step_are_rejected() {
    let no_slope = example("tanks.toml")
        .to_string()
        .replace("step = 0.5", "")
        .replace("initial = 0.2", "initial = 0.0");
    let error = EquationSimulator::<f64>::new(&no_slope.parse().unwrap()).unwrap_err();
    assert_eq!(error, SimulateError::NoStep { state: "h_1".into() });
    let stiff = model(
        r#"sample_time = 1.0
        states = { x = { unit = "1", initial = 1.0, derivative = "-1e6*x" } }
        outputs = { y = { unit = "1", value = "x" } }"#,
    );
    let error = EquationSimulator::<f64>::new(&stiff).unwrap_err();
    assert!(matches!(error, SimulateError::TooStiff { most: 10_000, .. }), "{error}");
}

#[test]
fn a_run_can_be_continued_and_repeated() {
    for name in ["pendulum.toml", "dc_drive_closed_loop.toml"] {
        let model = example(name);
        let mut simulator: Box<dyn Simulator> =
            Box::new(EquationSimulator::<f64>::new(&model).unwrap());
        let (theta, x0, ny) = (model.nominal(), model.initial(), model.outputs.len());
        let u: Vec<f64> = (0..200).map(|k| f64::from(k % 17)).collect();
        let whole = simulate(&mut *simulator, &u, 200);
        assert_eq!(simulate(&mut *simulator.clone(), &u, 200), whole, "{name}");

        simulator.start(&theta, &x0, 0);
        let mut y = vec![0.0; ny];
        for k in 0..120 {
            simulator.step(&u[k..=k], &u[k + 1..k + 2], &[], &mut y);
        }
        let halfway = simulator.state().to_vec();
        simulator.start(&theta, &halfway, 120);
        for k in 120..199 {
            simulator.step(&u[k..=k], &u[k + 1..k + 2], &[], &mut y);
            assert_eq!(y, whole[k * ny..(k + 1) * ny], "{name}, sample {k}");
        }
    }
}

#[test]
fn ports_take_forces() {
    let model = example("two_mass_drive.toml");
    let ts = model.sample_time().unwrap();
    let mut open = EquationSimulator::<f64>::with_ports(&model, ts).unwrap();
    let ports: Vec<String> = open.ports().iter().map(|port| port.channel.to_string()).collect();
    assert_eq!(ports, ["motor [N m]", "load [N m]", "shaft [N m]"]);
    assert_eq!(open.inputs(), model.external_inputs());
    let u = [0.7; 50];
    // Without forces nothing changes; a force on the motor is a torque more.
    assert_eq!(
        simulate(&mut open, &u, 50),
        simulate(&mut EquationSimulator::at(&model, ts).unwrap(), &u, 50)
    );
    let (mut y, mut all) = ([0.0; 2], Vec::new());
    open.start(&model.nominal(), &model.initial(), 0);
    for _ in 0..50 {
        open.step(&[0.5], &[0.5], &[0.2, 0.0, 0.0], &mut y);
        all.extend(y);
    }
    let expected = simulate(&mut EquationSimulator::at(&model, ts).unwrap(), &u, 50);
    // Differs by rounding: (tau + f)/J against tau/J + f/J.
    assert!(all.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{all:?} {expected:?}");
}

#[derive(Debug)]
struct Logistic;

impl Plant<f64> for Logistic {
    fn nx(&self) -> usize {
        1
    }

    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: 1 }
    }

    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        x_next[0] = u[0] * x[0] * (1.0 - x[0]);
    }

    fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
        y[0] = x[0];
    }
}

#[test]
fn any_plant_is_a_simulator() {
    let ts = SampleTime::new(1.0).unwrap();
    let channels = |prefix| Channel::numbered(prefix, 1);
    let mut simulator = BlackBox::new(Logistic, channels("u"), channels("y"), ts).unwrap();
    let mut y = [0.0; 3];
    assert_eq!(simulator.simulate(&[], &[0.5], &[2.0; 3], &mut y), Outcome::Complete);
    assert_eq!(y, [0.5; 3]);
    assert_eq!(
        simulator.simulate(&[], &[f64::NAN], &[2.0; 3], &mut y),
        Outcome::Diverged { sample: 0 }
    );
    assert!(BlackBox::new(Logistic, Vec::new(), channels("y"), ts).is_err());
}

#[test]
fn single_precision_is_close() {
    let model = example("pendulum.toml");
    let theta: Vec<f32> = vec![1.0, 0.5, 0.05, 9.81];
    let mut y = vec![0.0_f32; 500];
    let mut small = EquationSimulator::<f32>::new(&model).unwrap();
    assert_eq!(small.run(&theta, &[0.3, 0.0], &[0.5; 500], &mut y), Outcome::Complete);
    let expected = simulate(&mut EquationSimulator::new(&model).unwrap(), &[0.5; 500], 500);
    // 2000 steps with errors of 6e-8 in a damped oscillation of size 1.
    assert!(y.iter().zip(&expected).all(|(a, b)| (f64::from(*a) - b).abs() < 2e-4));
}
