"""Formulas that a user writes: arithmetic on numbers, names and a few functions, and its units.

Python's parser makes the tree; nothing of it is executed. What is not in the grammar below is a
fault: no attribute, index, text, keyword or function that is not listed.

    sum, difference, product, quotient, power, sign, one comparison (1 where it holds, else 0),
    number, name, function of as many arguments as it takes
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from scara_iso.run import FloatArray

Unit: TypeAlias = Mapping[str, Fraction]
"""Powers by symbol; none is a number."""

NUMBER: Unit = {}
_NUMBERS = {"", "1", "rad", "cycles", "cycle"}
_SAME = {"C": "°C", "degC": "°C", "percent": "%", "u": "um", "sec": "s"}
_OF_COLUMNS = {
    "C",
    "K",
    "kg",
    "g",
    "s",
    "min",
    "h",
    "mm",
    "um",
    "m",
    "N",
    "Nm",
    "V",
    "A",
    "Hz",
    "W",
    "bar",
    "hPa",
    "percent",
    "deg",
}
_FACTOR = re.compile(r"([A-Za-zµ°%]+[A-Za-z_0-9]*)(?:\^(-?[1-9]))?")


def unit_in(text: str) -> Unit | None:
    """Return the unit that ``text`` spells, such as ``mm``, ``1/s`` or ``kg*m^2``; None for none.

    ``rad`` and ``cycles`` are numbers.
    """
    unit: Unit = NUMBER
    for sign, part in re.findall(r"([*/]?)([^*/]*)", "*" + text.strip()[:60])[:-1]:
        factor = _FACTOR.fullmatch(part.strip())
        if part.strip() in _NUMBERS:
            continue
        if factor is None:
            return None
        symbol = _SAME.get(factor[1], factor[1])
        power = Fraction(int(factor[2] or 1))
        unit = times(unit, {symbol: power}, -1 if sign == "/" else 1)
    return unit


def unit_of_column(name: str) -> Unit:
    """Return the unit of a recorded column."""
    if name == "approach":  # +1 and -1
        return NUMBER
    ending = name.rpartition("_")[2]
    return {_SAME.get(ending, ending) if ending in _OF_COLUMNS else name: Fraction(1)}


def times(one: Unit, other: Unit, power: int = 1) -> Unit:
    """Return ``one`` times ``other`` to a power."""
    powers = {
        symbol: one.get(symbol, Fraction(0)) + power * other.get(symbol, Fraction(0))
        for symbol in (*one, *other)
    }
    return {symbol: n for symbol, n in powers.items() if n}


def spelled(unit: Unit) -> str:
    """Return a unit as it is written, 1 for none."""
    above = "*".join(_power(s, n) for s, n in sorted(unit.items()) if n > 0)
    below = "*".join(_power(s, -n) for s, n in sorted(unit.items()) if n < 0)
    return (above or "1") + (f"/({below})" if "*" in below else f"/{below}" if below else "")


def said_of(unit: Unit) -> str:
    """Return what a quantity of this unit is: ``in mm``, or a number."""
    return f"in {spelled(unit)}" if unit else "a number"


def _power(symbol: str, n: Fraction) -> str:
    return symbol if n == 1 else f"{symbol}^{n}"


SIZE_NAME = "size"
_MOST_LETTERS, _MOST_NODES, _LARGEST = 400, 120, 1e300

_OPERATORS: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.divide,
    ast.Pow: np.power,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_OF_NUMBERS: dict[str, Callable[[Any], Any]] = {
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "tanh": np.tanh,
    "atan": np.arctan,
}
_OF_ONE: dict[str, Callable[[Any], Any]] = {"abs": np.abs, "sign": np.sign, "sqrt": np.sqrt}
_OF_TWO: dict[str, Callable[[Any, Any], Any]] = {"min": np.minimum, "max": np.maximum}
FUNCTIONS: dict[str, Callable[..., Any]] = {**_OF_NUMBERS, **_OF_ONE, **_OF_TWO}
"""Those that a formula may call."""


class FormulaError(ValueError):
    """What is wrong with a formula, in words."""


@dataclass(frozen=True, eq=False, slots=True)
class Formula:
    """A formula that was read; ``names`` are the quantities in it, functions left out."""

    text: str
    tree: ast.expr
    names: frozenset[str]

    def value(self, values: Mapping[str, FloatArray | float]) -> FloatArray:
        """Return its value for a value of every name; not finite where it has none."""
        with np.errstate(all="ignore"):
            return np.asarray(_value(self.tree, values), dtype=np.float64)

    def unit(self, units: Mapping[str, Unit]) -> Unit:
        """Return its unit for a unit of every name; `FormulaError` where units do not agree."""
        return _unit(self.tree, units)


def parse_formula(text: str) -> Formula:
    """Return the formula that ``text`` spells; `FormulaError` for one that is not in the grammar.

    Bounded in length and parts, and so in depth.
    """
    if len(text) > _MOST_LETTERS:
        raise FormulaError(f"longer than {_MOST_LETTERS} letters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = getattr(error, "msg", None) or "cannot be read"
        raise FormulaError(f"{reason}; write it such as exp(-t / tau)") from error
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.expr)]
    if len(nodes) > _MOST_NODES:
        raise FormulaError("has too many parts; use fewer")
    called = {id(node.func) for node in nodes if isinstance(node, ast.Call)}
    quantities = (node for node in nodes if isinstance(node, ast.Name) and id(node) not in called)
    formula = Formula(text.strip(), tree, frozenset(node.id for node in quantities))
    formula.value(dict.fromkeys(formula.names, 1.0))  # what is not in the grammar has none
    return formula


def _check_call(name: str, arguments: int) -> None:
    if name not in FUNCTIONS:
        known = ", ".join(sorted(FUNCTIONS))
        raise FormulaError(f"{name[:40]} is not a known function: {known}")
    wanted = 2 if name in _OF_TWO else 1
    if arguments != wanted:
        raise FormulaError(f"{name} takes {wanted} argument{'s' * (wanted > 1)}")


def _value(node: ast.expr, values: Mapping[str, FloatArray | float]) -> Any:
    """Return the value of a node of the grammar; `FormulaError` for any other node."""
    match node:
        case ast.Constant(value=number):
            return _number(node, number)
        case ast.Name(id=name):
            if name in FUNCTIONS:
                raise FormulaError(f"{name} is a function: write {name}(..)")
            return values[name]
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as op, operand=part):
            return -_value(part, values) if isinstance(op, ast.USub) else _value(part, values)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_value(left, values), _value(right, values))
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _OPERATORS:
            holds = _OPERATORS[type(op)](_value(left, values), _value(right, values))
            return np.asarray(holds, dtype=np.float64)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]):
            _check_call(name, len(args))
            return FUNCTIONS[name](*(_value(part, values) for part in args))
    raise FormulaError(
        f"{ast.unparse(node)[:40]} is not allowed; + - * / ** < > and "
        f"{', '.join(sorted(FUNCTIONS))} are"
    )


def _number(node: ast.Constant, number: object) -> np.float64:
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise FormulaError(f"{ast.unparse(node)[:40]} is not a number")
    if not abs(number) < _LARGEST:
        raise FormulaError(f"{ast.unparse(node)[:40]} is too large")
    return np.float64(number)


def _unit(node: ast.expr, units: Mapping[str, Unit]) -> Unit:
    match node:
        case ast.Name(id=name):
            return units[name]
        case ast.UnaryOp(operand=part):
            return _unit(part, units)
        case ast.BinOp():
            return _unit_of_arithmetic(node, units)
        case ast.Compare(left=left, comparators=[right]):
            _not_of_size(node, _common(node, [left, right], units))
        case ast.Call(func=ast.Name(id=name), args=args):
            return _unit_of_call(node, name, args, units)
    return NUMBER


def _unit_of_arithmetic(node: ast.BinOp, units: Mapping[str, Unit]) -> Unit:
    match node.op:
        case ast.Mult() | ast.Div():
            power = 1 if isinstance(node.op, ast.Mult) else -1
            return times(_unit(node.left, units), _unit(node.right, units), power)
        case ast.Pow():
            return _unit_of_power(node.left, node.right, units)
    return _common(node, [node.left, node.right], units)


def _common(node: ast.expr, parts: list[ast.expr], units: Mapping[str, Unit]) -> Unit:
    """Return the unit that all parts have."""
    found = [_unit(part, units) for part in parts]
    for part, unit in zip(parts, found, strict=True):
        if unit != found[0]:
            raise FormulaError(
                f"in {ast.unparse(node)}, {ast.unparse(parts[0])} is {said_of(found[0])} and "
                f"{ast.unparse(part)} is {said_of(unit)}"
            )
    return found[0]


def _unit_of_power(base: ast.expr, exponent: ast.expr, units: Mapping[str, Unit]) -> Unit:
    unit, power = _unit(base, units), _unit(exponent, units)
    if power != NUMBER:
        raise FormulaError(f"the power {ast.unparse(exponent)} is {said_of(power)}, not a number")
    if unit == NUMBER:
        return NUMBER
    try:
        whole = ast.literal_eval(exponent)
    except ValueError:
        whole = None
    if not isinstance(whole, int):
        raise FormulaError(
            f"{ast.unparse(base)} is {said_of(unit)}: its power must be a whole number"
        )
    return {symbol: n * whole for symbol, n in unit.items() if whole}


def _unit_of_call(
    node: ast.expr, name: str, args: list[ast.expr], units: Mapping[str, Unit]
) -> Unit:
    unit = _common(node, args, units)
    _not_of_size(node, unit)
    if name in _OF_NUMBERS and unit != NUMBER:
        raise FormulaError(
            f"{name} takes a number, and {ast.unparse(args[0])} is {said_of(unit)}: divide it by a "
            "parameter of that unit"
        )
    if name == "sqrt":
        return {symbol: n / 2 for symbol, n in unit.items()}
    return NUMBER if name == "sign" else unit


def _not_of_size(node: ast.expr, unit: Unit) -> None:
    if unit.get(SIZE_NAME, Fraction(0)):
        raise FormulaError(
            f"{ast.unparse(node)}: {SIZE_NAME} may only be multiplied and added, for the readings "
            "move in proportion to it"
        )
