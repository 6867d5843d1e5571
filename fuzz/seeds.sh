#!/usr/bin/env bash
# seeds.sh OVERLOOK: small stores and manifests to begin with, from the given program, into fuzz/corpus.
set -euo pipefail
overlook=$1
corpus=$(dirname "$(realpath "$0")")/corpus
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
mkdir -p "$corpus/store" "$corpus/manifest"
"$overlook" demo orrery --cameras 2 --frames 4 --size 70x20 --out "$scratch/orrery"
for setting in store.coding=modeled store.coding=plain store.precision=bits8 store.normals=true spans.levels=off; do
    "$overlook" preprocess "$scratch/orrery" --set "$setting" --out "$corpus/store/${setting//[.=]/-}.ovl"
done
cp "$scratch/orrery/transforms.json" "$corpus/manifest/orrery.json"
cp "$(dirname "$corpus")/../assets/small_capture/transforms.json" "$corpus/manifest/small.json"
