#!/bin/sh
# Tracks on many machines: each task of a Slurm array tracks its share of the frame files into its own state folder.
#     sbatch --array=0-7 track_array.sh shards downlink --weights w.tlmw --mission-days 1095 --dtype u16le
#     toliman merge shards/shard_* --out mission
# For one large file instead of many, give each task a range: toliman track --frames A:B --state DIR ... FILE
# The merged folder is bit-identical to that of a single tracker of all frames. A killed task can be run again.
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
