"""A user's own effect: one file, a strict formula, and search, model and report take it."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from scara_iso import read_table, simulate
from scara_iso.base.errors import DataError, UsageError
from scara_iso.base.files import KeyFaults
from scara_iso.commands import main
from scara_iso.effects import Conditions, own_effects
from scara_iso.effects._formula import FormulaError, parse_formula, unit_in
from scara_iso.robot import predict, read_effects, read_model

ROOT = Path(__file__).parents[2]
MODEL = ROOT / "examples" / "fum_scara.toml"
COOLED = """
[[effect]]
name = "cooled_while_open"
formula = "abs(k - closed)"
cause = "the guard door stood open until that cycle"
confirm_by = "repeat the test with the door shut"
parameters = { closed = { from = 8, to = 24 } }
"""
CREEP = """
[[effect]]
name = "belt_creep"
formula = "size * log(1 + t / tau)"
parameters = { tau = { from = 20, to = 600, unit = "s" } }
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(COOLED, encoding="utf-8")
    return path


def faults_of(text):
    faults = KeyFaults()
    found = list(own_effects(tomllib.loads(text)["effect"], "effect", {"step"}, faults))
    return found, [fault.message for fault in faults]


def fault_of(formula, parameters="", name="mine"):
    text = f"[[effect]]\nname = '{name}'\nformula = '{formula}'\nparameters = {{ {parameters} }}"
    return faults_of(text)[1]


leaves = st.sampled_from(["k", "p", "2", "0.5", "t"])
expressions = st.recursive(
    leaves,
    lambda e: st.one_of(
        st.builds("({} {} {})".format, e, st.sampled_from(["+", "-", "*", "/", "**"]), e),
        st.builds("(1.0 * ({} {} {}))".format, e, st.sampled_from(["<", "<=", ">", ">="]), e),
        st.builds("-{}".format, e),
        st.builds("{}({})".format, st.sampled_from(["exp", "sin", "sqrt", "abs", "tanh"]), e),
        st.builds("{}({}, {})".format, st.sampled_from(["min", "max"]), e, e),
    ),
    max_leaves=8,
)


@given(expressions)
def test_a_formula_has_the_value_that_numpy_gives(text):
    values = {"k": np.arange(2.0, 9.0), "t": np.linspace(0, 60, 7), "p": np.float64(1.5)}
    functions = {name: getattr(np, name) for name in ("exp", "sin", "sqrt", "abs", "tanh")}
    functions |= {"min": np.minimum, "max": np.maximum}
    with np.errstate(all="ignore"):
        numbers = text.replace("0.5", "np.float64(0.5)").replace("2", "np.float64(2)")
        expected = eval(numbers, {"np": np, **functions, **values})  # noqa: S307 - the oracle
    found = parse_formula(text).value(values)
    np.testing.assert_array_equal(found, np.asarray(expected, dtype=float))


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')", "k.real", "k[0]", "[k]", "'a'", "True", "2j",
        "lambda: k",
        "k if k else t", "k and t", "k := 2", "open(k)", "exp(k, t)", "exp(x=k)", "exp(*k)", "exp",
        "1 < k < 9", "k == 2", "k // 2", "k % 2", "~k", "k @ k", "f'{k}'", "1e999", "9" * 350, "",
        "k +", "k; k", "k" * 500, "-" * 300 + "k", "k\x00",
        "+".join(["k"] * 150), "print(k)", "__class__(k)", "await k", "(yield)", "{k: k}",
    ],
)  # fmt: skip
def test_what_is_not_in_the_grammar_is_refused(text):
    with pytest.raises(FormulaError):
        parse_formula(text)


