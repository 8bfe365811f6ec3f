"""Where time was recorded a time constant is one in seconds: it holds at another pace too."""

import json
from pathlib import Path

import numpy as np
import pytest

from scara_iso.effects import Conditions

MODEL = str(Path(__file__).parents[2] / "examples" / "fum_scara.toml")
CYCLE = np.arange(2, 32)


def warming(call, path, interval, seed):
    effect = ("--effect", "warm_up@X:size=0.1,tau_s=80", "--interval", interval)
    assert call("simulate", MODEL, *effect, "--seed", seed, "-o", path)[0] == 0
    return path


def diagnosed(call, *argv):
    code, out, err = call("diagnose", *argv, "--json")
    assert (code, err) == (0, "")
    return json.loads(out)


@pytest.mark.slow
def test_the_next_table_at_another_pace_is_predicted(call, tmp_path):
    slow = warming(call, tmp_path / "slow.csv", 25, 2)
    found = warming(call, tmp_path / "a.csv", 10, 1)
    new = tmp_path / "new.toml"
    document = diagnosed(call, found, "--model", MODEL, "--save-model", new, "--hold-out", slow)
    (effect,) = document["effects"]
    assert effect["effect"] == "warm_up"
    assert effect["parameters"]["tau_s"] == pytest.approx(80, rel=0.15)
    assert effect["parameters"]["tau"] == pytest.approx(8, rel=0.15)
    assert effect["parameters"]["size"]["X"] == pytest.approx(0.1, rel=0.1)
    before, after = (document["error"][when]["held_out_rms"]["X"] for when in ("before", "after"))
    assert after < 0.5 * before
    assert diagnosed(call, slow, "--model", new)["verdict"] == "nothing-to-explain"
    text = new.read_text(encoding="utf-8")
    new.write_text("\n".join(line for line in text.splitlines() if "tau_s" not in line))
    assert diagnosed(call, slow, "--model", new)["verdict"] != "nothing-to-explain"


def test_it_is_said_in_both_units(call, tmp_path):
    table = warming(call, tmp_path / "a.csv", 10, 1)
    assert "tau 8.49 cycles (84.9 s)" in call("diagnose", table)[1]


def test_seconds_alone_need_a_clock(call, tmp_path):
    model = tmp_path / "m.toml"
    model.write_text("[indicator.X]\n[[effect]]\nname='warm_up'\ntau_s=80\nsize={X=1}\n")
    assert call("simulate", model, "--interval", 10)[0] == 0
    code, out, err = call("simulate", model)
    assert (code, out) == (2, "")
    assert "gives tau_s, and the test has no time_s" in err
    model.write_text("[indicator.X]\n[[effect]]\nname='warm_up'\ntau_s=-1\nsize={X=1}\n")
    assert "tau_s" in call("simulate", model)[2]
    assert call("simulate", MODEL, "--interval", 0)[0] == 2


@pytest.mark.parametrize(
    ("clock", "first"),
    [(12.0 * (CYCLE - 1), 12.0), (1e9 + 12.0 * CYCLE, 0.0), (12.0 * (CYCLE - 2), 0.0)],
)
def test_time_begins_at_the_first_cycle_where_the_clock_shows_it(clock, first):
    seconds = Conditions(CYCLE, {"time_s": clock}).seconds
    assert seconds[0] == first
    assert np.diff(seconds) == pytest.approx(12.0)
