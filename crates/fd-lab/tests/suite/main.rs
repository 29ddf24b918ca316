//! The integration tests of `fd-lab`, one program.

mod blind;
mod commands;
mod compare;
mod compare_own;
mod engine_benchmark;
mod engine_on_line;
mod gap_engine;
mod input_following;
mod rates;
mod real_logs;
