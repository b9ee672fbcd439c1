#!/usr/bin/env bash
# Runs a command with an S3 server of its own, which is gone afterwards: tools/with_s3.sh cargo test --test stores
# Uses moto_server from PATH, or installs it from PyPI into a temporary folder.
set -euo pipefail
folder=$(mktemp -d)
server=$(command -v moto_server || true)
if [ -z "$server" ]; then
    python3 -m venv "$folder/python"
    "$folder/python/bin/pip" install --quiet 'moto[server]'
    server=$folder/python/bin/moto_server
fi
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
"$server" -H 127.0.0.1 -p "$port" >"$folder/log" 2>&1 &
process=$!
stop() {
    kill "$process" 2>/dev/null || true
    rm -rf "$folder"
}
trap stop EXIT
for _ in $(seq 100); do
    if curl --silent --fail -X PUT "http://127.0.0.1:$port/photonfarm" >/dev/null; then break; fi
    sleep 0.2
done
export AWS_ENDPOINT="http://127.0.0.1:$port" AWS_ALLOW_HTTP=true AWS_REGION=us-east-1
export AWS_ACCESS_KEY_ID=test AWS_SECRET_ACCESS_KEY=test
export PHOTONFARM_TEST_S3=s3://photonfarm
"$@"
