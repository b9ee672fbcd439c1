"""What a farm of one worker spends beside tracing: processor time of its threads, in memory and durable. Linux only; takes as long as two jobs.

usage, in the project's root: python3 tools/time_by_thread.py SCENE PASSES [OPTIONS OF submit …]
"""
import glob, json, os, shutil, signal, socket, subprocess, sys, tempfile, time, urllib.request

program = "target/release/photonfarm"
ticks = os.sysconf("SC_CLK_TCK")


def threads(process):
    """Seconds of each thread, by number and name."""
    found = {}
    for path in glob.glob(f"/proc/{process.pid}/task/*/stat"):
        try:
            with open(path) as file:
                text = file.read()
        except OSError:
            continue
        name, fields = text[text.index("(") + 1:text.rindex(")")], text[text.rindex(")") + 2:].split()
        found[path, name] = (int(fields[11]) + int(fields[12])) / ticks
    return found


def run(data):
    with socket.socket() as place:
        place.bind(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{place.getsockname()[1]}"
    process = subprocess.Popen(
        [program, "serve", "--listen", url[7:], "--workers", "1", "--threads", "1", "--data", data],
        stderr=subprocess.DEVNULL)
    time.sleep(1)
    submit = [program, "submit", sys.argv[1], "--passes", sys.argv[2], *sys.argv[3:], "--coordinator", url]
    job = subprocess.run(submit, capture_output=True, text=True, check=True).stdout.strip()
    # Threads that end take their time with them: it is looked at often.
    seen, status = {}, {}
    while status.get("state") != "done":
        seen.update(threads(process))
        status = json.load(urllib.request.urlopen(f"{url}/v1/jobs/{job}"))
        time.sleep(1)
    seen.update(threads(process))
    process.send_signal(signal.SIGINT)
    process.wait()
    tracing = sum(seconds for (_, name), seconds in seen.items() if name.startswith("render-"))
    rest = sum(seen.values()) - tracing
    print(f"{'in memory' if data == 'none' else 'durable'}: {status['picture_version']} shards of {tracing / status['picture_version']:.2f} s, "
          f"tracing {tracing:.2f} s, all else {rest:.2f} s, {100 * rest / tracing:.1f} %", flush=True)


run("none")
folder = tempfile.mkdtemp()
run(folder)
shutil.rmtree(folder)
