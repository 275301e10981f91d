"""The sides of a comparison as processes that compute on request; contender.hpp describes the protocol."""

import json
import os
import selectors
import subprocess


class Failed(Exception):
    """The side gave no answer."""


class OutOfTime(Failed):
    pass


class Side:
    """A process that computes on request; see contender.hpp."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.pending = b""
        self.version = self.listen(600)["version"]

    def listen(self, limit):
        with selectors.DefaultSelector() as selector:
            selector.register(self.process.stdout, selectors.EVENT_READ)
            while b"\n" not in self.pending:
                if not selector.select(limit):
                    raise OutOfTime(f"more than {limit:g} s")
                some = os.read(self.process.stdout.fileno(), 1 << 16)
                if not some:
                    words = self.process.stderr.read().decode().strip().split("\n")[-1]
                    raise Failed(f"ended with status {self.process.wait()}: {words}")
                self.pending += some
        line, _, self.pending = self.pending.partition(b"\n")
        return json.loads(line)

    def ask(self, limit):
        """Computes once more and returns (seconds, answer)."""
        self.process.stdin.write(b"\n")
        self.process.stdin.flush()
        said = self.listen(limit)
        if "error" in said:
            raise Failed(said["error"])
        return said["seconds"], said["answer"]

    def stop(self):
        self.process.kill()
        self.process.communicate()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
