//! Reading and writing of models.

use faer::Mat;
use proptest::prelude::*;

use crate::{
    Channel, ChannelScale, Continuous, Discrete, SampleTime, StateSpace,
    file::{FileAction, LinearModel, LinearSystem, ModelChannel, ModelFileError},
};

const LAG: &str = r#"version = 1
kind = "state-space"
sample_time = 0.1
inputs = [{ name = "wf", unit = "kg/s", operating_point = 0.2, scale = 0.1 }]
outputs = [{ name = "N", unit = "rpm" }, { name = "T_7", unit = "K" }]

[matrices]
A = [
    [0.5, 0],
    [1, 0.25],
]
B = [[1.0], [0.0]]
C = [[1.0, 0.0], [0.0, 1.0]]
D = [[0.0], [0.0]]
"#;

fn message(text: &str) -> String {
    LinearModel::parse("model.toml", text).unwrap_err().to_string()
}

fn bits(model: &LinearModel) -> Vec<u64> {
    let matrices = model.system.matrices();
    let entries = matrices.iter().flat_map(|m| {
        (0..m.nrows()).flat_map(move |i| (0..m.ncols()).map(move |j| m[(i, j)].to_bits()))
    });
    let channels = model.inputs.iter().chain(&model.states).chain(&model.outputs);
    let scales = channels.flat_map(|c| [c.scale.offset, c.scale.scale.unwrap_or(0.0)]);
    entries.chain(scales.map(f64::to_bits)).collect()
}

fn finite() -> impl Strategy<Value = f64> {
    proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO
}

/// Text without controls and without separators of lines, which a file refuses in names.
fn plain(most: usize) -> impl Strategy<Value = String> {
    let pattern = format!("[^\\p{{C}}\\p{{Zl}}\\p{{Zp}}]{{0,{most}}}");
    proptest::string::string_regex(&pattern).unwrap()
}

fn any_channels(count: usize) -> impl Strategy<Value = Vec<ModelChannel>> {
    let scale = proptest::option::of(proptest::num::f64::NORMAL);
    let channel = (plain(5), plain(5), finite(), scale);
    proptest::collection::vec(channel, count).prop_map(|channels| {
        let entries = channels.into_iter().enumerate();
        entries
            .map(|(i, (name, unit, offset, scale))| ModelChannel {
                channel: Channel::new(format!("{name}{i}"), unit),
                scale: ChannelScale { offset, scale },
            })
            .collect()
    })
}

