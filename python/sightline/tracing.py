"""Potentials, robots and references of one's own, as Python functions.

A function is called once, with recording scalars in place of numbers; what it computes with them is its formula. Gradients,
Hessians and kernels follow from that, as for a formula in C++ or in a scenario, and no Python runs in a flight. What has no
derivative, or decides by a value that is not there yet, is refused with the line where it stands and the word to use.
"""

import inspect
import linecache
import math
import os
import re
import sys
from dataclasses import dataclass

import numpy as np

from . import _sightline

_own = os.path.dirname(os.path.abspath(__file__)) + os.sep
_numpy = os.path.dirname(os.path.abspath(np.__file__)) + os.sep


class TraceError(ValueError):
    """A function that cannot be recorded: "file:line: what is there, and what to use"."""


def _is_foreign(filename):
    """Whether a frame is neither ours nor numpy's, some of which have no file."""
    if filename.startswith(("<__array_function__", "<frozen")):
        return False
    return not os.path.abspath(filename).startswith((_own, _numpy))


def _user_frame():
    frame = sys._getframe(1)
    while frame is not None and not _is_foreign(frame.f_code.co_filename):
        frame = frame.f_back
    return frame


def _place(frame):
    if frame is None:
        return "<function>"
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"


def _source(frame):
    """The text of the call or the operation that a frame is in; its whole line where Python does not say more."""
    if frame is None:
        return ""
    line = linecache.getline(frame.f_code.co_filename, frame.f_lineno).strip()
    if not hasattr(frame.f_code, "co_positions"):
        return line
    positions = list(frame.f_code.co_positions())
    first, last, begin, end = positions[frame.f_lasti // 2]
    if None in (first, last, begin, end) or first != last:
        return line
    # Columns are counted in bytes.
    text = linecache.getline(frame.f_code.co_filename, first).encode()
    return text[begin:end].decode(errors="replace") or line


def _refuse(what, use):
    frame = _user_frame()
    raise TraceError(f"{_place(frame)}: {what}; {use}")


# What to write for what takes numbers alone.
_words = {
    "acos": "sl.atan2(sl.sqrt(1 - x * x), x)",
    "asin": "sl.atan2(x, sl.sqrt(1 - x * x))",
    "atan": "sl.atan2(x, 1.0)",
    "atan2": "sl.atan2",
    "ceil": None,
    "copysign": "abs",
    "cos": "sl.cos",
    "cosh": "0.5 * (sl.exp(x) + sl.exp(-x))",
    "degrees": "180 / math.pi * x",
    "dist": "sl.sqrt(r @ r)",
    "exp": "sl.exp",
    "expm1": "sl.exp(x) - 1",
    "fabs": "abs",
    "floor": None,
    "fmod": None,
    "hypot": "sl.sqrt(x * x + y * y)",
    "log": "sl.log",
    "log10": "sl.log(x) / math.log(10)",
    "log1p": "sl.log(1 + x)",
    "log2": "sl.log(x) / math.log(2)",
    "pow": "x ** n",
    "radians": "math.pi / 180 * x",
    "sin": "sl.sin",
    "sinh": "0.5 * (sl.exp(x) - sl.exp(-x))",
    "sqrt": "sl.sqrt",
    "tan": "sl.sin(x) / sl.cos(x)",
    "tanh": "2 * sl.logistic(2 * x) - 1",
}
_functions = "abs, sl.sqrt, sl.sin, sl.cos, sl.atan2, sl.exp, sl.log, sl.logistic, sl.softplus, sl.maximum, sl.minimum"
_no_branch = "use one expression for all values, with sl.logistic, sl.softplus, sl.maximum or sl.minimum"


def _refuse_number(asked):
    source = _source(_user_frame())
    called = re.match(r"(?:\w+\.)*(\w+)\s*\(", source)
    word = called.group(1) if called else None
    if word in _words:
        use = _words[word]
        _refuse(f"{source} takes numbers, not what is recorded",
                f"use {use}" if use else f"it has no derivative, expected {_functions}")
    _refuse(f"{source or asked} asks for a number, which is not there yet", f"expected {_functions}")


class Symbol:
    """What a recorded function computes with: a step of its formula."""

    __slots__ = ("_recorder", "_step")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, recorder, step):
        self._recorder = recorder
        self._step = step

    def __repr__(self):
        return f"<symbol {self._step}>"

    def _other(self, other):
        """The step of an operand, or None for what is no number."""
        if isinstance(other, Symbol):
            if other._recorder is not self._recorder:
                _refuse("it computes with what another function recorded", "expected its own arguments and numbers")
            return other._step
        if isinstance(other, (bool, np.bool_)) or not isinstance(other, (int, float, np.integer, np.floating)):
            return None
        return self._recorder.constant(float(other))

    def _binary(self, word, other, turned=False):
        step = self._other(other)
        if step is None:
            return NotImplemented
        a, b = (step, self._step) if turned else (self._step, step)
        return Symbol(self._recorder, getattr(self._recorder, word)(a, b))

    def _unary(self, word):
        return Symbol(self._recorder, getattr(self._recorder, word)(self._step))

    def __add__(self, other):
        return self._binary("add", other)

    def __radd__(self, other):
        return self._binary("add", other, turned=True)

    def __sub__(self, other):
        return self._binary("subtract", other)

    def __rsub__(self, other):
        return self._binary("subtract", other, turned=True)

    def __mul__(self, other):
        return self._binary("multiply", other)

    def __rmul__(self, other):
        return self._binary("multiply", other, turned=True)

    def __truediv__(self, other):
        return self._binary("divide", other)

    def __rtruediv__(self, other):
        return self._binary("divide", other, turned=True)

    def __neg__(self):
        return self._unary("negate")

    def __pos__(self):
        return self

    def __abs__(self):
        return self._unary("absolute")

    def __pow__(self, power, modulus=None):
        if modulus is not None:
            _refuse("a power with a modulus has no derivative", f"expected {_functions}")
        if isinstance(power, Symbol):
            _refuse("a power that is recorded", "use sl.exp(n * sl.log(x)), for x > 0")
        if isinstance(power, (int, float, np.integer, np.floating)) and not isinstance(power, bool):
            twice = 2 * float(power)
            if twice.is_integer() and abs(twice) <= 128:
                if twice % 2 == 0:
                    return Symbol(self._recorder, self._recorder.power(self._step, int(power)))
                return self._unary("sqrt") * self ** (int(twice - 1) // 2)
        _refuse(f"the power {power!r}", "expected a whole number or half of one up to 64; else use sl.exp(n * sl.log(x))")

    def __rpow__(self, base):
        _refuse("a power that is recorded", "use sl.exp(n * math.log(base))")

    # Methods that numpy calls on objects, element by element.
    def sqrt(self):
        return self._unary("sqrt")

    def sin(self):
        return self._unary("sin")

    def cos(self):
        return self._unary("cos")

    def exp(self):
        return self._unary("exp")

    def log(self):
        return self._unary("log")

    def conjugate(self):
        return self

    def __array_ufunc__(self, ufunc, method, *inputs, **given):
        made = _ufuncs.get(ufunc.__name__)
        if made is None or method != "__call__" or given:
            called = f"np.{ufunc.__name__}" + ("" if method == "__call__" else f".{method}")
            use = _words.get(_math_names.get(ufunc.__name__, ufunc.__name__))
            _refuse(f"{called} of what is recorded", f"use {use}" if use else f"expected {_functions}")
        # A number of numpy's would ask its ufunc again.
        inputs = [i.item() if isinstance(i, np.generic) else i for i in inputs]
        if not any(isinstance(i, np.ndarray) for i in inputs):
            return made(*inputs)
        objects = [np.asarray(i, dtype=object) for i in inputs]
        return np.frompyfunc(made, len(objects), 1)(*objects)

    # What decides by a value, or asks for one.
    def _compare(self, other, word):
        _refuse(f"it compares what is recorded ({_source(_user_frame())})", _no_branch)

    def __lt__(self, other):
        self._compare(other, "<")

    def __le__(self, other):
        self._compare(other, "<=")

    def __gt__(self, other):
        self._compare(other, ">")

    def __ge__(self, other):
        self._compare(other, ">=")

    def __eq__(self, other):
        self._compare(other, "==")

    def __ne__(self, other):
        self._compare(other, "!=")

    def __bool__(self):
        _refuse(f"it decides by what is recorded ({_source(_user_frame())})", _no_branch)

    def __float__(self):
        _refuse_number("float")

    def __int__(self):
        _refuse_number("int")

    def __complex__(self):
        _refuse_number("complex")

    def __index__(self):
        _refuse_number("an index")

    def __round__(self, digits=None):
        _refuse_number("round")

    def __trunc__(self):
        _refuse_number("trunc")

    def __floor__(self):
        _refuse_number("floor")

    def __ceil__(self):
        _refuse_number("ceil")

    def _refuse_remainder(self, other):
        _refuse("a remainder or a whole part of what is recorded has no derivative", f"expected {_functions}")

    __mod__ = __rmod__ = __floordiv__ = __rfloordiv__ = __divmod__ = __rdivmod__ = _refuse_remainder


def _of(word, of_number):
    """A function of one argument over symbols, numbers and arrays."""

    def function(x):
        if isinstance(x, Symbol):
            return x._unary(word)
        if isinstance(x, (np.ndarray, list, tuple)):
            return np.frompyfunc(function, 1, 1)(np.asarray(x, dtype=object))
        return of_number(x)

    function.__name__ = function.__qualname__ = word
    return function


def _of_two(word, of_numbers):
    """The same of two arguments."""

    def function(a, b):
        if isinstance(a, (np.ndarray, list, tuple)) or isinstance(b, (np.ndarray, list, tuple)):
            return np.frompyfunc(function, 2, 1)(np.asarray(a, dtype=object), np.asarray(b, dtype=object))
        if isinstance(a, Symbol):
            result = a._binary(word, b)
        elif isinstance(b, Symbol):
            result = b._binary(word, a, turned=True)
        else:
            return of_numbers(a, b)
        if result is NotImplemented:
            _refuse(f"{word} of {a!r} and {b!r}", "expected arguments of the function and numbers")
        return result

    function.__name__ = function.__qualname__ = word
    return function


def _logistic(x):
    return 1.0 / (1.0 + math.exp(-x)) if x >= 0 else math.exp(x) / (1.0 + math.exp(x))


def _softplus(x):
    return max(x, 0.0) + math.log1p(math.exp(-abs(x)))


sqrt = _of("sqrt", math.sqrt)
sin = _of("sin", math.sin)
cos = _of("cos", math.cos)
exp = _of("exp", math.exp)
log = _of("log", math.log)
logistic = _of("logistic", _logistic)
softplus = _of("softplus", _softplus)
atan2 = _of_two("atan2", math.atan2)
maximum = _of_two("maximum", max)
minimum = _of_two("minimum", min)

_ufuncs = {
    "absolute": abs,
    "add": lambda a, b: a + b,
    "arctan2": atan2,
    "cos": cos,
    "divide": lambda a, b: a / b,
    "exp": exp,
    "fabs": abs,
    "hypot": lambda a, b: sqrt(a * a + b * b),
    "log": log,
    "maximum": maximum,
    "minimum": minimum,
    "multiply": lambda a, b: a * b,
    "negative": lambda a: -a,
    "positive": lambda a: a,
    "power": lambda a, b: a**b,
    "reciprocal": lambda a: 1.0 / a,
    "sin": sin,
    "sqrt": sqrt,
    "square": lambda a: a * a,
    "subtract": lambda a, b: a - b,
    "true_divide": lambda a, b: a / b,
}
# numpy's names for what math calls otherwise.
_math_names = {"arccos": "acos", "arcsin": "asin", "arctan": "atan", "rint": "floor", "trunc": "floor",
               "float_power": "pow", "remainder": "fmod", "deg2rad": "radians", "rad2deg": "degrees"}


@dataclass(frozen=True)
class TracedSight:
    """What a recorded function sees of a body, in G: arrays of symbols, as Sight has numbers."""

    p: np.ndarray  # position [m], 3
    d: np.ndarray  # heading (cos psi, sin psi), 2
    v: np.ndarray  # velocity [m/s], 3
    lean: np.ndarray  # forward and to the left, 2


def _objects(symbols):
    array = np.empty(len(symbols), dtype=object)
    array[:] = symbols
    return array


def _sight(symbols):
    return TracedSight(_objects(symbols[0:3]), _objects(symbols[3:5]), _objects(symbols[5:8]), _objects(symbols[8:10]))


def _where(function):
    code = getattr(function, "__code__", None)
    return f"{code.co_filename}:{code.co_firstlineno}" if code else repr(function)


def _name(function):
    name = getattr(function, "__name__", "python")
    return name if name.isidentifier() else "python"


def _called(function, arguments):
    """The value of the function at the symbols; all that goes wrong in it is a TraceError with its line."""
    try:
        return function(**arguments)
    except TraceError:
        raise
    except Exception as error:
        place, walk = _where(function), error.__traceback__
        while walk is not None:
            if _is_foreign(walk.tb_frame.f_code.co_filename):
                place = f"{walk.tb_frame.f_code.co_filename}:{walk.tb_lineno}"
            walk = walk.tb_next
        raise TraceError(f"{place}: {error or type(error).__name__}; expected an expression of {_functions}") from error


def _step_of(function, recorder, result):
    if isinstance(result, np.ndarray) and result.ndim == 0:
        result = result.item()
    if isinstance(result, Symbol):
        if result._recorder is not recorder:
            raise TraceError(f"{_where(function)}: it returns what another function recorded, expected its own formula")
        return result._step
    if isinstance(result, (int, float, np.integer, np.floating)) and not isinstance(result, (bool, np.bool_)):
        return recorder.constant(float(result))
    raise TraceError(f"{_where(function)}: it returns {type(result).__name__}, expected one number")


def _formula(function, recorder, result):
    """The formula of what a function returned."""
    try:
        return recorder.finish(_step_of(function, recorder, result))
    except TraceError:
        raise
    except ValueError as error:
        raise TraceError(f"{_where(function)}: {error}") from error


def _taken(function, known, parameters):
    """Which of the known arguments a function takes."""
    taken = set()
    for name, argument in inspect.signature(function).parameters.items():
        if argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD, argument.POSITIONAL_ONLY):
            raise TraceError(f"{_where(function)}: the argument {argument}, expected arguments with names: {', '.join(known)}")
        if name in known:
            taken.add(name)
        elif name not in parameters and argument.default is argument.empty:
            raise TraceError(f"{_where(function)}: the argument {name}, expected one of {', '.join(known)}, "
                             "or a parameter that is given")
    for name in parameters:
        if name not in inspect.signature(function).parameters:
            raise TraceError(f"{_where(function)}: no argument for the parameter {name} that is given")
    return taken


