#!/bin/sh
# One target for so many seconds, guided by coverage, from its seeds and corpus:
#     (cd fuzz && cargo build)        # --features parquet for that format
#     fuzz/run.sh TARGET SECONDS [SEED]
# Prints executions, edges and inputs that reach them, and keeps the corpus, made small. A finding is left in the folder
# that is named. TMPDIR=/dev/shm makes targets quick that write files.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
guided=${GUIDED:-$root/fuzz/target/debug/guided}
export FDIAG_FUZZ_TARGET="$1"
work=${FDIAG_FUZZ_WORK:-/tmp/fdiag-fuzz}/$1
mkdir -p "$work/inputs" "$work/seeds"
TMPDIR=$(mktemp -d)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
# As every program of Rust has it; libFuzzer has a `main` of its own.
trap '' PIPE
rm -rf "$work/fewer" && mkdir "$work/fewer"
FDIAG_FUZZ_UNPACK="$work" "$guided" 2>/dev/null
cd "$work"
"$guided" inputs seeds -max_total_time="$2" -seed="${3:-1}" -max_len=16384 -timeout=20 -rss_limit_mb=3000 \
    -use_value_profile=0 -print_final_stats=1 -artifact_prefix="$work/found-" >log 2>&1 || echo "$1: a finding: $work/found-*"
cp seeds/* fewer/
"$guided" -merge=1 -max_len=16384 fewer inputs >merge.log 2>&1 || true
rm fewer/seeds-*
FDIAG_FUZZ_PACK="$work/fewer" "$guided" 2>/dev/null
grep -E "INITED|DONE|stat::(number_of_executed|average|peak)" log | sed "s|^|$1: |"
echo "$1: $(ls inputs | wc -l) inputs, $(ls fewer | wc -l) after merging"
