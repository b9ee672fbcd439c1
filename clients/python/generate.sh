#!/usr/bin/env bash
# Remakes photonfarm/generated/models.py from the OpenAPI document that a coordinator serves.
# usage: clients/python/generate.sh PROGRAM [OUTPUT]
# It needs datamodel-codegen on PATH, in the version that pyproject.toml pins.
set -euo pipefail
program=$(realpath "${1:?say which photonfarm to run}")
output=$(realpath "${2:-$(dirname "$0")/photonfarm/generated/models.py}")
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT
touch "$folder/log"
"$program" serve --listen 127.0.0.1:0 --data none 2>"$folder/log" &
until url=$(sed -n 's/^photonfarm listens at //p' "$folder/log") && [ -n "$url" ]; do
    kill -0 %1 || { cat "$folder/log" >&2; exit 1; }
    sleep 0.1
done
python3 -c 'import sys, urllib.request; sys.stdout.buffer.write(urllib.request.urlopen(sys.argv[1]).read())' "$url/openapi.json" >"$folder/openapi.json"
datamodel-codegen --input "$folder/openapi.json" --input-file-type openapi --output "$output" \
    --output-model-type pydantic_v2.BaseModel --target-python-version 3.10 --formatters builtin --disable-timestamp \
    --use-standard-collections --use-union-operator --use-annotated --use-type-alias --enum-field-as-literal all \
    --use-schema-description --use-field-description
