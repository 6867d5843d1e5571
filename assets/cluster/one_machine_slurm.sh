#!/bin/bash
# A Slurm cluster of two nodes on this machine alone, to try the profile for Slurm with: starts it, runs a command, and takes it down.
#
#     assets/cluster/one_machine_slurm.sh snakemake --snakefile assets/cluster/Snakefile --configfile my.yaml \
#         --profile assets/cluster/profiles/slurm
#
# Needs root, and Debian's slurmctld, slurmd, slurm-client and munge. All it writes is in a temporary folder, to which
# /etc/slurm/slurm.conf leads meanwhile; it removes both. With KEEP_LOGS=FOLDER logs are copied there first. Each node says that it has
# NODE_CPUS cores and NODE_MEMORY_MB of memory. Nothing listens beyond this machine's own ports 16817 to 16819.
set -euo pipefail

[ $# -gt 0 ] || { echo "give the command to run on the cluster" >&2; exit 2; }
[ "$(id -u)" = 0 ] || { echo "must be run as root, as Slurm's daemons are" >&2; exit 2; }
for program in slurmctld slurmd sinfo munged; do
    command -v "$program" > /dev/null || { echo "$program is missing; install slurmctld slurmd slurm-client munge" >&2; exit 2; }
done

# Steps of a job look nowhere else: what is set in the environment is taken away from them.
installed=/etc/slurm/slurm.conf
[ ! -e "$installed" ] && [ ! -L "$installed" ] || { echo "$installed exists: this machine is of a cluster already" >&2; exit 2; }

folder=$(mktemp -d /tmp/overlook-slurm.XXXXXX)
daemons=()
clean_up() {
    # Jobs outlive the daemons that started them.
    scancel --user=root 2> /dev/null || true
    for _ in $(seq 40); do
        [ -n "$(squeue --noheader 2> /dev/null)" ] || break
        sleep 0.5
    done
    for daemon in "${daemons[@]}"; do kill "$daemon" 2> /dev/null || true; done
    for daemon in "${daemons[@]}"; do wait "$daemon" 2> /dev/null || true; done
    [ -z "${KEEP_LOGS:-}" ] || { mkdir -p "$KEEP_LOGS" && cp "$folder"/*.log "$folder"/*.conf "$folder"/jobs "$KEEP_LOGS" 2> /dev/null || true; }
    rm -f "$installed"
    rm -rf "$folder"
}
trap clean_up EXIT

host=$(hostname -s)
# As much as the largest job of the profile asks for, whatever the machine has: a larger job would wait forever.
cpus=${NODE_CPUS:-16}
memory=${NODE_MEMORY_MB:-16000}
mkdir -p "$folder/state" "$folder/spool"
chmod 755 "$folder"
head -c 128 /dev/urandom > "$folder/key"
chmod 400 "$folder/key"
cat > "$folder/slurm.conf" << CONF
ClusterName=overlook
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.%n.log
# No control groups: containers and virtual machines often do not let them be made.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/filetxt
JobCompLoc=$folder/jobs
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
# Nodes are as large as they say, whatever the machine has.
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2
ReturnToService=2
MinJobAge=3600
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=16818 CPUs=$cpus RealMemory=$memory
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=16819 CPUs=$cpus RealMemory=$memory
PartitionName=all Nodes=one,two Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p "$(dirname "$installed")"
ln -s "$folder/slurm.conf" "$installed"

munged --foreground --force --key-file="$folder/key" --socket="$folder/munge.socket" --pid-file="$folder/munged.pid" \
    --log-file="$folder/munged.log" --seed-file="$folder/seed" > "$folder/munged.out.log" 2>&1 &
daemons+=($!)
slurmctld -D > "$folder/slurmctld.out.log" 2>&1 &
daemons+=($!)
for node in one two; do
    slurmd -D -N "$node" > "$folder/slurmd.$node.out.log" 2>&1 &
    daemons+=($!)
done

for _ in $(seq 60); do
    ready=$(sinfo --noheader --Node --format=%T 2> /dev/null | grep -c idle || true)
    [ "$ready" = 2 ] && break
    sleep 0.5
done
if [ "$ready" != 2 ]; then
    echo "the nodes did not come up:" >&2
    tail -n 20 "$folder"/*.log >&2
    exit 1
fi
"$@"
