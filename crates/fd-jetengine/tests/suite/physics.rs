//! What any turbofan does, and the published behaviour of this one.

#![allow(clippy::unwrap_used, reason = "tests stop at the first broken fixture")]

use fd_core::stage::Plant;
use fd_jetengine::{
    Compressor, EngineError,
    engine17::{
        Dynamics, Engine17, Environment, ExtendedEngine, FuelLimiter, Gas, Health, HealthParameter,
        MAX_STEP, NX, Parameters, Sampled, Transient, Trim, Unmodelled,
    },
};
use fd_model::{SampleTime, fault::Parameters as _};
use fd_numeric::dense::Dense;
use proptest::prelude::*;

fn engine() -> Engine17 {
    Engine17::new(&Parameters::default()).unwrap()
}

/// Largest magnitude of a pole, 1/s. Runge-Kutta is stable while its product with the step is
/// below 2.6 in the left half-plane.
fn fastest_pole(engine: &Engine17, trim: &Trim) -> f64 {
    let poles = engine.linearise(trim).unwrap().model.poles().unwrap();
    poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max)
}

/// Percent changes of `N_L, N_H, T_7, P_6, T_29` at the reference fuel flow, to the printed digits
/// of the specification, within half a unit of the last one. Three entries are corrected:
/// the specification prints -0.60 (`N_L`, first row), -0.06 (`T_29`, HPT flow) and -0.50 (`T_29`,
/// leak) where its own prototype gives -0.5946, -0.0548 and -0.4949.
#[test]
fn health_table() {
    use HealthParameter as H;
    #[rustfmt::skip]
    let table: [(H, f64, [f64; 5]); 12] = [
        (H::HpcEfficiency, -0.02, [-0.59, -1.45, 0.63, -0.88, -0.18]),
        (H::HptEfficiency, -0.02, [-0.75, -1.84, 0.82, -1.11, -0.23]),
        (H::LptEfficiency, -0.02, [-0.57, 0.22, 0.47, -0.55, -0.25]),
        (H::LpcEfficiency, -0.02, [-0.60, 0.34, 0.52, -0.65, 0.24]),
        (H::HpcFlow, -0.02, [-0.02, 1.56, 0.02, -0.04, -0.01]),
        (H::LpcFlow, -0.02, [0.71, 0.0, 0.0, 0.0, 0.0]),
        (H::HptFlow, 0.02, [-0.18, -0.63, 0.21, -0.27, -0.05]),
        (H::LptFlow, 0.02, [-0.23, 1.43, 0.08, 0.0, -0.16]),
        (H::NozzleArea, 0.02, [0.42, 0.21, -0.83, -0.95, -0.11]),
        (H::BleedLeak, 0.02, [-0.81, -0.12, 0.44, -1.83, -0.49]),
        (H::HeatingValue, -0.02, [-0.64, -0.45, -0.67, -1.19, -0.32]),
        (H::CombustorEfficiency, -0.02, [-0.64, -0.45, -0.67, -1.19, -0.32]),
    ];
    let healthy = engine().trim(0.712).unwrap().outputs();
    for (parameter, delta, want) in table {
        let faulty = engine().with_health(Health::default().shifted(parameter, delta));
        let outputs = faulty.trim(0.712).unwrap().outputs();
        for ((y, y_0), want) in outputs.iter().zip(healthy).zip(want) {
            let percent = 100.0 * (y / y_0 - 1.0);
            assert!((percent - want).abs() <= 0.005, "{parameter:?}: {percent} {want}");
        }
    }
}

/// Only the product of heating value and combustor efficiency enters: the faults are the same
/// to rounding of a product.
#[test]
fn heating_value_and_combustor_efficiency_are_inseparable() {
    let shifted =
        |p| engine().with_health(Health::default().shifted(p, -0.02)).trim(0.712).unwrap();
    let a = shifted(HealthParameter::HeatingValue);
    let b = shifted(HealthParameter::CombustorEfficiency);
    for (a, b) in a.x.iter().zip(b.x) {
        assert!((a / b - 1.0).abs() < 1e-11);
    }
}

