"""The host script of examples/ runs a G-code arm through a test of two sides, by the line."""

import runpy
import socket
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest
from controllers import Dial
from robots import OPEN
from test_paced_test import Recording, short_test

import scara_iso

SCRIPT = Path(__file__).parents[2] / "examples" / "gcode_arm.py"


pytestmark = pytest.mark.usefixtures("closed")


class Marlin:
    """A board on a socket that moves the arm which the dial touches, and says ok."""

    def __init__(self, dial, points):
        self._dial, self._names = dial, {text: name for name, text in points.items()}
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = f"socket://127.0.0.1:{self._server.getsockname()[1]}"
        self.went = []
        OPEN.append(self)
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        with suppress(OSError):
            peer, _ = self._server.accept()
            with peer, peer.makefile("rb") as lines:
                for line in lines:
                    word, _, rest = line.decode().strip().partition(" ")
                    if word == "G1":
                        self.went.append(self._names[rest.partition(" F")[0]])
                        self._dial.move(self.went[-1])
                    peer.sendall(b"echo:busy\nok\n" if word == "M400" else b"ok\n")

    def close(self):
        self._server.close()


@pytest.mark.slow
def test_a_script_runs_a_g_code_arm_through_a_test_of_two_sides(tmp_path, monkeypatch):
    script = runpy.run_path(str(SCRIPT))
    folder, dial = tmp_path / "a", Dial()
    short_test(folder, cycles=4, dwell=0.0)
    file = folder / "test.toml"
    text = file.read_text().replace('# approach = "one side"', 'approach = "both sides"')
    file.write_text(text)
    board = Marlin(dial, script["POINTS"])
    recording = Recording(folder, dial.gauge)
    given = ["gcode_arm.py", str(folder), recording.line, "--arm", board.port]
    monkeypatch.setattr(sys, "argv", given)
    script["main"]()
    recording.ended()
    for number, pose in enumerate(("P1", "P2"), 1):
        run = scara_iso.read_table(folder / f"{pose}-v100-l100.csv")
        assert run.axes["X"].readings.tolist() == [number + k / 1000 for k in (1, 2, 3, 4)]
        assert run.covariates["approach"].tolist() == [1, -1, 1, -1]
    assert board.went[:4] == ["appro_P1", "P1", "appro2_P1", "P1"]
