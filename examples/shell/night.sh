#!/bin/sh
# A night: reads what has arrived into the state folder of the mission, and adds a line to STATE.log.
#     night.sh SCENE STATE DOWNLINK [OPTIONS OF toliman track]
# SCENE is a calibrated scene. STATE.frames.jsonl has what happened to each frame. For cron, or the timer toliman-night.timer:
#     0 6 * * *  night.sh fitted.json mission downlink || tail -n 1 mission.log | mail -s toliman operator@example.org
# Exit code: that of track if it fails, otherwise that of night: 4 if something is wrong with the instrument.
set -u
if [ $# -lt 3 ]; then
    echo "usage: $0 SCENE STATE DOWNLINK [OPTIONS OF toliman track]" >&2
    exit 2
fi
scene=$1 state=$2 downlink=$3
shift 3
toliman=${TOLIMAN:-toliman}
"$toliman" track --fit "$scene" --state "$state" --every 1000000 "$@" "$downlink" >"$state.frames.jsonl" 2>"$state.messages" || {
    code=$?
    tail -n 1 "$state.messages" | tee -a "$state.log" >&2
    exit $code
}
line=$("$toliman" night "$state" 2>>"$state.messages")
code=$?
echo "$line" >>"$state.log"
echo "$line"
exit $code