/// Steps of the fuel flow: rise of `N_L` in rpm, nonlinear and by the DC gain of the linear
/// model, against the specification's printed digits.
#[test]
fn step_sizes_leave_the_linear_range() {
    let engine = engine();
    let trim = engine.trim(0.712).unwrap();
    let linear = engine.linearise(&trim).unwrap().model;
    let steady = {
        use faer::prelude::Solve;
        linear.a().lu().solve(&(-linear.b()))[(0, 0)]
    };
    for (step, nonlinear_rise, linear_rise, digit) in [
        (0.01, 22.7, 22.8, 0.1),
        (0.05, 112.0, 114.0, 1.0),
        (0.20, 430.0, 455.0, 1.0),
        (0.40, 816.0, 911.0, 1.0),
    ] {
        let rise = engine.trim(0.712 * (1.0 + step)).unwrap().x[0] - trim.x[0];
        assert!((rise - nonlinear_rise).abs() <= 0.51 * digit, "{step}: {rise}");
        let rise = steady * 0.712 * step;
        assert!((rise - linear_rise).abs() <= 0.51 * digit, "{step}: linear {rise}");
    }
}

/// From idle to high power with the fuel limited by `P_3`: settles on the trim, short of surge.
#[test]
fn limited_slam_settles_and_limited_chop_settles() {
    let engine = engine();
    let (idle, high) = (engine.trim(0.12).unwrap(), engine.trim(0.95).unwrap());
    let run = Transient { duration: 30.0, ..Transient::default() };
    for (from, to) in [(&idle, &high), (&high, &idle)] {
        let trajectory = run.run(&engine, from.x, |_| to.fuel).unwrap();
        let worst_loading = trajectory
            .states
            .iter()
            .zip(&trajectory.fuel)
            .map(|(x, &fuel)| engine.rates(x, fuel).1.hpc_loading)
            .fold(0.0, f64::max);
        println!("{} to {} kg/s: largest loading {worst_loading:.3}", from.fuel, to.fuel);
        assert!(worst_loading < 1.3);
        // The slowest pole at idle, -0.69 1/s, leaves less than 1e-6 after 20 s.
        let end = trajectory.states.last().unwrap();
        for (end, want) in end.iter().zip(to.x) {
            assert!((end / want - 1.0).abs() < 1e-5, "{end} {want}");
        }
    }
}

#[test]
fn unlimited_slam_surges() {
    let engine = engine();
    let idle = engine.trim(0.12).unwrap();
    let run = Transient { limiter: None, ..Transient::default() };
    let error = run.run(&engine, idle.x, |_| 0.95).unwrap_err();
    println!("{error}");
    let EngineError::Surge { compressor, value, limit, time } = error else {
        unreachable!("expected surge, got {error}")
    };
    assert_eq!(compressor, Compressor::HighPressure);
    assert!(limit < value && value < 2.5 && 0.0 < time && time < 1.0);

    // The same as a plant: NaN from there on, and the reason on request.
    let plant = Sampled::new(engine, SampleTime::new(0.02).unwrap());
    let (mut x, mut next) = (idle.x, [0.0; NX]);
    let mut surged = false;
    for _ in 0..200 {
        let reason = plant.try_advance(&x, 0.95);
        plant.advance(&x, &[0.95], &mut next);
        assert_eq!(reason.is_err(), next[0].is_nan());
        surged |= matches!(reason, Err(EngineError::Surge { .. }));
        x = next;
    }
    assert!(surged && x.iter().all(|v| v.is_nan()));
}

#[test]
fn nonsense_is_an_error() {
    let engine = engine();
    let trim = engine.trim(0.712).unwrap();
    let run = |transient: Transient| transient.run(&engine, trim.x, |_| 0.7).map(|_| ());
    let default = Transient { duration: 0.1, ..Transient::default() };
    assert!(run(default).is_ok());
    for step in [0.0, -1.0, 0.02, f64::NAN] {
        let error = run(Transient { step, ..default }).unwrap_err();
        assert!(matches!(error, EngineError::OutOfRange { .. }), "{error}");
    }
    let error = default.run(&engine, trim.x, |_| f64::NAN).unwrap_err();
    assert!(matches!(error, EngineError::NonFinite { .. }), "{error}");
    assert!(matches!(
        engine.trim(-0.1),
        Err(EngineError::NoTrim { .. } | EngineError::NonFinite { .. })
    ));
    assert!(engine.trim(f64::NAN).is_err());
    let reference = fd_jetengine::engine17::Reference { p_6: 260.0, ..Default::default() };
    let error = Parameters { reference, ..Parameters::default() }.design().unwrap_err();
    assert!(matches!(error, EngineError::Design { quantity: "1 - LPT efficiency", .. }), "{error}");
}

