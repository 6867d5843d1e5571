#!/usr/bin/env bash
# Prints a hash of everything that Overlook makes of some captures, to show that a change of the code changes no bit of any result:
#
#     diff <(tests/result_hashes.sh OLD_OVERLOOK) <(tests/result_hashes.sh NEW_OVERLOOK)
#
# prints nothing where two programs agree, and otherwise the results in which they differ.
#
# Usage: tests/result_hashes.sh OVERLOOK [CAPTURE...]
#
# Small captures go through every command: assets/small_capture, and a small recording of each demo scene. Captures that are
# given as arguments may be large, and go through fewer settings and at most three views. Each result is a line on stdout:
#
#     first 16 hex digits of its SHA-256  CAPTURE  WHAT
#     refused                             CAPTURE  what the program said
#     skipped                             CAPTURE  what this machine lacks
#
# Progress goes to stderr. Needs Python 3.
#
# Left out of the hashes, since they differ from run to run or from machine to machine: times, memory and numbers of threads
# (result_hashes.py takes them out of documents), and pareto.png, which draws times. Everything is painted on the CPU: by default a
# clock decides between it and a graphics card. Commands run inside a temporary folder and name all files by relative paths, so that
# no path of the machine gets into a result.
set -euo pipefail
export LC_ALL=C

