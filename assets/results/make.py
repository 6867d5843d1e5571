#!/usr/bin/env python3
"""Measures Overlook, and writes RESULTS.md, results.json and pareto.png.

    assets/results/make.py target/release/overlook [CAPTURE...]              accuracy, then times
    assets/results/make.py target/release/overlook --accuracy [CAPTURE...]   on a machine that does other work as well
    assets/results/make.py target/release/overlook --times [CAPTURE...]      on a quiet machine
    assets/results/make.py --write-only [target/release/overlook]

The built-in demo scenes and assets/small_capture are measured always. A CAPTURE is a folder with true pictures of further viewpoints in
novel/transforms.json, as FOLDER or NAME=FOLDER. With --only NAME, those of that name alone are measured, and the figures of all others
stay. With --work DIR, what was recorded and measured there is used again.

Each row has a hash of the pictures that its program makes of assets/small_capture. Rows whose hash is not that of the program are marked
on the page, and the headline leaves them out. --write-only writes the page from results.json without measuring; with a program it looks
anew which rows are the program's.

results.json holds all figures, page.py makes the page of them. Needs nothing but Python 3.
"""
import argparse
import datetime
import hashlib
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import page

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RESULTS = HERE / "results.json"

# Name, what it is, and the arguments of `overlook demo` that record it.
DEMOS = [
    ("orrery", "an orrery on a table under an open sky, exact", ["orrery", "--size", "320x240"]),
    ("orrery-3", "the same by three cameras", ["orrery", "--cameras", "3", "--frames", "16", "--size", "320x240"]),
    ("orrery-16", "the same by sixteen cameras", ["orrery", "--cameras", "16", "--frames", "8", "--size", "160x120"]),
    ("nine-cameras", "a living room, noisy color", ["nine-cameras", "--frames", "24", "--size", "320x240"]),
    ("four-cameras", "crystals that grow, exact", ["four-cameras", "--frames", "100"]),
    ("crystal", "a melt that condenses, exact", ["crystal", "--frames", "24", "--size", "320x240"]),
]
SMALL = ("small_capture", "an orrery by Blender, noisy color", ROOT / "assets/small_capture")

# What captures are that are not in the repository, by their names.
DESCRIBED = {
    "desk": "a desk, recorded by a depth camera in a hand; not in the repository",
    "shelf": "a shelf, recorded by a depth camera in a hand; not in the repository",
    "thicket": "stems that sway before a cloudy sky, by Mitsuba 3; not in the repository",
}

# The capture whose sweep is drawn, and whose rivals are timed.
CHARTED = "orrery"

# Pictures are timed as they come from a store, all of them this many times.
TIMED_RUNS = 3

# Every switch of the renderer that is no kernel, by itself.
SWITCHES = [
    "render.fill=none",
    "render.free_space=false",
    "render.depth_tolerance=1",
    "render.depth_tolerance=16",
    "render.views=1",
    "render.views=4",
    "render.antialias=off",
    "render.antialias=supersampled",
]

# What these switches are for, seen at the pictures that they are for: switch, the store, and how many times as wide the pictures are.
PURPOSES = [
    ("render.views=1", "everything", 1),
    ("render.views=4", "everything", 1),
    ("render.coarse=pyramid", "ours", 0.25),
    ("render.magnified=direct", "ours", 3),
]

# Captures whose true pictures are recorded at other sizes as well: as close-ups, and as coarse pictures.
RESIZED = ["orrery"]

# Sizes of pictures that are timed: of a capture of this size, seen at this size.
TIMED_SIZES = [(320, 240), (640, 480), (1280, 720)]
TIMED_DEMO = ["orrery", "--frames", "6"]

OTHERS = {
    "first_camera", "first_camera_at_count", "random", "voxel_grid",
    "triangle_mesh", "tsdf", "nearest_camera", "layered_depth_image",
}


