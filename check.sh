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
    python3-venv || exit 1

step() { printf '\n== %s\n' "$*"; }

step "formatting"
cargo fmt --check
step "lints"
cargo clippy --locked --all-targets -- -D warnings
cargo clippy --locked --package overlook-python -- -D warnings
step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --quiet
step "tests"
# Where nobody is logged in there is no folder for sockets, which the graphics driver's libraries call an error, once a test.
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
    mkdir -p target/runtime && chmod 700 target/runtime
    export XDG_RUNTIME_DIR="$PWD/target/runtime"
fi
# The software adapter was installed above, and so was what a real window needs: where they are missing, the renderer on the one and
# the program in the other must not go untested.
OVERLOOK_REQUIRE_GPU=1 OVERLOOK_REQUIRE_WINDOW=1 cargo test --locked --no-fail-fast
step "Python module"
# Built like the tests, so that most of it is built already. Its own tests compare it with the command line.
python3 -m venv target/python
MATURIN_PEP517_ARGS="--profile dev" target/python/bin/pip install --quiet --disable-pip-version-check ".[test]"
OVERLOOK="$(realpath "${CARGO_TARGET_DIR:-target}")/debug/overlook" target/python/bin/python -m pytest --quiet
