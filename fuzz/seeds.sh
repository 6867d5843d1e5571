#!/usr/bin/env bash
# seeds.sh OVERLOOK: small stores, manifests and files of captures to begin with, from the given program, into fuzz/corpus.
set -euo pipefail
overlook=$1
corpus=$(dirname "$(realpath "$0")")/corpus
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
mkdir -p "$corpus"/{store,manifest,colmap,npy,yuv}
"$overlook" demo orrery --cameras 2 --frames 4 --size 70x20 --out "$scratch/orrery"
for setting in store.coding=modeled store.coding=plain store.precision=bits8 store.normals=true spans.levels=off; do
    "$overlook" preprocess "$scratch/orrery" --set "$setting" --out "$corpus/store/${setting//[.=]/-}.ovl"
done
cp "$scratch/orrery/transforms.json" "$corpus/manifest/orrery.json"
cp "$(dirname "$corpus")/../assets/small_capture/transforms.json" "$corpus/manifest/small.json"

# COLMAP: cameras and images as text and binary, and a map of depth.
printf '1 PINHOLE 8 6 9 9 4 3\n2 OPENCV 8 6 9 9 4 3 0.1 0 0 0\n' > "$corpus/colmap/cameras.txt"
printf '1 1 0 0 0 1 2 3 1 a.jpg\n1 2 -1\n' > "$corpus/colmap/images.txt"
printf '8&6&1&' > "$corpus/colmap/depth.bin"
head -c 192 /dev/zero >> "$corpus/colmap/depth.bin"
{
    printf '\1\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0\10\0\0\0\0\0\0\0\6\0\0\0\0\0\0\0'
    head -c 32 /dev/zero
} > "$corpus/colmap/cameras.bin"
{
    printf '\1\0\0\0\0\0\0\0\1\0\0\0'
    head -c 56 /dev/zero
    printf '\1\0\0\0a.jpg\0\1\0\0\0\0\0\0\0'
    head -c 24 /dev/zero
} > "$corpus/colmap/images.bin"
{
    printf "\223NUMPY\1\0\73\0{'descr': '<f4', 'fortran_order': False, 'shape': (6, 8), }"
    head -c 192 /dev/zero
} > "$corpus/npy/depth.npy"
printf 'P5 8 6 65535\n' > "$corpus/npy/depth.pgm"
head -c 96 /dev/zero >> "$corpus/npy/depth.pgm"
cat > "$corpus/yuv/cameras.json" <<'JSON'
{"Version":"4.0","Content_name":"c","Fps":25,"Frames_number":1,"cameras":[{"Name":"v0","Position":[0,0,0],"Rotation":[0,0,0],
"Resolution":[8,6],"Projection":"Perspective","Focal":[8,8],"Principle_point":[4,3],"Depth_range":[0.5,25],"BitDepthColor":8,
"BitDepthDepth":16,"ColorSpace":"YUV420","DepthColorSpace":"YUV420","HasInvalidDepth":true}]}
JSON
