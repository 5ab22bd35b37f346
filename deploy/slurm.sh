#!/bin/bash
# A batch as an array of jobs on Slurm, each job a part of the captures:
#
#   sbatch --array=1-40 deploy/slurm.sh CAPTURES CASES
#   sbatch --dependency=afterany:JOB --wrap "limbgram batch CAPTURES -o CASES"
#
# With as many jobs as captures each job does one case. Both folders lie where every node sees them
# under the same name. The second line does what a job left undone and writes the table.
#
#SBATCH --job-name=limbgram
#SBATCH --nodes=1
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --time=00:30:00
#SBATCH --signal=B:INT@60
#SBATCH --output=limbgram-%A_%a.txt
set -euo pipefail

captures=${1:?Name the folder of the captures.}
cases=${2:?Name the folder of the cases.}
count=${SLURM_ARRAY_TASK_COUNT:?Start it as an array: sbatch --array=1-40 ...}
part=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN + 1))

# The shell gives way to the command: the warning before the time is over reaches it as Ctrl-C does,
# and it ends its case so that the next job goes on from there.
exec limbgram batch "$captures" -o "$cases" --part "$part/$count" --at-once 1 "${@:3}"
