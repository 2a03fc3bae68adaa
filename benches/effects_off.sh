#!/bin/sh
# Shows that effects that are off cost nothing: compares a build with all effects, all turned off, with a
# build without effects (feature "bare").
# Needs objdump. With valgrind it also counts the instructions of a whole picture.
set -eu
cd "$(dirname "$0")/.."
cargo build --release --quiet
cargo build --release --quiet --features bare --target-dir target/bare
with=target/release/petzval
without=target/bare/release/petzval

# Prints the number of instructions in the machine code of a function, over all its instances.
code() {
    objdump --disassemble --demangle --no-show-raw-insn "$1" | awk -v name="$2" '
        /^[0-9a-f]+ <.*>:$/ { inside = index($0, name) > 0 }
        inside && /^ +[0-9a-f]+:/ { count++ }
        END { print count + 0 }'
}

# Prints the number of instructions that a picture takes, in all and in the loop of the lens.
taken() {
    out=$(mktemp)
    valgrind --tool=callgrind --callgrind-out-file="$out" "$1" render scenes/dgauss.pbrt \
        --effects none --threads 1 --resolution 96x96 --spp 16 -o "$out.exr" >/dev/null 2>&1
    callgrind_annotate --threshold=100 "$out" | awk '
        { gsub(",", "", $1) }
        /PROGRAM TOTALS/ { all = $1 }
        /petzval::lens::trace::trace/ && !/lossy|ghost|one/ { lens += $1 }
        END { print all, lens }'
    rm -f "$out" "$out.exr"
}

row() { printf '%-44s %14s %14s\n' "$@"; }
row '' 'turned off' 'not built'
row "lens loop, instructions in its code" \
    "$(code $with 'petzval::lens::trace::trace>')" "$(code $without 'petzval::lens::trace::trace>')"
if command -v valgrind >/dev/null; then
    set -- $(taken $with) $(taken $without)
    row 'scenes/dgauss.pbrt, instructions executed' "$1" "$3"
    row 'of these in the lens loop' "$2" "$4"
fi