class Program:
    """The program, run in the folder in which captures lie under their names."""

    def __init__(self, path, folder, built_of):
        self.path, self.folder = Path(path).resolve(), folder
        self.commit = built_of or commit()
        self.pictures = self.hash_of_pictures()

    def run(self, *arguments):
        """Runs a command and gives what it prints."""
        done = subprocess.run([self.path, *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"overlook {' '.join(arguments)}\n{done.stderr}")
        return done.stdout

    def document(self, *arguments):
        return json.loads(self.run(*arguments, "--json"))

    def settings(self, *arguments):
        """All settings as lines of TOML, without their explanations."""
        lines = self.run("settings", *arguments).splitlines()
        return [line for line in lines if line and not line.startswith("#")]

    def hash_of_pictures(self):
        """CRC-32 of all pictures of assets/small_capture, in the order of their names; tests/lab/results.rs computes the same."""
        place = SMALL[2]
        self.run("preprocess", str(place), "--out", "hashed.ovl")
        self.run("render", "hashed.ovl", "--views", str(place / "novel/transforms.json"), "--out", "hashed", "--backend", "cpu")
        pictures = sorted((self.folder / "hashed").rglob("*.exr"))
        value = 0
        for picture in pictures:
            value = zlib.crc32(picture.read_bytes(), value)
        shutil.rmtree(self.folder / "hashed")
        return f"{value:08x}"

    def measured(self):
        """Which program measured, and when."""
        return {"pictures": self.pictures, "commit": self.commit, "date": datetime.date.today().isoformat()}

    def prepared(self, name, kind, arguments):
        """The store of a capture by some settings, and what `preprocess` said of it."""
        store, said = self.folder / f"{name}-{kind}.ovl", self.folder / f"{name}-{kind}.json"
        if not store.exists() or not said.exists():
            said.write_text(self.run("preprocess", name, "--out", store.name, *arguments, "--json"))
        return json.loads(said.read_text())

    def shown(self, name, kind, setting=None, views=None):
        """The scores of a store's pictures."""
        changed = ["--set", setting] if setting else []
        views = views or f"{name}/novel/transforms.json"
        return self.document("render", f"{name}-{kind}.ovl", "--views", views, "--out", "pictures", *changed)


def accuracy(program, name, content, recording):
    """Everything about one capture but times. It lies in the program's folder under its name."""
    info = program.document("info", name)
    sweep = ["sweep", name, "--vary", "render.kernel=gather,surfel,block,point", "--out", f"{name}-sweep"]
    points = program.document(*sweep)["points"]
    ours = one_of(points, "reference")
    paper = one_of(points, "paper")
    everything = next(point for point in points if point["label"] == "no pruning, gather")
    as_in_paper = changed(ours["settings"], paper["settings"])
    stores = store_arguments(as_in_paper)
    bytes_raw = [program.prepared(name, kind, arguments)["bytes_raw"] for kind, arguments in stores.items()][0]
    most = max(point["vantages"] for point in points)
    others = [point for point in points if point["series"] in OTHERS and point["vantages"] == most]
    rival = max(others, key=lambda point: point["psnr_filled_db"])
    first = [point for point in others if point["series"] == "first_camera"]
    methods = {
        "ours": method(ours, ours, info),
        "everything": method(everything, ours, info),
        "rival": method(rival, ours, info),
        "first": method(max(first, key=lambda point: point["psnr_filled_db"]), ours, info),
        "paper": method(paper, ours, info),
    }
    return {
        "name": name,
        "content": content,
        "recording": " ".join(["overlook", *recording]) if recording else None,
        "cameras": len(info["cameras"]),
        "frames": info["frames"],
        "sizes": sorted({f"{camera['width']}×{camera['height']}" for camera in info["cameras"]}),
        "pixels": info["pixels"],
        "bytes_raw": bytes_raw,
        "viewpoints": most,
        "true_pictures": len(ours["views"]),
        "accuracy": program.measured(),
        "sweep": " ".join(["overlook", *sweep]),
        "paper_settings": " ".join(as_in_paper),
        "error_by_class": ours["error_by_class"],
        "methods": methods,
        "points": [brief(point) for point in points],
        "switches": switches(program, name, recording),
    }


def store_arguments(as_in_paper):
    return {"ours": [], "everything": ["--set", "pruning.method=off"], "paper": as_in_paper}


def switches(program, name, recording):
    """What each switch of the renderer gives, in dB over all pixels of the pictures that it is for."""
    rows = [(setting, "ours", 1) for setting in SWITCHES if not setting.startswith("render.views")]
    rows += [row for row in PURPOSES if row[2] == 1 or name in RESIZED]
    defaults, measured = {}, []
    for setting, kind, wide in rows:
        views = resized_views(program, name, recording, wide)
        if (kind, wide) not in defaults:
            defaults[kind, wide] = overall(program.shown(name, kind, views=views))
        db = overall(program.shown(name, kind, setting, views))
        measured.append({"label": setting, "store": kind, "wide": wide, "db": db, "default_db": defaults[kind, wide]})
    return measured


def overall(evaluation):
    """PSNR over all pixels, the mean over pictures."""
    return round(evaluation["mean"]["psnr_all_db"], 4)


def resized_views(program, name, recording, wide):
    """True pictures of the same viewpoints, so many times as wide."""
    if wide == 1:
        return f"{name}/novel/transforms.json"
    folder = f"{name}-{wide}-times"
    if not (program.folder / folder).exists():
        arguments = list(recording)
        size = arguments.index("--size") + 1
        arguments[size] = "x".join(str(round(int(side) * wide)) for side in arguments[size].split("x"))
        arguments[-1] = folder
        program.run(*arguments, "--cameras", "1")
    return f"{folder}/novel/transforms.json"


def times(program, entry):
    """How long the pictures of one capture take, and preparing it."""
    name = entry["name"]
    stores = store_arguments(entry["paper_settings"].split())
    (program.folder / f"{name}-ours.json").unlink(missing_ok=True)
    milliseconds, painted_by = {}, set()
    for kind, arguments in stores.items():
        made = program.prepared(name, kind, arguments)
        milliseconds[kind], painters = timed(program, name, kind)
        painted_by |= painters
        if kind == "ours":
            seconds, threads = made["seconds_total"], made["threads"]
    switched = []
    for row in entry["switches"]:
        views = resized_views(program, name, entry["recording"] and entry["recording"].split()[1:], row["wide"])
        of_default, of_switch = (timed(program, name, row["store"], setting, views, 1)[0] for setting in (None, row["label"]))
        switched.append({"label": row["label"], "store": row["store"], "wide": row["wide"], "times_as_long": round(of_switch / of_default, 3)})
    if name == CHARTED:
        milliseconds["rival"] = charted(program, entry)
    return program.measured() | {
        "machine": machine(),
        "threads": threads,
        "painted_by": " and ".join(sorted(painted_by)),
        "seconds_preprocess": round(seconds, 2),
        "milliseconds": {kind: round(value, 2) for kind, value in milliseconds.items()},
        "switches": switched,
    }


def timed(program, name, kind, setting=None, views=None, runs=TIMED_RUNS):
    """The median time of a store's pictures with everything that the settings say, filling among it, and what painted them."""
    found, painters = [], set()
    for _ in range(runs):
        pictures = program.shown(name, kind, setting, views)["views"]
        found += [view["milliseconds"] for view in pictures]
        painters |= {view.get("adapter") or view["backend"] for view in pictures}
    return statistics.median(found), painters


def charted(program, entry):
    """Sweeps once more on the quiet machine, keeps the chart, and gives the time of the best rival's pictures."""
    *sweep, folder = entry["sweep"].split()[1:]
    shutil.rmtree(program.folder / f"{folder}-timed", ignore_errors=True)
    points = program.document(*sweep, f"{folder}-timed")["points"]
    shutil.copy(program.folder / f"{folder}-timed/pareto.png", HERE / "pareto.png")
    return next(point for point in points if point["label"] == entry["methods"]["rival"]["label"])["milliseconds"]


def sizes(program):
    """How long a picture of each size takes, of a capture of that size, by each kernel."""
    measured = []
    for width, height in TIMED_SIZES:
        name = f"size-{width}x{height}"
        recording = ["demo", *TIMED_DEMO, "--size", f"{width}x{height}", "--out", name]
        if not (program.folder / name).exists():
            program.run(*recording)
        (program.folder / f"{name}-ours.json").unlink(missing_ok=True)
        made = program.prepared(name, "ours", [])
        kernels = {kernel: round(timed(program, name, "ours", f"render.kernel={kernel}", runs=1)[0], 2) for kernel in ("gather", "surfel", "block", "point")}
        measured.append({
            "size": f"{width}×{height}",
            "recording": " ".join(["overlook", *recording]),
            "pixels": program.document("info", name)["pixels"],
            "seconds_preprocess": round(made["seconds_total"], 2),
            "milliseconds": kernels,
        })
    return program.measured() | {"machine": machine(), "rows": measured}


def one_of(points, series):
    return next(point for point in points if point["series"] == series)


def changed(settings, others):
    """The arguments that make one record of settings another."""
    arguments = []
    for section, values in others.items():
        for key, value in values.items():
            if settings[section][key] != value:
                text = str(value).lower() if isinstance(value, bool) else f"{value:g}" if isinstance(value, float) else str(value)
                arguments += ["--set", f"{section}.{key}={text}"]
    return arguments


def method(point, ours, info):
    """The figures of one way to show a capture."""
    mean, error = lead(ours, point)
    return brief(point) | {
        "kept": round(point["samples"] / info["pixels"], 6),
        "ours_ahead_db": round(mean, 4),
        "ours_ahead_db_se": round(error, 4),
    }


def brief(point):
    figures = {
        "db_surfaces": surfaces(point),
        "db_seen": point["psnr_filled_db"],
        "db_seen_se": point["psnr_filled_db_se"],
        "ssim": point["ssim"],
        "flip": point["flip"],
        "coverage": point["coverage"],
    }
    named = {"label": point["label"], "series": point["series"], "samples": point["samples"], "bytes": point["bytes"]}
    return named | {key: value and round(value, 4) for key, value in figures.items()}


def surfaces(point):
    """PSNR over all pixels of all true pictures that show a surface, holes filled; None where the truth has no depth."""
    classes = point["error_by_class"]
    if classes is None:
        return None
    parts = [part for part in classes.values() if part["psnr_db"] is not None]
    return page.decibels(sum(part["share"] * 10 ** (-part["psnr_db"] / 10) for part in parts))


def lead(ours, other):
    """By how many dB ours is ahead over all pixels that some camera saw, and its standard error: each viewpoint counts once."""
    theirs = {view["file_path"]: view["psnr_filled_db"] for view in other["views"]}
    by_vantage = {}
    for view in ours["views"]:
        if view["file_path"] in theirs:
            difference = view["psnr_filled_db"] - theirs[view["file_path"]]
            by_vantage.setdefault(view["vantage"], []).append(difference)
    means = [statistics.fmean(differences) for differences in by_vantage.values()]
    error = statistics.stdev(means) / len(means) ** 0.5 if len(means) > 1 else 0.0
    return statistics.fmean(means), error


def machine():
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def git(*arguments):
    done = subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


SOURCES = ["src", "shaders", "Cargo.toml", "Cargo.lock"]


def commit():
    """The last commit that changed the sources, with a plus where they were changed since."""
    last = git("log", "-1", "--format=%h", "--abbrev=7", "--", *SOURCES)
    return (last or "unknown") + ("+" if git("status", "--porcelain", "--", *SOURCES) else "")


def warn_of_an_old_program(path):
    committed = git("log", "-1", "--format=%ct", "--", *SOURCES)
    if committed and Path(path).stat().st_mtime < int(committed):
        print(f"{path} is older than the last change of the sources; build it again for figures of this commit", file=sys.stderr)


def captures(given):
    """Name, content, folder and recording of all captures."""
    for name, content, arguments in DEMOS:
        yield name, content, None, ["demo", *arguments, "--out", name]
    yield *SMALL, None
    for name, path in given:
        yield name, DESCRIBED.get(name, "not in the repository"), path, None


def named_capture(text):
    """The name and the folder of a capture that is given as FOLDER or NAME=FOLDER."""
    name, separator, path = text.rpartition("=")
    path = Path(path).resolve()
    if not (path / "novel/transforms.json").is_file():
        sys.exit(f"{path} has no true pictures: there is no novel/transforms.json in it")
    return (name if separator else path.name), path


def measure(arguments, folder):
    path, *given = arguments.paths
    given = [named_capture(text) for text in given]
    if not arguments.commit:
        warn_of_an_old_program(path)
    program = Program(path, folder, arguments.commit)
    results = known(program)
    both = arguments.accuracy == arguments.times
    chosen = [capture for capture in captures(given) if not arguments.only or capture[0] in arguments.only]
    if arguments.only:
        chosen = [capture for name in arguments.only for capture in chosen if capture[0] == name]
    if both or arguments.accuracy:
        for name, content, place, recording in chosen:
            with Progress(name):
                present(program, name, place, recording)
                entry = accuracy(program, name, content, recording)
                before = next((other for other in results["captures"] if other["name"] == name), {})
                if "times" in before:
                    entry["times"] = before["times"]
                results["captures"] = [other for other in results["captures"] if other["name"] != name] + [entry]
                save(results)
    if both or arguments.times:
        for name, _, place, recording in chosen:
            entry = next((entry for entry in results["captures"] if entry["name"] == name), None)
            if entry is None:
                sys.exit(f"{name} has no figures of accuracy yet")
            with Progress(name):
                present(program, name, place, recording)
                entry["times"] = times(program, entry)
                save(results)
        if not arguments.only or "sizes" in arguments.only:
            with Progress("sizes"):
                results["sizes"] = sizes(program)
                save(results)
    return results


def present(program, name, place, recording):
    """Records a capture, or links it, where it is not there yet."""
    if (program.folder / name).exists():
        return
    if recording:
        program.run(*recording)
    else:
        os.symlink(place, program.folder / name)


class Progress:
    """Says how long something took."""

    def __init__(self, name):
        self.name = name

    def __enter__(self):
        self.started = time.monotonic()

    def __exit__(self, *_):
        print(f"{time.monotonic() - self.started:5.0f} s  {self.name}", flush=True)


def known(program):
    """What was measured earlier, by this program or by another one."""
    lines = program.settings()
    before = json.loads(RESULTS.read_text()) if RESULTS.is_file() else {}
    return {
        "program": program.run("--version").strip(),
        "pictures": program.pictures,
        "settings_fingerprint": hashlib.sha256("\n".join(lines).encode()).hexdigest()[:12],
        "settings": lines,
        "sizes": before.get("sizes"),
        "captures": before.get("captures", []),
    }


def save(results):
    """Writes results.json in the order of the page; each method and each point is one line of it."""
    order = [name for name, *_ in captures([])]
    results["captures"].sort(key=lambda entry: order.index(entry["name"]) if entry["name"] in order else len(order))
    RESULTS.write_text(lined(results, ["captures", "methods", "points", "switches", "settings"]) + "\n")


def lined(value, opened, indent=""):
    """JSON with a line for each member of the outermost object, and of those members that are `opened`."""
    inner = indent + " "
    member = lambda key, value: lined(value, opened, inner) if key in opened else json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        lines = [f"{inner}{json.dumps(key)}: {member(key, value)}" for key, value in value.items()]
    else:
        lines = [inner + (lined(item, opened, inner) if "points" in item else json.dumps(item, ensure_ascii=False)) for item in value]
    start, end = "{}" if isinstance(value, dict) else "[]"
    return f"{start}\n" + ",\n".join(lines) + f"\n{indent}{end}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", metavar="PROGRAM [CAPTURE...]", help="the program, and more captures")
    parser.add_argument("--accuracy", action="store_true", help="measure accuracy and bytes alone")
    parser.add_argument("--times", action="store_true", help="measure times alone")
    parser.add_argument("--only", action="append", metavar="NAME", help="measure this capture alone (or 'sizes'); several are measured in their order")
    parser.add_argument("--work", metavar="DIR", type=Path, help="where captures and stores are written, and used again [default: a temporary folder]")
    parser.add_argument("--commit", metavar="HASH", help="the commit that the program was built of [default: the last that changed the sources]")
    parser.add_argument("--write-only", action="store_true", help="write the page from results.json, and measure nothing")
    arguments = parser.parse_intermixed_args()
    if not arguments.paths and not arguments.write_only:
        parser.error("name the program, as in assets/results/make.py target/release/overlook")
    with tempfile.TemporaryDirectory() as temporary:
        folder = (arguments.work or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        if not arguments.write_only:
            results = measure(arguments, folder)
        elif arguments.paths:
            results = known(Program(arguments.paths[0], folder, arguments.commit))
            save(results)
        else:
            results = json.loads(RESULTS.read_text())
    (ROOT / "RESULTS.md").write_text(page.results_page(results))
    readme = ROOT / "README.md"
    readme.write_text(page.with_headline(readme.read_text(), results))


if __name__ == "__main__":
    main()
