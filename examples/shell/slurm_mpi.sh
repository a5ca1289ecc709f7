#!/bin/sh
#SBATCH --job-name=toliman
#SBATCH --ntasks=64
#SBATCH --cpus-per-task=1
#SBATCH --output=campaign-%j.jsonl
# Runs a campaign of series over all ranks of a Slurm job, with one line of JSON per series; mpirun takes the number of
# ranks from the job.
#     sbatch slurm_mpi.sh SCENE SERIES
set -eu
scene=$1
series=$2
mpirun toliman-mpi "$scene" --campaign "$series"
