//! Delays and the first step of a run.

use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, OperatingPoint, Outcome, SimulateError, Simulator, linearize},
};

fn model(body: &str) -> Model {
    let text = format!("version = 1\nkind = \"equations\"\nname = \"test\"\n{body}");
    text.parse().unwrap_or_else(|error| panic!("{error}"))
}

fn simulate(model: &Model, u: &[f64], samples: usize) -> Vec<f64> {
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    let mut y = vec![0.0; samples];
    let outcome =
        Simulator::simulate(&mut simulator, &model.nominal(), &model.initial(), u, &mut y);
    assert_eq!(outcome, Outcome::Complete);
    y
}

const DELAYS: &str = r#"sample_time = 0.1
parameters = { T_u = { unit = "s", value = 0.25 }, T_y = { unit = "s", value = 0.13 } }
inputs = { u = { unit = "1" } }
states = { x = { unit = "1", initial = 0.0, derivative = "u_late" } }
outputs = { y = { unit = "1", value = "x_late" } }
[delays]
x_late = { value = "x", time = "T_y" }
u_late = { value = "u", time = "T_u" }"#;

fn delayed(t_u: f64, t_y: f64, u: &[f64]) -> Vec<f64> {
    let mut simulator = EquationSimulator::<f64>::new(&model(DELAYS)).unwrap();
    let mut y = vec![0.0; u.len()];
    assert_eq!(
        Simulator::simulate(&mut simulator, &[t_u, t_y], &[0.0], u, &mut y),
        Outcome::Complete
    );
    y
}

#[test]
fn delays_of_held_inputs_are_exact() {
    // A step at 0.1 s, integrated: a ramp from 0.1 s + T_u on.
    let mut u = [1.0; 30];
    u[0] = 0.0;
    for t_u in [0.0, 0.03, 0.1, 0.25, 1.07] {
        for (k, y) in delayed(t_u, 0.0, &u).into_iter().enumerate() {
            let exact = (0.1 * k as f64 - 0.1 - t_u).max(0.0);
            assert!((y - exact).abs() < 1e-14, "{t_u}, {k}: {y}, {exact}");
        }
    }
    // A delayed sensor of a ramp that has gone on for longer than the delay.
    let y = delayed(0.0, 0.13, &[1.0; 30]);
    assert!((10..30).all(|k| (y[k] - (0.1 * k as f64 - 0.13)).abs() < 1e-14), "{y:?}");
    // Before the run nothing moved.
    assert!(delayed(5.0, 0.0, &u).iter().all(|y| *y == 0.0));
    assert!((delayed(5.0, 0.0, &[1.0; 30])[29] - 2.9).abs() < 1e-13);
}

#[test]
fn delays_are_continuous_in_their_length() {
    let u: Vec<f64> = (0..60).map(|k| f64::from(k * k % 7)).collect();
    for length in [0.0, 0.1, 0.2, 0.37] {
        let (here, near) = (delayed(length, length, &u), delayed(length + 1e-9, length + 1e-9, &u));
        // Slopes are at most 6/s for y, whose delay and input are shifted.
        assert!(here.iter().zip(&near).all(|(a, b)| (a - b).abs() < 2e-8), "{length}");
    }
}

