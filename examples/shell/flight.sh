#!/bin/sh
# Trains weights and simulates frames for the static program c/flight.c, runs it, and compares its values with those of
# `toliman encode`.
#     flight.sh TOLIMAN FLIGHT SCENE
set -eu
toliman=$1
flight=$2
scene=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$toliman" train "$scene" --steps 20 --out "$work/weights.tlmw"
"$toliman" simulate "$scene" --frames 0:24 --out "$work/frames.bin"
"$flight" "$work/weights.tlmw" "$work/frames.bin" >"$work/flight.txt"
"$toliman" encode --weights "$work/weights.tlmw" --dtype u32le --shape 256x256 "$work/frames.bin" >"$work/latents.csv"
awk -F, 'NR > 1 {print "frame " $2 " " $3 " px"}' "$work/latents.csv" >"$work/expected.txt"
grep '^frame' "$work/flight.txt" | cmp - "$work/expected.txt"
tail -2 "$work/flight.txt"
