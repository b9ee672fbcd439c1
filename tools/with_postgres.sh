#!/usr/bin/env bash
# Runs a command with a PostgreSQL of its own, which is gone afterwards: tools/with_postgres.sh cargo test --test stores
# Needs the Debian package postgresql. As root, the server runs as the user postgres.
set -euo pipefail
binaries=$(find /usr/lib/postgresql -maxdepth 2 -name bin 2>/dev/null | sort -V | tail -1)
[ -x "$binaries/initdb" ] || { echo "install the package postgresql" >&2; exit 1; }
folder=$(mktemp -d)
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
runner=()
if [ "$(id -u)" = 0 ]; then
    chown postgres "$folder"
    runner=(runuser -u postgres --)
fi
control=("${runner[@]}" "$binaries/pg_ctl" -D "$folder/data" -l "$folder/log" -w)
stop() {
    (cd / && "${control[@]}" -m immediate stop >/dev/null) || true
    rm -rf "$folder"
}
trap stop EXIT
cd_back=$PWD
cd /
"${runner[@]}" "$binaries/initdb" -D "$folder/data" -A trust -U postgres >"/dev/null"
"${control[@]}" -o "-p $port -k $folder -c listen_addresses=127.0.0.1" start >/dev/null
cd "$cd_back"
export PHOTONFARM_TEST_POSTGRES="postgres://postgres@127.0.0.1:$port/postgres"
export PHOTONFARM_TEST_POSTGRES_RESTART="cd / && ${control[*]} -m fast restart"
"$@"
