#!/bin/sh
# The compiler, with what `cargo fuzz` adds for coverage, but only for what reads inputs: guidance by the branches of
# matrix products would be none, and their counters cost time. No sanitizer, so that stable Rust will do: code that is
# `unsafe` is in `fd-sim/src/outside/fmu/api` alone, which calls functions of FMUs and is no target.
name=
next=
for argument in "$@"; do
    [ "$next" ] && name=$argument && break
    [ "$argument" = --crate-name ] && next=1
done
case $name in
fd_* | fdiag | guided | csv | csv_core | serde_json | toml | toml_parser | hdf5_reader | hdf5_core | rawzip | \
    rumqttc | roxmltree | ruzstd | lz4_flex | miniz_oxide | flate2 | parquet)
    exec "$@" --cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
        -Cllvm-args=-sanitizer-coverage-trace-compares
    ;;
esac
exec "$@"
