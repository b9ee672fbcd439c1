"""A coordinator and workers of the program under test, and what the tests ask of them by REST."""

import io
import json
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-diffuse/scene.xml"


def launch_browser(playwright):
    """Debian's Chromium."""
    return playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def wait_until(holds, what, seconds=30):
    """Waits until `holds()` answers something true, and answers that."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = holds()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"after {seconds} s: {what}")


class Farm:
    """A coordinator that keeps everything in memory. It can be stopped and started again at the same address."""

    # Where it listens; it is called at 127.0.0.1.
    listen = "127.0.0.1"

    def __init__(self, program, *options):
        self.program = program
        self.options = options
        self.port = free_port()
        self.address = f"http://127.0.0.1:{self.port}"
        self.log = tempfile.TemporaryFile()
        self.workers = []
        self.token = None
        self.start()

    def start(self):
        command = [self.program, "serve", "--listen", f"{self.listen}:{self.port}", "--data", "none", *self.options]
        self.coordinator = subprocess.Popen(command, stderr=self.log)
        wait_until(self.is_ready, "the coordinator is not ready")

    def is_ready(self):
        try:
            return urllib.request.urlopen(self.address + "/readyz", timeout=2).status == 200
        except OSError:
            return False

    def start_worker(self):
        command = [self.program, "worker", "--coordinator", self.address, "--threads", "1"]
        self.workers.append(subprocess.Popen(command, stderr=self.log))

    def stop_coordinator(self):
        self.coordinator.kill()
        self.coordinator.wait()

    def stop_workers(self):
        for worker in self.workers:
            worker.kill()
            worker.wait()
        self.workers = []

    def stop(self):
        self.stop_workers()
        self.stop_coordinator()

    def ask(self, path, body=None, method=None):
        """An answer's JSON; bytes are sent as they are, everything else as JSON."""
        is_raw = isinstance(body, bytes)
        data = body if is_raw or body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/octet-stream" if is_raw else "application/json"}
        if self.token:
            headers["Authorization"] = f"Bearer {self.token}"
        request = urllib.request.Request(self.address + path, data, headers, method=method)
        with urllib.request.urlopen(request, timeout=30) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def bytes(self, path):
        with urllib.request.urlopen(self.address + path, timeout=30) as answer:
            return answer.read()

    def job(self, job):
        return self.ask(f"/v1/jobs/{job}")

    def submit(self, name, passes=4, size=64, method="sppm", scene=SCENE, **further):
        scene = self.ask("/v1/scenes", archive(scene) if scene.is_dir() else scene.read_bytes())["hash"]
        stop = further.pop("stop", {"passes": passes})
        job = {"scene": scene, "name": name, "method": method, "stop": stop, "scene_changes": {"width": size}, **further}
        return self.ask("/v1/jobs", job)["id"]

    def submit_paused(self, name, **further):
        """A job that pauses before its first pass, which takes far longer than the request."""
        job = self.submit(name, size=512, **further)
        self.ask(f"/v1/jobs/{job}/pause", {})
        assert self.job(job)["passes_done"] == 0
        return job

    def wait(self, job, state="done"):
        return wait_until(lambda: (self.job(job)["state"] == state) and self.job(job), f"job {job} is not {state}", 60)


def archive(folder):
    """A zip archive of what is in a folder."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as files:
        for path in folder.iterdir():
            files.write(path, path.name)
    return packed.getvalue()


class Hand:
    """A worker made by hand, which says what a real one would not. It speaks protobuf, of which it knows as much as it needs."""

    def __init__(self, farm, name):
        self.farm = farm
        self.secret = None
        build = farm.ask("/version")["build"]
        self.secret = fields(self.post("register", text(1, name) + b"\x10\x01" + text(3, build)))[3].decode()

    def fail(self, problem):
        """Takes some work and says that it cannot be done."""
        lease = fields(fields(self.post("lease", b""))[1])
        self.post(f"leases/{lease[1]}/{lease[2]}/result", text(3, problem))

    def post(self, path, body):
        headers = {"Authorization": f"Bearer {self.secret}"} if self.secret else {}
        request = urllib.request.Request(f"{self.farm.address}/farm/v1/{path}", body, headers, method="POST")
        with urllib.request.urlopen(request, timeout=30) as answer:
            return answer.read()


def text(number, value):
    """A field of up to 127 bytes."""
    return bytes([number << 3 | 2, len(value.encode())]) + value.encode()


def fields(message):
    """The fields of a message by their numbers: integers, and bytes."""
    found, at = {}, 0

    def integer():
        nonlocal at
        value = shift = 0
        while True:
            byte = message[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(message):
        key = integer()
        if key & 7 == 0:
            found[key >> 3] = integer()
        else:
            length = integer()
            found[key >> 3] = message[at:at + length]
            at += length
    return found
