#!/usr/bin/env python3
"""Measures Overlook, and writes RESULTS.md, results.json and pareto.png.

    assets/results/make.py target/release/overlook [CAPTURE...]
    assets/results/make.py --write-only

The built-in demo scenes and assets/small_capture are measured always, some 12 minutes on two cores. A CAPTURE is a folder with true
pictures of further viewpoints in novel/transforms.json. With --only NAME, those of that name alone are measured, and the figures of all
others stay, unless they are of other default settings. --write-only writes the page from results.json, without measuring.

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
from pathlib import Path

import page

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RESULTS = HERE / "results.json"

# Name, what it is, and the arguments of `overlook demo` that record it.
DEMOS = [
    ("orrery", "an orrery on a table, exact", ["orrery", "--size", "320x240"]),
    ("orrery-3", "the same by three cameras", ["orrery", "--cameras", "3", "--frames", "16", "--size", "320x240"]),
    ("orrery-16", "the same by sixteen cameras", ["orrery", "--cameras", "16", "--frames", "8", "--size", "160x120"]),
    ("nine-cameras", "a living room, noisy color", ["nine-cameras", "--frames", "24", "--size", "320x240"]),
    ("four-cameras", "crystals that grow, exact", ["four-cameras", "--frames", "100"]),
    ("crystal", "a melt that condenses, exact", ["crystal", "--frames", "24", "--size", "320x240"]),
]
SMALL = ("small_capture", "an orrery by Blender, noisy color", ROOT / "assets/small_capture")

# The capture whose sweep is drawn.
CHARTED = "orrery"

# Pictures are timed as they come from a store, all of them this many times.
TIMED_RUNS = 3

OTHERS = {
    "first_camera", "first_camera_at_count", "random", "voxel_grid",
    "triangle_mesh", "tsdf", "nearest_camera", "layered_depth_image",
}


class Program:
    """The program, run in the folder in which captures lie under their names."""

    def __init__(self, path, folder):
        self.path, self.folder = Path(path).resolve(), folder

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


def measured(program, name, content, recording):
    """Everything about one capture, which lies in the program's folder under its name."""
    info = program.document("info", name)
    sweep = ["sweep", name, "--vary", "render.kernel=gather,surfel,block,point", "--out", f"{name}-sweep"]
    swept = program.document(*sweep)
    points = swept["points"]
    switches = ["sweep", name, "--vary", "render", "--out", f"{name}-switches"]
    switched = [point for point in program.document(*switches)["points"] if point["series"] in ("reference", "variation")]
    ours = one_of(points, "reference")
    paper = one_of(points, "paper")
    everything = next(point for point in points if point["label"] == "no pruning, gather")
    as_in_paper = changed(ours["settings"], paper["settings"])
    stores = {
        "ours": stored(program, name, "ours", []),
        "everything": stored(program, name, "everything", ["--set", "pruning.method=off"]),
        "paper": stored(program, name, "paper", as_in_paper),
    }
    most = max(point["vantages"] for point in points)
    others = [point for point in points if point["series"] in OTHERS and point["vantages"] == most]
    rival = max(others, key=lambda point: point["psnr_filled_db"])
    first = [point for point in others if point["series"] == "first_camera"]
    methods = {
        "ours": method(ours, ours, info, stores["ours"]),
        "everything": method(everything, ours, info, stores["everything"]),
        "rival": method(rival, ours, info, None),
        "first": method(max(first, key=lambda point: point["psnr_filled_db"]), ours, info, None),
        "paper": method(paper, ours, info, stores["paper"]),
    }
    return {
        "name": name,
        "content": content,
        "recording": " ".join(["overlook", *recording]) if recording else None,
        "cameras": len(info["cameras"]),
        "frames": info["frames"],
        "sizes": sorted({f"{camera['width']}×{camera['height']}" for camera in info["cameras"]}),
        "pixels": info["pixels"],
        "bytes_raw": stores["ours"]["bytes_raw"],
        "viewpoints": most,
        "true_pictures": len(ours["views"]),
        "seconds_preprocess": round(stores["ours"]["seconds"], 2),
        "threads": stores["ours"]["threads"],
        "painted_by": stores["ours"]["painted_by"],
        "machine": machine(),
        "commit": commit(),
        "date": datetime.date.today().isoformat(),
        "sweep": " ".join(["overlook", *sweep]),
        "paper_settings": " ".join(as_in_paper),
        "error_by_class": ours["error_by_class"],
        "methods": methods,
        "points": [brief(point) for point in points],
        "switches": [brief(point) for point in switched],
    }


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


