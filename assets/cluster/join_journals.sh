#!/bin/sh
# Puts the journals of sweeps, or of stress tests, into one:
#
#     join_journals.sh a/sweep.journal b/sweep.journal > all/sweep.journal
#
# `overlook sweep --out all` over all settings then has nothing left to measure. The first line of a journal names what it was measured on
# and with how many threads; a journal of another state is refused by its name.
set -eu

[ $# -gt 0 ] || { echo "give the journals to put together" >&2; exit 2; }
exec awk '
    FNR == 1 && NR > 1 && $0 != head {
        print FILENAME ": was measured on another state of the capture than " ARGV[1] ", or with other threads" > "/dev/stderr"
        exit 1
    }
    FNR == 1 && NR > 1 { next }
    FNR == 1 { head = $0 }
    { print }
' "$@"
