#!/bin/sh
# Many machines: each task of a Slurm array tracks its share of the pairs into a state folder of its own.
#     sbatch --array=0-7 track_array.sh shards downlink --weights w.tlmw --mission-days 1095 --dtype u16le
#     toliman merge shards/shard_* --out mission
# Of one large file instead of many pairs each task takes its frames: toliman track --frames A:B --state DIR ... FILE
# The merged folder has the bits that one tracker of all frames would have; a task that was killed may run again.
#SBATCH --job-name=track
#SBATCH --cpus-per-task=1
set -eu
if [ $# -lt 3 ] || [ -z "${SLURM_ARRAY_TASK_ID:-}" ] || [ -z "${SLURM_ARRAY_TASK_COUNT:-}" ]; then
    echo "usage: sbatch --array=0-7 $0 SHARDS DOWNLINK OPTIONS OF toliman track..." >&2
    exit 2
fi
shards=$1
downlink=$2
shift 2
mkdir -p "$shards"
ls "$downlink"/*_meta.jsonl |
    awk -v tasks="$SLURM_ARRAY_TASK_COUNT" -v mine="$SLURM_ARRAY_TASK_ID" 'NR % tasks == mine' |
    "${TOLIMAN:-toliman}" track --state "$shards/shard_$SLURM_ARRAY_TASK_ID" "$@" - >"$shards/frames_$SLURM_ARRAY_TASK_ID.jsonl"
