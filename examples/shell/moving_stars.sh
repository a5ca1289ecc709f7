#!/bin/sh
# Trains a bank of networks for 18 days of moving stars, encodes simulated frames by it, and compares its separations
# with those of the fit: both have the same true value, and the networks add at most a few percent to the noise.
#     moving_stars.sh TOLIMAN SCENE
# SCENE: one with moving stars, such as sky.json. For a mission, give its first and last date, without --places and
# --steps.
set -eu
toliman=$1
scene=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$toliman" train "$scene" --bank 2026.5:2026.55 --places 1 --steps 150 --out "$work/bank.tlmb"
"$toliman" simulate "$scene" --frames 0:8 --out "$work/frames.npy"
"$toliman" encode --fit "$scene" --weights "$work/bank.tlmb" "$work/frames.npy" >"$work/values.csv"
awk -F, 'NR == 1 {for (i = 1; i <= NF; i++) column[$i] = i}
         NR > 1 {difference = $column["displacement_px"] - $column["fit_displacement_px"]
                 sum += (difference / $column["separation_sigma_px"])^2; efficiency += $column["efficiency"]; n++}
         END {printf "%d frames: efficiency %.2f; network minus fit: %.2f sigma rms\n", n, efficiency/n, sqrt(sum/n)
              exit sum/n > 1}' "$work/values.csv"
