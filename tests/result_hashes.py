"""The parts of result_hashes.sh that take more than a shell: documents without what differs from run to run, stores without what
they say about themselves, and manifests with other views. Prints text or bytes to be hashed; Python's standard library is enough.

    result_hashes.py json FILE                  a JSON document
    result_hashes.py csv FILE                   a table
    result_hashes.py tuned FILE                 what `tune --json` decided
    result_hashes.py points FILE                what `tune --json` tried: label, tab, document, one a line
    result_hashes.py samples FILE               a store without settings, report and provenance
    result_hashes.py last_camera FILE           the name of the last camera in what `info --json` says
    result_hashes.py views FROM TO COUNT        a folder with at most COUNT of a folder's views
    result_hashes.py scaled_views FROM TO SIZE  the same views so many times as large, without true pictures
    result_hashes.py path FROM FILE             a camera path through the views, one place at a time
"""

import csv
import json
import re
import struct
import sys
from pathlib import Path

MANIFEST = "transforms.json"

# Keys that are left out wherever they stand. Times, load, memory and threads differ from run to run. The bytes of a store depend on the
# words in which it says how it was made; result_hashes.sh hashes the stores themselves.
LEFT_OUT = re.compile(r"milliseconds|seconds(_.*)?|load_of_others|threads|peak_rss_bytes|bytes_store")


def read_json(path):
    """Numbers stay the texts they are: reading and writing them again could hide a difference."""
    return json.loads(Path(path).read_text(), parse_float=lambda text: f"float {text}")


def without_what_differs(document):
    if isinstance(document, list):
        return [without_what_differs(part) for part in document]
    if not isinstance(document, dict):
        return document
    kept = {key: without_what_differs(part) for key, part in document.items() if not LEFT_OUT.fullmatch(key)}
    # A point of a study counts the words in its store apart: without them, its bytes are those of the samples.
    if "bytes_record" in kept:
        kept["bytes"] = int(kept["bytes"]) - int(kept.pop("bytes_record"))
    return kept


def print_json(document):
    print(json.dumps(without_what_differs(document)))


def print_table(path):
    with open(path, newline="") as file:
        print_json(list(csv.DictReader(file)))


def print_tuned(path):
    """Without the list of what was tried, and its length in the words."""
    document = read_json(path)
    del document["points"]
    document["words"] = [re.sub(r"^Of \d+ settings", "Of all settings", words) for words in document["words"]]
    print_json(document)


def print_points(path):
    for point in read_json(path)["points"]:
        print(point["label"], json.dumps(without_what_differs(point)), sep="\t")


def print_samples(path):
    """All chunks but settings, report, provenance and verdicts on dropped pixels, and the index without offsets in the file; see FORMAT.md."""
    store = Path(path).read_bytes()
    at = 12
    while at < len(store):
        name, length = struct.unpack_from(">4sI", store, at)
        payload = store[at + 8 : at + 8 + length]
        at += 8 + length + length % 2
        if name == b"INDX":
            payload = index_without_offsets(payload)
        if name not in (b"SETT", b"REPT", b"RPTZ", b"PROV", b"VERD"):
            sys.stdout.buffer.write(name + payload)


def index_without_offsets(payload):
    """Without the file's size, each image's offset, and the checksum over both."""
    (count,) = struct.unpack_from(">I", payload, 8)
    images = [struct.unpack_from(">6IQ2I", payload, 12 + 40 * image) for image in range(count)]
    return b"".join(struct.pack(">8I", *image[:6], *image[7:]) for image in images)


def print_last_camera(path):
    print(read_json(path)["cameras"][-1]["name"])


def evenly(entries, count):
    """At most so many of them, from the first to the last, so that they differ in vantage and in frame."""
    count = min(count, len(entries))
    return [entries[index * (len(entries) - 1) // max(count - 1, 1)] for index in range(count)]


def write_views(source, target, count):
    """Pictures are linked, so that they are the truth of the views that are left."""
    source, target = Path(source), Path(target)
    target.mkdir()
    for path in source.iterdir():
        if path.name != MANIFEST:
            (target / path.name).symlink_to(path.resolve())
    manifest = json.loads((source / MANIFEST).read_text())
    manifest["frames"] = evenly(manifest["frames"], int(count))
    (target / MANIFEST).write_text(json.dumps(manifest))


def write_scaled_views(source, target, size):
    target = Path(target)
    target.mkdir()
    manifest = json.loads((Path(source) / MANIFEST).read_text())
    for entry in manifest["frames"]:
        for key in ("w", "h"):
            entry[key] = round(float(size) * entry.get(key, manifest.get(key)))
        for key in ("fl_x", "fl_y", "cx", "cy"):
            if key in entry or key in manifest:
                entry[key] = float(size) * entry.get(key, manifest.get(key))
    (target / MANIFEST).write_text(json.dumps(manifest))


def write_path(source, target):
    """From one vantage to the next as time goes on, so that the camera moves."""
    manifest = json.loads((Path(source) / MANIFEST).read_text())
    at_time = {}
    for entry in manifest["frames"]:
        at_time.setdefault(entry["time"], []).append(entry)
    times = sorted(at_time)
    manifest["frames"] = [at_time[time][index % len(at_time[time])] for index, time in enumerate(times)]
    Path(target).write_text(json.dumps(manifest))


COMMANDS = {
    "json": lambda path: print_json(read_json(path)),
    "csv": print_table,
    "tuned": print_tuned,
    "points": print_points,
    "samples": print_samples,
    "last_camera": print_last_camera,
    "views": write_views,
    "scaled_views": write_scaled_views,
    "path": write_path,
}

if __name__ == "__main__":
    COMMANDS[sys.argv[1]](*sys.argv[2:])
