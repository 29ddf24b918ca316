//! The integration tests of `fd-log`, one program.

mod derived;
mod foreign;
mod hdf5;
mod info;
mod loggers;
mod mat;
mod messages;
mod npz;
mod packed;
mod parquet;
mod people;
mod robots;
