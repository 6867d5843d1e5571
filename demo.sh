#!/usr/bin/env bash
# Builds Overlook and runs its main job on the built-in demo: records the scene, removes what is redundant, renders the
# rest from where no camera stood and says how close that comes to the truth. With a display it then opens the window.
# Installs the Debian packages that this needs, and says which.
set -euo pipefail
cd "$(dirname "$0")"
. .ci/packages

need_rust
need_packages gcc libc6-dev libvulkan1 mesa-vulkan-drivers libegl1 libxcursor1 libxi6 libxkbcommon-x11-0 ||
    echo "Going on without them: the window or the graphics card may not work." >&2

out=target/demo
mkdir -p "$out"
cargo build --release --locked
overlook=${CARGO_TARGET_DIR:-target}/release/overlook

run() { printf '\n$ overlook %s\n' "$*"; "$overlook" "$@"; }

run demo orrery --out "$out/orrery"
run preprocess "$out/orrery" --out "$out/orrery.ovl"
run render "$out/orrery.ovl" --views "$out/orrery/novel/transforms.json" --out "$out/pictures"
run evaluate "$out/orrery" --views "$out/orrery/novel/transforms.json"

printf '\nThe pictures are in %s/pictures.\n' "$out"
if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
    echo "Opening the window on the same capture…"
    exec "$overlook" "$out/orrery"
fi
echo "There is no display here; where there is one, '$overlook' opens the window."
