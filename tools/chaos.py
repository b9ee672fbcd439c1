"""A farm of real processes under random faults; every picture must have the bits of a quiet run.

Coordinator and workers are killed with SIGKILL and stopped with SIGSTOP at random, connections pass through a proxy that is cut or stalls, the
coordinator's small file system fills up, and its database restarts where it is a PostgreSQL server. Users submit, pause, resume and extend
jobs and delete old ones meanwhile. In the end every job that was accepted must be there and done.

usage, in the project's root:
    python3 tools/chaos.py [--seconds 600] [--workers 3] [--seed 1] [--program target/release/photonfarm]
    tools/with_postgres.sh python3 tools/chaos.py --postgres                its records in PostgreSQL, which is restarted, too
Takes --seconds and about two minutes more. The full file system needs root; without it that fault is left out, and said so.
"""
import argparse, collections, json, os, pathlib, random, shutil, signal, socket, subprocess, sys, tempfile, threading, time
import urllib.error, urllib.request

SCENE = "scenes/cornell-diffuse/scene.xml"
# What is rendered: method, passes, passes after an extension.
KINDS = [("sppm", 120, 180), ("path", 60, 90), ("sppm", 20, 40), ("bdpt", 24, 30)]
SIZE = 48
LIVE_JOBS = 4
# Ended jobs of which the oldest are deleted, once their pictures are compared.
KEPT_JOBS = 12
DISK_BYTES = 48 << 20

options = argparse.ArgumentParser()
options.add_argument("--seconds", type=float, default=600)
options.add_argument("--workers", type=int, default=3)
options.add_argument("--seed", type=int, default=1)
options.add_argument("--program", default="target/release/photonfarm")
options.add_argument("--postgres", action="store_true")
options = options.parse_args()
TEMPORARY = pathlib.Path(tempfile.mkdtemp())
LOG = TEMPORARY / "coordinators.log"
chance = random.Random(options.seed)
start = time.time()
counts = collections.Counter()
deleted = set()
latencies = []


def say(text):
    print(f"{time.time() - start:6.0f} s  {text}", flush=True)


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


class Proxy:
    """Forwards connections; may cut them all, or let their bytes wait."""

    def __init__(self, target):
        self.target, self.port = target, free_port()
        self.is_cut, self.is_stalled = False, False
        self.open = set()
        listener = socket.create_server(("127.0.0.1", self.port))
        threading.Thread(target=self.accept, args=[listener], daemon=True).start()

    def accept(self, listener):
        while True:
            client, _ = listener.accept()
            if self.is_cut:
                client.close()
                continue
            try:
                server = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                client.close()
                continue
            self.open |= {client, server}
            for pair in ((client, server), (server, client)):
                threading.Thread(target=self.forward, args=pair, daemon=True).start()

    def forward(self, source, sink):
        try:
            while data := source.recv(1 << 16):
                while self.is_stalled:
                    time.sleep(0.05)
                sink.sendall(data)
        except OSError:
            pass
        self.open -= {source, sink}
        for end in (source, sink):
            end.close()

    def cut(self, is_cut):
        self.is_cut = is_cut
        for connection in list(self.open) if is_cut else []:
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


class Farm:
    def __init__(self, folder, workers, database=None):
        self.folder, self.port, self.database = folder, free_port(), database
        self.url = f"http://127.0.0.1:{self.port}"
        self.proxy = Proxy(self.port)
        self.log = open(LOG, "ab")
        self.coordinator, self.workers, self.named = None, [], 0
        self.serve()
        for _ in range(workers):
            self.add_worker()

    def serve(self):
        command = [options.program, "serve", "--listen", f"127.0.0.1:{self.port}", "--data", str(self.folder),
                   "--snapshot-interval", "2", "--check-share", "0.05"]
        command += ["--database", self.database] if self.database else []
        self.coordinator = subprocess.Popen(command, stderr=self.log, stdout=self.log)

    def add_worker(self):
        self.named += 1
        command = [options.program, "worker", "--coordinator", f"http://127.0.0.1:{self.proxy.port}", "--threads", "1",
                   "--name", f"w{self.named}"]
        self.workers.append(subprocess.Popen(command, stderr=subprocess.DEVNULL))

    def ask(self, method, path, body=None, patience=30):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.url + path, data, {"Content-Type": "application/json"}, method=method)
        begin = time.time()
        with urllib.request.urlopen(request, timeout=patience) as answer:
            read = answer.read()
        if method == "GET":
            latencies.append(time.time() - begin)
        return read

    def insist(self, method, path, body=None):
        """Until it is answered."""
        while True:
            try:
                return self.ask(method, path, body)
            except urllib.error.HTTPError as problem:
                if problem.code < 500 and problem.code != 429:
                    raise
            except OSError:
                pass
            time.sleep(0.3)

    def insist_quietly(self, method, path, body=None):
        """The same for what may come too late."""
        try:
            self.insist(method, path, body)
        except urllib.error.HTTPError:
            counts["users came too late"] += 1

    def jobs(self):
        return json.loads(self.insist("GET", "/v1/jobs"))["jobs"]

    def picture(self, job):
        file = pathlib.Path(tempfile.mkstemp(".exr", dir=TEMPORARY)[1])
        file.write_bytes(self.insist("GET", f"/v1/jobs/{job}/image.exr"))
        return file

    def stop(self):
        for process in [self.coordinator, *self.workers]:
            process.send_signal(signal.SIGCONT)
            process.kill()
            process.wait()


