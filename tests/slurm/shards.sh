#!/bin/bash
# Renders eight shards as an array job, of which one is killed, one requeued, one on a node that is lost and
# one out of time, and compares the merged picture with a single render. Run it in cluster.sh.
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

# Waits until a shard has a checkpoint, and sets $job and $node.
wait_for_checkpoint() {
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

wait_for_checkpoint 1
kill -KILL "$(process 1)"
say "shard 1, on $node, is killed"

wait_for_checkpoint 3
scontrol requeue "$job"
say "shard 3, on $node, is requeued"

# Simulates a power failure: kills the daemon, its job step daemon, the shell and petzval.
wait_for_checkpoint 5
stepd=$(pgrep -f "slurmstepd: \[$job\.batch\]")
kill -KILL "$(cat "$node.pid")" "$stepd" "$(pgrep --parent "$stepd")" "$(process 5)"
scontrol update nodename="$node" state=down reason=lost
say "shard 5 is lost with $node"
slurmd -N "$node"

wait_for_checkpoint 7
scancel --signal=USR1 --batch "$job"
say "shard 7, on $node, is told that its time is nearly up"

seen=
while left=$(squeue --array --noheader --format=%j | sort | uniq -c | xargs) && [ -n "$left" ]; do
    if [ "$left" != "$seen" ]; then say "$left left"; fi
    seen=$left
    sleep 0.2
done
[ -e out.exr ] || fail 'there is no picture'
say "$(grep '^picture:' out.exr.parts/merge.log)"
for shard in {1..8}; do
    [ "$(grep -c 'from the beginning' "out.exr.parts/$shard.log")" = 1 ] ||
        fail "shard $shard did not go on from its checkpoint"
done
for shard in 3 7; do
    grep -q 'holds the state of the render' "out.exr.parts/$shard.log" ||
        fail "shard $shard was not left the time for its checkpoint"
done
[ -z "$(ls out.exr.parts/*.petzval.checkpoint 2>/dev/null)" ] || fail 'a checkpoint is left over'

"$PETZVAL" render "$scene" "${words[@]}" -o whole.exr 2>/dev/null
"$root/scenes/slurm/submit.sh" "$scene" 8 out.exr --spp 8 2>refused.log &&
    fail 'parts of another picture were resumed'
grep -q 'parts of another picture' refused.log || fail "$(cat refused.log)"

# Only the order of sums differs.
"$PETZVAL" compare --metric relmse --fail-above 1e-10 out.exr whole.exr || fail 'the pictures differ'
say 'merged, it is the picture of a single run'
