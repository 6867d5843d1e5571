"""From a COLMAP workspace with dense depth to a picture and its score: every eighth image is held out.

    pip install . pillow
    python python/examples/score_a_colmap_folder.py path/to/workspace picture.png
"""

import sys

import numpy as np
import overlook
from PIL import Image


def srgb(linear):
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def main(folder, picture):
    capture = overlook.open(folder)
    for warning in capture.warnings:
        print("warning:", warning)
    held_out = [camera.name for camera in capture.cameras[::8]]
    scores = overlook.evaluate(capture, hold_out=held_out, progress=lambda stage, done, total: print(f"\r{stage} {done}/{total}   ", end=""))
    mean = scores["as_set"]["mean"]
    print(f"\n{len(held_out)} views held out: {mean['psnr_db']:.2f} dB, coverage {100 * mean['coverage']:.1f} %")

    store = capture.preprocess()
    kept = len(store.samples())
    print(f"kept {kept:,} of {store.report['samples_in']:,} samples")

    # Halfway between the first two cameras, looking as the first one does.
    first, second = capture.cameras[:2]
    pose = first.pose.copy()
    pose[:3, 3] = (first.pose[:3, 3] + second.pose[:3, 3]) / 2
    color, depth, coverage = store.render(pose, first.lens)
    print(f"median depth {np.median(depth[np.isfinite(depth)]):.2f}, {100 * coverage.mean():.1f} % seen, the rest filled")
    Image.fromarray((srgb(color) * 255 + 0.5).astype(np.uint8)).save(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