def request(kind, scene):
    method, passes, _ = kind
    return {"scene": scene, "method": method, "stop": {"passes": passes}, "name": "-".join(map(str, kind))}


def upload(farm):
    bytes = pathlib.Path(SCENE).read_bytes().replace(b'name="size" value="512"', b'name="size" value="%d"' % SIZE)
    known = urllib.request.Request(farm.url + "/v1/scenes", bytes, method="POST")
    while True:
        try:
            return json.loads(urllib.request.urlopen(known, timeout=30).read())["hash"]
        except OSError:
            time.sleep(0.3)


def quiet_pictures(folder):
    """Pictures by kind and passes, from one worker that nothing happens to."""
    farm = Farm(folder, 1)
    scene = upload(farm)
    wanted = {}
    for kind in KINDS:
        for passes in kind[1:]:
            body = {**request(kind, scene), "stop": {"passes": passes}}
            wanted[kind, passes] = json.loads(farm.insist("POST", "/v1/jobs", body))["id"]
    while any(job["state"] != "done" for job in farm.jobs()):
        time.sleep(0.2)
    found = {key: farm.picture(job) for key, job in wanted.items()}
    farm.stop()
    return found


def wait_and(action, most):
    """Lets something end after a while."""
    timer = threading.Timer(chance.uniform(0.2, most), action)
    timer.daemon = True
    timer.start()


def fault(farm, disk):
    worker = chance.choice(farm.workers)
    kinds = ["kill coordinator", "kill worker", "kill worker", "stop worker", "stop coordinator", "cut", "stall"]
    kinds += ["fill disk"] if disk else []
    kinds += ["restart database"] if farm.database else []
    name = chance.choice(kinds)
    if name == "kill coordinator":
        farm.coordinator.kill()
        farm.coordinator.wait()
        time.sleep(chance.uniform(0, 3))
        farm.serve()
    elif name == "kill worker":
        worker.kill()
        worker.wait()
        farm.workers.remove(worker)
        farm.add_worker()
    elif name == "stop worker":
        worker.send_signal(signal.SIGSTOP)
        wait_and(lambda: worker.send_signal(signal.SIGCONT), 40)
    elif name == "stop coordinator":
        stopped = farm.coordinator
        stopped.send_signal(signal.SIGSTOP)
        time.sleep(chance.uniform(0.2, 20))
        stopped.send_signal(signal.SIGCONT)
    elif name == "cut":
        farm.proxy.cut(True)
        wait_and(lambda: farm.proxy.cut(False), 10)
    elif name == "stall":
        farm.proxy.is_stalled = True
        wait_and(lambda: setattr(farm.proxy, "is_stalled", False), 10)
    elif name == "fill disk":
        ballast = disk / "ballast"
        try:
            with open(ballast, "wb") as file:
                while True:
                    file.write(b"\0" * 4096)
                    file.flush()
        except OSError:
            pass
        wait_and(lambda: ballast.unlink(missing_ok=True), 15)
    elif name == "restart database":
        subprocess.run(os.environ["PHOTONFARM_TEST_POSTGRES_RESTART"], shell=True, check=True, stdout=subprocess.DEVNULL)
    counts[name] += 1


def act_as_user(farm, scene, accepted):
    """Submits, pauses, resumes and extends; what an answer does not come for is asked again by its name."""
    jobs = farm.jobs()
    for job in jobs:
        if job["id"] not in deleted:
            accepted.setdefault(job["id"], job["name"])
    if sum(job["state"] not in ("done", "failed", "cancelled") for job in jobs) < LIVE_JOBS:
        try:
            job = json.loads(farm.ask("POST", "/v1/jobs", request(chance.choice(KINDS), scene)))
            accepted[job["id"]] = job["name"]
        except OSError:
            # Accepted or not: the list of jobs tells next time.
            counts["submissions without an answer"] += 1
    running = [job for job in jobs if job["state"] == "running"]
    if running and chance.random() < 0.1:
        paused = chance.choice(running)["id"]
        farm.insist_quietly("POST", f"/v1/jobs/{paused}/pause")
        wait_and(lambda: farm.insist_quietly("POST", f"/v1/jobs/{paused}/resume"), 5)
        counts["paused by a user"] += 1
    short = [job for job in jobs if job["state"] == "done" and job["passes_done"] == kind_of(job)[1]]
    if short and chance.random() < 0.1:
        longer = chance.choice(short)
        farm.insist_quietly("POST", f"/v1/jobs/{longer['id']}/extend", {"passes": kind_of(longer)[2]})
        counts["extended by a user"] += 1


