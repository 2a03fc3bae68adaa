#!/bin/bash
# Runs a command on a temporary Slurm cluster: a controller and two nodes of one core, all on this machine
# over the loopback interface, as the calling user. It leaves nothing behind and reads nothing in /etc.
#
#     cluster.sh COMMAND...
#
# Needs Debian's slurm-wlm and munge. The command gets $SLURM_CONF and $CLUSTER, a folder that is removed
# at the end, and has two minutes.
set -eu
PATH=$PATH:/usr/sbin
CLUSTER=$(mktemp -d)
export CLUSTER SLURM_CONF=$CLUSTER/slurm.conf

# Prints the daemons that were started with this configuration, and their child processes.
ours() {
    local process
    for process in /proc/[0-9]*; do
        if grep -qs '^slurm\|^munged' "$process/comm" &&
            grep -qsz "^SLURM_CONF=$SLURM_CONF\$" "$process/environ"; then
            echo "${process#/proc/}"
        fi
    done
}

stop() {
    scancel --user="$(id -un)" 2>/dev/null || true
    for _ in {1..50}; do
        [ -n "$(squeue --noheader 2>/dev/null)" ] || break
        sleep 0.1
    done
    for signal in TERM KILL; do
        for _ in {1..30}; do
            local left
            left=$(ours)
            [ -n "$left" ] || break 2
            # A process may have ended since.
            # shellcheck disable=SC2086
            kill -$signal $left 2>/dev/null || true
            sleep 0.1
        done
    done
    rm -rf "$CLUSTER"
}
trap stop EXIT
trap 'exit 130' INT TERM HUP

# Three consecutive free ports, below those that the system assigns.
used() { (: <"/dev/tcp/127.0.0.1/$1") 2>/dev/null; }
port=$((20000 + RANDOM % 12000))
while used $port || used $((port + 1)) || used $((port + 2)); do
    port=$((20000 + RANDOM % 12000))
done

# Munge requires folders that only its user can write to, and clients must reach its socket.
chmod 755 "$CLUSTER"
cd "$CLUSTER"
mkdir state
(umask 077 && head -c 128 /dev/urandom >munge.key)
munged --key-file="$CLUSTER/munge.key" --socket="$CLUSTER/munge.socket" --num-threads=2 \
    --pid-file="$CLUSTER/munged.pid" --log-file="$CLUSTER/munged.log" \
    --seed-file="$CLUSTER/munged.seed"

cat >slurm.conf <<END
ClusterName=petzval
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
# A requeued job waits until its credentials expire, by default two minutes.
AuthInfo=socket=$CLUSTER/munge.socket,cred_expire=5
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
StateSaveLocation=$CLUSTER/state
SlurmctldPidFile=$CLUSTER/slurmctld.pid
SlurmctldLogFile=$CLUSTER/slurmctld.log
SlurmdSpoolDir=$CLUSTER/%n
SlurmdPidFile=$CLUSTER/%n.pid
SlurmdLogFile=$CLUSTER/%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
NodeName=node1 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1
NodeName=node2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1
PartitionName=all Nodes=node1,node2 Default=yes
END
slurmctld -c
slurmd -N node1
slurmd -N node2
for _ in {1..100}; do
    [ "$(sinfo --noheader --states=idle --format=%D 2>/dev/null)" = 2 ] && break
    sleep 0.1
done
if [ "$(sinfo --noheader --states=idle --format=%D)" != 2 ]; then
    echo 'the nodes do not answer:' >&2
    tail -n 5 ./*.log >&2
    exit 1
fi
cd "$OLDPWD"
timeout --foreground 120 "$@"
