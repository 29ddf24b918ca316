//! Texts that people write: models, expressions, specs, maps.

use std::path::Path;

use fdiag::{
    core::Limits,
    log::{LogMap, read_log_from},
    model::file::LinearModel,
    sim::{
        equation::Expr,
        model::Model,
        outside::{Fmu, OutsideFile, Stated},
        simulate::{EquationSimulator, Simulator, check_limits},
    },
    spec::PipelineSpec,
};

use super::{Target, seeds};

/// A text, or that it is none.
fn with_text(input: &[u8], target: impl Fn(&str) -> String) -> String {
    std::str::from_utf8(input).map_or_else(|_| "not UTF-8".to_owned(), target)
}

fn said<T, E: ToString>(result: Result<T, E>, well: impl FnOnce(T) -> String) -> String {
    result.map_or_else(|error| error.to_string(), well)
}

const MODELS: [&str; 5] = [
    "examples/models/two_mass_drive.toml",
    "examples/models/dc_drive_closed_loop.toml",
    "examples/models/cart_pole.toml",
    "examples/models/tanks.toml",
    "examples/models/pendulum.toml",
];

pub fn expressions() -> Target {
    let own: [&[u8]; 5] = [
        b"-k1*(x - y)/m + clamp(u, -1, 1)^2",
        b"if(x > 0 and not (y <= 1.5e-3), sin(x), tanh(y)*exp(-x))",
        b"sqrt(abs(a)) + min(b, max(c, 2)) - atan2(y, x)",
        b"table1(x) + sign(v)*mu*(1 - exp(-abs(v)/vs))",
        b"((((((((1))))))))",
    ];
    let all = own.map(<[u8]>::to_vec).to_vec();
    Target::new("expressions", all, |input| {
        with_text(input, |text| {
            said(Expr::parse(text), |expr| {
                // What is printed means the same, and everything that is done to an expression ends.
                let printed = expr.to_string();
                let again = Expr::parse(&printed).map(|again| again.to_string());
                assert_eq!(again.as_deref(), Ok(printed.as_str()), "{text}");
                let simple = expr.simplify();
                if printed.len() < 2000 {
                    let _ = expr.differentiate("x").simplify().depth();
                }
                let value = simple.evaluate::<f64>(&|_: &str| Some(1.5));
                format!("{} {}", simple.depth(), said(value, |v| v.is_finite().to_string()))
            })
        })
    })
}

pub fn models() -> Target {
    Target::new("models", seeds(&MODELS), |input| {
        with_text(input, |text| {
            said(text.parse::<Model>(), |model| {
                let ts = match model.sample_time() {
                    Ok(ts) => ts,
                    Err(error) => return error.to_string(),
                };
                // As the program does before it simulates: two samples must be cheap.
                let limits = Limits { substeps: 100, delay_steps: 10_000, ..Limits::default() };
                if let Err(error) = check_limits(&model, ts, &limits) {
                    return error.to_string();
                }
                let mut simulator = match EquationSimulator::<f64>::new(&model) {
                    Ok(simulator) => simulator,
                    Err(error) => return error.to_string(),
                };
                let (nu, ny) = (simulator.inputs().len(), simulator.outputs().len());
                let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
                let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
                let mut y = vec![0.0; 2 * ny];
                let outcome = simulator.simulate(&theta, &x0, &vec![0.1; 2 * nu], &mut y);
                format!("{outcome:?}")
            })
        })
    })
}

pub fn linear_models() -> Target {
    let files = [
        "examples/turbine.toml",
        "examples/engine/f100.toml",
        "examples/micro-gas-turbine/model.toml",
    ];
    Target::new("linear-models", seeds(&files), |input| {
        with_text(input, |text| {
            said(LinearModel::parse("model.toml", text), |model| {
                let again = LinearModel::parse("again.toml", &model.to_toml());
                said(again, |_| "read again".to_owned())
            })
        })
    })
}

pub fn specs() -> Target {
    let own = "residual = { kind = \"observer\" }\nhold_missing = 3\nbias.orders = { kind = \"fixed\", na = 2, nb = 3 }\n\
        detector = { kind = \"maximum\", margin = 0.5 }\nrule = { raise = 3, out_of = 3, clear = 5 }\n\
        isolation = { kind = \"nearest\", faults = \"sensors\" }\n[compensation.operating_point]\npolicy = { kind = \"retrain\" }\n";
    let all = [seeds(&["examples/micro-gas-turbine/spec.toml"]), vec![own.into()]].concat();
    Target::new("specs", all, |input| {
        with_text(input, |text| {
            said(text.parse::<PipelineSpec>(), |spec| {
                said(spec.check_limits(&Limits::default()), |()| {
                    said(toml::to_string(&spec), |_| "written again".to_owned())
                })
            })
        })
    })
}

pub fn column_maps() -> Target {
    let files = ["examples/micro-gas-turbine/columns.toml", "examples/gap/xl330/columns.toml"];
    let own = "inputs = [{ name = \"wf\", unit = \"kg/s\", column = \"Fuel\" }]\n\
        outputs = [{ name = \"T_7\", unit = \"K\", column = \"EGT\" }]\ndelimiter = \",\"\n\
        [time]\ncolumn = \"t\"\n[resample]\nsample_time = 0.5\nmax_gap_s = 2\n";
    let all = [seeds(&files), vec![own.into()]].concat();
    let csv = "t,Fuel [g/s],EGT [degC]\n0,250,600\n0.5,251,\n1,252,602\n";
    Target::new("column-maps", all, |input| {
        with_text(input, |text| {
            said(toml::from_str::<LogMap>(text), |map| {
                let log = read_log_from("run.csv", csv.as_bytes(), &map);
                said(log, |log| format!("{} rows", log.record.len()))
            })
        })
    })
}

pub fn simulators_of_their_own() -> Target {
    Target::new("outside", seeds(&["examples/process/cart.toml"]), |input| {
        with_text(input, |text| {
            let read = OutsideFile::parse(Path::new("cart.toml"), text);
            said(read, |_| "read".to_owned())
        })
    })
}

pub fn descriptions_of_fmus() -> Target {
    let own = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="mass" guid="{1}"><CoSimulation modelIdentifier="mass"/>
<ModelVariables><ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" unit="N"/></ScalarVariable>
<ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable></ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure></fmiModelDescription>"#;
    let folder = tempfile::tempdir().unwrap();
    let all = vec![own.into()];
    Target::new("fmus", all, move |input| {
        std::fs::write(folder.path().join("modelDescription.xml"), input).unwrap();
        // There is no library for any machine, so it cannot be loaded, whatever it says.
        Fmu::load(folder.path(), &Stated::default()).unwrap_err().to_string()
    })
}
