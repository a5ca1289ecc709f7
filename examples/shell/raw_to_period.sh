#!/bin/sh
# From raw frames to the period in one pipeline that stores no frame.
#     raw_to_period.sh TOLIMAN SCENE
# Prints the result as JSON; its "period" is in days.
# A receiver of headerless frames can replace the simulator; with --follow the period is printed after every frame:
#     receiver | toliman encode --weights w.tlmw --dtype u16le --shape 256x256 - |
#         toliman period - --columns frame,latent_px --follow --f0 1e-3 --df 1e-4 --nf 5000
set -eu
toliman=$1
scene=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
weights=$work/weights.tlmw
"$toliman" train "$scene" --out "$weights" 2>"$work/train.txt" || { cat "$work/train.txt" >&2; exit 1; }
"$toliman" simulate "$scene" --out - |
    "$toliman" encode --weights "$weights" - |
    "$toliman" period - --columns frame,latent_px --json
