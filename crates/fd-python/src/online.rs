//! The on-line side: a diagnosis trained by a spec, and its pipeline, a sample or an array at a time.

use std::{
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
};

use fd_core::{
    DynPipeline, FrameError, Snapshot,
    stage::{Phase, Stage},
};
use fd_log::{LogMap, read_log};
use fd_model::{ChannelScale, Record, Scaling, file::LinearModel};
use fdiag::{
    spec::{NominalPlant, PipelineSpec},
    training::{self, Healthy, train},
};
use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::{prelude::*, types::PyDict};
use serde_json::json;

use crate::{
    errors::{analysis, input},
    log::{LogInput, named},
};

/// A diagnosis that has learned from healthy logs.
#[pyclass(frozen, module = "fdiag._fdiag")]
#[derive(Debug)]
pub(crate) struct Trained {
    learned: training::Trained,
    model: LinearModel,
    sample_time: f64,
}

/// A pipeline of it, with a memory of its own.
#[pyclass(frozen, module = "fdiag._fdiag")]
#[derive(Debug)]
pub(crate) struct Pipeline {
    stages: Mutex<DynPipeline>,
    scaling: Scaling,
    residuals: usize,
}

/// What one sample gave: residual, compensated residual, statistic, threshold, whether the bias is subtracted,
/// whether there is an alarm, and what happened.
type StepOut<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, f64, f64, bool, bool, Vec<String>);

#[pymethods]
impl Trained {
    /// Trains what the TOML text `spec` describes on healthy logs of the model file `text`.
    #[new]
    fn new(
        py: Python<'_>,
        text: &str,
        file: &str,
        spec: &str,
        healthy: Vec<LogInput<'_>>,
        learn_share: f64,
        columns: Option<&str>,
    ) -> PyResult<Self> {
        let model = LinearModel::parse(file, text).map_err(|error| input(py, &error))?;
        let spec: PipelineSpec = spec.parse().map_err(|error| {
            let error = format!("spec: {error}");
            input(py, &error)
        })?;
        let map = columns.map(serde_json::from_str::<LogMap>).transpose();
        let map = map.map_err(|error| input(py, &error))?;
        let mut map = map.unwrap_or_else(|| LogMap::for_model(&model));
        if let Some(ts) = model.system.sample_time() {
            map.resample.sample_time.get_or_insert(ts.seconds());
        }
        let mut tables = Vec::new();
        let names = named(py, healthy, &mut tables)?;
        let mut records: Vec<Record> = Vec::new();
        for name in names {
            let table = tables.iter().find(|table| name == Path::new(table.name()));
            let log = table.map_or_else(|| read_log(&name, &map), |table| table.read(&map));
            let record = log.map_err(|error| input(py, &error))?.record;
            // All logs are brought onto the time base of the first.
            map.resample.sample_time.get_or_insert(record.ts().seconds());
            let scaled = record.scaled(&model.scaling()).map_err(|error| input(py, &error))?;
            records.push(scaled);
        }
        let Some(first) = records.first() else {
            return Err(input(py, &"healthy: expected at least one log, found none"));
        };
        let ts = first.ts();
        let trained = py.detach(|| {
            let plant = model.system.sampled(ts).map_err(|error| error.to_string())?;
            let healthy: Vec<Healthy<'_>> =
                records.iter().map(|record| Healthy::split(record, learn_share)).collect();
            let plant = NominalPlant::from(&plant).in_units(model.scaling());
            train(&spec, plant, &healthy).map_err(|error| error.to_string())
        });
        let trained = trained.map_err(|error| analysis(py, &error))?;
        Ok(Self { learned: trained, model, sample_time: ts.seconds() })
    }

    /// Channels with units, time between samples, and the bias that was learned, as JSON.
    fn described(&self) -> String {
        let channels = |all: &[fd_model::file::ModelChannel]| -> Vec<serde_json::Value> {
            all.iter().map(|c| json!([c.channel.name, c.channel.unit])).collect()
        };
        let bias = self.learned.bias_model();
        json!({
            "inputs": channels(&self.model.inputs),
            "outputs": channels(&self.model.outputs),
            "residuals": self.learned.design().residual_len(),
            "sample_time": self.sample_time,
            "theta": bias.theta(),
            "selection": self.learned.order_selection().map(|table| table.verdict().to_string()),
            "events": self.learned.events().iter().map(|e| e.kind.to_string()).collect::<Vec<_>>(),
        })
        .to_string()
    }

    /// A pipeline at its beginning, with the bias subtracted or not.
    fn pipeline(&self, py: Python<'_>, compensated: bool) -> PyResult<Pipeline> {
        let made =
            if compensated { self.learned.compensated() } else { self.learned.uncompensated() };
        let pipeline = made.map_err(|error| analysis(py, &error))?;
        Ok(Pipeline {
            stages: Mutex::new(pipeline),
            scaling: self.model.scaling(),
            residuals: self.learned.design().residual_len(),
        })
    }
}

/// Everything that a run gives, row by row.
struct Rows {
    residual: Vec<f64>,
    compensated: Vec<f64>,
    statistic: Vec<f64>,
    threshold: Vec<f64>,
    alarm: Vec<bool>,
    compensating: Vec<bool>,
    refused: Vec<bool>,
    events: Vec<(u64, String)>,
}

impl Pipeline {
    fn open(&self) -> MutexGuard<'_, DynPipeline> {
        self.stages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A row in the units of the pipeline.
    fn scaled(values: &[f64], scales: &[ChannelScale], into: &mut Vec<f64>) {
        into.clear();
        // A wrong number of values is for the pipeline to refuse.
        let scale = |i: usize| scales.get(i).copied().unwrap_or_default();
        into.extend(values.iter().enumerate().map(|(i, value)| scale(i).scaled(*value)));
    }

