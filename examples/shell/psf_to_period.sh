#!/bin/sh
# The same job in the shell, step by step, in a folder of its own: weights, frames, latents, period.
#     psf_to_period.sh TOLIMAN SCENE
set -eu
toliman=$1
scene=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$toliman" psf "$scene" --out "$work/psf.npy"
"$toliman" train "$scene" --steps 60 --out "$work/weights.tlmw"
"$toliman" simulate "$scene" --frames 0:24 --out "$work/frames.bin"
"$toliman" encode --weights "$work/weights.tlmw" --dtype u32le --shape 256x256 "$work/frames.bin" >"$work/latents.csv"
awk -F, 'NR > 1 {print $2 "," $3}' "$work/latents.csv" >"$work/series.csv"
"$toliman" period "$work/series.csv" --json
