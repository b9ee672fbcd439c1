"""How long a coordinator takes to start on a store with many ended jobs, and what memory they cost. Takes seconds.

usage, in the project's root: python3 tools/restart_time.py [JOBS] [PROGRAM]
"""
import pathlib, shutil, socket, sqlite3, subprocess, sys, tempfile, time, urllib.request

jobs = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
program = sys.argv[2] if len(sys.argv) > 2 else "target/release/photonfarm"


def start(folder):
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port = found.getsockname()[1]
    begin = time.time()
    process = subprocess.Popen(
        [program, "serve", "--listen", f"127.0.0.1:{port}", "--data", str(folder)], stderr=subprocess.DEVNULL)
    while True:
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/healthz").read()
            break
        except OSError:
            time.sleep(0.01)
    seconds = time.time() - begin
    begin = time.time()
    listed = len(urllib.request.urlopen(f"http://127.0.0.1:{port}/v1/jobs").read())
    listing = time.time() - begin
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    memory = int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1]) / 1024
    process.terminate()
    process.wait()
    return seconds, memory, listing, listed


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    shutil.copy("tests/stores/released/version-1.sqlite", folder / "photonfarm.sqlite")
    for count in (1, jobs):
        base = sqlite3.connect(folder / "photonfarm.sqlite")
        row = list(base.execute("SELECT * FROM jobs ORDER BY id LIMIT 1").fetchone())
        known = base.execute("SELECT COUNT(*) FROM jobs").fetchone()[0]
        rows = [[row[0] + index, *row[1:]] for index in range(known, count)]
        base.executemany(f"INSERT INTO jobs VALUES ({','.join('?' * len(row))})", rows)
        base.commit()
        base.close()
        seconds, memory, listing, listed = start(folder)
        print(f"{count} ended jobs: answers after {seconds:.2f} s, {memory:.0f} MiB resident, "
              f"GET /v1/jobs {listing:.2f} s and {listed / 1e6:.1f} MB")
