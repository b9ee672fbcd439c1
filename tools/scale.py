"""How many workers one coordinator carries, and what more would. docs/measured/SCALE.md explains it.

usage, in the project's root:
  python3 tools/scale.py                      arithmetic and simulations, as they stand in docs/measured/SCALE.md
  python3 tools/scale.py arithmetic           the arithmetic alone
  python3 tools/scale.py validate             the simulator beside what was measured
  python3 tools/scale.py simulate KEY=VALUE … one simulation; the keys are those of FARM
  python3 tools/scale.py measure SCENE WIDTHxHEIGHT PASSES [WORKERS=N] [MEGABYTES=M] [OPTIONS OF submit …]
                                              what workers send a real coordinator, over a link of M MB/s; PHOTONFARM names the program

Plain Python 3; seeded: the same output every time, except for `measure`.
"""
import collections, heapq, json, math, os, random, re, socket, statistics, subprocess, sys, tempfile, threading, time
import urllib.request

# What was measured: docs/measured/SCALE.md, "What was measured".
METHODS = {  # bytes a pixel: planes of a tally, the same as sent, a radius field as sent; is the radius rule `statistics`?
    "sppm": dict(raw=32, sent=25.2, field=3.2, statistics=True),
    "path": dict(raw=12, sent=10.1, field=0.0, statistics=False),
}
SIZES = {"512 × 512": 512 * 512, "1080p": 1920 * 1080, "4K": 3840 * 2160}
GIGABIT = 125e6

FARM = dict(
    workers=100, threads=1,      # worker processes; rendering threads of each
    jobs=0,                      # running at the same time; 0: as many as keep all workers busy
    pixels=1920 * 1080, method="sppm",
    pass_seconds=3.0,            # of one core, for a pass of the whole picture
    photon_share=0.25,           # of it: what every region of a picture traces again
    passes=1,                    # of a full-grown shard
    regions=1, epoch=16,         # regions in which a picture is traced; shards of a region in an epoch
    mergers=1,                   # processes among which the rows of a picture are divided when tallies are delivered
    store=False,                 # tallies and radius fields go through an object store
    shared_fields=False,         # radius fields come from elsewhere than the mergers' links
    link=10 * GIGABIT, worker_link=1 * GIGABIT, store_link=100 * GIGABIT, store_delay=0.05,
    cores=8,                     # of a merger
    decode=0.55e9, merge=1.7e9,  # bytes of planes per second of one core; decoding includes receiving
    field_seconds=30e-9,         # of one core, a pixel: median and compression of a radius field
    mutex=10e-6,                 # seconds for which a lease or a result holds the rules
    round_trip=0.001,
    scene_bytes=0.0, prepare=0.0,  # of a job's own scene, when it is not the one that all jobs share
    affinity=True,               # a worker stays with the job that it worked on until that is two shards ahead
    deaths=0.0,                  # share of workers that die per minute
    prefetch=True,
    fresh=False,                 # nothing but one new job: when is its first picture there?
    newcomer=True,               # a job is submitted when the others have warmed up
    seconds=0.0,                 # simulated and counted after warming up; 0: ten shards or more
    seed=1,
)
LEASES, SLOTS, FIELDS, SCENES = 3, 2, 6, 2   # of a worker: leases, deliveries, radius fields and scenes that it keeps
SCHEDULE_WINDOW = 64             # shards of a job without `statistics` that may be under way
CREDIT = 1.0                     # passes that a job may catch up
SHARDS_AHEAD = 2                 # by which the job that a worker stays with may be ahead
EXPIRY, REPLACED = 15.0, 30.0    # seconds until a dead worker's leases expire, and until another one stands in its place


class Queue:
    """Servers that take one thing after the other."""

    def __init__(self, servers=1):
        self.free, self.busy = [0.0] * servers, 0.0

    def take(self, now, seconds):
        start = max(now, heapq.heappop(self.free))
        heapq.heappush(self.free, start + seconds)
        self.busy += seconds
        return start + seconds


