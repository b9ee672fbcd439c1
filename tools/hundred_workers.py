"""A hundred worker processes on one machine: one time-out must not lead to others.

The coordinator is stopped for longer than leases live, and one worker for good. Only that one may be thought silent, and the picture must have
the bits of a quiet run. Takes about three minutes on two cores.

usage, in the project's root: python3 tools/hundred_workers.py [WORKERS] [PROGRAM]
"""
import json, pathlib, signal, socket, subprocess, sys, tempfile, time, urllib.request

workers = int(sys.argv[1]) if len(sys.argv) > 1 else 100
program = sys.argv[2] if len(sys.argv) > 2 else "target/release/photonfarm"
with socket.socket() as found:
    found.bind(("127.0.0.1", 0))
    url = f"http://127.0.0.1:{found.getsockname()[1]}"
start = time.time()


def say(text):
    print(f"{time.time() - start:4.0f} s  {text}", flush=True)


def ask(path, data=None, **headers):
    with urllib.request.urlopen(urllib.request.Request(url + path, data, headers), timeout=60) as answer:
        return answer.read()


def job(name):
    return json.loads(ask(f"/v1/jobs/{name}"))


def submit(passes):
    body = {"scene": scene, "method": "sppm", "stop": {"passes": passes}}
    return json.loads(ask("/v1/jobs", json.dumps(body).encode(), **{"Content-Type": "application/json"}))["id"]


def wait_for(condition):
    while not condition():
        time.sleep(0.2)


def picture(name):
    file = pathlib.Path(folder.name) / f"{name}.exr"
    file.write_bytes(ask(f"/v1/jobs/{name}/image.exr"))
    return file


def add_worker(name):
    return subprocess.Popen([program, "worker", "--coordinator", url, "--threads", "1", "--name", name], stderr=subprocess.DEVNULL)


folder = tempfile.TemporaryDirectory()
processes = []
try:
    coordinator = subprocess.Popen([program, "serve", "--listen", url[7:], "--data", "none"], stderr=subprocess.DEVNULL)
    processes.append(coordinator)
    time.sleep(1)
    text = pathlib.Path("scenes/cornell-diffuse/scene.xml").read_bytes()
    scene = json.loads(ask("/v1/scenes", text.replace(b'name="size" value="512"', b'name="size" value="128"')))["hash"]
    alone = add_worker("alone")
    quiet = submit(400)
    wait_for(lambda: job(quiet)["state"] == "done")
    alone.kill()
    say(f"400 passes by one worker took {job(quiet)['seconds']:.0f} s")
    crowd = [add_worker(f"w{index}") for index in range(workers)]
    processes += crowd
    wait_for(lambda: len(json.loads(ask("/v1/workers"))["workers"]) >= workers)
    say(f"{workers} workers are there")
    crowded = submit(400)
    wait_for(lambda: job(crowded)["passes_done"] > 50)
    say("SIGSTOP to one worker and, for 20 s, to the coordinator")
    crowd[0].send_signal(signal.SIGSTOP)
    coordinator.send_signal(signal.SIGSTOP)
    time.sleep(20)
    coordinator.send_signal(signal.SIGCONT)
    wait_for(lambda: job(crowded)["state"] == "done")
    say(f"400 passes by {workers} workers took {job(crowded)['seconds']:.0f} s")
    time.sleep(20)
    silent = [line["text"] for line in json.loads(ask("/v1/journal"))["lines"] if "silent" in line["text"]]
    silent = [line for line in silent if "alone" not in line]
    say(f"thought silent: {silent}")
    compared = subprocess.run([program, "compare", picture(crowded), picture(quiet), "--json"], capture_output=True, check=True)
    rmse = json.loads(compared.stdout)["rmse"]
    say("same bits" if rmse == 0 else f"DIFFERENT: rmse {rmse}")
    sys.exit(rmse != 0 or len(silent) != 1 or "w0 " not in silent[0])
finally:
    for process in processes:
        process.kill()
    folder.cleanup()
