"""Submits workers to OpenCue, one a frame. Each joins the coordinator, works, and leaves after some hours.

    export PHOTONFARM_URL=https://HOST:8080 PHOTONFARM_FINGERPRINT=sha256:… PHOTONFARM_TOKEN_FILE=/shared/photonfarm/worker-token
    python3 photonfarm_workers.py --workers 32 --threads 16 --hours 8 --show SHOW --shot SHOT

The file with the token has to be readable on the hosts by the user of the frames. It needs opencue-pyoutline and packaging from PyPI.
"""

import argparse
import os
import shlex

import outline
import outline.cuerun
from outline.modules.shell import Shell

# What the worker reads of the environment of whoever submits.
TAKEN_ALONG = ("PHOTONFARM_URL", "PHOTONFARM_FINGERPRINT", "PHOTONFARM_AUTHORITIES", "PHOTONFARM_TOKEN_FILE")


def options():
    parser = argparse.ArgumentParser(description="Submits photonfarm workers to OpenCue.")
    parser.add_argument("--workers", type=int, default=8, help="frames, one worker each")
    parser.add_argument("--threads", type=int, default=4, help="cores of each")
    parser.add_argument("--hours", type=float, default=8, help="after these it gives back what it has, and the frame succeeds")
    parser.add_argument("--program", default="photonfarm", help="where photonfarm is on the hosts")
    parser.add_argument("--show", required=True)
    parser.add_argument("--shot", required=True)
    return parser.parse_args()


def command(chosen):
    """What a frame runs.

    OpenCue ends frames by SIGKILL, so `timeout` asks the worker to leave in time, by SIGTERM. In the foreground it stays in the frame's group of
    processes; otherwise a frame that is killed would leave its worker behind.
    """
    worker = [chosen.program, "worker", "--name", "opencue-#IFRAME#", "--threads", str(chosen.threads)]
    return ["timeout", "--foreground", "--preserve-status", "--signal=TERM", f"{round(chosen.hours * 3600)}s", *worker]


def job(chosen):
    """The whole job."""
    if "PHOTONFARM_URL" not in os.environ:
        raise SystemExit("set PHOTONFARM_URL to the coordinator's address")
    made = outline.Outline("photonfarm-workers", frame_range=f"1-{chosen.workers}", show=chosen.show, shot=chosen.shot)
    words = " ".join(word if "#IFRAME#" in word else shlex.quote(word) for word in command(chosen))
    layer = Shell("workers", command=words, range=f"1-{chosen.workers}", threads=chosen.threads, threadable=False)
    for name in TAKEN_ALONG:
        if name in os.environ:
            layer.set_env(name, os.environ[name])
    made.add_layer(layer)
    return made


if __name__ == "__main__":
    # Frames run the command as it is here, without PyOutline on the hosts.
    outline.cuerun.launch(job(options()), use_pycuerun=False)
