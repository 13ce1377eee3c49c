#!/usr/bin/env bash
# A Slurm of one node on 127.0.0.1 alone, for tests:  scripts/slurm_local.sh COMMAND [ARGUMENT ...]
# Starts munged, slurmctld and slurmd in a folder of its own, runs the command with SLURM_CONF set,
# stops the three by their ids, and ends as the command did. Needs root and slurmctld, slurmd,
# slurm-client, munge of Debian 12.
set -euo pipefail
(($# > 0)) || { echo "slurm_local.sh: COMMAND is missing, expected what is to run" >&2; exit 2; }
((EUID == 0)) || { echo "slurm_local.sh: user = $(id -un), expected root: slurmd starts tasks" >&2; exit 2; }
for program in munged slurmctld slurmd sbatch; do
  [[ -x $(PATH=$PATH:/usr/sbin command -v $program) ]] ||
    { echo "slurm_local.sh: $program is missing, expected the packages slurmctld, slurmd, slurm-client and munge" >&2; exit 2; }
done
PATH=$PATH:/usr/sbin

at=$(mktemp -d /tmp/slurm_local.XXXXXX)
chmod 755 "$at"
mkdir -p "$at"/{state,spool}
pids=()
stop() {
  local pid
  # Tasks have daemons of their own.
  timeout 10 scancel --user="$(id -un)" 2>/dev/null || true
  for _ in {1..50}; do [[ -n $(timeout 5 squeue --noheader 2>/dev/null) ]] || break; sleep 0.1; done
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do
    for _ in {1..50}; do kill -0 "$pid" 2>/dev/null || break; sleep 0.1; done
    kill -KILL "$pid" 2>/dev/null || true
  done
  for pid in $(pgrep slurmstepd); do
    ! grep -qsz "^SLURM_CONF=$at/" "/proc/$pid/environ" || kill -KILL "$pid" 2>/dev/null || true
  done
  rm -rf "$at"
}
trap stop EXIT

(umask 077; head -c 1024 /dev/urandom >"$at/munge.key")
munged --foreground --force --key-file="$at/munge.key" --socket="$at/munge.socket" --pid-file="$at/munged.pid" \
  --log-file="$at/munged.log" --seed-file="$at/munged.seed" >/dev/null 2>&1 &
pids+=($!)

host=$(hostname -s)
cat >"$at/slurm.conf" <<CONF
ClusterName=local
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=${SLURM_PORT:-17117}
SlurmdPort=$((${SLURM_PORT:-17117} + 1))
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
AuthType=auth/munge
AuthInfo=socket=$at/munge.socket
CredType=cred/munge
SlurmUser=root
StateSaveLocation=$at/state
SlurmdSpoolDir=$at/spool
SlurmctldPidFile=$at/slurmctld.pid
SlurmdPidFile=$at/slurmd.pid
SlurmctldLogFile=$at/slurmctld.log
SlurmdLogFile=$at/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=2
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=local Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$at/slurm.conf
slurmctld -D >/dev/null 2>&1 &
pids+=($!)
slurmd -D >/dev/null 2>&1 &
pids+=($!)

for _ in {1..100}; do
  sinfo --noheader --format %t 2>/dev/null | grep -q idle && break
  sleep 0.2
done
sinfo --noheader --format %t 2>/dev/null | grep -q idle || {
  echo "slurm_local.sh: the node does not come up" >&2
  tail -n 5 "$at"/*.log >&2
  exit 1
}
code=0
"$@" || code=$?
exit $code