/// Halving the step of a fourth-order method divides its error by 16. From a disturbed state over
/// 20 ms, with steps of 1.25 and 0.625 ms against 0.156 ms; the fastest mode (-327 1/s) makes
/// `step · λ` up to 0.4, hence the wide band.
#[test]
fn integration_is_of_fourth_order() {
    let engine = engine();
    let mut x = engine.trim(0.712).unwrap().x;
    for (i, x) in x.iter_mut().enumerate() {
        *x *= 1.0 + 1e-3 * (i as f64 - 8.0) / 8.0;
    }
    let end = |step: f64| {
        let run = Transient { duration: 0.02, step, limiter: None };
        *run.run(&engine, x, |_| 0.75).unwrap().states.last().unwrap()
    };
    let exact = end(0.02 / 256.0);
    let error = |step: f64| {
        end(step).iter().zip(exact).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1.25e-3), error(0.625e-3));
    let order = (coarse / fine).log2();
    println!("errors {coarse:.1e}, {fine:.1e}: order {order:.2}");
    assert!((3.7..4.6).contains(&order));
}

/// A component fault moves the running engine from its healthy to its faulty equilibrium.
#[test]
fn a_component_fault_acts_on_the_running_engine() {
    let engine = engine();
    let healthy = engine.trim(0.712).unwrap();
    let health = Health::default().shifted(HealthParameter::HpcEfficiency, -0.02);
    let faulty = engine.clone().with_health(health).trim(0.712).unwrap();
    let mut plant = Sampled::new(engine, SampleTime::new(0.01).unwrap());
    let names = plant.parameter_names();
    assert_eq!(names.len(), HealthParameter::ALL.len());
    let index = names.iter().position(|name| name == "hpc_efficiency").unwrap();
    assert!((plant.parameter(index) - 1.0).abs() < f64::EPSILON);
    plant.set_parameter(index, 0.98);
    let mut x = healthy.x;
    for _ in 0..1500 {
        x = plant.try_advance(&x, 0.712).unwrap();
    }
    for (x, want) in x.iter().zip(faulty.x) {
        // exp(-1.67 · 15) of 2 % is left.
        assert!((x / want - 1.0).abs() < 1e-8, "{x} {want}");
    }
}

/// The extended engine shares the equilibrium, and follows a small step to the same end.
#[test]
fn extended_engine_settles_on_the_same_trim() {
    let engine = engine();
    let (from, to) = (engine.trim(0.70).unwrap(), engine.trim(0.72).unwrap());
    let extended = ExtendedEngine::new(engine, Unmodelled::default()).unwrap();
    let run =
        Transient { duration: 60.0, limiter: Some(FuelLimiter::default()), ..Transient::default() };
    let x = extended.equilibrium(&from);
    let trajectory = run.run(&extended, x, |_| 0.72).unwrap();
    for (end, want) in trajectory.states.last().unwrap().iter().zip(extended.equilibrium(&to)) {
        // exp(-0.12 · 60) = 7e-4 of a change of up to 3 %.
        assert!((end / want - 1.0).abs() < 5e-5, "{end} {want}");
    }
}

