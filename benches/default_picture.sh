#!/usr/bin/env bash
# Compares how long two programs take for the default picture, with every default on: an orbit around three built-in scenes, each picture
# another viewpoint, the programs in turn. Fails if NEW takes over a tenth longer than OLD at any of the sizes.
# Usage: benches/default_picture.sh OLD NEW [TURNS]   (two programs `overlook`; needs python3; keep the machine quiet meanwhile)
set -euo pipefail
old=$(realpath "$1") new=$(realpath "$2") turns=${3:-5}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
for scene in nine-cameras orrery crystal; do
    "$new" demo "$scene" --frames 2 --out "$scene" >/dev/null 2>&1
    # Each program makes its own store, which the other need not know how to read.
    "$old" preprocess "$scene" --out "$scene.old.ovl" >/dev/null 2>&1
    "$new" preprocess "$scene" --out "$scene.new.ovl" >/dev/null 2>&1
done
python3 - "$old" "$new" "$turns" <<'P'
import json, math, statistics, subprocess, sys

programs, turns = dict(old=sys.argv[1], new=sys.argv[2]), int(sys.argv[3])
SIZES = [(640, 480), (1280, 720), (1920, 1080)]
VIEWS, STEP_RAD = 6, 0.012


def orbit(scene, width, height):
    """Viewpoints around what the first true view of a scene looks at, as a manifest."""
    manifest = json.load(open(f"{scene}/novel/transforms.json"))
    first = manifest["frames"][0]
    lens = lambda key: first.get(key, manifest.get(key))
    pose = first["transform_matrix"]
    eye = [row[3] for row in pose[:3]]
    pivot = [eye[axis] - 3 * pose[axis][2] for axis in range(3)]
    scale = width / lens("w")
    frames = []
    for nth in range(VIEWS):
        c, s = math.cos(STEP_RAD * nth), math.sin(STEP_RAD * nth)
        turn = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        times = lambda vector: [sum(a * b for a, b in zip(row, vector)) for row in turn]
        columns = [times([pose[row][column] for row in range(3)]) for column in range(3)]
        place = [p + d for p, d in zip(pivot, times([e - p for e, p in zip(eye, pivot)]))]
        matrix = [[*(column[row] for column in columns), place[row]] for row in range(3)] + [[0, 0, 0, 1]]
        frames.append({**first, "file_path": f"orbit/{nth:02}.exr", "transform_matrix": matrix})
    sized = dict(w=width, h=height, fl_x=lens("fl_x") * scale, fl_y=lens("fl_x") * scale, cx=width / 2, cy=height / 2)
    for frame in frames:
        frame.update({key: value for key, value in sized.items() if key in frame})
    return {**manifest, **sized, "frames": frames}


def milliseconds(program, store, views):
    command = [program, "render", store, "--views", views, "--out", "pictures", "--backend", "cpu", "--json"]
    answer = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    # The first picture reads the store.
    return [view["milliseconds"] for view in answer["views"]][1:]


worst = 0
for scene in ("nine-cameras", "orrery", "crystal"):
    for width, height in SIZES:
        views = f"{scene}.{width}.json"
        json.dump(orbit(scene, width, height), open(views, "w"))
        taken = dict(old=[], new=[])
        for _ in range(turns):
            for name, program in programs.items():
                taken[name] += milliseconds(program, f"{scene}.{name}.ovl", views)
        old, new = (statistics.median(taken[name]) for name in ("old", "new"))
        worst = max(worst, new / old)
        print(f"{scene:14} {width:4}×{height:<4}  old {old:7.1f} ms  new {new:7.1f} ms  ratio {new / old:.2f}", flush=True)
if worst > 1.1:
    sys.exit(f"the default picture takes {worst:.2f} times as long as before")
P
