#!/bin/bash
# Measures the cost of checkpoints: medians of the CPU time (user and system) of alternating runs with a
# checkpoint every second and with none. Time that a run waits for the disk does not count.
# benches/checkpoint_cost.sh [WxH:SPP]; a picture of some seconds is enough. Needs GNU time.
# PETZVAL names a built program to measure.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ -z "${PETZVAL:-}" ]; then
    cargo build --release --quiet
    PETZVAL=target/release/petzval
fi
picture=${1:-3840x2160:2}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Prints the CPU seconds and the bytes written of a render with this checkpoint interval.
run() {
    /usr/bin/time -f '%U %S %O' -o "$out/time" "$PETZVAL" render scenes/dgauss.pbrt --effects none \
        --resolution "${picture%:*}" --spp "${picture#*:}" --checkpoint "$1" -o "$out/a.exr" 2>/dev/null
    awk '{ print $1 + $2, 512 * $3 }' "$out/time"
}

for _ in 1 2 3 4 5; do
    echo "$(run off) $(run 1s)"
done | awk -v picture="$picture" -v cores="$(nproc)" '
    { none[NR] = $1; some[NR] = $3; bytes[NR] = $4 - $2; each[NR] = ($3 - $1) / ($4 - $2) }
    END {
        split(picture, size, /[x:]/)
        n = middle(each)
        one = 24 * size[1] * size[2]
        printf "%s: %.2f s without, %.2f s with %.2f GB of checkpoints: %.2f s a GB, %.3f s for a ", \
            picture, middle(none), middle(some), middle(bytes) / 1e9, 1e9 * n, one * n
        printf "whole one, every 60 s %.2f %% of %d cores\n", 100 * one * n / (60 * cores), cores
    }
    function middle(values,    i, j, t) {
        for (i = 1; i <= 5; i++) for (j = i + 1; j <= 5; j++)
            if (values[j] < values[i]) { t = values[i]; values[i] = values[j]; values[j] = t }
        return values[3]
    }'
