#!/usr/bin/env bash
# Measures the window's own work per frame (logic and ui, painting apart) in a real window of 1280×800 on a virtual display,
# CPU renderer, while a sweep and recomputing of the whole capture are under way and somebody flies, points and drags.
# Usage: benches/window_pace.sh [SECONDS] [PATH of a capture]   (needs Xvfb and xdotool; builds the release program first)
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-35}
cargo build --release --quiet
folder=$(mktemp -d)
exec 3>"$folder/display"
Xvfb -displayfd 3 -screen 0 1280x800x24 -nolisten tcp -noreset 2>/dev/null &
server=$!
trap 'kill $server 2>/dev/null; rm -rf "$folder"' EXIT
until [ -s "$folder/display" ]; do sleep 0.1; done
DISPLAY=":$(cat "$folder/display")"
export DISPLAY
RUST_LOG=${RUST_LOG:-overlook=info} XDG_DATA_HOME=$folder DBUS_SESSION_BUS_ADDRESS=unix:path=/nonexistent \
    target/release/overlook ${2:+"$2"} 2>"$folder/log" &
program=$!
window=$(xdotool search --sync --onlyvisible --name '^Overlook$' | head -n 1)
xdotool windowfocus --sync "$window"
say() { xdotool key ctrl+p; sleep 0.4; xdotool type --delay 15 "$1"; sleep 0.4; xdotool key Return; sleep 0.4; }
sleep 12
say "close the introduction"
say "renderer: cpu"
say "run a sweep"
say "frame times: write"
end=$((SECONDS + seconds))
while [ $SECONDS -lt $end ]; do
    say "recompute the whole"
    # Points at the source picture, orbits in the live view, drags a threshold's line and lets go.
    for step in $(seq 1 40); do xdotool mousemove $((60 + step * 8)) $((200 + step * 5)); sleep 0.02; done
    xdotool mousemove 650 300 mousedown 1
    for step in $(seq 1 30); do xdotool mousemove_relative -- 3 1; sleep 0.02; done
    xdotool mouseup 1 mousemove 1100 405 mousedown 1
    for step in $(seq 1 10); do xdotool mousemove_relative -- 2 0; sleep 0.03; done
    xdotool mouseup 1 key ctrl+z
done
say "open view: sweep"
[ -z "${PICTURE:-}" ] || import -window root "$PICTURE"
say "frame times: write"
sleep 1
kill $program
wait $program 2>/dev/null || true
grep "frame times," "$folder/log" | tail -n 1 | grep . || { echo "the window did not tell; its log:"; cat "$folder/log"; exit 1; }