_pair_arguments = ("observer", "target", "seen", "t")
_single_arguments = ("robot", "t")


def _record(function, is_pair, parameters):
    """The formula of a potential, or of its limit."""
    size = _sightline.sight_size
    known = _pair_arguments if is_pair else _single_arguments
    recorder = _sightline.Recorder(3 + 2 * size + 1 if is_pair else size + 1)
    symbols = [Symbol(recorder, recorder.variable(i)) for i in range(3 + 2 * size + 1 if is_pair else size + 1)]
    if is_pair:
        values = {"seen": _objects(symbols[0:3]), "observer": _sight(symbols[3:3 + size]),
                  "target": _sight(symbols[3 + size:3 + 2 * size]), "t": symbols[-1]}
    else:
        values = {"robot": _sight(symbols[:size]), "t": symbols[-1]}
    taken = _taken(function, known, parameters)
    result = _called(function, {**parameters, **{name: values[name] for name in taken}})
    return _formula(function, recorder, result)


def potential(function=None, *, limit=None, mount=None, name=None, **parameters):
    """A potential of one's own from a function of what two bodies show, or of what one robot shows.

    function: takes, by their names, what it needs of `observer`, `target` (p, d, v, lean in G), `seen` (the target in the sensor
    frame, x along the axis [m]) and `t` [s]; or, of one robot, `robot` and `t`. Gives l [-].
    limit: a function of the same arguments that is > 0 where the limit is broken; figures and judgements use it.
    mount: the SensorMount by which `seen` is meant; a scenario's or `seen_from` sets another.
    Other arguments are parameters of the function.

    Called once, here. As a decorator, `@sl.potential` makes the function a Potential.

        def sonar(seen, reach=4.0):
            return sl.softplus(3 * (sl.sqrt(seen @ seen) - reach))

        team.couple(0.4 * sl.potential(sonar, reach=3.0), between=(uav0, uav1), felt_by=uav0)
    """
    if function is None:
        return lambda f: potential(f, limit=limit, mount=mount, name=name, **parameters)
    arguments = inspect.signature(function).parameters
    is_pair = any(word in arguments for word in ("observer", "target", "seen"))
    if not is_pair and "robot" not in arguments:
        raise TraceError(f"{_where(function)}: it takes {', '.join(arguments) or 'nothing'}, expected one or more of "
                         f"{', '.join(_pair_arguments)}, or robot")
    if is_pair and "robot" in arguments:
        raise TraceError(f"{_where(function)}: it takes robot beside bodies of a pair, expected robot, or observer and target")
    if mount is not None and not is_pair:
        raise TraceError(f"{_where(function)}: a mount for a potential of one robot, expected one that takes seen")
    formula = _record(function, is_pair, parameters)
    of_limit = None
    if limit is not None:
        own = {k: v for k, v in parameters.items() if k in inspect.signature(limit).parameters}
        of_limit = _record(limit, is_pair, own)
    called = name or _name(function)
    if is_pair:
        return _sightline.recorded_pair(called, formula, of_limit, mount)
    return _sightline.recorded_single(called, formula, of_limit)


