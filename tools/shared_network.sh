#!/usr/bin/env bash
# Two users with tokens, TLS, workers that joined by token, a job each; one user is refused the other's cancel; the coordinator that leads is killed
# and the one that stood by takes over. Both pictures must have the bits of a quiet run. Takes about two minutes.
# usage, in the project's root: tools/with_postgres.sh tools/with_s3.sh tools/shared_network.sh [PROGRAM]
set -euo pipefail
program=${1:-target/release/photonfarm}
[ -x "$program" ] || cargo build --release
: "${PHOTONFARM_TEST_POSTGRES:?start it by tools/with_postgres.sh}" "${PHOTONFARM_TEST_S3:?start it by tools/with_s3.sh}"
folder=$(mktemp -d)
trap 'for process in $(jobs -p); do murder "$process" 2>/dev/null; done; rm -rf "$folder"' EXIT
start=$SECONDS status=0
# The shell need not say that it was killed.
murder() { kill -9 "$1"; wait "$1" 2>/dev/null || true; }
say() { printf '%4d s  %s\n' $((SECONDS - start)) "$*"; }
port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }
first_port=$(port) second_port=$(port)

say "a certificate for both coordinators"
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 30 -subj /CN=photonfarm -addext subjectAltName=DNS:localhost,IP:127.0.0.1 \
    -keyout "$folder/key.pem" -out "$folder/certificate.pem" 2>/dev/null
fingerprint=sha256:$(openssl x509 -in "$folder/certificate.pem" -outform DER | sha256sum | cut -d ' ' -f 1)
openssl rand -hex 32 >"$folder/operator.token"
serve() {
    "$program" serve --listen "127.0.0.1:$2" --data "$folder/$1" --database "$PHOTONFARM_TEST_POSTGRES" --blobs "$PHOTONFARM_TEST_S3/shared-network" \
        --tls-certificate "$folder/certificate.pem" --tls-key "$folder/key.pem" --admin-token-file "$folder/operator.token" \
        --snapshot-interval 2 2>>"$folder/$1.log" &
    last=$!
}
export PHOTONFARM_FINGERPRINT=$fingerprint
ready() { "$program" health --ready --coordinator "https://127.0.0.1:$1" 2>/dev/null; }
serve first "$first_port"; leader=$last
until ready "$first_port"; do sleep 0.1; done
serve second "$second_port"
until "$program" health --coordinator "https://127.0.0.1:$second_port" 2>/dev/null; do sleep 0.1; done
if ready "$second_port"; then say "two lead"; exit 1; fi
say "one coordinator leads, one stands by"
export PHOTONFARM_URL=https://127.0.0.1:$first_port,https://127.0.0.1:$second_port

operator() { PHOTONFARM_TOKEN_FILE=$folder/operator.token "$program" "$@"; }
operator user add anna --role artist >"$folder/anna.token" 2>/dev/null
operator user add ben --role artist >"$folder/ben.token" 2>/dev/null
operator token new --scope worker --label "two workers" >"$folder/worker.token"
as() { PHOTONFARM_TOKEN_FILE=$folder/$1.token "$program" "${@:2}"; }
for worker in one two; do
    "$program" worker --threads 1 --name "$worker" --token-file "$folder/worker.token" 2>/dev/null &
done
if "$program" jobs 2>"$folder/said"; then say "no token was asked for"; exit 1; fi
say "without a token: $(cut -c 1-100 "$folder/said")"
if "$program" worker --threads 1 --token-file "$folder/anna.token" 2>"$folder/said"; then exit 1; fi
say "a worker with anna's token: $(tail -1 "$folder/said" | cut -c 1-110)"

submit() { as "$1" submit scenes/cornell-diffuse/scene.xml -D size=128 --method sppm "${@:2}" 2>/dev/null; }
annas=$(submit anna --passes 500) bens=$(submit ben --passes 300 --seed 1)
say "anna's job $annas, ben's job $bens"
if as ben cancel "$annas" 2>"$folder/said"; then status=1; fi
say "ben cancels anna's: $(cut -c 1-110 "$folder/said")"
passes() { as anna jobs | awk -v job="$1" '$1 == job { split($3, done, "/"); print done[1] }'; }
until [ "$(passes "$annas")" -ge 60 ]; do sleep 0.2; done
say "jobs: $(as anna jobs | cut -f 1-3 | tr '\t\n' '  ')"
say "kill -9 the one that leads"; murder "$leader"; killed=$SECONDS
until ready "$second_port"; do sleep 0.1; done
say "the other leads after $((SECONDS - killed)) s; jobs: $(as anna jobs | cut -f 1-3 | tr '\t\n' '  ')"
serve first "$first_port"
as anna watch "$annas" 2>/dev/null; as ben watch "$bens" 2>/dev/null
say "both are done; owners: $(as ben jobs --json | python3 -c 'import json, sys; print(*(job["owner"] for job in json.load(sys.stdin)))')"
as anna fetch "$annas" -o "$folder/anna.exr"; as ben fetch "$bens" -o "$folder/ben.exr"

say "the same in a quiet run on this machine"
quiet() { "$program" render scenes/cornell-diffuse/scene.xml -D size=128 --method sppm -o "$folder/quiet-$1.exr" "${@:2}" 2>/dev/null; }
quiet anna --passes 500; quiet ben --passes 300 --seed 1
for user in anna ben; do
    found=$("$program" compare "$folder/$user.exr" "$folder/quiet-$user.exr" --json | python3 -c '
import json, sys
found = json.load(sys.stdin)
print("same bits" if found["rmse"] == 0 else f"DIFFERENT: {found}"); sys.exit(found["rmse"] != 0)') || status=1
    say "$user's picture beside the quiet one: $found"
done
exit $status
