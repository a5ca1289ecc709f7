#!/bin/sh
# From raw frames to the period in one pipeline, which keeps no frame.
#     raw_to_period.sh TOLIMAN SCENE
# In the simulator's place a receiver of headerless frames may stand, and in the end a period after every frame:
#     receiver | toliman encode --weights w.tlmw --dtype u16le --shape 256x256 - |
#         toliman period - --columns frame,latent_px --follow --f0 1e-3 --df 1e-4 --nf 5000
set -eu
toliman=$1
scene=$2
weights=$(mktemp)
trap 'rm -f "$weights"' EXIT
"$toliman" train "$scene" --out "$weights"
"$toliman" simulate "$scene" --out - |
    "$toliman" encode --weights "$weights" - |
    "$toliman" period - --columns frame,latent_px --json
