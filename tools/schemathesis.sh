#!/usr/bin/env bash
# Lets schemathesis call everything that the OpenAPI document names, with good and bad values, also one call after the other, for a bounded
# time. Answers must be among those that the document names, and of its form. Installs schemathesis from PyPI where it is not there.
# usage, in the project's root: tools/schemathesis.sh [--seconds N] [--program PROGRAM] [further options of `schemathesis run`]
set -euo pipefail
seconds=60 program=target/release/photonfarm
while [ $# -gt 0 ]; do
    case $1 in
    --seconds) seconds=$2 && shift 2 ;;
    --program) program=$2 && shift 2 ;;
    *) break ;;
    esac
done
program=$(realpath "$program")
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT
schemathesis=$(command -v schemathesis || true)
if [ -z "$schemathesis" ]; then
    python3 -m venv "$folder/python"
    "$folder/python/bin/pip" install --quiet 'schemathesis>=4.32,<5'
    schemathesis=$folder/python/bin/schemathesis
fi
"$program" serve --listen 127.0.0.1:0 --data none --workers 1 --threads 1 2>"$folder/log" &
until url=$(sed -n 's/^photonfarm listens at //p' "$folder/log") && [ -n "$url" ]; do sleep 0.1; done
# It leaves a folder of what it learned where it runs.
cd "$folder"
# Streams of events end with their jobs, not with the request; users are made elsewhere, since the first one ends the calls of all others.
"$schemathesis" run "$url/openapi.json" --max-time "$seconds" --seed 1 --request-timeout 20 --continue-on-failure --warnings off \
    --exclude-path-regex '/events$|^/v1/users|^/v1/session' \
    --checks not_a_server_error,status_code_conformance,content_type_conformance,response_headers_conformance,response_schema_conformance,unsupported_method,use_after_free \
    "$@"
kill -0 %1 || { echo "the coordinator is gone" >&2; tail "$folder/log" >&2; exit 1; }
