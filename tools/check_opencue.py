#!/usr/bin/env python3
"""Runs workers as frames of OpenCue's own RQD, from the job that deploy/opencue/photonfarm_workers.py makes.

usage, in the project's root: python3 tools/check_opencue.py --program PROGRAM

A frame whose time is up succeeds, and its worker has given back what it had; one that is killed fails, and its worker is gone at once; one whose
worker is refused fails. PyOutline and RQD come from PyPI. Cuebot, which needs PostgreSQL and Java, is not there: this script tells RQD what to run
and hears what became of it, as Cuebot does. RQD runs frames as an ordinary user, so this has to be started as root. About a minute.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from concurrent.futures import ThreadPoolExecutor

# What is imported from deploy/ leaves nothing there.
sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).parents[1]
PACKAGES = ["opencue-pyoutline>=1.37", "opencue-rqd>=1.37", "packaging"]
NOBODY = 65534
PORTS = {"cuebot": 8622, "rqd": 8623}


def in_own_environment(folder):
    """Installs OpenCue's packages and starts this script again where they are."""
    subprocess.run([sys.executable, "-m", "venv", folder / "python"], check=True)
    subprocess.run([folder / "python/bin/pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES], check=True)
    return subprocess.run([folder / "python/bin/python", *sys.argv, "--folder", folder]).returncode


class Cuebot:
    """What RQD takes for Cuebot: it hears how frames ended."""

    def __init__(self):
        import grpc
        from opencue_proto import report_pb2, report_pb2_grpc

        self.has_started, self.ended = False, {}
        cuebot = self

        class Reports(report_pb2_grpc.RqdReportInterfaceServicer):
            def ReportRqdStartup(self, request, context):
                cuebot.has_started = True
                return report_pb2.RqdReportRqdStartupResponse()

            def ReportStatus(self, request, context):
                return report_pb2.RqdReportStatusResponse()

            def ReportRunningFrameCompletion(self, request, context):
                report = request.frame_complete_report
                cuebot.ended[report.frame.frame_id] = (report.exit_status, report.exit_signal)
                return report_pb2.RqdReportRunningFrameCompletionResponse()

        self.server = grpc.server(ThreadPoolExecutor(4))
        report_pb2_grpc.add_RqdReportInterfaceServicer_to_server(Reports(), self.server)
        self.server.add_insecure_port(f"127.0.0.1:{PORTS['cuebot']}")
        self.server.start()


class Rqd:
    """OpenCue's program on a host."""

    def __init__(self, folder):
        import grpc
        from opencue_proto import rqd_pb2, rqd_pb2_grpc

        self.messages, self.folder = rqd_pb2, folder
        settings = {"OVERRIDE_CUEBOT": "127.0.0.1", "CUEBOT_GRPC_PORT": PORTS["cuebot"], "RQD_GRPC_PORT": PORTS["rqd"], "OVERRIDE_NIMBY": "false"}
        (folder / "rqd.conf").write_text("[Override]\n" + "".join(f"{name}={value}\n" for name, value in settings.items()))
        log = open(folder / "rqd.log", "w")
        self.process = subprocess.Popen([pathlib.Path(sys.executable).parent / "rqd", "-c", folder / "rqd.conf"], stdout=log, stderr=log)
        self.stub = rqd_pb2_grpc.RqdInterfaceStub(grpc.insecure_channel(f"127.0.0.1:{PORTS['rqd']}"))

    def launch(self, layer, number, environment):
        frame = self.messages.RunFrame(
            resource_id=str(number), frame_id=str(number), job_id="job", layer_id="layer", job_name="test-workers", frame_name=f"{number:04}-workers",
            command=layer.find("cmd").text.replace("#IFRAME#", str(number)), environment=environment, user_name="nobody", uid=NOBODY, gid=NOBODY,
            show="test", shot="test", num_cores=100, start_time=int(time.time()), ignore_nimby=True, job_temp_dir=str(self.folder / "logs"),
            frame_temp_dir=str(self.folder / "logs"), log_dir=str(self.folder / "logs"), log_file="log", log_dir_file=str(self.folder / "logs/log"),
        )
        self.stub.LaunchFrame(self.messages.RqdStaticLaunchFrameRequest(run_frame=frame))

    def kill(self, number):
        self.stub.KillRunningFrame(self.messages.RqdStaticKillRunningFrameRequest(frame_id=str(number), message="by a user"))


def layer_of_job(program, url, seconds):
    """The layer of workers, from the job specification that PyOutline would send to Cuebot, and its environment."""
    sys.path.insert(0, str(ROOT / "deploy/opencue"))
    import photonfarm_workers
    from outline.cuerun import OutlineLauncher

    os.environ["PHOTONFARM_URL"] = url
    chosen = argparse.Namespace(workers=3, threads=1, hours=seconds / 3600, program=str(program), show="test", shot="test")
    specification = OutlineLauncher(photonfarm_workers.job(chosen), user="nobody").serialize(use_pycuerun=False)
    layer = ElementTree.fromstring(specification).find("job/layers/layer")
    return layer, {key.get("name"): key.text for key in layer.find("env")}


def wait_until(what, true, seconds=30):
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            raise SystemExit(f"this did not happen in {seconds} s: {what}")
        time.sleep(0.2)
    print(what)


def check(program, folder):
    def ask(*words):
        return subprocess.run([program, *words, "--coordinator", url], capture_output=True, text=True, check=True).stdout

    def listed(name):
        return name in ask("workers")

    os.chmod(folder, 0o755)
    (folder / "logs").mkdir()
    os.chmod(folder / "logs", 0o777)
    log = folder / "coordinator.log"
    processes = [subprocess.Popen([program, "serve", "--listen", "127.0.0.1:0", "--data", "none"], stderr=open(log, "w"))]
    try:
        cuebot, rqd = Cuebot(), Rqd(folder)
        processes.append(rqd.process)
        wait_until("RQD reports to Cuebot", lambda: cuebot.has_started)
        wait_until("a coordinator listens", lambda: "photonfarm listens at " in log.read_text())
        url = log.read_text().split("photonfarm listens at ")[1].split()[0]
        layer, environment = layer_of_job(program, url, seconds=10)
        print("frames run:", layer.find("cmd").text)
        ask("submit", str(ROOT / "scenes/cornell-diffuse/scene.xml"), "--size", "32", "--passes", "100000")
        rqd.launch(layer, 3, environment | {"PHOTONFARM_TOKEN": "short"})
        wait_until("frame 3 has failed with code 3: its worker's token is none", lambda: cuebot.ended.get("3") == (3, 0))
        rqd.launch(layer, 1, environment)
        rqd.launch(layer, 2, environment)
        wait_until("both workers work", lambda: ask("workers").count("working") == 2)
        rqd.kill(2)
        wait_until("frame 2 has failed by SIGKILL", lambda: cuebot.ended.get("2") == (1, 9), seconds=5)
        wait_until("frame 1 has succeeded", lambda: cuebot.ended.get("1") == (0, 0))
        if listed("opencue-1"):
            raise SystemExit("the worker of frame 1 did not say that it leaves")
        print("its worker had left in order")
    finally:
        for process in reversed(processes):
            process.terminate()
        for process in processes:
            process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=lambda text: pathlib.Path(text).resolve(), required=True)
    parser.add_argument("--folder", type=pathlib.Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.folder:
        return check(chosen.program, chosen.folder)
    with tempfile.TemporaryDirectory() as folder:
        return in_own_environment(pathlib.Path(folder))


if __name__ == "__main__":
    sys.exit(main())