def test_a_formula_that_grows_without_end_ends_at_once():
    assert not np.isfinite(parse_formula("9**9**9**9").value({}))


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("exp(-t / 60)", "exp takes a number, and -t / 60 is in s"),
        ("exp(-t / q)", "exp takes a number, and -t / q is in s/°C"),
        ("q + k", "in q + k, q is in °C and k is a number"),
        ("temperature_C + payload_kg * q", "temperature_C is in °C and payload_kg * q is in kg*°C"),
        ("humidity - q", "humidity is in humidity and q is in °C"),
        ("k ** q", "the power q is in °C"),
        ("q ** 0.5 * k", "its power must be a whole number"),
        ("exp(size * k) * q / q", "size may only be multiplied and added"),
        ("size ** 2 * k * q", "must be in proportion to size"),
        ("size + size * k + q * size / q + size * size", "in size"),
    ],
)
def test_units_must_agree(formula, said):
    (fault,) = fault_of(
        formula + " + 0 * q" * ("q" not in formula), 'q = {value = 2, unit = "degC"}'
    )
    assert said in fault or "in exp(-t / 60)" in fault


@pytest.mark.parametrize(
    ("text", "powers"),
    [
        ("1/s", {"s": -1}), ("kg*m^2", {"kg": 1, "m": 2}), ("degC/sec^2", {"°C": 1, "s": -2}),
        ("N*m/N", {"m": 1}), ("cycles", {}), ("rad*mm", {"mm": 1}), ("m^2/m^-1", {"m": 3}),
        ("?", None), ("mm mm", None), ("m^10", None),
    ],
)  # fmt: skip
def test_a_unit_is_a_product_of_powers(text, powers):
    assert unit_in(text) == powers


def test_the_unit_of_the_size_follows():
    text = '[[effect]]\nname = "a"\nformula = "(temperature_C - T0) * sqrt(t / tau)"\n'
    text += (
        'parameters = { T0 = {value = 20, unit = "degC"}, tau = {from = 5, to = 9, unit = "s"} }'
    )
    (effect,), faults = faults_of(text)
    assert faults == []
    assert effect.parameters[-1].unit == "reading/°C"
    assert effect.needs == ("temperature_C", "time_s")


