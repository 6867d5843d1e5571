#!/bin/sh
# Bytes that the pictures of a capture take in other lossless forms, all cameras and frames together.
#
#     pip install OpenEXR numpy        # and ffmpeg and zstd from the system
#     assets/results/other_codecs.sh CAPTURE
#
# CAPTURE holds a transforms.json with EXR pictures that have R, G, B and Z, as `overlook demo` writes them.
#   EXR          ZIP, half-float color and 32-bit depth, one file a picture
#   video color  8-bit sRGB, H.264 (x264, RGB, lossless), one film a camera
#   video depth  inverse depth in 16 bits, scaled to the camera's nearest point, FFV1, one film a camera
#   xor + zstd   both of these in their bytes, each frame xor the one before, zstd at level 3
set -eu
capture=${1:?usage: other_codecs.sh CAPTURE}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Writes the EXR files, and per camera the raw frames that the other programs read.
python3 - "$capture" "$work" <<'PYTHON'
import json, pathlib, sys
import numpy, OpenEXR

capture, work = map(pathlib.Path, sys.argv[1:])
entries = json.loads((capture / "transforms.json").read_text())["frames"]
cameras = {}
for entry in sorted(entries, key=lambda entry: entry["file_path"]):
    cameras.setdefault(pathlib.Path(entry["file_path"]).parent, []).append(capture / entry["file_path"])


def read(path):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    color, depth = ([channels[name].pixels for name in names] for names in ("RGB", "Z"))
    return numpy.stack(color, axis=-1).astype("f2"), depth[0].astype("f4")


def inverse(depth):
    return numpy.where(numpy.isfinite(depth) & (depth > 0), 1 / numpy.maximum(depth, 1e-30), 0)


for number, paths in enumerate(cameras.values()):
    nearest = max(inverse(read(path)[1]).max() for path in paths)
    before = b""
    with open(work / f"{number}.rgb", "wb") as rgb, open(work / f"{number}.gray", "wb") as gray, \
            open(work / f"{number}.xor", "wb") as xor:
        for frame, path in enumerate(paths):
            color, depth = read(path)
            planes = dict(zip("RGB", numpy.moveaxis(color, -1, 0).copy()), Z=depth)
            header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
            OpenEXR.File(header, planes).write(str(work / f"{number}.{frame}.exr"))
            linear = numpy.clip(color.astype("f4"), 0, 1)
            srgb = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
            pixels = numpy.rint(255 * srgb).astype("u1").tobytes()
            levels = numpy.rint(65535 * inverse(depth) / nearest).astype("<u2").tobytes()
            rgb.write(pixels)
            gray.write(levels)
            now = numpy.frombuffer(pixels + levels, "u1")
            xor.write((now ^ numpy.frombuffer(before or bytes(now.size), "u1")).tobytes())
            before = now.tobytes()
    (work / f"{number}.size").write_text(f"{depth.shape[1]}x{depth.shape[0]}")
PYTHON

for size in "$work"/*.size; do
    camera=${size%.size}
    ffmpeg -v error -y -f rawvideo -pix_fmt rgb24 -s "$(cat "$size")" -i "$camera.rgb" -c:v libx264rgb -qp 0 "$camera.color.mkv"
    ffmpeg -v error -y -f rawvideo -pix_fmt gray16le -s "$(cat "$size")" -i "$camera.gray" -c:v ffv1 -level 3 -coder 2 "$camera.depth.mkv"
    zstd -3 -q -f "$camera.xor" -o "$camera.xor.zst"
done

total() { cat "$work"/*"$1" | wc -c; }
echo "EXR          $(total .exr)"
echo "video color  $(total .color.mkv)"
echo "video depth  $(total .depth.mkv)"
echo "xor + zstd   $(total .xor.zst)"