/// What is held switches where its delay ends, so that an oscillator answers as accurately as without a delay; and as its
/// own undelayed answer, read later.
#[test]
fn delays_of_held_inputs_switch_within_a_step() {
    let text = r#"sample_time = 0.04
        step = 0.04
        parameters = { T = { unit = "s", value = 0.0 } }
        inputs = { u = { unit = "N" } }
        outputs = { y = { unit = "m", value = "x" } }
        delays = { late = { value = "u", time = "T" } }
        [states]
        x = { unit = "m", initial = 0.0, derivative = "v" }
        v = { unit = "m/s", initial = 0.0, derivative = "late - 0.5*v - 25*x" }"#;
    let simulator = EquationSimulator::<f64>::new(&model(text)).unwrap();
    let u: Vec<f64> = (0..400).map(|k| f64::from(k * k % 7) - 3.0).collect();
    let run = |factor: usize, delay: f64| {
        let mut y = vec![0.0; 400];
        let mut simulator = simulator.refined(factor);
        Simulator::simulate(&mut simulator, &[delay], &[0.0, 0.0], &u, &mut y);
        y
    };
    let error = |factor: usize, delay: f64| {
        let (y, fine) = (run(factor, delay), run(60, delay));
        y.iter().zip(&fine).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    // Late inputs are others at the beginning, which is why errors may differ by a small factor.
    let plain = [1, 4].map(|factor| error(factor, 0.0));
    assert!(150.0 * plain[1] < plain[0], "order 4: {plain:?}");
    for delay in [0.013, 0.053, 0.1] {
        let late = [1, 4].map(|factor| error(factor, delay));
        assert!((0..2).all(|i| late[i] < 3.0 * plain[i]), "{delay}: {late:?}, {plain:?}");
    }
}

#[test]
fn a_delay_has_no_finite_linear_model() {
    let model = model(DELAYS);
    let mut at = OperatingPoint::initial(&model);
    let error = linearize(&model, &at).unwrap_err();
    assert_eq!(error, SimulateError::Delay { delay: "x_late".into() });
    at.theta.fill(0.0);
    assert_eq!(linearize(&model, &at).unwrap().b()[(0, 0)], 1.0);
}

#[test]
fn control_signals_are_delayed_on_their_way() {
    let model = model(
        r#"sample_time = 0.1
        parameters = { T_d = { unit = "s", value = 0.05 } }
        inputs = { u = { unit = "1/s" } }
        states = { x = { unit = "1", initial = 0.0, derivative = "u_late" } }
        outputs = { y = { unit = "1", value = "x" } }
        delays = { u_late = { value = "u", time = "T_d" } }
        [controller]
        sample_time = 0.1
        references = { r = { unit = "1" } }
        [controller.signals]
        u = "2*(r - y)""#,
    );
    let y = simulate(&model, &[1.0; 20], 20);
    let mut x = 0.0;
    // Before the run the first signal was held.
    let mut before = 2.0;
    for (k, y) in y.iter().enumerate() {
        assert!((y - x).abs() < 1e-13, "{k}: {y}, {x}");
        let signal = 2.0 * (1.0 - x);
        x += 0.05 * before + 0.05 * signal;
        before = signal;
    }
}

#[test]
fn delays_of_delays_add_up() {
    let twice = DELAYS.replace("value = \"u\"", "value = \"u_1\"")
        + "\nu_1 = { value = \"u\", time = \"T_y\" }\n";
    let mut simulator = EquationSimulator::<f64>::new(&model(&twice)).unwrap();
    let u: Vec<f64> = (0..40).map(|k| f64::from(k * k % 7)).collect();
    let mut y = vec![0.0; 40];
    Simulator::simulate(&mut simulator, &[0.3, 0.2], &[0.0], &u, &mut y);
    let once = delayed(0.5, 0.2, &u);
    assert!(y.iter().zip(&once).all(|(a, b)| (a - b).abs() < 1e-13), "{y:?} {once:?}");
}

#[test]
fn the_first_step_is_known() {
    let model = model(
        r#"sample_time = 0.1
        states = { count = { unit = "1", initial = 0.0, update = "if(first > 0, 10, count + 1)" } }
        outputs = { y = { unit = "1", value = "count" } }"#,
    );
    assert_eq!(simulate(&model, &[], 4), [0.0, 10.0, 11.0, 12.0]);
    // Of every run.
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    for _ in 0..2 {
        let mut y = [0.0; 3];
        Simulator::simulate(&mut simulator, &[], &[5.0], &[], &mut y);
        assert_eq!(y, [5.0, 10.0, 11.0]);
    }
}

/// A lag of a step, delayed and integrated: `flow = 1 - e^{-t}`, `arriving = flow(t - T)`,
/// `silo = (t - T) - (1 - e^{-(t - T)})`, from the delay on.
fn conveyor(step: f64, late: f64) -> [f64; 2] {
    let text = format!(
        r#"sample_time = 0.5
        step = {step:?}
        parameters = {{ T = {{ unit = "s", value = {late:?} }} }}
        inputs = {{ u = {{ unit = "1" }} }}
        outputs = {{ y_1 = {{ unit = "1", value = "arriving" }}, y_2 = {{ unit = "s", value = "silo" }} }}
        delays = {{ arriving = {{ value = "flow", time = "T" }} }}
        [states]
        flow = {{ unit = "1", initial = 0.0, derivative = "u - flow" }}
        silo = {{ unit = "s", initial = 0.0, derivative = "arriving" }}"#
    );
    let mut simulator = EquationSimulator::<f64>::new(&model(&text)).unwrap();
    let mut y = [0.0; 40];
    let outcome = Simulator::simulate(&mut simulator, &[late], &[0.0; 2], &[1.0; 20], &mut y);
    assert_eq!(outcome, Outcome::Complete);
    let exact = |k: usize| {
        let after = (0.5 * k as f64 - late).max(0.0);
        [1.0 - (-after).exp(), after - 1.0 + (-after).exp()]
    };
    let errors = (0..20).map(|k| [0, 1].map(|c| (y[2 * k + c] - exact(k)[c]).abs()));
    errors.fold([0.0; 2], |most, errors| [0, 1].map(|c| errors[c].max(most[c])))
}

#[test]
fn delays_of_what_moves_are_of_third_order() {
    for late in [1.0, 1.13, 2.4] {
        let [coarse, fine] = [0.5, 0.25].map(|step| conveyor(step, late));
        // The remainder of a parabola through three points half a step apart, h³/(72 √3), and half of it again for what
        // Runge-Kutta adds; a held value would be h/2 late, 0.25 of the silo here.
        let bound = |h: f64| h.powi(3) / 72.0 / f64::sqrt(3.0);
        for (h, errors) in [(0.5, coarse), (0.25, fine)] {
            assert!(errors.iter().all(|e| *e < 1.5 * bound(h)), "{late}, {h}: {errors:?}");
        }
    }
}
