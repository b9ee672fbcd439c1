"""What a measurement says of how it was made: commit, date and machine."""
import datetime
import re
import subprocess


def provenance(root):
    """A line for the head of a document of measurements."""
    commit = subprocess.run(["git", "rev-parse", "--short=7", "HEAD"], cwd=root, capture_output=True, check=True, text=True).stdout.strip()
    model = re.search(r"^model name\s*: (.*)$", open("/proc/cpuinfo").read(), re.M)
    return f"Commit {commit}, {datetime.date.today()}, processor {model[1] if model else 'unknown'}."
