//! Dual numbers through the whole simulation: exact sensitivities.

use std::path::Path;

use fd_sim::{
    equation::{Expr, Program, Scope},
    model::Model,
    simulate::{EquationSimulator, Outcome},
};
use num_dual::{Dual64, DualSVec64};

#[test]
fn dual_numbers_give_the_sensitivity_of_a_simulation() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models");
    for name in ["pendulum", "cart_pole", "dc_drive_closed_loop", "two_input"] {
        let model = Model::load(&root.join(format!("{name}.toml"))).unwrap();
        let (ny, nu) = (model.outputs.len(), model.external_inputs().len());
        let scale = if name == "two_input" { 1e-4 } else { 1.0 };
        let u: Vec<f64> = (0..100 * nu).map(|k| scale * (1.0 + (0.1 * k as f64).sin())).collect();
        let x0 = model.initial();
        let mut plain = EquationSimulator::<f64>::new(&model).unwrap();
        let mut dual = EquationSimulator::<Dual64>::new(&model).unwrap();

        for p in 0..model.parameters.len() {
            let run = |simulator: &mut EquationSimulator<f64>, change: f64| {
                let mut theta = model.nominal();
                theta[p] *= 1.0 + change;
                let mut y = vec![0.0; 100 * ny];
                assert_eq!(simulator.run(&theta, &x0, &u, &mut y), Outcome::Complete);
                y
            };
            let mut theta: Vec<Dual64> = model.nominal().into_iter().map(Dual64::from_re).collect();
            theta[p].eps = theta[p].re;
            let start: Vec<Dual64> = x0.iter().copied().map(Dual64::from_re).collect();
            let mut y = vec![Dual64::from_re(0.0); 100 * ny];
            assert_eq!(dual.run(&theta, &start, &u, &mut y), Outcome::Complete);

            let h = 1e-5;
            let (up, down, mid) = (run(&mut plain, h), run(&mut plain, -h), run(&mut plain, 0.0));
            for k in 0..y.len() {
                // Dual numbers divide by multiplying with the reciprocal: a rounding more per division.
                assert!((y[k].re - mid[k]).abs() <= 1e-11 * (1.0 + mid[k].abs()), "{name}");
                let difference = (up[k] - down[k]) / (2.0 * h);
                // h^2 of the third derivative, and rounding of 1e-16/h of the largest output.
                let allowed = 1e-6 * (difference.abs() + mid[k].abs()) + 1e-9;
                assert!(
                    (y[k].eps - difference).abs() < allowed,
                    "{name}, {p}, {k}: {} {difference}",
                    y[k].eps
                );
            }
        }
    }
}

#[test]
fn bytecode_on_dual_numbers_agrees_with_the_symbolic_derivative() {
    let texts = [
        "sin(x)*exp(-a*x^2) + tanh(3*x)/(1 + x^4)",
        "if(x < 0.2, abs(x)*x, sqrt(x)) + clamp(2*x, -1, 1)",
        "max(x, a*x^-1) + atan2(x, a) + x^a + ln(2 + x) - log10(3 + x)",
        "sign(x)*x + step(x)*x + floor(x)*x + min(x, a)",
    ];
    let scope = Scope { slow: vec!["a".into()], fast: vec!["x".into()], ..Scope::default() };
    for text in texts {
        let expr = Expr::parse(text).unwrap();
        let program = Program::compile(&scope, std::slice::from_ref(&expr)).unwrap();
        let symbolic = Program::compile(&scope, &[expr.differentiate("x")]).unwrap();
        let (mut dual, mut plain) = (program.workspace::<Dual64>(), symbolic.workspace::<f64>());
        dual.slow_mut()[0] = Dual64::from_re(0.7);
        plain.slow_mut()[0] = 0.7;
        program.prepare(&mut dual);
        symbolic.prepare(&mut plain);
        for step in 1..40 {
            let x = 0.07 * f64::from(step);
            dual.fast_mut()[0] = Dual64::new(x, 1.0);
            plain.fast_mut()[0] = x;
            let (mut value, mut slope) = ([Dual64::from_re(0.0)], [0.0]);
            program.run(&mut dual, &mut value);
            symbolic.run(&mut plain, &mut slope);
            // A few operations of relative error 1e-16 in another order.
            assert!(
                (value[0].eps - slope[0]).abs() <= 1e-13 * (1.0 + slope[0].abs()),
                "{text} at {x}"
            );
        }
    }
}

#[test]
fn one_run_gives_the_sensitivities_to_all_parameters() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/models");
    let model = Model::load(&root.join("pendulum.toml")).unwrap();
    let (u, nominal) = (vec![0.5; 200], model.nominal());
    let mut all = EquationSimulator::<DualSVec64<4>>::new(&model).unwrap();
    let theta: Vec<_> =
        nominal.iter().enumerate().map(|(i, p)| DualSVec64::from_re(*p).derivative(i)).collect();
    let start: Vec<_> = model.initial().into_iter().map(DualSVec64::from_re).collect();
    let mut y = vec![DualSVec64::from_re(0.0); 200];
    assert_eq!(all.run(&theta, &start, &u, &mut y), Outcome::Complete);
    for p in 0..4 {
        let mut one = EquationSimulator::<Dual64>::new(&model).unwrap();
        let mut theta: Vec<Dual64> = nominal.iter().copied().map(Dual64::from_re).collect();
        theta[p].eps = 1.0;
        let start: Vec<Dual64> = model.initial().into_iter().map(Dual64::from_re).collect();
        let mut single = vec![Dual64::from_re(0.0); 200];
        one.run(&theta, &start, &u, &mut single);
        for (all, single) in y.iter().zip(&single) {
            let slope = all.eps.unwrap_generic(nalgebra::Const::<4>, nalgebra::Const::<1>)[p];
            assert!((slope - single.eps).abs() <= 1e-12 * (1.0 + single.eps.abs()));
        }
    }
}
