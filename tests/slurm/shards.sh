#!/bin/bash
# Eight shards as an array on a cluster, one of them killed, one requeued, one on a node that is
# lost, one late: nothing is lost of the picture. Run it in cluster.sh.
#
#     cluster.sh shards.sh PETZVAL
set -eu
PETZVAL=$(realpath "$1")
export PETZVAL
root=$(realpath "$(dirname "$0")/../..")
scene=$root/scenes/dgauss.pbrt
words=(--resolution 120x80 --spp 4096)
cd "$CLUSTER"

say() { printf '%3d s  %s\n' $SECONDS "$*"; }
fail() {
    echo "FAILED: $*"
    squeue --array || true
    tail -n 20 out.exr.parts/*.log slurmctld.log node?.log
    exit 1
} >&2

# Waits until a shard has a checkpoint, and sets what it is then: its job, and its node.
running() {
    until [ -e "out.exr.parts/$1.petzval.checkpoint" ]; do
        [ ! -e "out.exr.parts/$1.petzval" ] || fail "shard $1 ended before its checkpoint"
        sleep 0.02
    done
    read -r job node <<<"$(squeue --noheader --jobs="${array}_$1" --format='%A %N')"
}
process() { pgrep -f -- "--shard $1/8 -o out.exr.parts/"; }

SECONDS=0
submitted=$("$root/scenes/slurm/submit.sh" "$scene" 8 out.exr "${words[@]}" --checkpoint 100ms)
say "$submitted"
array=$(squeue --noheader --name=petzval --format=%F | head -n 1)

running 1
kill -KILL "$(process 1)"
say "shard 1, on $node, is killed"

running 3
scontrol requeue "$job"
say "shard 3, on $node, is requeued"

# As if its power had gone: daemon, the job's keeper, its shell and petzval.
running 5
keeper=$(pgrep -f "slurmstepd: \[$job\.batch\]")
kill -KILL "$(cat "$node.pid")" "$keeper" "$(pgrep --parent "$keeper")" "$(process 5)"
scontrol update nodename="$node" state=down reason=lost
say "shard 5 is lost with $node"
slurmd -N "$node"

running 7
scancel --signal=USR1 --batch "$job"
say "shard 7, on $node, hears that its time is nearly up"

seen=
while left=$(squeue --array --noheader --format=%j | sort | uniq -c | xargs) && [ -n "$left" ]; do
    if [ "$left" != "$seen" ]; then say "$left left"; fi
    seen=$left
    sleep 0.2
done
[ -e out.exr ] || fail 'there is no picture'
say "$(tail -n 1 out.exr.parts/merge.log)"
for shard in {1..8}; do
    [ "$(grep -c 'from the beginning' "out.exr.parts/$shard.log")" = 1 ] ||
        fail "shard $shard did not go on from its checkpoint"
done
for shard in 3 7; do
    grep -q 'holds what is done' "out.exr.parts/$shard.log" ||
        fail "shard $shard was not left the time for its checkpoint"
done
[ -z "$(ls out.exr.parts/*.petzval.checkpoint 2>/dev/null)" ] || fail 'a checkpoint is left over'

"$PETZVAL" render "$scene" "${words[@]}" -o whole.exr 2>/dev/null
"$root/scenes/slurm/submit.sh" "$scene" 8 out.exr --spp 8 2>refused.log &&
    fail 'parts of another picture were gone on with'
grep -q 'parts of another picture' refused.log || fail "$(cat refused.log)"

# Sums differ by their order only.
"$PETZVAL" compare --metric relmse --fail-above 1e-10 out.exr whole.exr || fail 'the pictures differ'
say 'merged, it is the picture of a single run'
