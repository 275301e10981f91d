#!/usr/bin/env python3
"""Folders include only what their READMEs allow.

Every folder of core/ and host/ is a room. Its README ends with "May use:" and the rooms whose headers it includes.
That must hold exactly, core/ may not use host/, and no chain of rooms leads back to itself. Every room may use the
public headers in include/boxunion, which include only each other and the standard library.
"""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parent.parent
rooms = [p for house in ("core", "host") for p in sorted((root / house).iterdir()) if p.is_dir()]
faults = []


def name(room):
    return room.relative_to(root).as_posix()


def allowed(room):
    """The rooms that a README names; a name without a folder is a neighbor."""
    text = " ".join((room / "README.md").read_text().split())
    found = re.search(r"May use: (.*)\.$", text)
    if not found:
        faults.append(f"{name(room)}/README.md: expected a last sentence 'May use: ROOM, ROOM.'")
        return set()
    listed = [] if found[1] == "nothing" else found[1].split(", ")
    return {n if "/" in n else f"{room.parent.name}/{n}" for n in listed}


def included(room):
    """The rooms that a room's files include, each with the files that do."""
    uses = {}
    for file in sorted(room.glob("*.[ch]pp")):
        for header in re.findall(r'#include "([^"]+)"', file.read_text()):
            other = header.rpartition("/")[0]
            if other.startswith(("core/", "host/")) and other != name(room):
                uses.setdefault(other, []).append(file.name)
    return uses


may_use = {name(room): allowed(room) for room in rooms}
for room in rooms:
    uses = included(room)
    for other, files in uses.items():
        if other not in may_use[name(room)]:
            faults.append(f"{name(room)} includes {other} ({', '.join(files)}), which its README does not name")
        if room.parent.name == "core" and other.startswith("host/"):
            faults.append(f"{name(room)} is below {other} and may not include it ({', '.join(files)})")
    for other in sorted(may_use[name(room)] - uses.keys()):
        faults.append(f"{name(room)}/README.md names {other}, which no file there includes")

# Repeatedly remove the rooms that use none of the remaining rooms.
left = dict(may_use)
while floor := [room for room, uses in left.items() if not uses & left.keys()]:
    for room in floor:
        del left[room]
if left:
    faults.append(f"a circle among {', '.join(sorted(left))}")

for file in sorted((root / "include" / "boxunion").glob("*.hpp")):
    for header in re.findall(r'#include ["<]([^">]+)[">]', file.read_text()):
        if not re.fullmatch(r"boxunion/\w+\.hpp|[a-z_]+", header):
            faults.append(f"include/boxunion/{file.name} includes {header}, which is not installed")

print("\n".join(faults) or f"{len(rooms)} rooms, {sum(map(len, may_use.values()))} arrows, all one way")
sys.exit(bool(faults))
