"""Robots that pace a recording over a socket, for the tests of the line and of the programs."""

from __future__ import annotations

import socket
import threading
from dataclasses import replace

from scara_iso import read_table, recorder
from scara_iso.base.files import Disk
from scara_iso.rawfile import Tour
from scara_iso.recorder import (
    Job,
    Quit,
    RecordingPlan,
    RobotLine,
    choose_clock,
    parse_gauges,
)
from scara_iso.recorder.ports.listening import ListeningLine

SIM = "X=opto-rs232@sim:?pace=0&scatter=0.01"


OPEN = []
"""What `close_all` closes behind a test."""


def close_all():
    """End what a test left open."""
    while OPEN:
        OPEN.pop().close()


class Attendant:
    """Who hears everything, and ends the session when ``over`` is set."""

    def __init__(self):
        self.heard = []
        self.over = threading.Event()
        self.commands = []

    def poll(self):
        if self.commands:
            return self.commands.pop(0)
        return Quit() if self.over.is_set() else None


class Serving:
    """A recording that listens, in a thread of its own."""

    def __init__(self, table, *, poses=(), cycles=3, resume=False, gauge=SIM, **kwargs):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.line = ListeningLine(f"listen://127.0.0.1:{port}")
        self.where = ("127.0.0.1", port)
        trigger = RobotLine(self.line.address, self.line)
        plan = RecordingPlan(trigger, cycles, rearm_s=0.0, tour=Tour(tuple(poses)))
        self.job = replace(Job(table, parse_gauges([gauge]), plan, {}, resume), **kwargs)
        self.attendant = Attendant()
        self.error = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        OPEN.append(self)

    def _run(self):
        try:
            recorder.record(
                self.job, disk=Disk(), operator=self.attendant,
                clock=choose_clock(spec.address for spec in self.job.gauges),
                tell=self.attendant.heard.append,
            )  # fmt: skip
        except Exception as error:  # noqa: BLE001 - looked at in the test
            self.error = error

    def ended(self):
        """Return the table when the recording is over."""
        self._thread.join(30)
        assert not self._thread.is_alive()
        self.line.close()
        return read_table(self.job.table)

    def stop(self):
        self.attendant.over.set()
        self._thread.join(30)
        self.line.close()

    close = stop


class Arm:
    """A robot's end of the line."""

    def __init__(self, where):
        self.where = where
        self.socket = socket.create_connection(where, timeout=20)
        self.file = self.socket.makefile("rb")
        OPEN.append(self)

    def send(self, line):
        self.socket.sendall(line if isinstance(line, bytes) else f"{line}\n".encode())

    def answer(self):
        return self.file.readline().decode().strip()

    def says(self, line):
        self.send(line)
        return self.answer()

    def leave(self):
        self.file.close()
        self.socket.close()

    close = leave