def is_same(picture, other):
    """Whether all pixels are the same: the header of a file names its job."""
    found = subprocess.run([options.program, "compare", picture, other, "--json"], capture_output=True, check=True)
    return json.loads(found.stdout)["rmse"] == 0


def kind_of(job):
    method, passes, longer = job["name"].split("-")
    return method, int(passes), int(longer)


def delete_old(farm, accepted, compared):
    """As users do who want room."""
    done = [job["id"] for job in farm.jobs() if job["state"] == "done" and (job["id"], (kind_of(job), job["passes_done"])) in compared]
    for job in done[:-KEPT_JOBS]:
        # Whether it is deleted or an answer is lost, it need not be there any more.
        accepted.pop(job, None)
        deleted.add(job)
        farm.insist_quietly("DELETE", f"/v1/jobs/{job}")
        counts["deleted by a user"] += 1


def check(farm, expected, compared):
    """Compares the picture of every job that is done with that of the quiet run."""
    for job in farm.jobs():
        key = (kind_of(job), job["passes_done"])
        if job["state"] == "done" and (job["id"], key) not in compared:
            try:
                found = farm.picture(job["id"])
            except urllib.error.HTTPError:
                # The coordinator was killed before it had stored the end: the last passes are traced again.
                counts["ends that were not stored yet"] += 1
                continue
            # It may have been extended while the picture came.
            if key in expected:
                compared[job["id"], key] = is_same(found, expected[key]) or is_same(found, expected[key[0], key[0][2]])
            found.unlink()


def mounted_disk(folder):
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES}", "tmpfs", folder]).returncode:
        say("no small file system: not root, or not allowed to mount")
        return None
    return folder


def percentile(share):
    return sorted(latencies)[int(share * (len(latencies) - 1))] * 1000 if latencies else 0


def main():
    farm, disk = None, None
    try:
        expected = quiet_pictures(TEMPORARY / "quiet")
        say(f"{len(expected)} pictures of a quiet run")
        small = TEMPORARY / "small"
        small.mkdir()
        disk = mounted_disk(small)
        database = os.environ["PHOTONFARM_TEST_POSTGRES"] if options.postgres else None
        farm = Farm(small / "data", options.workers, database)
        scene = upload(farm)
        accepted, compared = {}, {}
        latencies.clear()
        begin, next_fault = time.time(), 0
        while time.time() - begin < options.seconds:
            act_as_user(farm, scene, accepted)
            if time.time() >= next_fault:
                fault(farm, disk)
                next_fault = time.time() + chance.uniform(0.5, 8)
            check(farm, expected, compared)
            delete_old(farm, accepted, compared)
            time.sleep(0.3)
        say("no faults any more")
        time.sleep(41)
        patience = time.time() + 120
        while any(job["state"] != "done" for job in farm.jobs()) and time.time() < patience:
            for job in farm.jobs():
                if job["state"] == "paused":
                    counts["paused until a user resumed them"] += 1
                    say(f"job {job['id']} pauses: {job['paused']}")
                    farm.insist_quietly("POST", f"/v1/jobs/{job['id']}/resume")
            time.sleep(1)
        check(farm, expected, compared)
        jobs = {job["id"]: job for job in farm.jobs()}
        lost = [job for job in accepted if job not in jobs]
        open_jobs = [(job["id"], job["state"], job.get("error")) for job in jobs.values() if job["state"] != "done"]
        wrong = [key for key, is_right in compared.items() if not is_right]
        say(f"faults: {dict(counts)}")
        say(f"{len(jobs) + len(deleted)} jobs, {len(lost)} lost, {len(open_jobs)} not done {open_jobs}")
        say(f"{len(compared)} pictures compared with the quiet run, {len(wrong)} differ {wrong}")
        say(f"{len(latencies)} questions answered, p50 {percentile(0.5):.1f} ms, p99 {percentile(0.99):.0f} ms, faults included")
        bad = bool(lost or open_jobs or wrong or not compared)
        if bad:
            print(LOG.read_text()[-6000:])
        sys.exit(bad)
    finally:
        if farm:
            farm.stop()
        if disk:
            subprocess.run(["umount", "-l", disk])
        shutil.rmtree(TEMPORARY, ignore_errors=True)


main()
