//! The integration tests of `fd-log`, one program.

mod derived;
mod hdf5;
mod info;
mod loggers;
mod mat;
mod npz;
mod packed;
mod parquet;
mod robots;
