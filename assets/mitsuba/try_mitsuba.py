# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tries the script for real: renders a small scene with `mitsuba`, and opens it in Overlook.

    pip install mitsuba && python try_mitsuba.py OVERLOOK FOLDER [VARIANT]

Two cameras record four frames of a ball that rolls over a textured floor; a third one between them is the truth. What Overlook renders
there from the other two has to score above 30 dB, and nothing may be asked or warned of.
"""

import json
import os
import subprocess
import sys

import mitsuba as mi
import numpy as np

mi.set_variant(sys.argv[3] if len(sys.argv) > 3 else "scalar_rgb")
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]
import overlook_capture
from overlook_capture import render_capture
from score_capture import score_capture

FRAMES = 4


def texture(waves):
    """A smooth diffuse pattern."""
    y, x = np.mgrid[0:256, 0:256] * (2 * np.pi / 256)
    planes = [0.5 + 0.35 * np.sin(waves * x + shift) * np.cos(waves * y - shift) for shift in (0, 1, 2)]
    bitmap = mi.Bitmap(np.stack(planes, -1).astype(np.float32))
    return {"type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": bitmap, "raw": True}}


def scene(frame):
    place = mi.ScalarTransform4f
    return {
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
        "sun": {"type": "directional", "direction": [0.3, 0.6, -1.0], "irradiance": {"type": "rgb", "value": 2.5}},
        "floor": {"type": "rectangle", "to_world": place().scale(20), "bsdf": texture(40)},
        "wall": {
            "type": "rectangle",
            "to_world": place().translate([0, 4, 0]).rotate([1, 0, 0], 90).scale(20),
            "bsdf": texture(40),
        },
        "ball": {
            "type": "sphere",
            "to_world": place().translate([0.15 * (frame - 1.5), 0, 0.8]).scale(0.8),
            "bsdf": texture(6),
        },
    }


def camera(x):
    view = mi.ScalarTransform4f().look_at(origin=[x, -6, 2.5], target=[0, 0, 0.6], up=[0, 0, 1])
    film = {"type": "hdrfilm", "width": 320, "height": 240, "rfilter": {"type": "gaussian"}}
    return mi.load_dict({"type": "perspective", "fov": 40, "principal_point_offset_x": 0.02, "principal_point_offset_y": -0.03, "to_world": view, "film": film})


def check_placed(overlook, folder):
    """Poses that are placed by the capture become sensors that stand and look as the manifest says."""
    placed = os.path.join(folder, "placed.json")
    subprocess.run([overlook, "place", folder, "--cameras", "2", "--size", "400x200", "--out", placed], check=True)
    with open(placed, encoding="utf-8") as file:
        manifest = json.load(file)
    made = overlook_capture.sensors(manifest)
    for entry in manifest["frames"]:
        pose = overlook_capture.camera_to_world(made[entry["camera"]])
        assert np.allclose(pose, entry["transform_matrix"], atol=1e-5)
        lens = overlook_capture.pinhole(entry["camera"], made[entry["camera"]], pose)
        assert all(abs(lens[key] - entry[key]) < 0.01 for key in lens), (lens, entry)


def main():
    overlook, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    load = lambda frame: mi.load_dict(scene(frame))
    render_capture(load, {"left": camera(-0.5), "right": camera(0.5)}, folder, range(FRAMES))
    novel = os.path.join(folder, "novel")
    render_capture(load, {"between": camera(0.0)}, novel, range(FRAMES))
    score_capture(overlook, folder, f"Mitsuba {mi.__version__}", FRAMES)
    check_placed(overlook, folder)


if __name__ == "__main__":
    main()