/// Parts of size 0 are not there: the readings are those of the seventeen states, to the bit.
#[test]
fn extended_engine_without_extensions_is_the_engine() {
    let engine = engine();
    let from = engine.trim(0.70).unwrap();
    let nothing = Unmodelled {
        actuator: 0.0,
        conductance_h: 0.0,
        conductance_l: 0.0,
        temperature_sensor: 0.0,
        pressure_sensor: 0.0,
        ..Unmodelled::default()
    };
    let bare = ExtendedEngine::new(engine.clone(), nothing).unwrap();
    let run = Transient { duration: 2.0, limiter: None, ..Transient::default() };
    let with = run.run(&bare, bare.equilibrium(&from), |_| 0.72).unwrap();
    let without = run.run(&engine, from.x, |_| 0.72).unwrap();
    for (a, b) in with.states.iter().zip(&without.states) {
        for (i, j) in bare.measured().into_iter().zip(Dynamics::<f64, NX>::measured(&engine)) {
            assert_eq!(a[i].to_bits(), b[j].to_bits());
        }
    }
    for bad in [-1.0, 1e-4, f64::NAN] {
        let with = Unmodelled { actuator: bad, ..nothing };
        assert!(ExtendedEngine::new(engine.clone(), with).is_err());
    }
    let weightless = Unmodelled { metal_mass_h: 0.0, ..nothing };
    assert!(ExtendedEngine::new(engine, weightless).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    /// Equilibria over the whole range of fuel flows: tiny residual, no power left on the shafts,
    /// mass and energy conserved, all modes stable.
    #[test]
    fn every_trim_balances_and_is_stable(fuel in 0.08..1.1_f64) {
        let engine = engine();
        let trim = engine.trim(fuel).unwrap();
        prop_assert!(trim.residual < 1e-11);
        let a = &trim.auxiliary;
        // Powers are of 1e7 W; a residual of 1e-11 /s of the kinetic energy (6e6 J) is far below.
        prop_assert!(a.excess_power_l.abs() < 1e-2 && a.excess_power_h.abs() < 1e-2);
        let p = engine.parameters();
        let air = trim.x[2] + trim.x[11];
        let overboard = a.w_3 * p.overboard_bleed;
        prop_assert!((air + fuel - overboard - a.w_8).abs() < 1e-9 * a.w_8);

        // Energy: what air and fuel bring leaves with jet, overboard bleed, bearings, accessories.
        let gas_7 = Gas::products(fuel / (a.w_8 - fuel));
        let hot = Gas::<f64>::air();
        let h_1 = hot.enthalpy(288.15);
        let bring = air * h_1
            + fuel * (p.combustor_efficiency * p.heating_value + p.fuel_enthalpy);
        let turbines = (a.w_3 * (hot.enthalpy(a.t_3) - hot.enthalpy(a.t_2))
            + trim.x[2] * (hot.enthalpy(a.t_2) - h_1)
            + trim.x[11] * (hot.enthalpy(trim.x[13]) - h_1))
            * (1.0 / p.mechanical_efficiency - 1.0);
        let accessories = p.accessory_power * trim.x[1] / p.reference.n_h;
        let leave = a.w_8 * gas_7.enthalpy(trim.x[16]) + overboard * hot.enthalpy(a.t_3)
            + turbines + accessories;
        // Overboard and cooling air have no fuel in them: f_5 counts cooling, so mass and
        // energy close to rounding of the equilibrium.
        prop_assert!((leave / bring - 1.0).abs() < 1e-9, "{} {}", leave, bring);

        prop_assert!(engine.linearise(&trim).unwrap().model.is_stable().unwrap());
        let fastest = fastest_pole(&engine, &trim);
        prop_assert!(fastest * MAX_STEP < 2.0, "{} 1/s", fastest);
        let extended = ExtendedEngine::new(engine, Unmodelled::default()).unwrap();
        prop_assert!(extended.linearise(&trim).unwrap().model.is_stable().unwrap());
    }

    #[test]
    fn more_fuel_is_faster_and_above_idle_hotter(fuel in 0.08..1.0_f64, more in 1.01..1.1_f64) {
        let engine = engine();
        let (a, b) = (engine.trim(fuel).unwrap(), engine.trim(fuel * more).unwrap());
        prop_assert!(a.x[0] < b.x[0] && a.x[1] < b.x[1]);
        // Below idle the compressors get so poor that less fuel no longer means a cooler engine.
        prop_assert!(fuel < 0.15 || (a.x[5] < b.x[5] && a.x[16] < b.x[16]));
        prop_assert!(a.auxiliary.thrust < b.auxiliary.thrust);
    }

    /// Flight conditions within the stated validity trim, with the fuel scaled by inlet pressure.
    #[test]
    fn flight_conditions_trim(altitude in 0.0..11_000.0_f64, mach in 0.0..0.8_f64, hot in -15.0..15.0_f64) {
        let environment = Environment { altitude, mach, isa_deviation: hot, ..Environment::default() };
        let ambient = environment.ambient();
        let (delta, theta) = (ambient.total_pressure / 101.325, ambient.total_temperature / 288.15);
        let engine = engine().at(environment);
        let trim = engine.trim(0.6 * delta * theta.sqrt()).unwrap();
        prop_assert!(trim.residual < 1e-10);
        let fastest = fastest_pole(&engine, &trim);
        prop_assert!(fastest * MAX_STEP < 2.0, "{} 1/s", fastest);
    }

    /// A healthy engine is the nominal one to the bit, and shifting health there and back is neutral.
    #[test]
    fn neutral_health_changes_nothing(scale in 0.9..1.1_f64, fuel in 0.2..0.9_f64) {
        let engine = engine();
        let x = engine.trim(0.712).unwrap().x.map(|v| v * scale);
        let same = engine.clone().with_health(Health::default()).at(Environment::default());
        let bits = |engine: &Engine17| engine.rhs(&x, fuel).map(f64::to_bits);
        prop_assert_eq!(bits(&engine), bits(&same));
    }

    /// Worse components need more fuel for the same thrust, so give less thrust for the same fuel.
    #[test]
    fn lower_efficiency_costs_thrust(loss in 0.002..0.05_f64) {
        use HealthParameter as H;
        let nominal = engine().trim(0.712).unwrap().auxiliary.thrust;
        for parameter in [H::LpcEfficiency, H::HpcEfficiency, H::HptEfficiency, H::LptEfficiency] {
            let worn = engine().with_health(Health::default().shifted(parameter, -loss));
            prop_assert!(worn.trim(0.712).unwrap().auxiliary.thrust < nominal);
        }
    }
}
