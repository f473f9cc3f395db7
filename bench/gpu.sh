#!/usr/bin/env bash
# Run everything that needs a GPU in under ten minutes: kernel tests, steps, whole fits, hardware counters of two
# kernels, and the other tests.
#
#     bench/gpu.sh [FOLDER_OF_THE_KODAK_SET]
#
# The folder is kodak/ by default. Without kodim07.png in it, whole fits use a sample photo of scikit-image, and the steps
# of kodim07 count as failed. Set PYTHON to choose the interpreter. Parts that fail or run out of time are listed at the
# end, and the exit status is 1; without a GPU it is 2.
#
# With 15 minutes on a GPU, in this order, each command only if it still has the time beside it:
#
#   1. 10 min  bench/gpu.sh kodak
#   2.  1 min  python bench/bench_fit.py kodak/kodim07.png --curves 512 --repeat 3 --no-vtracer --set device=cuda
#              (if 1 left it out; the aim is 1.5 s a fit, and 0.25 ms a step at 1024 paths in 1)
#   3.  2 min  python bench/paper.py interior kodak --set device=cuda --out interior.csv
#              (28.08 dB in the paper, with interior gradients; its seconds to that in interior.fits/*.json)
#   4.  rest   python bench/paper.py table1 kodak --presets paper,paper-released --set device=cuda --out table1.csv
#              (each fit is kept; the same command goes on where the time ended)
set -uo pipefail
case "${1:-}" in
    -h | --help)
        sed -n '2,/^set -uo/{/^set -uo/d;s/^# \{0,1\}//;p}' "$0"
        exit 0
        ;;
esac
cd "$(dirname "$0")/.." || exit 2

python=${PYTHON:-python}
photos=${1:-kodak}
cache=$(mktemp -d)
trap 'rm -rf "$cache"' EXIT
limit=585 # seconds for all parts together
pytest=("$python" -m pytest -q -n 8 -p no:cacheprovider -p no:benchmark -m "")
kernel_tests=(tests/rendering/stages tests/rendering/test_exact.py)
failed=()

no_gpu() {
    echo "bench/gpu.sh: no GPU to measure: $1" >&2
    exit 2
}

command -v "$python" >/dev/null || no_gpu "$python is not a command; set PYTHON to the interpreter that has warpvec"
reason=$("$python" - 2>/dev/null <<'PYTHON'
import torch, warp as wp
wp.config.log_level = wp.LOG_ERROR
if not torch.cuda.is_available():
    print(f"torch {torch.__version__} sees none")
elif wp.get_cuda_device_count() == 0:
    print("Warp sees none")
PYTHON
) || no_gpu "$python cannot import torch and warp; set PYTHON to the interpreter that has warpvec"
[ -z "$reason" ] || no_gpu "$reason"

# part NAME SECONDS COMMAND...: run COMMAND under a heading, for at most SECONDS or the time left; keep its output.
part() {
    local name=$1 seconds=$2 left=$((limit - SECONDS))
    shift 2
    [ "$seconds" -le "$left" ] || seconds=$left
    printf '\n## %s\n\n' "$name"
    if [ "$seconds" -le 5 ]; then
        echo "left out because no time is left"
        failed+=("$name")
        return
    fi
    timeout --kill-after=5 "$seconds" "$@" | tee "$cache/printed"
    local status=${PIPESTATUS[0]}
    [ "$status" -ne 124 ] || echo "stopped after $seconds s"
    [ "$status" -eq 0 ] || failed+=("$name")
}

# step SCENE SECONDS: time one step of SCENE by stage, and keep its output under the name of the scene.
step() {
    : >"$cache/printed"
    part "step, $1" "$2" "$python" bench/bench_step.py --scene "$1" --photos "$photos" --device cuda --repeat 20 \
        --cache "$cache"
    mv "$cache/printed" "$cache/$1"
}

# slowest FILE: print the kernels of the two slowest stages in the output FILE of a step, as a pattern.
slowest() {
    "$python" - "$1" <<'PYTHON'
import json, sys
kernels = {
    "flattening": "emit_vertices", "binning": "mark_pairs", "coverage": "accumulate_winding",
    "compositing_adjoint": "composite_adjoint", "coverage_adjoint": "integrate_edges",
    "flattening, adjoint": "gather_segments_adjoint", "regularization": "add_regularizers",
    "population": "step_population",
}
line = next(line for line in open(sys.argv[1]) if line.startswith("{"))
(rows,) = (result["step"] for result in json.loads(line)["ms"].values())
found = sorted((name for name in kernels if name in rows), key=lambda name: -rows[name]["min"])
print("|".join(kernels[name] for name in found[:2]))
PYTHON
}

command -v nvidia-smi >/dev/null && nvidia-smi --query-gpu=name,driver_version,clocks.max.sm,memory.total --format=csv

# An H200's machine took 38 s for these with 8 workers, most of it to compile.
part "kernel tests on the GPU" 200 "${pytest[@]}" -k cuda "${kernel_tests[@]}"
if [ -f "$photos/kodim07.png" ]; then
    step kodim07-256 60
    step kodim07-1024 60
    step photo-2040x1344-2048 90
else
    echo "steps of kodim07 left out: no kodim07.png in $photos"
    failed+=("steps of kodim07")
fi
step wide-4096x4096-4096 120

photo=$photos/kodim07.png
if [ ! -f "$photo" ]; then
    photo=$cache/coffee.png
    "$python" -c 'import sys; from warpvec.image.samples import write_sample; write_sample("coffee.png", sys.argv[1])' "$photo"
fi
part "whole fits" 90 "$python" bench/bench_fit.py "$photo" --curves 512,1024 --repeat 3 --no-vtracer --set device=cuda

if command -v ncu >/dev/null && grep -q '^{' "$cache/kodim07-1024" 2>/dev/null; then
    part "counters of the two slowest kernels" 90 ncu --clock-control none --set basic --section SpeedOfLight --section Occupancy \
        --kernel-name-base function --kernel-name "regex:.*($(slowest "$cache/kodim07-1024")).*" --launch-skip 4 \
        --launch-count 4 "$python" bench/bench_step.py --scene kodim07-1024 --photos "$photos" --device cuda \
        --repeat 1 --cache "$cache"
else
    printf '\ncounters left out: they need the program ncu and the step of kodim07-1024\n'
fi

# These took 57 s with 8 workers. Those in test_cuda_compile.py compile for a GPU but need none.
part "other tests on the GPU" 200 "${pytest[@]}" -k "cuda and not cuda_compile" \
    "${kernel_tests[@]/#/--ignore=}" tests

printf '\n%s s in total\n' "$SECONDS"
if [ ${#failed[@]} -gt 0 ]; then
    printf 'failed: %s\n' "${failed[@]}"
    exit 1
fi
