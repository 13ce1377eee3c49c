"""Formulas and limits as text (docs/potentials.md), evaluated with NumPy; units, parameters, regions."""

import re

import numpy as np

_units = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "rad": 1.0, "deg": np.pi / 180, "s": 1.0, "ms": 0.001, "Hz": 1.0}
_unit = "|".join(sorted(_units, key=len, reverse=True))
_number = re.compile(r"(?<![\w.])(\d+\.?\d*(?:[eE][+-]?\d+)?)(?:\s*(%s)(?![\w])((?:\s*/\s*(?:%s)(?![\w]))*))?" % (_unit, _unit))


def _norm(*parts):
    return np.sqrt(sum(part * part for part in parts))


_functions = {
    "abs": np.abs, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log,
    "atan2": np.arctan2, "norm": _norm, "hypot": _norm, "pi": np.pi,
    "min": lambda *a: np.minimum.reduce(np.broadcast_arrays(*a)), "max": lambda *a: np.maximum.reduce(np.broadcast_arrays(*a)),
}  # fmt: skip


def _in_si(match):
    number, unit, below = match.group(1), match.group(2), match.group(3)
    if not unit:
        return number
    scale = _units[unit]
    for other in re.findall(_unit, below or ""):
        scale /= _units[other]
    return f"({number}*{scale!r})"


def _python(text):
    text = re.sub(r"([A-Za-z]\w*)\.([A-Za-z]\w*)", r"\1__\2", text)
    return _number.sub(_in_si, text).replace("^", "**")


def value(text, names):
    """A number, a table {value, unit}, or a formula over `names`."""
    if isinstance(text, dict):
        return value(text["value"], names) * _units.get(text.get("unit", "m"), 1.0)
    if not isinstance(text, str):
        return float(text)
    return eval(_python(text), {"__builtins__": {}}, {**_functions, **names})


def parameters(table):
    """Parameters, each as a number or a text with a unit."""
    known = {}
    for key, text in (table or {}).items():
        known[key] = value(text, known)
    return known


def excess(region, names):
    """How far outside of a region one is, in the limit's unit; <= 0 inside."""
    if isinstance(region, dict):
        if "limit" in region:
            return excess(region["limit"], names)
        if "not" in region:
            return -excess(region["not"], names)
        parts = [excess(part, names) for part in region.get("all_of", region.get("any_of"))]
        parts = np.broadcast_arrays(*parts)
        return (np.maximum if "all_of" in region else np.minimum).reduce(parts)
    pieces = re.split(r"(<=|>=|<|>)", region)
    worst, left = -np.inf, value(pieces[0], names)
    for sign, piece in zip(pieces[1::2], pieces[2::2]):
        right = value(piece, names)
        worst = np.maximum(worst, left - right if sign[0] == "<" else right - left)
        left = right
    return worst
