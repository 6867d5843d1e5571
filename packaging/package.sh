#!/usr/bin/env bash
# Makes the packages for Linux in target/package: a Debian package and a portable archive, both with the program, its manual pages,
# shell completions, icon, menu entry, file type, and the licenses of all that is compiled in.
# usage: packaging/package.sh
# Needs cargo-deb and cargo-bundle-licenses: cargo install cargo-deb cargo-bundle-licenses --locked
set -euo pipefail
cd "$(dirname "$0")/.."

for tool in cargo-deb cargo-bundle-licenses; do
    command -v "$tool" >/dev/null || {
        echo "$tool is missing; install it with: cargo install $tool --locked" >&2
        exit 1
    }
done

built=${CARGO_TARGET_DIR:-target}/release
out=target/package
files=$out/files
rm -rf "$out"
mkdir -p "$files"
cargo build --release --locked
cargo bundle-licenses --format json --output "$out/licenses.json" 2>"$out/licenses.log"
cargo run --release --locked --quiet --example package_files -- "$files" "$out/licenses.json"

# What is linked and what the manifest names decide the package's dependencies; nothing is built again.
cargo deb --locked --no-build --output "$out/"

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
name="overlook-$version-$(uname -m)-linux"
archive=$out/$name
mkdir -p "$archive"/{bin,share/applications,share/mime/packages,share/man/man1,share/icons/hicolor/scalable/apps}
mkdir -p "$archive"/share/{bash-completion/completions,zsh/site-functions,fish/vendor_completions.d,doc/overlook}
install -m 755 "$built/overlook" "$archive/bin/overlook"
strip "$archive/bin/overlook"
cp packaging/overlook.desktop "$archive/share/applications/"
cp packaging/overlook.xml "$archive/share/mime/packages/"
cp "$files"/man/*.1 "$archive/share/man/man1/"
cp packaging/icon.svg "$archive/share/icons/hicolor/scalable/apps/overlook.svg"
for side in "$files"/icons/*; do
    mkdir -p "$archive/share/icons/hicolor/$(basename "$side")/apps"
    cp "$side/overlook.png" "$archive/share/icons/hicolor/$(basename "$side")/apps/"
done
cp "$files/completions/overlook.bash" "$archive/share/bash-completion/completions/overlook"
cp "$files/completions/_overlook" "$archive/share/zsh/site-functions/"
cp "$files/completions/overlook.fish" "$archive/share/fish/vendor_completions.d/"
cp README.md GUIDE.md EXPORT.md EDITING.md SCIENCE.md CAPTURES.md FORMAT.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$files/THIRD_PARTY.txt" \
    "$archive/share/doc/overlook/"
tar -C "$out" --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$(git log -1 --format=%ct 2>/dev/null || echo 0)" \
    -czf "$out/$name.tar.gz" "$name"
rm -rf "$archive"
ls -l "$out"/*.deb "$out"/*.tar.gz