class Job:
    def __init__(self, farm, number, growing):
        self.farm, self.number, self.growing = farm, number, growing
        self.next = self.merged = self.turn = 0
        self.arrived, self.returned, self.out = set(), [], {}
        self.done, self.is_merging = {}, False
        self.lock, self.served, self.typical, self.first, self.has_pilot = 0.0, 0.0, None, None, not growing

    def epoch(self, index):
        return index // (self.farm.p["epoch"] * self.farm.p["regions"])

    def passes(self, index):
        most = self.farm.p["passes"]
        return min(most, 2 ** min(30, self.epoch(index))) if self.growing else most

    def may_issue(self):
        if not self.has_pilot:
            return not self.out
        if self.returned:
            return True
        p = self.farm.p
        if METHODS[p["method"]]["statistics"]:
            return self.merged >= (self.epoch(self.next) - 1) * p["epoch"] * p["regions"]
        return self.merged >= self.next + 1 - SCHEDULE_WINDOW


class Worker:
    def __init__(self):
        self.life = 0
        self.begin()

    def begin(self):
        self.held, self.ready, self.tracing, self.blocked, self.asking, self.delivering = set(), None, None, None, False, 0
        self.up = self.down = 0.0
        self.fields, self.scenes, self.last, self.is_up = collections.OrderedDict(), collections.OrderedDict(), None, True