fn any_model() -> impl Strategy<Value = LinearModel> {
    (0_usize..4, 0_usize..3, 1_usize..4, any::<bool>()).prop_flat_map(|(nx, nu, ny, named)| {
        let entries = proptest::collection::vec(finite(), (nx + ny) * (nx + nu));
        let channels =
            (any_channels(nu), any_channels(if named { nx } else { 0 }), any_channels(ny));
        let ts = proptest::option::of(1e-9..1e9_f64);
        let name = proptest::option::of(plain(20));
        (entries, channels, ts, name).prop_map(
            move |(entries, (inputs, states, outputs), ts, name)| {
                let block = |rows: usize, cols: usize, from: (usize, usize)| {
                    Mat::from_fn(rows, cols, |i, j| entries[(from.0 + i) * (nx + nu) + from.1 + j])
                };
                // A small A, whose eigenvalues surely converge.
                let a = Mat::from_fn(nx, nx, |i, j| entries[i * (nx + nu) + j] % 1.0);
                let (b, c, d) =
                    (block(nx, nu, (0, nx)), block(ny, nx, (nx, 0)), block(ny, nu, (nx, nx)));
                let system = match ts {
                    None => {
                        LinearSystem::Continuous(StateSpace::new(a, b, c, d, Continuous).unwrap())
                    }
                    Some(ts) => LinearSystem::Discrete(
                        StateSpace::new(a, b, c, d, Discrete { ts: SampleTime::new(ts).unwrap() })
                            .unwrap(),
                    ),
                };
                LinearModel { name, inputs, states, outputs, system, allow_unstable: true }
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn models_survive_a_file_to_the_bit(model in any_model()) {
        let text = model.to_toml();
        let back = LinearModel::parse("model.toml", &text).unwrap();
        prop_assert_eq!(bits(&back), bits(&model));
        prop_assert_eq!(&back.name, &model.name);
        prop_assert_eq!(&back.inputs, &model.inputs);
        prop_assert_eq!(&back.states, &model.states);
        prop_assert_eq!(&back.outputs, &model.outputs);
        prop_assert_eq!(back.system.sample_time(), model.system.sample_time());
        prop_assert_eq!(back.to_toml(), text);
    }
}

#[test]
fn a_model_brings_its_scaling() {
    let model = LinearModel::parse("model.toml", LAG).unwrap();
    assert_eq!(model.scaling().inputs, [ChannelScale::per_unit(0.2, 0.1)]);
    assert_eq!(model.scaling().outputs, [ChannelScale::default(); 2]);
    assert_eq!(model.output_channels()[1], Channel::new("T_7", "K"));
    assert_eq!(model.system.matrices()[0].nrows(), 2);
}

#[test]
fn wrong_shapes_are_named_with_line_and_row() {
    assert_eq!(
        message(&LAG.replace("[1, 0.25]", "[1]")),
        "model.toml, line 10: row 1 of `matrices.A` must have 2 entries, one per state, found 1"
    );
    assert_eq!(
        message(&LAG.replace("C = [[1.0, 0.0], [0.0, 1.0]]", "C = [[1.0, 0.0]]")),
        "model.toml, line 13: `matrices.C` must have 2 rows, one per output, found 1"
    );
    assert_eq!(
        message(&LAG.replace("[0.5, 0]", "[0.5, nan]")),
        "model.toml, line 9: `matrices.A[0][1]` must be finite, found NaN"
    );
}

#[test]
fn unstable_models_must_say_so() {
    let unstable = LAG.replace("0.5, 0]", "1.5, 0]");
    assert_eq!(
        message(&unstable),
        "model.toml: the model is not stable, there is an eigenvalue at 1.5 +0i; if that is \
         meant, set `allow_unstable = true`"
    );
    let meant = unstable.replace("version = 1", "version = 1\nallow_unstable = true");
    assert!(LinearModel::parse("model.toml", &meant).is_ok());
}

#[test]
fn broken_toml_and_wrong_keys_have_a_place() {
    assert_eq!(
        message(&LAG.replace("sample_time = 0.1", "sample_time = = 0.1")).split(": ").next(),
        Some("model.toml, line 3, column 15")
    );
    let unknown = message(&LAG.replace("sample_time", "sampletime"));
    assert!(
        unknown.starts_with("model.toml, line 3, column 1: unknown field `sampletime`"),
        "{unknown}"
    );
    assert!(unknown.contains("`sample_time`"), "{unknown}");
    let wrong = message(&LAG.replace("[0.5, 0]", "[0.5, \"0\"]"));
    assert!(wrong.starts_with("model.toml, line 9, column 11: invalid type: string"), "{wrong}");
    let missing = message(&LAG.replace("B = [[1.0], [0.0]]", ""));
    assert!(missing.contains("missing field `B`"), "{missing}");
}

#[test]
fn other_versions_and_kinds_are_refused() {
    assert_eq!(
        message("version = 2\nkind = 'state-space'\nnovelty = true"),
        "model.toml: expected `version = 1`, found 2"
    );
    assert_eq!(
        message("version = 1\nkind = 'neural'"),
        "model.toml: expected `kind = \"state-space\"`, found `neural`"
    );
}

#[test]
fn channels_are_checked() {
    assert_eq!(
        message(&LAG.replace("scale = 0.1", "scale = 0")),
        "model.toml: `scale` of input `wf` must be finite and not 0, found 0"
    );
    assert_eq!(
        message(&LAG.replace("operating_point = 0.2", "operating_point = inf")),
        "model.toml: `operating_point` of input `wf` must be finite, found inf"
    );
    assert_eq!(message(&LAG.replace("\"T_7\"", "\"N\"")), "model.toml: two outputs are called `N`");
    assert_eq!(
        message(&LAG.replace("sample_time = 0.1", "sample_time = -1")),
        "model.toml: sample time must be positive and finite, got -1 s"
    );
    let model = LinearModel::parse("model.toml", LAG).unwrap();
    let too_few = LinearModel::new(
        model.system,
        vec![],
        model.outputs.iter().map(|o| o.channel.clone()).collect(),
    );
    assert_eq!(too_few.unwrap_err().to_string(), "model: the model has 1 inputs, got 0 channels");
}

#[test]
fn files_are_written_and_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("lag.toml");
    let model = LinearModel::parse("model.toml", LAG).unwrap();
    model.write(&path).unwrap();
    assert_eq!(bits(&LinearModel::read(&path).unwrap()), bits(&model));
    let error = LinearModel::read(directory.path().join("none.toml")).unwrap_err();
    assert!(matches!(error, ModelFileError::Io { action: FileAction::Read, .. }), "{error}");
}