def _list_of(function, recorder, result):
    """The formulas of the numbers that a function returned."""
    if not isinstance(result, (list, tuple, np.ndarray)):
        raise TraceError(f"{_where(function)}: it returns {type(result).__name__}, expected a list with a number for each state")
    return [_formula(function, recorder, one) for one in result]


def robot(function=None, *, states, inputs, position=("p_x", "p_y", "p_z"), heading=(), u_min=None, u_max=None, name=None,
          **parameters):
    """A robot of one's own from a function that gives the rate x' of each state.

    function: takes `x` and `u`, arrays in the order of states and inputs, and parameters
    states, inputs: their names; at most 16 and 8
    position: the states that are p_x, p_y, p_z in G [m]; heading: the state psi [rad], or the two of the direction; none: along x
    u_min, u_max: limits of the inputs; -1 and 1 if not given

    Called once, here. As a decorator, `@sl.robot(states=..., inputs=...)` makes the function a Model::

        @sl.robot(states=["p_x", "p_y", "p_z", "psi", "v"], inputs=["a", "w"], heading=["psi"])
        def car(x, u, drag=0.5):
            psi, v = x[3], x[4]
            return [v * sl.cos(psi), v * sl.sin(psi), 0, u[1], u[0] - drag * v]
    """
    if function is None:
        return lambda f: robot(f, states=states, inputs=inputs, position=position, heading=heading, u_min=u_min, u_max=u_max,
                               name=name, **parameters)
    if len(position) != 3:
        raise TraceError(f"{_where(function)}: position = {position!r}, expected the names of three states")
    recorder = _sightline.Recorder(len(states) + len(inputs))
    symbols = [Symbol(recorder, recorder.variable(i)) for i in range(len(states) + len(inputs))]
    values = {"x": _objects(symbols[:len(states)]), "u": _objects(symbols[len(states):])}
    taken = _taken(function, ("x", "u"), parameters)
    rates = _list_of(function, recorder, _called(function, {**parameters, **{word: values[word] for word in taken}}))
    try:
        return _sightline.recorded_robot(name or _name(function), rates, list(states), list(inputs), list(position),
                                         list(heading), u_min, u_max)
    except ValueError as error:
        raise TraceError(f"{_where(function)}: {error}") from error


def reference(function):
    """A reference of one's own: a function of the time t [s] that gives the state x*(t), a number for each state.

    Called once, here; as a decorator it makes the function a Reference.

        uav1 = team.add(sl.multirotor(), Q=..., x_ref=sl.reference(
            lambda t: [0.5 * sl.cos(0.3 * t), 0.5 * sl.sin(0.3 * t), 1, 0, 0, 0, 0]))
    """
    recorder = _sightline.Recorder(1)
    _taken(function, ("t",), {})
    result = _called(function, {"t": Symbol(recorder, recorder.variable(0))})
    states = _list_of(function, recorder, result)
    try:
        return _sightline.recorded_reference(states)
    except ValueError as error:
        raise TraceError(f"{_where(function)}: {error}") from error
