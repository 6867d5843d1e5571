#!/usr/bin/env bash
# Installs the Debian package into a clean Debian, starts the program from its menu entry on a virtual display, and removes it again.
# usage: packaging/check_package.sh target/package/overlook_VERSION_ARCH.deb   (as root; needs mmdebstrap)
# Fails where the package leaves a file behind, or the window does not appear.
set -euo pipefail
deb=$(realpath "$1")
suite=${SUITE:-bookworm}
work=$(mktemp -d)
trap 'umount "$work/root/proc" 2>/dev/null || true; rm -rf "$work"' EXIT

# What the package depends on, the first of each choice, is there before it: so dpkg alone decides whether that is enough.
needs=$(dpkg-deb -f "$deb" Depends | tr ',' '\n' | sed 's/[|(].*//; s/ //g' | paste -sd,)
mmdebstrap --quiet --variant=minbase \
    --include="$needs,libgl1-mesa-dri,xvfb,xdotool,desktop-file-utils,shared-mime-info,hicolor-icon-theme,man-db" "$suite" "$work/root"
mount -t proc proc "$work/root/proc"
inside() { chroot "$work/root" env DEBIAN_FRONTEND=noninteractive HOME=/root XDG_RUNTIME_DIR=/tmp/runtime "$@"; }
inside mkdir -p -m 700 /tmp/runtime
cp "$deb" "$work/root/tmp/overlook.deb"

listing() { inside find / -xdev -path /proc -prune -o -path /tmp -prune -o -path /var/lib/dpkg -prune -o -path /var/lib/apt -prune \
    -o -path /var/log -prune -o -path /var/cache -prune -o -type f -print -o -type l -print | sort; }
listing >"$work/before"
inside dpkg -i /tmp/overlook.deb >/dev/null
listing >"$work/with"
echo "The package is $(stat -c %s "$deb") bytes; installed it takes $(inside dpkg-query -W -f '${Installed-Size}' overlook) KiB."

inside desktop-file-validate /usr/share/applications/overlook.desktop
inside grep -q 'application/x-overlook-store' /usr/share/mime/globs2 || {
    echo "the file type is not known to the system" >&2
    exit 1
}
inside man -w overlook-render >/dev/null
inside overlook --version
command=$(inside sed -n 's/^Exec=\([^ ]*\).*/\1/p' /usr/share/applications/overlook.desktop)

# The window of the menu entry's command, timed from the start of the program to the first picture of it on the display.
inside sh -c '
    Xvfb :9 -screen 0 1280x800x24 -nolisten tcp >/dev/null 2>&1 & server=$!
    sleep 2
    start=$(date +%s%N)
    DISPLAY=:9 '"$command"' >/tmp/said.txt 2>&1 & program=$!
    for attempt in $(seq 600); do
        window=$(DISPLAY=:9 xdotool search --onlyvisible --name "^Overlook$" 2>/dev/null) && break
        kill -0 $program 2>/dev/null || { cat /tmp/said.txt >&2; exit 1; }
        sleep 0.05
    done
    [ -n "$window" ] || { echo "no window appeared" >&2; exit 1; }
    echo "The window appeared after $(( ($(date +%s%N) - start) / 1000000 )) ms."
    sleep 3
    kill -0 $program || { cat /tmp/said.txt >&2; exit 1; }
    DISPLAY=:9 xdotool windowfocus --sync $window
    DISPLAY=:9 xdotool key ctrl+q
    wait $program && echo "It closed by Ctrl+Q."
    kill $server
'
inside rm -rf /root/.local /root/.cache /root/.config

inside dpkg --purge overlook >/dev/null
listing >"$work/after"
if ! diff "$work/before" "$work/after"; then
    echo "the package left the files above behind" >&2
    exit 1
fi
echo "Removed: of $(comm -13 "$work/before" "$work/with" | wc -l) files none is left."