def stored(program, name, kind, arguments):
    """A store of the capture, and how long its pictures take with everything that the settings say, filling among it."""
    store = f"{name}-{kind}.ovl"
    made = program.document("preprocess", name, "--out", store, *arguments)
    render = ["render", store, "--views", f"{name}/novel/transforms.json", "--out", f"{name}-{kind}"]
    times, painted_by = [], set()
    for _ in range(TIMED_RUNS):
        views = program.document(*render)["views"]
        times += [view["milliseconds"] for view in views]
        painted_by |= {view.get("adapter") or view["backend"] for view in views}
    return {
        "milliseconds": statistics.median(times),
        "bytes_raw": made["bytes_raw"],
        "seconds": made["seconds_total"],
        "threads": made["threads"],
        "painted_by": " and ".join(sorted(painted_by)),
    }


def method(point, ours, info, store):
    """The figures of one way to show a capture. Rivals keep no store, and are timed by the sweep."""
    mean, error = lead(ours, point)
    return brief(point) | {
        "kept": round(point["samples"] / info["pixels"], 6),
        "ours_ahead_db": round(mean, 4),
        "ours_ahead_db_se": round(error, 4),
        "milliseconds": round(store["milliseconds"] if store else point["milliseconds"], 2),
    }


def brief(point):
    figures = {
        "db_surfaces": surfaces(point),
        "db_seen": point["psnr_filled_db"],
        "db_seen_se": point["psnr_filled_db_se"],
        "ssim": point["ssim"],
        "flip": point["flip"],
        "coverage": point["coverage"],
        "milliseconds": point["milliseconds"],
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
    for path in given:
        yield path.name, "not in the repository", path, None


def measure(arguments):
    path, *given = arguments.paths
    given = [Path(capture).resolve() for capture in given]
    for capture in given:
        if not (capture / "novel/transforms.json").is_file():
            sys.exit(f"{capture} has no true pictures: there is no novel/transforms.json in it")
    warn_of_an_old_program(path)
    with tempfile.TemporaryDirectory(dir=arguments.work) as folder:
        program = Program(path, Path(folder))
        results = known(program)
        for name, content, place, recording in captures(given):
            if arguments.only and name not in arguments.only:
                continue
            started = time.monotonic()
            if recording:
                program.run(*recording)
            else:
                os.symlink(place, Path(folder) / name)
            entry = measured(program, name, content, recording)
            entry["seconds_measuring"] = round(time.monotonic() - started)
            results["captures"] = [other for other in results["captures"] if other["name"] != name] + [entry]
            if name == CHARTED:
                shutil.copy(Path(folder) / f"{name}-sweep/pareto.png", HERE / "pareto.png")
            print(f"{entry['seconds_measuring']:5} s  {name}", flush=True)
            for left in Path(folder).glob(f"{name}*"):
                left.unlink() if left.is_symlink() or left.is_file() else shutil.rmtree(left)
            save(results)
    return results


def known(program):
    """What was measured earlier with the same default settings."""
    lines = program.settings()
    results = {
        "program": program.run("--version").strip(),
        "settings_fingerprint": hashlib.sha256("\n".join(lines).encode()).hexdigest()[:12],
        "settings": lines,
        "captures": [],
    }
    if RESULTS.is_file():
        before = json.loads(RESULTS.read_text())
        if before["settings"] == lines:
            results["captures"] = before["captures"]
        else:
            names = ", ".join(entry["name"] for entry in before["captures"])
            print(f"The default settings are others than those of results.json; the figures of {names} go")
    return results


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
    parser.add_argument("--only", action="append", metavar="NAME", help="measure this capture alone; may be given several times")
    parser.add_argument("--work", metavar="DIR", help="where captures and stores are written for a while [default: /tmp]")
    parser.add_argument("--write-only", action="store_true", help="write the page from results.json, and measure nothing")
    arguments = parser.parse_args()
    if arguments.write_only:
        results = json.loads(RESULTS.read_text())
    elif arguments.paths:
        results = measure(arguments)
    else:
        parser.error("name the program, as in assets/results/make.py target/release/overlook")
    (ROOT / "RESULTS.md").write_text(page.results_page(results))
    readme = ROOT / "README.md"
    readme.write_text(page.with_headline(readme.read_text(), results))


if __name__ == "__main__":
    main()
