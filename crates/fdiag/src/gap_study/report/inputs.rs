//! What was diagnosed.

use fd_model::SampleTime;
use fd_sim::model::{Model, Output, Parameter};
use schemars::JsonSchema;
use serde::Serialize;

use crate::gap_study::{
    data::Data,
    log_part::{LogPart, Pace, file_name},
    memory::Memory,
    request::Request,
};

/// What was diagnosed.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Inputs {
    /// Model file.
    pub model_file: String,
    /// Name of the model.
    pub model: String,
    /// Outputs of the model: whatever has one entry per output has this order.
    pub outputs: Vec<Output>,
    /// Parameters of the model, as the file has them and with the tolerances of the request.
    pub parameters: Vec<Parameter>,
    /// Runs and parts of runs, fitted ones first.
    pub logs: Vec<LogPart>,
    /// Time between samples, in seconds.
    pub sample_time_s: f64,
    /// Where that comes from.
    pub pace: Pace,
    /// How long the model remembers its initial state.
    pub memory: Memory,
}

impl Inputs {
    pub(in crate::gap_study) fn of(
        request: &Request,
        model: &Model,
        data: &Data,
        memory: Memory,
    ) -> Self {
        Self {
            model_file: file_name(&request.model),
            model: model.name.clone(),
            outputs: model.outputs.clone(),
            parameters: model.parameters.clone(),
            logs: data.parts.clone(),
            sample_time_s: data.ts().map_or(model.sample_time, SampleTime::seconds),
            pace: data.pace,
            memory,
        }
    }
}