def test_every_fault_of_a_file_is_said_at_once(call, tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(
        "more = 1\n"
        "[[effect]]\nname = 'step'\nformula = 'k'\n"
        "[[effect]]\nname = 'Two Words'\nformula = 'open(k)'\nrange = 1\n"
        "[[effect]]\nname = 'a'\ncause = 3\n"
        "parameters = { k = {value = 1}, b = {from = 2, to = 1}, c = {value = 'x', unit = '?'}, "
        "d = 4, e = {from = 0, to = 9, step = 0} }\n"
        "[[effect]]\nname = 'b'\nformula = 'a*b*c*d*k'\nparameters = { a = {from=1, to=2}, "
        "b = {from=1, to=2}, c = {from=1, to=2}, d = {from=1, to=2}, e = {from=1, to=2} }\n"
        "[[effect]]\nname = 'c'\nformula = '2'\n",
        encoding="utf-8",
    )
    for words in (["diagnose", "examples/scatter.csv"], ["simulate", MODEL]):
        code, out, err = call(*words, "--effects", path)
        assert (code, out) == (65, "")
        for said in (
            "more", "another effect is called step", "effect 2.name", "effect 2.formula: open",
            "effect 2.range", "effect 3.cause", "parameters.k: has another meaning",
            "from 2 to 1 is not a range", "c.value", "c.unit", "parameters.d", "e.step",
            "effect 3.formula: missing", "effect 4.parameters: more than", "parameters.e: does not",
            "effect 5.formula: is the same in every cycle",
        ):  # fmt: skip
            assert said in err
    assert call("diagnose", "examples/scatter.csv", "--effects", tmp_path / "none.toml")[0] == 66
    path.write_text("", encoding="utf-8")
    assert call("diagnose", "examples/scatter.csv", "--effects", path)[0] == 65


def test_the_loop_closes_with_it(call, file, tmp_path):
    table, new = tmp_path / "run.csv", tmp_path / "new.toml"
    effect = ("--effect", "cooled_while_open@Z:size=0.004,closed=14", "--seed", 4)
    assert call("simulate", MODEL, "--effects", file, *effect, "-o", table)[0] == 0
    options = ("--model", MODEL, "--effects", file)
    code, out, _ = call("diagnose", table, *options, "--save-model", new, "--json")
    assert code == 0
    found = json.loads(out)["effects"][0]
    assert found["effect"] == "cooled_while_open"
    assert "Z" in found["axes"]
    assert found["parameters"]["closed"] == pytest.approx(14, abs=1.5)
    assert found["parameters"]["size"]["Z"] == pytest.approx(0.004, abs=0.001)
    code, out, _ = call("diagnose", table, "--model", new, "--json")  # which stands alone
    assert json.loads(out)["verdict"] == "nothing-to-explain"
    page = tmp_path / "r.md"
    assert call("report", table, "--effects", file, "-o", page)[0] == 0
    said = page.read_text(encoding="utf-8")
    assert "cooled while open on" in said
    assert "the guard door stood open until that cycle" in said


def test_a_model_in_hand_takes_them_too(call, file, tmp_path):
    table, effect = tmp_path / "run.csv", "cooled_while_open@Z:size=0.004,closed=14"
    assert call("simulate", MODEL, "--effects", file, "--effect", effect, "-o", table)[0] == 0
    run = simulate(read_model(MODEL), effects=effect, own_effects=read_effects(file))
    assert run.axes["Z"].readings == pytest.approx(read_table(table).axes["Z"].readings)


def test_what_cannot_show_is_said(call, tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(CREEP + '[[effect]]\nname = "still"\nformula = "k ** 9999"\n')
    notes = json.loads(
        call("diagnose", ROOT / "examples" / "scatter.csv", "--effects", path, "--json")[1]
    )["notes"]
    assert "belt_creep: not looked for; the table has no column time_s" in notes
    assert "still: not looked for; its formula moves nothing in these cycles" in notes


def test_a_model_defines_what_it_declares(tmp_path):
    model = tmp_path / "m.toml"
    declared = "[[effect]]\nname = 'belt_creep'\ntau = 60\nsize = { X = 0.5 }\n"
    defined = CREEP.replace("[[effect]]", "[[definition]]")
    model.write_text(f"[indicator.X]\n{declared}{defined}")
    seconds = np.arange(30) * 12.0
    course = predict(read_model(model), Conditions(np.arange(1, 31), {"time_s": seconds}))
    assert course.axes["X"].readings == pytest.approx(0.5 * np.log(1 + seconds / 60))
    with pytest.raises(UsageError, match="needs the column time_s"):
        predict(read_model(model), Conditions(np.arange(1, 31)))
    (tmp_path / "other.toml").write_text(CREEP.replace("600", "900"))
    with pytest.raises(DataError) as wrong:
        read_model(model, read_effects(tmp_path / "other.toml"))
    assert "differs from the effect of that name" in str(wrong.value.faults[0])


def test_a_declared_course_without_a_value_is_refused(tmp_path):
    model = tmp_path / "m.toml"
    model.write_text(
        "[indicator.X]\n[[definition]]\nname = 'a'\nformula = 'log(k - 5)'\n"
        "[[effect]]\nname = 'a'\nsize = { X = 1 }\n"
    )
    with pytest.raises(UsageError, match="no finite value at cycle 1"):
        predict(read_model(model), Conditions(np.arange(1, 31)))


def test_a_file_that_is_no_toml_is_told_what_one_is(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    path.write_text("a,b\n", encoding="utf-8")
    assert main(["diagnose", str(ROOT / "examples" / "warm_up.csv"), "--effects", str(path)]) == 65
    told = capsys.readouterr().err
    assert "is not valid TOML" in told
    assert "write KEY = VALUE lines" in told
