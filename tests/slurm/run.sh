#!/usr/bin/env bash
# The small workflow through Slurm, as `make test-slurm` runs it: a cluster of this one machine, of
# Debian's packages and any user, gives the same bytes as a local run, and completes after a job
# was killed. All of it is in one folder, $WORK if that is set, and its daemons end with this. Other
# targets than `all`, of which one is the network of closing, may be named.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
export PATH=$PATH:/usr/sbin
for tool in munged slurmctld slurmd sbatch; do
  command -v "$tool" >/dev/null || {
    echo "$tool is missing: apt install munge slurmctld slurmd slurm-client" >&2
    exit 1
  }
done
work=${WORK:-$(mktemp -d)}
targets=("${@:-all}")
rm -rf "$work/slurm"
mkdir -p "$work"/{bin,state,spool,local,slurm}
chmod 755 "$work"
export SLURM_CONF=$work/slurm.conf
stop() {
  scancel --user "$(id -un)" || true
  for file in "$work"/*.pid; do
    pid=$(cat "$file") && kill "$pid" && tail --pid="$pid" -f /dev/null || true
  done
}
trap stop EXIT

cat >"$SLURM_CONF" <<END
ClusterName=one
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=${PORT:-26817}
SlurmdPort=$((${PORT:-26817} + 1))
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=5
JobAcctGatherParams=OverMemoryKill
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(free -m | awk '/^Mem/ {print $2}')
OverTimeLimit=10
PartitionName=only Nodes=ALL Default=YES
END
head -c 1024 /dev/urandom >"$work/munge.key"
chmod 600 "$work/munge.key"
# Jobs start srun without the variables of Slurm, which name its configuration.
printf '#!/bin/sh\nSLURM_CONF=%s exec %s "$@"\n' "$SLURM_CONF" "$(command -v srun)" >"$work/bin/srun"
chmod +x "$work/bin/srun"
export PATH=$work/bin:$PATH

munged --force --key-file="$work/munge.key" --socket="$work/munge.socket" \
  --pid-file="$work/munged.pid" --log-file="$work/munged.log" --seed-file="$work/munge.seed"
slurmctld -c
slurmd
timeout 60 sh -c 'until sinfo -h -t idle | grep -q .; do sleep 1; done'

# Snakemake with the code here, in a folder of its own.
run() {
  cp -r "$root/config" "$work/$1"
  (cd "$work/$1" && shift && snakemake --snakefile "$root/Snakefile" "$@" \
    --configfile config/test.yaml -- "${targets[@]}")
}
through=(--profile "$root/profiles/slurm" --default-resources slurm_partition=only
  "mem_mb=attempt * 2000" "runtime=attempt * 10" --slurm-status-command squeue --slurm-init-seconds-before-status-checks 5)

echo "== through Slurm, until a training is killed: $work"
run slurm "${through[@]}" --retries 0 >"$work/killed.log" 2>&1 &
until [ -s "$work/slurm/logs/train/closing.log" ]; do
  kill -0 $! || { cat "$work/killed.log"; exit 1; }
  sleep 1
done
scancel "$(squeue -h -o '%i %k' | awk '/rule_train_wildcards_closing/ {print $1}')"
if wait $!; then
  echo "no job was missed that was killed" >&2
  exit 1
fi
grep -q "status is: 'CANCELLED'" "$work/killed.log"

echo "== again: what is left"
run slurm "${through[@]}"
echo "== the same on this machine"
run local --cores "$(nproc)"
diff -r -x benchmarks -x logs -x .snakemake "$work/local" "$work/slurm"
echo "== the same bytes in $(find "$work/local/results" -type f | wc -l) files of results"
