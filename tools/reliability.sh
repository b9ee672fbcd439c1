#!/usr/bin/env bash
# Three workers, two jobs of different length; the coordinator is killed twice, a worker killed, a worker stopped and resumed. Both pictures
# must have the bits of a quiet run. Takes about three minutes. usage, in the project's root: tools/reliability.sh [PROGRAM]
set -euo pipefail
program=${1:-target/release/photonfarm}
[ -x "$program" ] || cargo build --release
folder=$(mktemp -d)
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
export PHOTONFARM_URL=http://127.0.0.1:$port
trap 'for process in $(jobs -p); do murder "$process" 2>/dev/null; done; rm -rf "$folder"' EXIT
start=$SECONDS status=0
# The shell need not say that it was killed.
murder() { kill -9 "$1"; wait "$1" 2>/dev/null || true; }
say() { printf '%4d s  %s\n' $((SECONDS - start)) "$*"; }
serve() {
    "$program" serve --listen "127.0.0.1:$port" --data "$1" --snapshot-interval 2 2>>"$folder/log" & coordinator=$!
    until curl -sf "$PHOTONFARM_URL/healthz" >/dev/null; do sleep 0.1; done
}
worker() { "$program" worker --coordinator "$PHOTONFARM_URL" --threads 1 --name "$1" 2>/dev/null & last=$!; }
submit() { "$program" submit scenes/cornell-diffuse/scene.xml -D size=256 --method sppm "$@" 2>/dev/null; }
passes() { "$program" jobs | cut -f 1-3 | tr '\t\n' '  '; }
wait_for_passes() { until [ "$("$program" jobs | head -1 | cut -f 3 | cut -d / -f 1)" -ge "$1" ]; do sleep 0.2; done; }

say "a quiet run: one coordinator, one worker"
serve "$folder/quiet"; worker quiet; quiet=$last
long=$(submit --passes 300); short=$(submit --passes 80 --seed 1)
"$program" watch "$long" 2>/dev/null; "$program" watch "$short" 2>/dev/null
"$program" fetch "$long" -o "$folder/long.exr"; "$program" fetch "$short" -o "$folder/short.exr"
kill "$coordinator" "$quiet"; wait "$coordinator" "$quiet" 2>/dev/null || true

say "a troubled run: one coordinator, three workers"
serve "$folder/troubled"
worker one; one=$last; worker two; two=$last; worker three
long=$(submit --passes 300); short=$(submit --passes 80 --seed 1)
wait_for_passes 25; say "jobs: $(passes)"
say "kill -9 the coordinator"; murder "$coordinator"; sleep 2; serve "$folder/troubled"; say "it is back; jobs: $(passes)"
wait_for_passes 100; say "kill -9 worker one"; murder "$one"
say "kill -STOP worker two"; kill -STOP "$two"; sleep 5
wait_for_passes 160; say "kill -9 the coordinator again"; murder "$coordinator"; sleep 2; serve "$folder/troubled"
say "it is back; jobs: $(passes)"
kill -CONT "$two"; say "kill -CONT worker two"
"$program" watch "$long" 2>/dev/null; "$program" watch "$short" 2>/dev/null
say "both are done; jobs: $(passes)"
compare_bits() {
    "$program" compare "$folder/$2.exr" "$folder/$1.exr" --json | python3 -c '
import json, sys
found = json.load(sys.stdin)
print("same bits" if found["rmse"] == 0 else f"DIFFERENT: {found}"); sys.exit(found["rmse"] != 0)'
}
for picture in long short; do
    id=$([ $picture = long ] && echo "$long" || echo "$short")
    "$program" fetch "$id" -o "$folder/$id.exr"
    found=$(compare_bits $picture "$id") || status=1
    say "the $picture job beside the quiet run: $found"
done
say "the coordinator's log of joins, losses and ends:"
grep -vE "listens|data is kept" "$folder/log" | sed 's/^[^ ]* *//' | cut -c1-150
exit $status