class Farm:
    """One representative merger stands for all of them: rows are shared out evenly, so all have the same to do at the same time."""

    def __init__(self, **given):
        self.p = p = dict(FARM, **given)
        self.random = random.Random(p["seed"])
        method = METHODS[p["method"]]
        pixels = p["pixels"] / p["regions"]
        self.sent, self.raw, self.field = (method[key] * pixels for key in ("sent", "raw", "field"))
        self.core_pass = p["pass_seconds"] * (p["photon_share"] + (1 - p["photon_share"]) / p["regions"])
        self.shard = self.core_pass * p["passes"] / p["threads"]
        in_flight = 1.5 * p["epoch"] * p["regions"] if method["statistics"] else SCHEDULE_WINDOW
        jobs = p["jobs"] or math.ceil(p["workers"] * LEASES / in_flight)
        self.link_in, self.link_out, self.store_in, self.store_out, self.rules = (Queue() for _ in range(5))
        self.cores = Queue(p["cores"])
        jobs = 0 if p["fresh"] else jobs
        self.jobs = [Job(self, number, False) for number in range(jobs)]
        self.workers = [Worker() for _ in range(p["workers"])]
        self.events, self.count, self.now = [], 0, 0.0
        self.open = [(0.0, number) for number in range(jobs)]
        self.is_open = set(range(jobs))
        self.idle = collections.OrderedDict()
        # Until all that workers may hold has piled up where it is slowest.
        slowest = max(self.sent / p["link"], self.raw * (2 / p["decode"] + 1 / p["merge"]) / p["cores"]) / p["mergers"]
        fill = LEASES * p["workers"] * slowest
        self.warm = 0.0 if p["fresh"] else max(10.0, 8 * self.shard, 1.5 * fill)
        self.end = self.warm + (p["seconds"] or max(10.0, 10 * self.shard, fill / 3))
        self.traced = self.wasted = self.useful = 0.0
        self.served, self.turn = 0.0, 0.0
        self.waits, self.results, self.leases, self.herd = [], 0, 0, 0
        self.bytes_in = self.bytes_out = 0.0

    def at(self, time, action, *arguments):
        self.count += 1
        heapq.heappush(self.events, (time, self.count, action, arguments))

    def run(self):
        p = self.p
        for number, worker in enumerate(self.workers):
            self.at(self.random.random() * self.shard, self.ask, worker, worker.life)
        self.at(0.5, self.poll)
        if p["newcomer"]:
            self.at(self.warm, self.newcomer)
        self.at(self.warm, self.mark)
        if self.p["deaths"]:
            self.at(self.next_death(), self.death)
        patience = self.end + 20 * max(self.shard, 5.0)
        is_missing = lambda: self.p["newcomer"] and self.jobs[-1].first is None
        while self.events[0][0] <= self.end or is_missing() and self.events[0][0] <= patience:
            self.now, _, action, arguments = heapq.heappop(self.events)
            action(*arguments)
        return self.figures()

    def mark(self):
        self.marked = [queue.busy for queue in (self.cores, self.rules)]
        self.at(self.end, self.stop)

    def stop(self):
        self.traced += sum(self.counted(worker.tracing[2], self.end) for worker in self.workers if worker.is_up and worker.tracing)
        self.busy = [queue.busy - before for queue, before in zip((self.cores, self.rules), self.marked)]

    def counts(self):
        return self.warm <= self.now <= self.end

    def counted(self, start, end):
        """Seconds of this span that are counted."""
        return max(0.0, min(end, self.end) - max(start, self.warm))

    # Leases.

    def newcomer(self):
        """Somebody submits a job: when is its first picture there?"""
        job = Job(self, len(self.jobs), True)
        job.served = self.served - CREDIT
        self.jobs.append(job)
        self.offer(job)

    def offer(self, job):
        """Work may have appeared: all that wait ask again, and hold the rules one after the other."""
        if job.number in self.is_open or not job.may_issue():
            return
        self.is_open.add(job.number)
        heapq.heappush(self.open, (job.served, job.number))
        self.herd += len(self.idle) * self.counts()
        self.rules.take(self.now, self.p["mutex"] * len(self.idle))
        while self.idle:
            worker = next(iter(self.idle))
            job = self.choose(worker)
            if job is None:
                return
            del self.idle[worker]
            self.give(job, worker)

    def choose(self, worker):
        turn = self.whose_turn()
        self.turn = turn.served if turn else self.served
        if turn is None or not self.p["affinity"] or worker.last is None or len(self.jobs) <= SCENES:
            return turn
        last = self.jobs[worker.last]
        return last if last.may_issue() and last.served <= turn.served + SHARDS_AHEAD * self.p["passes"] else turn

    def whose_turn(self):
        while self.open:
            served, number = self.open[0]
            job = self.jobs[number]
            if served != job.served:
                heapq.heapreplace(self.open, (job.served, number))
                continue
            if job.may_issue():
                return job
            heapq.heappop(self.open)
            self.is_open.discard(number)
        return None

    def ask(self, worker, life):
        if worker.life != life or not worker.is_up or worker.asking or worker.ready is not None or len(worker.held) >= LEASES:
            return
        if not self.p["prefetch"] and worker.held:
            return
        worker.asking = True
        granted = self.rules.take(self.now + self.p["round_trip"] / 2, self.p["mutex"])
        self.at(granted, self.grant, worker, life)

    def grant(self, worker, life):
        if worker.life != life:
            return
        job = self.choose(worker)
        if job is None:
            self.idle[worker] = self.now
            return
        self.give(job, worker)

    def give(self, job, worker):
        index = heapq.heappop(job.returned) if job.returned else job.next
        if job.has_pilot and index == job.next:
            job.next += 1
        self.issue(job, index, worker)

    def issue(self, job, index, worker):
        self.leases += self.counts()
        # Fair shares: a job that could not take its share catches up a little at most.
        served = max(job.served, self.served - CREDIT)
        self.served = max(self.served, min(served, self.turn))
        job.served = served + job.passes(index)
        job.out.setdefault(index, []).append((self.now, worker))
        worker.held.add((job.number, index))
        worker.last = job.number
        self.at(self.fetch(job, index, worker), self.prepared, job, index, worker, worker.life)

    def fetch(self, job, index, worker):
        """What the shard needs and the worker lacks."""
        p, ready = self.p, self.now + self.p["round_trip"] / 2
        if p["scene_bytes"] and not self.keeps(worker.scenes, job.number, SCENES):
            ready = self.load(worker, p["scene_bytes"], ready, False)
        if self.field and job.has_pilot and not self.keeps(worker.fields, (job.number, job.epoch(index), index // p["epoch"] % p["regions"]), FIELDS):
            ready = self.load(worker, self.field, ready, p["store"] or p["shared_fields"])
        return ready

    @staticmethod
    def keeps(cache, key, most):
        if key in cache:
            cache.move_to_end(key)
            return True
        cache[key] = True
        if len(cache) > most:
            cache.popitem(last=False)
        return False

    def load(self, worker, size, now, elsewhere):
        p = self.p
        if elsewhere:
            sent = self.store_out.take(now, size / p["store_link"]) + p["store_delay"]
        else:
            self.bytes_out += size / p["mergers"] * self.counts()
            sent = self.link_out.take(now, size / p["mergers"] / p["link"])
        worker.down = max(now, worker.down) + size / p["worker_link"]
        return max(sent, worker.down)

    # Tracing.

    def prepared(self, job, index, worker, life):
        if worker.life == life:
            worker.asking, worker.ready = False, (job, index)
            self.trace(worker)

    def trace(self, worker):
        if worker.tracing is not None or worker.blocked is not None or worker.ready is None:
            return
        (job, index), worker.ready = worker.ready, None
        passes = 3 * self.p["regions"] if not job.has_pilot else job.passes(index)
        seconds = self.core_pass * passes / self.p["threads"] * self.random.uniform(0.9, 1.1)
        prepare = self.p["prepare"] if self.p["scene_bytes"] and worker.scenes.get(job.number) is True else 0.0
        if prepare:
            worker.scenes[job.number] = "prepared"
        worker.tracing = (job, index, self.now)
        self.at(self.now + seconds + prepare, self.finish, worker, worker.life, seconds)
        self.ask(worker, worker.life)

    def finish(self, worker, life, seconds):
        if worker.life != life:
            return
        job, index, _ = worker.tracing
        worker.tracing = None
        if self.now <= self.end:
            self.traced += self.counted(self.now - seconds, self.now)
        worker.blocked = (job, index, self.now)
        self.deliver(worker)

    def deliver(self, worker):
        if worker.blocked is None or worker.delivering >= SLOTS:
            return
        (job, index, done), worker.blocked = worker.blocked, None
        worker.delivering += 1
        size = self.sent if job.has_pilot else self.field
        start = max(self.now, worker.up)
        worker.up = start + size / self.p["worker_link"]
        self.at(start, self.send, job, index, worker, worker.life, done, size)
        self.trace(worker)
        self.ask(worker, worker.life)

    def send(self, job, index, worker, life, done, size):
        p, least = self.p, self.now + size / self.p["worker_link"]
        if p["store"]:
            put = max(least, self.store_in.take(self.now, size / p["store_link"])) + p["store_delay"]
            self.at(put, self.stored, job, index, worker, life, done, size)
        else:
            came = max(least, self.link_in.take(self.now, size / p["mergers"] / p["link"]))
            self.at(came + p["round_trip"] / 2, self.came, job, index, worker, life, done)

    def stored(self, job, index, worker, life, done, size):
        """The worker is free; the merger reads when it can."""
        p = self.p
        if worker.life == life and job.has_pilot and job.out.pop(index, None) is None:
            self.wasted += self.shard * self.counts()
            self.answered(job, index, worker, life)
            return
        self.answered(job, index, worker, life)
        got = self.link_in.take(self.now, size / p["mergers"] / p["link"])
        self.at(max(got, self.store_out.take(self.now, size / p["store_link"])) + p["store_delay"], self.came, job, index, None, 0, done)

    # Merging.

    def came(self, job, index, worker, life, done):
        p = self.p
        self.bytes_in += self.sent / p["mergers"] * self.counts()
        decoded = self.cores.take(self.now, self.raw / p["mergers"] / p["decode"])
        taken = self.rules.take(decoded, p["mutex"])
        self.at(taken, self.take, job, index, worker, life, done)

    def take(self, job, index, worker, life, done):
        if worker is not None and worker.life != life:
            return  # It died before it had sent everything.
        self.results += self.counts()
        p = self.p
        if not job.has_pilot:
            job.has_pilot = True
            job.out.clear()
            if worker is not None:
                self.answered(job, index, worker, life)
            self.offer(job)
            return
        leases = job.out.pop(index, None)
        if leases is None and (index < job.merged or index in job.arrived or index in job.returned and not self.unreturn(job, index)):
            self.wasted += self.shard * self.counts()
            if worker is not None:
                self.answered(job, index, worker, life)
            return
        if leases:
            took = (self.now - leases[0][0]) / job.passes(index)
            job.typical = took if job.typical is None else job.typical + 0.1 * (took - job.typical)
        job.arrived.add(index)
        job.done[index] = done
        if self.counts():
            self.useful += job.passes(index)
        if job.turn == index and not job.is_merging:
            self.fold(job)
        if worker is not None:
            self.at(max(self.now, job.lock) + p["round_trip"] / 2, self.answered, job, index, worker, life)

    def fold(self, job):
        """Merges all that is in turn, under the job's lock."""
        p, seconds = self.p, 0.0
        while job.turn in job.arrived:
            seconds += self.raw / p["mergers"] / p["merge"]
            job.arrived.discard(job.turn)
            job.turn += 1
            if job.turn % (p["epoch"] * p["regions"]) == 0 and self.field:
                seconds += p["field_seconds"] * p["pixels"] / p["mergers"]
        job.lock, job.is_merging = self.cores.take(self.now, seconds), True
        self.at(job.lock, self.merged, job, job.turn)

    @staticmethod
    def unreturn(job, index):
        job.returned.remove(index)
        heapq.heapify(job.returned)
        return True

    def merged(self, job, turn):
        for index in range(job.merged, turn):
            done = job.done.pop(index)
            if self.counts():
                self.waits.append(self.now - done)
        job.merged = max(job.merged, turn)
        if job.first is None and job.growing and job.merged > (self.p["regions"] - 1) * self.p["epoch"]:
            job.first = self.now - self.warm
        job.is_merging = False
        if job.turn in job.arrived:
            self.fold(job)
        self.offer(job)

    def answered(self, job, index, worker, life):
        if worker.life != life:
            return
        worker.delivering -= 1
        worker.held.discard((job.number, index))
        self.deliver(worker)
        self.ask(worker, life)

    # Idle workers.

    def poll(self):
        """Waiting workers ask twice a second; they may be given what others hold for too long."""
        self.rules.take(self.now, self.p["mutex"] * len(self.idle))
        if self.idle and self.p["deaths"]:  # Without deaths nothing is lost: what takes long waits in a queue.
            self.give_overdue()
        self.at(self.now + 0.5, self.poll)

    def give_overdue(self):
        for job in self.jobs:
            if job.typical is None:
                continue
            for index, leases in list(job.out.items()):
                if not self.idle:
                    return
                worker = next(iter(self.idle))
                factor = 6 if worker.held else 2
                age = self.now - leases[0][0]
                if len(leases) == 1 and age > max(0.5, factor * job.typical * job.passes(index)) and leases[0][1] is not worker:
                    del self.idle[worker]
                    self.issue(job, index, worker)

    # Deaths.

    def next_death(self):
        return self.now + self.random.expovariate(self.p["workers"] * self.p["deaths"] / 60)

    def death(self):
        worker = self.random.choice([worker for worker in self.workers if worker.is_up])
        worker.life += 1
        worker.is_up = False
        if worker.tracing is not None:
            self.traced += self.counted(worker.tracing[2], self.now) * (self.now <= self.end)
            self.wasted += self.counted(worker.tracing[2], self.now)
        self.idle.pop(worker, None)
        self.at(self.now + EXPIRY * self.random.uniform(2 / 3, 1), self.expire, worker, set(worker.held))
        self.at(self.now + REPLACED, self.replace, worker)
        self.at(self.next_death(), self.death)

    def expire(self, worker, held):
        for number, index in held:
            job = self.jobs[number]
            left = [lease for lease in job.out.get(index, []) if lease[1] is not worker]
            if index in job.out and not left:
                del job.out[index]
                if job.has_pilot:
                    heapq.heappush(job.returned, index)
            elif left:
                job.out[index] = left
            self.offer(job)

    def replace(self, worker):
        worker.begin()
        self.ask(worker, worker.life)

    def figures(self):
        p, span = self.p, self.end - self.warm
        last = self.jobs[-1] if p["newcomer"] else None
        waited = sorted(self.waits) or [float("nan")]
        return dict(
            jobs=len(self.jobs) - p["newcomer"], shard=self.shard,
            busy=self.traced / (p["workers"] * span),
            efficiency=self.useful / p["regions"] * p["pass_seconds"] / p["threads"] / (p["workers"] * span),
            link_in=self.bytes_in / span, link_out=self.bytes_out / span,
            cores=self.busy[0] / span / p["cores"], rules=self.busy[1] / span,
            wait=waited[len(waited) // 2], late=waited[len(waited) * 95 // 100], herd=self.herd / span,
            leases=self.leases / span, results=self.results / span,
            wasted=self.wasted / (p["workers"] * span), first=last and last.first)


# Measurements.

class Link:
    """A proxy in front of a coordinator: notes every request, and lets workers send so many bytes a second together."""

    def __init__(self, port, rate=None):
        self.port, self.rate, self.seen, self.free, self.lock = port, rate, [], 0.0, threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            client, _ = self.listener.accept()
            threading.Thread(target=self.carry, args=(client,), daemon=True).start()

    def carry(self, client):
        server = socket.create_connection(("127.0.0.1", self.port))
        up, down = client.makefile("rb"), server.makefile("rb")
        try:
            while request := self.pass_on(up, server, self.rate):
                start = time.monotonic()
                if not (answer := self.pass_on(down, client, None)):
                    return
                self.seen.append((request[0], request[1], answer[1], start, time.monotonic()))
        except OSError:
            pass
        finally:
            client.close()
            server.close()

    def pass_on(self, source, sink, rate):
        lines = [source.readline()]
        if not lines[0]:
            return None
        left = length = 0
        while (line := source.readline()) not in (b"\r\n", b""):
            lines.append(line)
            if line.lower().startswith(b"content-length:"):
                left = length = int(line.split(b":")[1])
        sink.sendall(b"".join(lines) + b"\r\n")
        while left:
            piece = source.read(min(left, 1 << 16))
            if not piece:
                return None
            if rate:
                with self.lock:
                    self.free = max(self.free, time.monotonic()) + len(piece) / rate
                    pause = self.free - time.monotonic()
                time.sleep(max(0.0, pause))
            sink.sendall(piece)
            left -= len(piece)
        return lines[0].decode(), length


def processor_seconds(process):
    with open(f"/proc/{process.pid}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(scene, size, passes, *options):
    program = os.environ.get("PHOTONFARM", "target/release/photonfarm")
    settings = dict(option.split("=") for option in options if re.match(r"(WORKERS|MEGABYTES)=", option))
    options = [option for option in options if option.split("=")[0] not in settings]
    count, rate = int(settings.get("WORKERS", 1)), float(settings.get("MEGABYTES", 0)) * 1e6
    with open(scene) as file:
        text = file.read()
    for name, value in zip(("width", "height"), size.split("x")):
        text = re.sub(f'name="{name}" value="[^"]*"', f'name="{name}" value="{value}"', text)
    with socket.socket() as place, tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(text)
        file.flush()
        place.bind(("127.0.0.1", 0))
        port = place.getsockname()[1]
        place.close()
        start = lambda *arguments: subprocess.Popen([program, *arguments], stderr=subprocess.DEVNULL)
        processes = [start("serve", "--listen", f"127.0.0.1:{port}", "--data", "none", "--check-share", "0")]
        time.sleep(1)
        link, url = Link(port, rate), f"http://127.0.0.1:{port}"
        try:
            processes += [start("worker", "--coordinator", link.url, "--threads", "1", "--name", f"w{n}") for n in range(count)]
            command = [program, "submit", file.name, "--passes", passes, *options, "--coordinator", url]
            job = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
            while json.load(urllib.request.urlopen(f"{url}/v1/jobs/{job}"))["state"] not in ("done", "failed", "paused"):
                time.sleep(0.2)
            spent = [processor_seconds(process) for process in processes]
        finally:
            for process in processes[::-1]:
                process.kill()
                process.wait()
    pixels = math.prod(map(int, size.split("x")))
    results = sorted((seen for seen in link.seen if "/result" in seen[0]), key=lambda seen: seen[4])
    tallies, fields = results[1:], [seen for seen in link.seen if "/radius/" in seen[0]]
    later = tallies[len(tallies) // 3:]
    print(f"{size}, {passes} passes {' '.join(options)}, {count} workers, link {rate / 1e6 or 'not limited'}")
    print(f"  {len(tallies)} tallies, median {statistics.median(seen[1] for seen in tallies) / 1e6:.2f} MB, "
          f"{statistics.median(seen[1] for seen in tallies) / pixels:.2f} B a pixel; first {tallies[0][1] / 1e6:.2f}, last {tallies[-1][1] / 1e6:.2f} MB")
    print(f"  radius fields {len(fields)}, {statistics.median([seen[2] for seen in fields] or [0]) / pixels:.2f} B a pixel; "
          f"pilot {results[0][1] / 1e6:.2f} MB; scene {[seen[2] for seen in link.seen if '/scenes/' in seen[0]]} B; "
          f"lease answer {[seen[2] for seen in link.seen if '/lease ' in seen[0]][2:3]} B")
    print(f"  tallies a second in the last two thirds: {(len(later) - 1) / (later[-1][4] - later[0][4]):.3f}; "
          f"delivery, median {statistics.median(seen[4] - seen[3] for seen in tallies):.3f} s")
    print(f"  processor seconds: coordinator {spent[0]:.2f} ({spent[0] / len(tallies):.3f} a tally), workers {sum(spent[1:]) / int(passes):.3f} a pass")


# Tables.

# Passes of a full-grown shard as `plan.rs` chooses them, and seconds of one core for a pass, both as measured.
CUTS = {"512 × 512": dict(passes=4, pass_seconds=0.36, regions=1), "1080p": dict(passes=1, pass_seconds=3.0, regions=1),
        "4K": dict(passes=1, pass_seconds=10.5, regions=2)}


def table(head, rows):
    print("\n| " + " | ".join(head) + " |\n|" + "---|" + "---:|" * (len(head) - 1))
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |", flush=True)


def sized(name, **given):
    return dict(CUTS[name], pixels=SIZES[name], **given)


def number(value):
    return f"{value:,.0f}" if value >= 10 else f"{value:.1f}"


def arithmetic():
    """The formulas of docs/measured/SCALE.md."""
    rows = []
    for name, pixels in SIZES.items():
        for method, bytes_of in METHODS.items():
            farm = dict(FARM, **sized(name))
            share = farm["photon_share"] + (1 - farm["photon_share"]) / farm["regions"]
            shard = farm["passes"] * farm["pass_seconds"] * share
            raw, sent, field = (bytes_of[key] * pixels / farm["regions"] for key in ("raw", "sent", "field"))
            work = raw / farm["decode"] + raw / farm["merge"]
            window = 24 * farm["regions"] if bytes_of["statistics"] else SCHEDULE_WINDOW
            rows.append([f"{name}, `{method}`", farm["passes"], f"{shard:.1f}", f"{raw / 1e6:.1f}", f"{sent / 1e6:.1f}", f"{field / 1e6:.1f}",
                         *(number(gigabits * GIGABIT * shard / sent) for gigabits in (1, 10, 25)),
                         number(shard / work), number(shard * farm["merge"] / raw), number(window / LEASES) + "–" + number(window),
                         number(shard / (2 * farm["mutex"]))])
    table(["picture, method", "passes a shard", "core-seconds a shard", "tally, MB", "sent, MB", "field, MB", "1 Gbit/s", "10 Gbit/s", "25 Gbit/s",
           "one core decodes and merges", "lock of one job", "window of one job", "mutex"], rows)


COLUMNS = ["", "workers", "jobs", "tracing", "efficiency", "in, MB/s", "out, MB/s", "cores", "merged after, median", "95 %", "first picture, s",
           "wasted, 1 % die a minute", "efficiency then"]


def simulated(name, deaths=True, **given):
    is_alone = given.get("jobs") == 1
    figures = Farm(**given, newcomer=not is_alone).run()
    if is_alone:
        figures["first"] = Farm(**given, fresh=True).run()["first"]
    percent = lambda value: f"{100 * value:.0f} %"
    first = "–" if figures["first"] is None else f"{figures['first']:.1f}"
    row = [name, f"{given['workers']:,}", figures["jobs"], percent(figures["busy"]), percent(figures["efficiency"]), number(figures["link_in"] / 1e6),
           number(figures["link_out"] / 1e6), percent(min(1.0, figures["cores"])), f"{figures['wait']:.1f}", f"{figures['late']:.1f}", first]
    if deaths:
        shard = Farm(**given).shard
        troubled = Farm(newcomer=False, **dict(given, deaths=0.01, seconds=max(60.0, 10 * shard))).run()
        row += [f"{100 * troubled['wasted']:.1f} %", percent(troubled["efficiency"])]
    return row


DESIGNS = [("one coordinator", {}), ("8 passes a shard", dict(passes=8)), ("32 passes a shard", dict(passes=32)), ("4 mergers", dict(mergers=4)),
           ("16 mergers", dict(mergers=16)), ("through the store", dict(store=True)), ("16 mergers through the store", dict(mergers=16, store=True)),
           ("8 passes, 4 mergers", dict(passes=8, mergers=4)), ("8 passes, 16 mergers", dict(passes=8, mergers=16))]
LARGEST = [("32 passes a shard", dict(passes=32)), ("64 mergers", dict(mergers=64)), ("192 mergers", dict(mergers=192)),
           ("8 passes, 16 mergers", dict(passes=8, mergers=16)), ("8 passes, 32 mergers", dict(passes=8, mergers=32)),
           ("32 passes, 8 mergers", dict(passes=32, mergers=8))]
MACHINES = [("one coordinator", {}), ("8 passes a shard", dict(passes=8)), ("32 passes a shard", dict(passes=32)),
            ("8 passes, 4 mergers", dict(passes=8, mergers=4)), ("32 passes, 4 mergers", dict(passes=32, mergers=4)),
            ("32 passes, 16 mergers", dict(passes=32, mergers=16))]


def simulations():
    print("\n1080p, `sppm`, one thread a worker, as many jobs as keep all workers busy.")
    table(COLUMNS, [simulated("one coordinator", workers=10)] + [simulated(name, workers=count, **design) for count in (100, 1000) for name, design in DESIGNS])
    table(COLUMNS[:-2], [simulated(name, False, workers=10000, **design) for name, design in LARGEST])
    print("\nThe same, 16 threads a worker.")
    table(COLUMNS[:-2], [simulated(name, False, workers=count, threads=16, **design) for count in (10, 100, 1000) for name, design in MACHINES])
    print("\nOne 1080p job of `sppm`, 32 mergers, one thread a worker: shards of a region in an epoch, and regions.")
    table(COLUMNS[:-2], [simulated(f"{epoch} shards, {regions} × region, {passes} × pass", False, workers=count, jobs=1, mergers=32, epoch=epoch,
                                   regions=regions, passes=passes)
                    for count, cuts in ((10, [(16, 1, 1)]), (32, [(16, 1, 1)]), (100, [(16, 1, 1), (16, 1, 8), (64, 1, 1), (128, 1, 1), (16, 8, 1)]),
                                        (1000, [(16, 1, 1), (1024, 1, 1), (1024, 1, 8)]))
                    for epoch, regions, passes in cuts])
    print("\n1,000 workers of one thread, other pictures and links.")
    table(COLUMNS[:-2], [simulated(f"{name}, `{method}`, {mergers} × merger, {link} Gbit/s", False, workers=1000, method=method, mergers=mergers, link=link * GIGABIT, **sized(name))
                    for name in SIZES for method in METHODS for mergers, link in ((1, 10), (1, 25), (16, 10))])
    print("\n1,000 workers of one thread, 16 mergers, 1080p `sppm`: every job with a scene of its own.")
    scenes = [("20 MB, 0.5 s to prepare", dict(scene_bytes=20e6, prepare=0.5)), ("200 MB, 5 s to prepare", dict(scene_bytes=200e6, prepare=5.0))]
    table(COLUMNS[:-2], [simulated(f"{name}{'' if affinity else ', the job whose turn it is'}", False, workers=1000, mergers=16, affinity=affinity, **scene)
                    for name, scene in scenes for affinity in (False, True)])
    print("\n10,000 workers of one thread, pictures of 512 × 512: what the leader alone has to do.")
    for microseconds in (10, 30):
        figures = Farm(workers=10000, mergers=64, mutex=microseconds * 1e-6, **sized("512 × 512")).run()
        print(f"  mutex held {microseconds} µs: {figures['leases']:,.0f} leases/s, mutex {100 * figures['rules']:.0f} % held, efficiency {100 * figures['efficiency']:.0f} %")


def validate():
    print("Rates as the simulator has them, beside what was measured (docs/measured/SCALE.md).")
    empty = dict(pixels=64 * 64, method="path", pass_seconds=2.0, passes=1, prefetch=False, newcomer=False, seconds=40.0)
    for name, given in (("farm_load 500 100: results/s", dict(workers=500, jobs=100)), ("farm_load 200 1: results/s", dict(workers=200, jobs=1))):
        print(f"  {name}: {Farm(**empty, **given).run()['results']:.1f}")
    for workers, megabytes in VALIDATED:
        given = dict(workers=workers, jobs=1, pixels=512 * 512, pass_seconds=0.40, passes=2, link=megabytes * 1e6, worker_link=1e9, cores=2, newcomer=False, seconds=60.0)
        print(f"  {workers} workers, 512 × 512 `sppm`, link of {megabytes} MB/s: tallies/s {Farm(**given).run()['results']:.2f}")


VALIDATED = [(1, 1000), (2, 1000), (2, 8), (2, 4)]  # Workers, MB/s


def show(**given):
    figures = Farm(**given).run()
    print(json.dumps({key: round(value, 4) if isinstance(value, float) else value for key, value in figures.items()}))


if __name__ == "__main__":
    command = sys.argv[1] if len(sys.argv) > 1 else "all"
    if command == "simulate":
        given = dict(argument.split("=", 1) for argument in sys.argv[2:])
        show(**{key: (value if isinstance(FARM[key], str) else type(FARM[key])(float(value))) for key, value in given.items()})
    elif command == "measure":
        measure(*sys.argv[2:])
    elif command in ("all", "arithmetic", "validate"):
        if command in ("all", "arithmetic"):
            arithmetic()
        if command in ("all", "validate"):
            validate()
        if command == "all":
            simulations()
    else:
        sys.exit(__doc__)
