#!/usr/bin/env bash
# Runs every check of the project, fast to slow: formatting, lints, documentation, tests.
# Installs the Debian packages that building and testing need, and says which. Needs no GPU and no display.
set -euo pipefail
cd "$(dirname "$0")"
. .ci/packages

need_rust
need_packages gcc libc6-dev \
    libvulkan1 mesa-vulkan-drivers libegl1 \
    xvfb libxcursor1 libxi6 libxkbcommon-x11-0 xdotool imagemagick \
    python3-venv chromium || exit 1

step() { printf '\n== %s\n' "$*"; }

step "formatting"
cargo fmt --check
# Everything is built once here: keeping what the next edit would reuse costs more than it saves.
export CARGO_INCREMENTAL=0
step "lints"
cargo clippy --locked --workspace --all-targets -- -D warnings
step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --quiet --workspace --exclude overlook-python
step "tests"
# Where nobody is logged in there is no folder for sockets, which the graphics driver's libraries call an error, once a test.
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    mkdir -p target/runtime && chmod 700 target/runtime
    export XDG_RUNTIME_DIR="$PWD/target/runtime"
fi
# The Python module is built and tested with everything else; its own tests compare it with the command line.
python3 -m venv target/python
target/python/bin/pip install --quiet --disable-pip-version-check "numpy>=1.24" "pytest>=8" "OpenEXR>=3.3"
export OVERLOOK_PYTHON="$PWD/target/python/bin/python"
# All that a test may lack was installed above: where it is missing after all, what it tests must not go untested.
OVERLOOK_REQUIRE_GPU=1 OVERLOOK_REQUIRE_WINDOW=1 OVERLOOK_REQUIRE_PYTHON=1 OVERLOOK_REQUIRE_BROWSER=1 cargo test --locked --workspace --no-fail-fast
