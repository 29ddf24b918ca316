//! The integration tests of `fdiag-cli`, one program.

#[path = "../../../fdiag/tests/suite/support/mod.rs"]
mod support;

mod bounds;
mod cli;
mod commands;
mod demo;
mod fmus;
mod folder;
mod fuzz;
mod gap;
mod gap_quick_start;
mod healthy_logs;
mod hostile;
mod limits;
mod log_info;
mod logs;
mod nonlinear;
mod outputs_alone;
mod pages;
mod people;
mod programs;
mod simulator;
mod structure;
mod watch;
mod watch_diagnose;
mod watch_http;
mod watch_kill;
mod watch_mqtt;
mod watch_mqtt_ask;
mod watch_mqtt_away;
mod watch_mqtt_imposter;
mod watching;
