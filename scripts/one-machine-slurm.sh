#!/bin/sh
# Starts Slurm on this machine, as whoever runs this, for tests: its own keys, ports and state, all in FOLDER.
#   Usage: . scripts/one-machine-slurm.sh; slurm_start FOLDER; ...; slurm_stop
# Debian: apt-get install --no-install-recommends slurmctld slurmd slurm-client munge

# Whether what it takes is installed; says what is missing.
slurm_missing() {
  for program in munged slurmctld slurmd sbatch squeue scancel; do
    PATH="$PATH:/usr/sbin" command -v $program > /dev/null || { echo "no $program"; return; }
  done
}

slurm_start() {
  slurm=$(realpath "$1") host=$(hostname -s) user=$(id -un)
  PATH="$PATH:/usr/sbin"
  mkdir -p "$slurm/state" "$slurm/spool"
  chmod 700 "$slurm"
  head -c 128 /dev/urandom > "$slurm/munge.key"
  chmod 400 "$slurm/munge.key"
  # As many processors as jobs of a test want, whatever this machine has: they wait more than they compute.
  # Ports that nobody else on this machine is likely to have.
  port=$((20000 + $$ % 20000))
  cat > "$slurm/slurm.conf" << CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$slurm/munge.socket
CredType=cred/munge
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/slurmd.pid
SlurmctldLogFile=$slurm/slurmctld.log
SlurmdLogFile=$slurm/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=1,defer_batch
MinJobAge=600
ReturnToService=2
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=32 RealMemory=100000 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
CONF
  SLURM_CONF=$slurm/slurm.conf
  export SLURM_CONF PATH
  munged --force --key-file="$slurm/munge.key" --socket="$slurm/munge.socket" --pid-file="$slurm/munged.pid" \
    --log-file="$slurm/munged.log" --seed-file="$slurm/munged.seed" > /dev/null
  slurmctld -c
  slurmd
  for _ in $(seq 60); do
    case $(sinfo --noheader --format=%T 2> /dev/null) in idle*) return 0 ;; esac
    sleep 0.5
  done
  echo "Slurm: found no idle node, expected one; see $slurm/slurmctld.log, $slurm/slurmd.log" >&2
  return 1
}

slurm_stop() {
  for name in slurmd slurmctld munged; do
    [ ! -s "$slurm/$name.pid" ] || kill "$(cat "$slurm/$name.pid")" 2> /dev/null || true
  done
}