if [ $# -lt 1 ] || [ ! -x "$1" ]; then
    echo "Usage: tests/result_hashes.sh OVERLOOK [CAPTURE...]" >&2
    exit 2
fi
program=$(realpath "$1")
shift
here=$(realpath "$(dirname "$0")")
# The interpreter itself, which starts faster than a wrapper around it.
python=$(python3 -c 'import sys; print(sys.executable)')

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# --- Lines -----------------------------------------------------------------------------------------------------------------

# The capture that the program works on. Its name is also its relative path, since every capture is linked into a folder of its own.
capture=

note() { printf '%4d s  %s\n' "$SECONDS" "$*" >&2; }

# line HASH WHAT
line() { printf '%s  %s  %s\n' "$1" "$capture" "$2"; }

# Runs the program; what it prints is in the file `printed`. Fails where the program fails; `said` then gives the error.
overlook() { "$program" "$@" >printed 2>trouble; }

# The first line of the last error; warnings may stand before it.
said() { grep -v '^overlook: warning: ' trouble | grep -m 1 .; }

# attempt WHAT ARGUMENT...: runs the program; where it refuses, prints a line that says so and fails.
attempt() {
    local what=$1
    shift
    overlook "$@" || { line refused "$what: $(said)"; return 1; }
}

# --- Hashes ----------------------------------------------------------------------------------------------------------------

helper() { "$python" -I "$here/result_hashes.py" "$@"; }

# The hash of stdin.
short_hash() { sha256sum | cut -c 1-16; }

# hash_file WHAT FILE
hash_file() { line "$(short_hash <"$2")" "$1"; }

# hash_files WHAT FOLDER EXTENSION: one hash of all files below a folder, with their names.
hash_files() {
    local list
    list=$(cd "$2" && find . -type f -name "*.$3" -print0 | sort -z | xargs -0r sha256sum)
    line "$(short_hash <<<"$list")" "$1: $(grep -c . <<<"$list") files .$3"
}

# hash_part WHAT PART FILE: a file without what differs from run to run; PART is a command of result_hashes.py. The hash is taken
# before the line is printed: where the helper fails, the script ends rather than print a hash of nothing.
hash_part() {
    local hash
    hash=$(helper "$2" "$3" | short_hash)
    line "$hash" "$1"
}

# --- Commands --------------------------------------------------------------------------------------------------------------

# hash_store WHAT FILE: the samples have a hash of their own, as the file also holds settings, report and provenance in words.
hash_store() {
    hash_file "$1: store" "$2"
    hash_part "$1: samples" samples "$2"
}

# store NAME ARGUMENT...: preprocesses the capture into NAME.ovl.
store() {
    local name=$1
    shift
    attempt "preprocess, $name" preprocess "$capture" --out "$name.ovl" --json "$@" || return 0
    hash_store "preprocess, $name" "$name.ovl"
    hash_part "preprocess, $name: report" json printed
}

stores_at_default() {
    store default
    store spans.levels=paper --set spans.levels=paper
}

info_of_store() {
    attempt "info of the store" info default.ovl --json || return 0
    hash_part "info of the store" json printed
}

# The default store with other numbers of threads: the same hash each time.
stores_by_threads() {
    local threads
    for threads in 1 2; do
        store "threads $threads" --threads "$threads"
        cmp -s default.ovl "threads $threads.ovl" || note "$capture: WITH $threads THREADS THE STORE IS ANOTHER ONE"
    done
}

# Every choice that is not the default, and every switch.
stores_by_setting() {
    local setting
    for setting in \
        spans.levels=off spans.noise=0 \
        pruning.method={off,first_camera} pruning.rate={paper,footprint,stretch} pruning.mixed_pixels={keep,drop} \
        pruning.across_spans=false pruning.overlap=false \
        store.precision={bits16,bits12,bits10,bits8} store.coding=plain store.normals=true; do
        store "$setting" --set "$setting"
    done
    # Normals are stored, so that they have a hash.
    local estimated=(--set normals.source=estimated --set store.normals=true)
    store normals.source=estimated "${estimated[@]}"
    store normals.estimator=cross "${estimated[@]}" --set normals.estimator=cross
    store hold-out --hold-out "$(helper last_camera info.json)"
}

# pictures WHAT STORE VIEWS ARGUMENT...: paints a store from the views of a folder.
pictures() {
    local what=$1 from=$2 views=$3
    shift 3
    attempt "render, $what" render "$from.ovl" --views "$views" --out pictures --backend cpu --json "$@" || return 0
    hash_files "render, $what" pictures exr
    hash_files "render, $what" pictures png
    hash_part "render, $what: scores" json printed
    rm -r pictures
}

# A manifest of views with their true pictures; without any, of the capture's own cameras.
truth() { if [ -e "$capture/novel/transforms.json" ]; then echo "$capture/novel"; else echo "$capture"; fi; }

pictures_by_kernel() {
    local kernel fill
    for kernel in point block surfel gather; do
        for fill in none pushpull; do
            pictures "$kernel, fill $fill" default views --kernel "$kernel" --fill "$fill"
        done
    done
}

# Views that are coarser and finer than what was recorded, and stores that are read in other ways.
pictures_by_size_and_store() {
    local kernel size from
    for size in 0.4 2.5; do
        helper scaled_views views "views_$size" "$size"
        for kernel in point block surfel gather; do
            pictures "$kernel, $size times the size" default "views_$size" --kernel "$kernel"
        done
    done
    pictures render.antialias=off default views_0.4 --set render.antialias=off
    for from in spans.levels=paper pruning.method=off store.precision=bits10 store.coding=plain; do
        pictures "store with $from" "$from" views
    done
}

export_points() {
    attempt "export points" export points default.ovl --out points || return 0
    hash_files "export points" points ply
    attempt "export points --static" export points store.normals=true.ovl --static --out static.ply || return 0
    hash_file "export points --static, of a store with normals" static.ply
}

export_film() {
    helper path views path.json
    attempt "export pictures" export pictures default.ovl --path path.json --out film --backend cpu || return 0
    hash_files "export pictures" film exr
    hash_files "export pictures" film png
    attempt "export video" export video default.ovl --path path.json --out film.mp4 --backend cpu || return 0
    hash_file "export video" film.mp4
}

export_stores() {
    local setting
    for setting in store.precision=lossless store.precision=bits10 store.coding=plain; do
        attempt "export store, $setting" export store default.ovl --out again.ovl --set "$setting" || continue
        hash_store "export store, $setting" again.ovl
    done
}

# evaluation WHAT ARGUMENT...
evaluation() {
    local what=$1
    shift
    attempt "$what" evaluate "$capture" --backend cpu --json "$@" || return 0
    hash_part "$what" json printed
}

# study WHAT COMMAND ARGUMENT...: the commands that measure many settings have no --backend.
study() {
    local what=$1 command=$2
    shift 2
    attempt "$what" "$command" "$capture" --set render.backend=cpu --json "$@"
}

# sweep NAME ARGUMENT...
sweep() {
    local name=$1
    shift
    study "$name" sweep --frames 2 --out "$name" "$@" || return 0
    hash_part "$name: sweep.json" json "$name/sweep.json"
    hash_part "$name: sweep.csv" csv "$name/sweep.csv"
}

# Every disturbance, at one frame and with a fast kernel.
stress() {
    study "stress" stress --frames 1 --set render.kernel=block --out stress || return 0
    hash_part "stress.json" json stress/stress.json
    hash_part "stress.csv" csv stress/stress.csv
    hash_file "stress.png" stress/stress.png
}

# A line for each setting that was tried: where a choice is added or taken away, all others can still be compared.
tune() {
    study "tune" tune --frames 1 --set render.kernel=block --out tuned.toml || return 0
    hash_part "tune: decision" tuned printed
    line "$(grep -v '^#' tuned.toml | short_hash)" "tune: settings"
    helper points printed | while IFS=$'\t' read -r label point; do
        line "$(short_hash <<<"$point")" "tune: $label"
    done
}

# --- Captures --------------------------------------------------------------------------------------------------------------

# Enters a new, empty folder.
folders=0
enter() {
    capture=$1
    folders=$((folders + 1))
    mkdir "$work/$folders"
    cd "$work/$folders"
    note "$capture"
}

# Whether the program takes the capture at all.
is_taken() {
    if ! overlook info "$capture" --json; then
        line refused "$(said)"
        return 1
    fi
    mv printed info.json
    hash_part "info" json info.json
}

# Runs all commands on the capture in this folder.
everything() {
    is_taken || return 0
    helper views "$(truth)" views 1000
    note "$capture: preprocess"
    stores_at_default
    info_of_store
    stores_by_threads
    stores_by_setting
    note "$capture: render and export"
    pictures_by_kernel
    pictures_by_size_and_store
    export_points
    export_film
    export_stores
    note "$capture: evaluate"
    evaluation "evaluate"
    evaluation "evaluate --hold-out" --hold-out "$(helper last_camera info.json)"
    note "$capture: sweep"
    sweep "sweep" --vary pruning.depth_tolerance=0.5,2 --vary pruning.rate=paper,footprint
    sweep "sweep --cross-validate" --cross-validate --vary spans.levels=paper
    note "$capture: stress"
    stress
    note "$capture: tune"
    tune
}

# What a large capture is put through.
the_essential() {
    is_taken || return 0
    helper views "$(truth)" views 3
    stores_at_default
    note "$capture: render"
    pictures_by_kernel
    note "$capture: evaluate"
    evaluation "evaluate" --views views
}

# demo NAME SIZE FRAMES
demo() {
    enter "$1"
    attempt "demo" demo "$1" --size "$2" --frames "$3" --out "$1" || return 0
    hash_files "demo" "$1" exr
    hash_files "demo" "$1" json
    everything
}

small_capture() {
    enter small_capture
    ln -s "$here/../assets/small_capture" small_capture
    everything
}

# given CAPTURE: a folder or its manifest.
given() {
    local folder
    folder=$(realpath -m "$1")
    [ -f "$folder" ] && folder=$(dirname "$folder")
    enter "$(basename "$folder")"
    ln -s "$folder" "$capture"
    the_essential
}

# Relative captures are meant from where the script was called.
started=$PWD
small_capture
demo orrery 72x54 6
demo nine-cameras 64x48 5
demo four-cameras 100x70 9
demo crystal 64x48 6
for named in "$@"; do
    cd "$started"
    given "$named"
done
cd "$started"
note "done"
