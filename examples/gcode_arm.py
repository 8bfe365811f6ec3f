"""A G-code arm paces its own test: moves by a serial port, arrivals by the recorder's line.

``python examples/gcode_arm.py DIR HOST:PORT --arm /dev/ttyUSB1`` while
``scara-iso record DIR --gauge .. --trigger listen://HOST:PORT`` runs; by itself no arm moves.
Was never run on an arm: read it, and run it first at a low feed with a hand at the switch.
"""

import argparse
import contextlib
import socket
import sys
import time

import serial

import scara_iso

FEED = 3000  # mm/min at 100 %
POINTS = {  # of your arm: the pose, and a point on either side of it along the dial
    "P1": "X200 Y0 Z50", "appro_P1": "X190 Y0 Z50", "appro2_P1": "X210 Y0 Z50",
    "P2": "X160 Y90 Z50", "appro_P2": "X150 Y90 Z50", "appro2_P2": "X170 Y90 Z50",
    "P3": "X160 Y-90 Z50", "appro_P3": "X150 Y-90 Z50", "appro2_P3": "X170 Y-90 Z50",
}  # fmt: skip


class Arm:
    """Marlin, Klipper and their like: each command is answered ``ok`` when it was taken."""

    def __init__(self, port: str) -> None:
        self._port = (
            None if port == "simulated" else serial.serial_for_url(port, 115200, timeout=60)
        )
        if self._port is not None:
            time.sleep(2)  # many boards begin anew when the port is opened
            self._port.reset_input_buffer()
        self.does("G90")

    def close(self) -> None:
        """Give the port back."""
        if self._port is not None:
            self._port.close()

    def does(self, command: str) -> None:
        """Return when the arm has taken a command; the program ends where it reports an error."""
        if self._port is None:
            return
        self._port.write(f"{command}\n".encode())
        while not (said := self._port.readline().decode("ascii", "replace").strip()).startswith(
            "ok"
        ):
            if not said or said.lower().startswith(("error", "!!", "resend")):
                sys.exit(f"the arm to {command}: {said or 'no answer in 60 s'}")

    def goes(self, point: str, feed: float) -> None:
        """Return when the arm is at a point: M400 is answered at the end of all motion."""
        self.does(f"G1 {POINTS[point]} F{feed:g}")
        self.does("M400")


class Line:
    """The recorder's line; what was not answered is said again on a new connection."""

    def __init__(self, text: str) -> None:
        host, _, port = text.rpartition(":")
        self._where = host, int(port)
        self._socket: socket.socket | None = None

    def says(self, words: str) -> int:
        """Return the number behind OK; the program ends at NO, and where nobody answers."""
        for _ in range(100):
            answer = self._asked(words)
            if answer.startswith("OK "):
                return int(answer[3:])
            if answer:
                sys.exit(f"the recorder to {words}: {answer}")
            time.sleep(0.3)
        sys.exit(f"nobody answers {words}")

    def close(self) -> None:
        """End the connection."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _asked(self, words: str) -> str:
        """Return the answer; nothing where the connection is lost, which the next call renews."""
        with contextlib.suppress(OSError):
            if self._socket is None:
                self._socket = socket.create_connection(self._where, timeout=30)
            self._socket.sendall(f"{words}\n".encode())
            with self._socket.makefile("rb") as answers:
                if answer := answers.readline(200):
                    return answer.decode("ascii", "replace").strip()
        self.close()
        return ""


def main() -> None:
    """Visit the poses of every part, each behind the cycles that are stored."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder")
    parser.add_argument("line", metavar="HOST:PORT")
    parser.add_argument("--arm", default="simulated", metavar="PORT")
    given = parser.parse_args()
    test = scara_iso.program("urscript", given.folder, line=given.line)
    arm, line = Arm(given.arm), Line(given.line)
    both_sides = any(point.startswith("appro2_") for point in test.points)
    for part in test.stages:
        hello = f"HELLO program={part.program} poses={len(part.poses)} cycles={part.cycles}"
        for cycle in range(line.says(hello) + 1, part.cycles + 1):
            second = both_sides and cycle % 2 == 0
            for pose in part.poses:
                arm.goes(f"appro{2 * second or ''}_{pose}", FEED * part.speed / 100)
                arm.goes(pose, FEED * part.speed / 100)
                time.sleep(test.dwell_s)
                side = f" approach={'-' if second else '+'}1" if both_sides else ""
                line.says(f"AT {pose} cycle={cycle}{side}")
    line.says("END")
    line.close()
    arm.close()


if __name__ == "__main__":
    main()
