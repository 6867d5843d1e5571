#!/usr/bin/env bash
# Makes room.ovl, the scene that the window opens by itself: the living room of nine cameras, a little smaller than the demo so that the
# program stays small. Takes some minutes, most of them for tracing.
#
#   assets/room/make.sh target/release/overlook
set -euo pipefail
overlook=${1:?give the program, as in target/release/overlook}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$overlook" demo nine-cameras --size 400x300 --out "$work/room"
"$overlook" preprocess "$work/room" --set store.precision=bits8 --set store.verdicts=1 --out "$here/room.ovl"
