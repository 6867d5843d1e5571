#!/bin/bash
# Runs assets/cluster with Snakemake and holds what it makes against the same work done in one piece: preprocessing in 6 parts, a sweep of
# 3 values and a stress test of 2 disturbances, each by a job, and a film. Then a job is killed in the middle, and at last a picture is
# changed under finished parts.
#
#     tests/cluster.sh PROGRAM local
#     assets/cluster/one_machine_slurm.sh tests/cluster.sh PROGRAM slurm
#
# Needs snakemake on PATH (for Slurm with snakemake-executor-plugin-slurm), python3 and ffmpeg. Everything is made in a temporary folder,
# which is removed; KEEP=FOLDER copies what Snakemake said there.
set -euo pipefail

program=$(realpath "$1")
profile=$2
assets=$(realpath "$(dirname "$0")/../assets/cluster")
folder=$(mktemp -d /tmp/overlook-cluster.XXXXXX)
trap '[ -z "${KEEP:-}" ] || { mkdir -p "$KEEP"; cp "$folder"/*.log "$KEEP"; }; rm -rf "$folder"' EXIT
cd "$folder"
vary=pruning.depth_tolerance=0.5,1,2
painted="--set render.backend=cpu"
measured="--frames 2 $painted"
# Jobs that are done are asked for at once, of the controller: there is no accounting.
more=
[ "$profile" != slurm ] || more="--slurm-status-command squeue --slurm-init-seconds-before-status-checks 3 --seconds-between-status-checks 3"

fail() {
    echo "FAILED: $1" >&2
    exit 1
}

# Makes everything in a folder of this name.
workflow() {
    local out=$1
    shift
    sed "s|^out:.*|out: $out|" all.yaml > "$out.yaml"
    snakemake --snakefile "$assets/Snakefile" --configfile "$out.yaml" --profile "$assets/profiles/$profile" \
        --default-resources mem_mb=1000 runtime=30 --latency-wait 10 ${more:-} "$@" > "$out.log" 2>&1
}

# What a document says but for times, which no two measurements share, and for where it lies.
timeless() {
    python3 - "$1" << 'PYTHON'
import json, sys
LEFT_OUT = {"milliseconds", "milliseconds_se", "seconds_preprocess", "pareto", "command"}
def strip(value):
    if isinstance(value, dict):
        return {key: strip(inner) for key, inner in value.items() if key not in LEFT_OUT}
    return [strip(inner) for inner in value] if isinstance(value, list) else value
print(json.dumps(strip(json.load(open(sys.argv[1])))))
PYTHON
}

# Whether nothing was measured again when journals were put together.
is_joined() {
    local lines=1 journal
    for journal in "$1"/job-*/*.journal; do lines=$((lines + $(wc -l < "$journal") - 1)); done
    [ "$lines" = "$(wc -l < "$2")" ] || fail "$2 has points that no job measured"
}

is_as_in_one_piece() {
    local picture
    cmp one.ovl "$1/scene.ovl" || fail "$1/scene.ovl is not the store of one piece"
    cmp one.mp4 "$1/film.mp4" || fail "$1/film.mp4 is not the film of one piece"
    for picture in one-sweep/worst*.png; do
        cmp "$picture" "$1/sweep/$(basename "$picture")" || fail "$picture is not that of one piece"
    done
    for picture in one-stress/breaking/*.png; do
        cmp "$picture" "$1/stress/breaking/$(basename "$picture")" || fail "$picture is not that of one piece"
    done
    [ "$(timeless one-sweep/sweep.json)" = "$(timeless "$1/sweep/sweep.json")" ] || fail "$1 has another sweep"
    [ "$(timeless one-stress/stress.json)" = "$(timeless "$1/stress/stress.json")" ] || fail "$1 has another stress test"
    is_joined "$1/sweep" "$1/sweep/sweep.journal"
    is_joined "$1/stress" "$1/stress/stress.journal"
}

"$program" demo nine-cameras --out scene --frames 48 --size 240x180 > /dev/null
python3 - << 'PYTHON'
import json
def view(time, x):
    pose = [[1, 0, 0, x], [0, 0, -1, -3], [0, 1, 0, 1], [0, 0, 0, 1]]
    return {"file_path": f"{time}.exr", "time": time, "transform_matrix": pose}
json.dump({"w": 160, "h": 120, "fl_x": 130, "frames": [view(0, 0.0), view(47, 0.4)]}, open("path.json", "w"))
PYTHON
cat > all.yaml << YAML
overlook: $program
capture: scene
out: out
options: ""
preprocess: {parts: 6}
sweep: {vary: "$vary", options: "$measured"}
stress: {only: [camera pose, depth noise], options: "$measured"}
views: {manifests: [scene/novel/transforms.json], options: "$painted"}
film: {path: path.json, options: "$painted"}
YAML
sed 's/^sweep:.*/sweep: null/; /^stress:/d; /^views:/d; /^film:/d' all.yaml > preprocess.yaml
"$program" preprocess scene --out one.ovl > /dev/null
# Options are words of their own.
# shellcheck disable=SC2086
"$program" sweep scene --out one-sweep --vary $vary $measured > /dev/null
# shellcheck disable=SC2086
"$program" stress scene --out one-stress --only "camera pose" --only "depth noise" $measured > /dev/null
# shellcheck disable=SC2086
"$program" render one.ovl --views scene/novel/transforms.json --out one-views $painted > /dev/null
# shellcheck disable=SC2086
"$program" export video one.ovl --path path.json --out one.mp4 $painted > /dev/null

workflow whole || { tail -n 60 whole.log >&2; fail "the workflow"; }
is_as_in_one_piece whole
diff -r --exclude=views.json one-views whole/views/1 || fail "the views are not those of one piece"
echo "$profile: a store from 6 parts, a sweep of 3 jobs, a stress test of 2, views and a film are those of one piece"

cp preprocess.yaml all.yaml
workflow killed &
running=$!
killed=
while [ -z "$killed" ] && kill -0 $running 2> /dev/null; do
    killed=$(pgrep -f "^$program preprocess .*killed/scene.ovl .*--stage prune --part 3/6$" | head -n 1 || true)
    sleep 0.01
done
[ -n "$killed" ] || fail "no job was there to be killed"
sleep 0.05
kill -KILL "$killed" || fail "the job was done before it could be killed"
wait $running || { tail -n 60 killed.log >&2; fail "the workflow with a killed job"; }
grep -q "Error in rule prune" killed.log || fail "nothing was killed in the middle"
cmp one.ovl killed/scene.ovl || fail "the store of a workflow whose job was killed"
echo "$profile: a job that was killed was run again, and the store is that of one piece"

rm killed/scene.ovl
picture=$(find scene -name '*.exr' | grep -v novel | sort | tail -n 1)
touch "$picture"
if workflow killed --retries 0; then fail "parts of a picture that changed were joined"; fi
{ cat killed.log; find .snakemake -name '*.log' -exec cat {} +; } > said.txt
grep "killed/scene.ovl.[^ ]*: was made from another state" said.txt > refused.txt || { tail -n 40 killed.log >&2; fail "nothing was refused by name"; }
head -n 1 refused.txt
echo "$profile: what was made of a picture that changed was refused by its name"
