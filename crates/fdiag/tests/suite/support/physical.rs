//! The same plant in physical units about an operating point: 1 per unit is 0.5 kg/s, 100 rpm, 50 K.

use fdiag::model::{Channel, Record};

use super::{plant, run};

/// What the diagnosis believes, as a model file.
pub const MODEL: &str = r#"
version = 1
kind = "state-space"
name = "small turbine"
sample_time = 0.1

[[inputs]]
name = "fuel"
unit = "kg/s"
operating_point = 2.0
scale = 0.5

[[outputs]]
name = "speed"
unit = "rpm"
operating_point = 3000.0
scale = 100.0

[[outputs]]
name = "temperature"
unit = "K"
operating_point = 900.0
scale = 50.0

[matrices]
A = [[0.90, 0.06], [-0.04, 0.83]]
B = [[0.06], [0.11]]
C = [[1.0, 0.0], [0.3, 1.0]]
"#;

/// A healthy run under `u`.
pub fn log(u: &[f64], seed: u64) -> Record {
    let record = run(&plant(), u, 1e-3, seed);
    let fuel = vec![Channel::new("fuel", "kg/s")];
    let outputs = vec![Channel::new("speed", "rpm"), Channel::new("temperature", "K")];
    let rows = record
        .samples()
        .map(|(u, y)| ([2.0 + 0.5 * u[0]], [3000.0 + 100.0 * y[0], 900.0 + 50.0 * y[1]]));
    Record::from_rows(fuel, outputs, rows, record.ts()).unwrap()
}