    fn rows(&self, u: &[f64], y: &[f64], samples: usize) -> Result<Rows, FrameError> {
        let (nu, ny) = (u.len() / samples.max(1), y.len() / samples.max(1));
        let (mut now, mut out) = (Vec::new(), Vec::new());
        let mut rows = Rows {
            residual: Vec::new(),
            compensated: Vec::new(),
            statistic: Vec::new(),
            threshold: Vec::new(),
            alarm: Vec::new(),
            compensating: Vec::new(),
            refused: Vec::new(),
            events: Vec::new(),
        };
        let nothing = vec![f64::NAN; self.residuals];
        let mut pipeline = self.open();
        for k in 0..samples {
            Self::scaled(&u[k * nu..(k + 1) * nu], &self.scaling.inputs, &mut now);
            Self::scaled(&y[k * ny..(k + 1) * ny], &self.scaling.outputs, &mut out);
            match pipeline.step(&now, &out) {
                Ok(step) => {
                    rows.residual.extend_from_slice(step.residual);
                    rows.compensated.extend_from_slice(step.compensated);
                    rows.statistic.push(step.verdict.statistic);
                    rows.threshold.push(step.verdict.threshold);
                    rows.alarm.push(step.decision.is_fault());
                    rows.compensating.push(step.phase == Phase::Compensating);
                    rows.refused.push(false);
                    rows.events.extend(step.events.iter().map(|e| (k as u64, e.to_string())));
                }
                Err(FrameError::NonFinite { .. }) => {
                    rows.residual.extend_from_slice(&nothing);
                    rows.compensated.extend_from_slice(&nothing);
                    rows.statistic.push(f64::NAN);
                    rows.threshold.push(f64::NAN);
                    rows.alarm.push(false);
                    rows.compensating.push(false);
                    rows.refused.push(true);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(rows)
    }
}

#[pymethods]
impl Pipeline {
    /// One sample.
    fn step<'py>(
        &self,
        py: Python<'py>,
        u: PyReadonlyArray1<'py, f64>,
        y: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<StepOut<'py>> {
        let (mut now, mut out) = (Vec::new(), Vec::new());
        Self::scaled(&u.as_array().to_vec(), &self.scaling.inputs, &mut now);
        Self::scaled(&y.as_array().to_vec(), &self.scaling.outputs, &mut out);
        let mut pipeline = self.open();
        let step = pipeline.step(&now, &out).map_err(|error| input(py, &error))?;
        Ok((
            PyArray1::from_slice(py, step.residual),
            PyArray1::from_slice(py, step.compensated),
            step.verdict.statistic,
            step.verdict.threshold,
            step.phase == Phase::Compensating,
            step.decision.is_fault(),
            step.events.iter().map(|event| event.to_string()).collect(),
        ))
    }

    /// Rows of samples, from where the pipeline stands.
    fn run<'py>(
        &self,
        py: Python<'py>,
        u: PyReadonlyArray2<'py, f64>,
        y: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let samples = y.shape()[0];
        if u.shape()[0] != samples {
            let found = u.shape()[0];
            return Err(input(py, &format!("u: expected {samples} rows, as y has, found {found}")));
        }
        let all = |array: &PyReadonlyArray2<'py, f64>| -> Vec<f64> {
            array
                .as_slice()
                .map_or_else(|_| array.as_array().iter().copied().collect(), <[f64]>::to_vec)
        };
        let (u, y) = (all(&u), all(&y));
        let rows = py.detach(|| self.rows(&u, &y, samples)).map_err(|error| input(py, &error))?;
        let out = PyDict::new(py);
        let matrix = |values: Vec<f64>| -> PyResult<Bound<'py, PyArray2<f64>>> {
            PyArray1::from_vec(py, values).reshape([samples, self.residuals])
        };
        out.set_item("residual", matrix(rows.residual)?)?;
        out.set_item("compensated", matrix(rows.compensated)?)?;
        out.set_item("statistic", PyArray1::from_vec(py, rows.statistic))?;
        out.set_item("threshold", PyArray1::from_vec(py, rows.threshold))?;
        out.set_item("alarm", PyArray1::from_vec(py, rows.alarm))?;
        out.set_item("compensating", PyArray1::from_vec(py, rows.compensating))?;
        out.set_item("refused", PyArray1::from_vec(py, rows.refused))?;
        out.set_item("events", rows.events)?;
        Ok(out)
    }

    /// Back to the beginning.
    fn reset(&self) {
        self.open().reset();
    }

    /// Its memory, as JSON.
    fn snapshot(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&Snapshot::of(&mut *self.open()))
            .map_err(|error| analysis(py, &error))
    }

    /// Puts a memory back.
    fn restore(&self, py: Python<'_>, snapshot: &str) -> PyResult<()> {
        let snapshot: Snapshot =
            serde_json::from_str(snapshot).map_err(|error| input(py, &error))?;
        snapshot.restore(&mut *self.open()).map_err(|error| input(py, &error))
    }
}

/// Names of the inputs and of the outputs of a linear model.
#[pyfunction]
#[pyo3(signature = (text, file, /))]
pub(crate) fn linear_channels(
    py: Python<'_>,
    text: &str,
    file: &str,
) -> PyResult<(Vec<String>, Vec<String>)> {
    let model = LinearModel::parse(file, text).map_err(|error| input(py, &error))?;
    let names = |all: &[fd_model::file::ModelChannel]| -> Vec<String> {
        all.iter().map(|c| c.channel.name.clone()).collect()
    };
    Ok((names(&model.inputs), names(&model.outputs)))
}
