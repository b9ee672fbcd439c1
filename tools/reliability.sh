#!/usr/bin/env bash
# Three workers, two jobs of different length; the coordinator is killed twice, a worker killed, a worker stopped and resumed. Both pictures
# must have the bits of a quiet run. Takes about three minutes. usage, in the project's root: tools/reliability.sh [PROGRAM]
set -euo pipefail
program=${1:-target/release/photonfarm}
[ -x "$program" ] || cargo build --release
folder=$(mktemp -d)
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
export PHOTONFARM_URL=http://127.0.0.1:$port
trap 'kill -9 $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT
start=$SECONDS
say() { printf '%4d s  %s\n' $((SECONDS - start)) "$*"; }
serve() {
    "$program" serve --listen "127.0.0.1:$port" --data "$1" --snapshot-interval 2 2>>"$folder/log" & coordinator=$!
    until curl -sf "$PHOTONFARM_URL/healthz" >/dev/null; do sleep 0.1; done
}
worker() { "$program" worker --coordinator "$PHOTONFARM_URL" --threads 1 --name "$1" 2>/dev/null & last=$!; }
submit() { "$program" submit scenes/cornell-diffuse/scene.xml -D size=256 --method sppm "$@" 2>/dev/null; }
passes() { "$program" jobs | cut -f 1-3 | tr '\t\n' '  '; }
wait_for_passes() { until [ "$("$program" jobs | head -1 | cut -f 3 | cut -d / -f 1)" -ge "$1" ]; do sleep 0.2; done; }
# The pixels alone: a file's header names its job.
pixels() { "$program" fetch "$1" -o "$folder/$1.exr" && "$program" compare "$folder/$1.exr" "$2" --json; }

say "a quiet run: one coordinator, one worker"
serve "$folder/quiet"; worker quiet; quiet=$last
long=$(submit --passes 300); short=$(submit --passes 40 --seed 1)
"$program" watch "$long" 2>/dev/null; "$program" watch "$short" 2>/dev/null
"$program" fetch "$long" -o "$folder/long.exr"; "$program" fetch "$short" -o "$folder/short.exr"
kill "$coordinator" "$quiet"; wait "$coordinator" "$quiet" 2>/dev/null || true

say "a troubled run: one coordinator, three workers"
serve "$folder/troubled"
worker one; one=$last; worker two; two=$last; worker three
long=$(submit --passes 300); short=$(submit --passes 40 --seed 1)
wait_for_passes 40; say "jobs: $(passes)"
say "kill -9 the coordinator"; kill -9 "$coordinator"; sleep 2; serve "$folder/troubled"; say "it is back; jobs: $(passes)"
wait_for_passes 100; say "kill -9 worker one"; kill -9 "$one"
say "kill -STOP worker two"; kill -STOP "$two"; sleep 5
wait_for_passes 160; say "kill -9 the coordinator again"; kill -9 "$coordinator"; sleep 2; serve "$folder/troubled"
say "it is back; jobs: $(passes)"
kill -CONT "$two"; say "kill -CONT worker two"
"$program" watch "$long" 2>/dev/null; "$program" watch "$short" 2>/dev/null
say "both are done; jobs: $(passes)"
say "the long job beside the quiet run:  $(pixels "$long" "$folder/long.exr" | tr -d ' \n')"
say "the short job beside the quiet run: $(pixels "$short" "$folder/short.exr" | tr -d ' \n')"
for picture in long short; do
    name=$([ $picture = long ] && echo "$long" || echo "$short")
    "$program" compare "$folder/$name.exr" "$folder/$picture.exr" --json | python3 -c '
import json, sys
found = json.load(sys.stdin)
print("        same bits" if found["rmse"] == 0 else f"        DIFFERENT: {found}"); sys.exit(found["rmse"] != 0)'
done
say "the coordinator's log of joins, losses and ends:"
grep -vE "listens|data is kept" "$folder/log" | sed 's/^[^ ]* *//' | cut -c1-150
