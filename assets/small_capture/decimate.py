#!/usr/bin/env python3
"""Makes this small capture from a larger one: every third pixel, some frames, half-float normals.

    pip install OpenEXR numpy
    python3 decimate.py SOURCE DESTINATION

SOURCE holds a transforms.json with EXR pictures in Blender's channel names, and vantages in SOURCE/novel.
Picking pixels keeps an exact pinhole camera. Pixel i of the result is pixel 3 i of the source, whose center
3 i + 1/2 must be seen through i + 1/2: u_source = 3 u - 1, hence fl = fl_source / 3, c = (c_source + 1) / 3.
"""

import json
import pathlib
import sys

import numpy
import OpenEXR

STEP = 3
FRAMES = {0, 6, 12, 18}
LENS_KEYS = ("fl_x", "fl_y")
CENTER_KEYS = ("cx", "cy")
SIZE_KEYS = ("w", "h")


def decimate_picture(source, destination, with_normals):
    channels = {}
    with OpenEXR.File(str(source), separate_channels=True) as picture:
        for name, channel in picture.channels().items():
            is_normal = ".Normal." in name
            if is_normal and not with_normals:
                continue
            pixels = channel.pixels[::STEP, ::STEP]
            channels[name] = numpy.ascontiguousarray(pixels, dtype="float16" if is_normal else pixels.dtype)
    destination.parent.mkdir(parents=True, exist_ok=True)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as picture:
        picture.write(str(destination))


def decimate_entry(entry):
    entry = dict(entry)
    entry.pop("camera_angle_x", None)
    for key in LENS_KEYS:
        entry[key] /= STEP
    for key in CENTER_KEYS:
        entry[key] = (entry[key] + (STEP - 1) / 2) / STEP
    for key in SIZE_KEYS:
        entry[key] = (entry[key] + STEP - 1) // STEP
    return entry


def decimate_manifest(source, destination, with_normals):
    manifest = json.loads((source / "transforms.json").read_text())
    manifest["frames"] = [decimate_entry(entry) for entry in manifest["frames"] if entry["time"] in FRAMES]
    if not with_normals:
        manifest["normal_space"] = None
    for entry in manifest["frames"]:
        decimate_picture(source / entry["file_path"], destination / entry["file_path"], with_normals)
    text = json.dumps(manifest, indent=1)
    (destination / "transforms.json").write_text(text + "\n")


def main():
    source, destination = (pathlib.Path(argument) for argument in sys.argv[1:3])
    decimate_manifest(source, destination, with_normals=True)
    decimate_manifest(source / "novel", destination / "novel", with_normals=False)


if __name__ == "__main__":
    main()
