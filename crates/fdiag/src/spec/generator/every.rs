//! A line of a spec for each kind of generator.

/// A line with the equations of a model in it.
macro_rules! nonlinear {
    ($kind:literal, $settings:literal) => {
        concat!(
            "kind = \"",
            $kind,
            r#"", model = { text = "version = 1\nkind = \"equations\"\nname = \"tests\"\nsample_time = 0.1\n"#,
            r#"inputs = { u1 = { unit = \"1\" } }\n"#,
            r#"[states]\na = { unit = \"1\", initial = 0.0, update = \"0.9*a + 0.06*b + 0.06*u1\" }\n"#,
            r#"b = { unit = \"1\", initial = 0.0, update = \"0.83*b - 0.04*a + 0.11*u1\" }\n"#,
            r#"[outputs]\ny1 = { unit = \"1\", value = \"a\", noise = 0.02 }\n"#,
            r#"y2 = { unit = \"1\", value = \"0.3*a + b\", noise = 0.02 }\n" }, "#,
            $settings,
        )
    };
}

/// Lines of specs, at least one of each kind, for a model of one input, two states and two outputs.
///
/// Those with a model of their own have that of the tests.
pub(in crate::spec) const EVERY: [&str; 30] = [
    r#"kind = "simulation""#,
    r#"kind = "observer", rate = 2.0"#,
    r#"kind = "kalman", process_noise = 0.1, output_noise = 1.0"#,
    r#"kind = "zonotope", rate = 2.0, noise = [3.0, 3.0], disturbance = [[0.5, 0.0], [0.0, 0.5]]"#,
    r#"kind = "zonotope", rate = 2.0, noise = [3.0, 3.0], initial = [1.0, 1.0], model = { b = [[0.01], [0.02]] }, columns = 6"#,
    r#"kind = "parity", order = 2"#,
    r#"kind = "unknown-input", disturbance = { kind = "learned", rank = 1 }, rate = 2.0"#,
    r#"kind = "unknown-input", disturbance = { kind = "directions", columns = [[1.0, 0.5]] }, rate = 2.0"#,
    r#"kind = "decoupled", disturbance = { kind = "learned", rank = 1, duration_s = 2.0 }, rate = 2.0"#,
    r#"kind = "eigenstructure", disturbance = { kind = "directions", columns = [[1.0, 0.5]] }"#,
    r#"kind = "eigenstructure", disturbance = { kind = "learned", rank = 1 }, rate = 3.0"#,
    r#"kind = "unknown-input", disturbance = { kind = "perturbed", rank = 1, models = 20, perturbation = { fraction = 0.03 } }, rate = 2.0"#,
    r#"kind = "unknown-input", disturbance = { kind = "models", rank = 1, shifts = [{ a = [[0.02, -0.01], [0.01, 0.02]], b = [[-0.01], [0.01]] }] }, rate = 2.0"#,
    r#"kind = "optimal", process_noise = 0.01, output_noise = 1.0, attenuated = { kind = "learned", rank = 1 }"#,
    r#"kind = "structured", faults = [{ sensor = 1 }, { sensor = 2 }], structure = { kind = "dedicated" }"#,
    r#"kind = "structured", faults = [{ sensor = 1 }, { sensor = 2 }], structure = { kind = "rows", rows = ["10", "11"] }, rate = 2.0"#,
    r#"kind = "directional", rate = 2.0"#,
    r#"kind = "adaptive", parameters = { kind = "state-rates" }, process_noise = 0.1, output_noise = 1e-4"#,
    r#"kind = "fault-estimate", faults = [{ actuator = 1 }, { sensor = 2 }], process_noise = 1e-4, output_noise = 1e-2, drift = 1e-4"#,
    nonlinear!("extended", "process_noise = { a = 0.01, b = 0.01 }"),
    nonlinear!("extended", "process_noise = { a = 0.01, b = 0.01 }, linearised_over = 2"),
    nonlinear!("unscented", "process_noise = { a = 0.01, b = 0.01 }, kappa = 0.5"),
    nonlinear!("particle", "process_noise = { a = 0.05, b = 0.05 }, particles = 40, seed = 3"),
    nonlinear!("patched", "suspicion = 2.0"),
    nonlinear!("patched", "suspicion = 2.0, observer_rate = 2.0"),
    r#"kind = "pca""#,
    r#"kind = "pca", lags = 2, components = { kind = "variance", share = 0.99 }, part = "scores""#,
    r#"kind = "pca", components = { kind = "count", count = 1 }, part = "statistics""#,
    r#"kind = "cva", past = 4, future = 3, states = 2"#,
    r#"kind = "data-parity", order = 3, states = 2"#,
];
