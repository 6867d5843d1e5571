# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the scripts that try an exporter ask of a capture: it opens without a question, and scores well at a camera that was left out."""

import json
import os
import subprocess


def run(*words):
    """What a command prints; where it fails, that ends the script with what it said."""
    found = subprocess.run(words, capture_output=True, text=True, check=False)
    if found.returncode != 0:
        raise SystemExit(f"{' '.join(words)}\n{found.stdout}{found.stderr}")
    return found.stdout


def score_capture(overlook, folder, renderer, frames):
    """Opens the capture of two cameras in FOLDER, renders its true views in FOLDER/novel, and wants more than 30 dB."""
    info = json.loads(run(overlook, "info", folder, "--json"))
    assert (len(info["cameras"]), info["frames"], info["normals"]) == (2, frames, True), info
    assert not info["warnings"] and not info["conventions"]["is_warning"], info
    store = os.path.join(folder, "capture.ovl")
    run(overlook, "preprocess", folder, "--out", store)
    views = os.path.join(folder, "novel", "transforms.json")
    scores = json.loads(run(overlook, "render", store, "--views", views, "--out", os.path.join(folder, "shown"), "--json"))
    mean = scores["mean"]
    print(f"{renderer}: {mean['psnr_db']:.2f} dB at the third camera, coverage {mean['coverage']:.3f}")
    assert mean["psnr_db"] > 30, mean
