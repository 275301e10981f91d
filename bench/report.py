"""Shared by the scripts of bench: the machine, results as JSON, Markdown tables, and a virtual environment."""

import datetime
import json
import math
import os
import pathlib
import platform
import re
import shlex
import statistics
import subprocess
import sys

BENCH = pathlib.Path(__file__).resolve().parent
SOURCE = BENCH.parent
BUILD = SOURCE / "build" / "dev"
RESULTS = BENCH / "results"
REQUIREMENTS = BENCH / "peers" / "requirements.txt"


def output_of(*command):
    """The output of a command, or nothing if it is missing or fails."""
    try:
        return subprocess.run(command, cwd=SOURCE, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


LOAD_BEFORE = os.getloadavg()[0]


def context(command):
    """The machine, date and sources of results. `load` is that of the machine before the command began."""

    def find(pattern, path):
        found = re.search(pattern, pathlib.Path(path).read_text()) if os.path.exists(path) else None
        return found[1].strip() if found else ""

    def without_folder(word):
        return os.path.basename(word) if os.path.isabs(word) else word

    changes = output_of("git", "status", "--porcelain", "--untracked-files=no", "--", ".", ":!bench/results", ":!docs")
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
        "command": shlex.join([os.path.relpath(command[0], SOURCE), *map(without_folder, command[1:])]),
        "commit": output_of("git", "rev-parse", "--short", "HEAD") + ("-dirty" if changes else ""),
        "cpu": find(r"model name\s*:(.*)", "/proc/cpuinfo"),
        "cores": os.cpu_count(),
        "load": round(LOAD_BEFORE, 1),
        "memory_gib": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30),
        "system": find(r'PRETTY_NAME="(.*)"', "/etc/os-release"),
        "kernel": platform.release(),
        "compiler": output_of("c++", "--version").split("\n")[0],
    }


def write(path, results):
    """Writes JSON as a whole or not at all, one record per line."""
    text = json.dumps(results, indent=1)
    text = re.sub(r"\{\s+([^{}\[\]]*?)\s+\}", lambda m: "{" + re.sub(r"\s*\n\s*", " ", m[1]) + "}", text)
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_text(text + "\n")
    part.replace(path)


def read(path):
    return json.loads(pathlib.Path(path).read_text())


def three_digits(value):
    """A number with three digits and without exponent: 0.00123, 12.3, 1230."""
    if value == 0:
        return "0"
    text = f"{float(f'{value:.3g}'):.12f}".rstrip("0").rstrip(".")
    digits = len(text.replace(".", "").lstrip("0"))
    if digits < 3 and "." in text:
        text += "0" * (3 - digits)
    elif digits < 3 and abs(value) < 100:
        text += "." + "0" * (3 - digits)
    return text


def table(header, rows):
    """A Markdown table of the texts of any values."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in [header, *rows]]
    return "\n".join([lines[0], "|" + "---|" * len(header), *lines[1:]])


def exponent(points):
    """The slope of log y over log x, by least squares."""
    x, y = zip(*((math.log(a), math.log(b)) for a, b in points))
    mean_x, mean_y = statistics.fmean(x), statistics.fmean(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)


def virtual_python():
    """The Python of build/venv, which is made if needed, with the packages of requirements.txt.

    None, with a message on standard error, if that fails.
    """
    folder = SOURCE / "build" / "venv"
    python, stamp = folder / "bin" / "python", folder / "requirements.txt"
    if stamp.exists() and stamp.read_text() == REQUIREMENTS.read_text():
        return python
    try:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True, capture_output=True, text=True)
        install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", REQUIREMENTS]
        subprocess.run(install, check=True, capture_output=True, text=True, timeout=600)
    except (OSError, subprocess.SubprocessError) as error:
        why = (getattr(error, "stderr", None) or str(error)).strip().split("\n")[-1]
        print(f"No virtual environment, so no rivals from PyPI: {why}", file=sys.stderr)
        return None
    stamp.write_text(REQUIREMENTS.read_text())
    return python
