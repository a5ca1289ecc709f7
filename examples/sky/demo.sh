#!/bin/sh
# From a downlink to a planet in three lines: draws a mission that nobody has seen, finds out what is in it, and prints the
# truth next to it. demo.sh [FOLDER [OPTIONS OF mission.py]]
set -e
here=$(cd "$(dirname "$0")" && pwd)
PATH=$here/../../build/bin:$PATH
folder=${1:-sky.run}
[ $# -eq 0 ] || shift
say() {
    echo
    echo "\$ $*"
}
python="/usr/bin/python3 -W ignore::RuntimeWarning"

$python "$here/mission.py" "$folder" "$@"
cd "$folder"
say toliman calibrate scene.json downlink/
toliman calibrate scene.json downlink/
say toliman track --fit fitted.json --state mission downlink/
toliman track --fit fitted.json --state mission --every 100 downlink/ >track.jsonl
say toliman planet mission
toliman planet mission || case $? in 3 | 4) ;; *) exit 1 ;; esac # no frame fits, or a candidate is not a planet
say toliman night mission
toliman night mission || [ $? -eq 4 ]
echo
$python "$here/compare.py" .
echo
echo "figures: $folder/$(toliman report . mission)"
