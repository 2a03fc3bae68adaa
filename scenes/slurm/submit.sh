#!/bin/bash
# Renders a scene as N tasks of a Slurm array, and merges their parts when all are done.
#
#     submit.sh SCENE N OUT [OPTIONS OF petzval render]
#
# Nodes see the scene, OUT.parts and petzval (or $PETZVAL) under the names that they have here.
# Slurm's own variables choose where and how long: SBATCH_PARTITION, SBATCH_TIMELIMIT and such.
# The same words again go on with the parts that are there.
set -eu
if [ $# -lt 3 ] || ! [[ $2 =~ ^[1-9][0-9]*$ ]]; then
    echo "usage: $0 SCENE N OUT [OPTIONS OF petzval render]" >&2
    exit 2
fi
scene=$1 n=$2 out=$3
shift 3
parts=$out.parts
words=$(printf '%q ' "$scene" "$n" "$@")
mkdir -p "$parts"
if compgen -G "$parts/*.petzval*" >/dev/null && [ "$(cat "$parts/words")" != "$words" ]; then
    echo "$parts holds parts of another picture, $(cat "$parts/words"); move or remove it" >&2
    exit 2
fi
echo "$words" >"$parts/words"

array=$(sbatch --parsable --array="1-$n" --output="$parts/%a.log" \
    "$(dirname "$0")/render.sbatch" "$scene" "$n" "$parts" "$@")
array=${array%%;*}

merge=("${PETZVAL:-petzval}" merge -o "$out")
for ((i = 1; i <= n; i++)); do merge+=("$parts/$i.petzval"); done
sum=$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes \
    --job-name=petzval-merge --output="$parts/merge.log" --wrap="$(printf '%q ' "${merge[@]}")")
echo "array $array renders $n parts to $parts, then job ${sum%%;*} merges them into $out"
