"""Writes python/sightline/_sightline.pyi, what type checkers and editors know of the compiled module, from the docstrings of the
module that is built:

    PYTHONPATH=build/release/python python3 python/packaging/stubs.py
"""

import ast
import inspect
import re
import sys
import types
from pathlib import Path

file = Path(__file__).resolve().parents[1] / "sightline" / "_sightline.pyi"

head = '''# Made by python/packaging/stubs.py.
import os
from collections.abc import Sequence
from typing import Any, ClassVar, Optional

import numpy as np
import numpy.typing as npt
'''

_words = {
    "numpy.ndarray[numpy.float64]": "npt.ArrayLike",
    "os.PathLike": "str | os.PathLike[str]",
    "List": "list",
    "Dict": "dict",
    "Tuple": "tuple",
    "Set": "set",
    "handle": "Any",
    "object": "Any",
    "buffer": "Any",
    "function": "Any",
    "iterable": "Sequence[Any]",
    "sequence": "Sequence[Any]",
    "Sequence": "Sequence[Any]",  # of pybind11 since 2.12
}
_word = re.compile(rf"(?<![\w.])({'|'.join(map(re.escape, _words))})(?!\w)")


def _type(text, given):
    """A type as pybind11 writes it, as Python does; arrays are taken as numpy takes them, and given as they are."""
    text = re.sub(r"sightline\._sightline\.|sightline::(python::)?", "", text.strip())
    text = re.sub(r"(\w)\[\d+\]|Annotated\[(.*?), FixedSize\(\d+\)\]", r"\1\2", text)  # the length of an array
    text = _word.sub(lambda found: _words[found[0]], text)
    if not given:
        text = text.replace("npt.ArrayLike", "npt.NDArray[np.float64]").replace("str | os.PathLike[str]", "os.PathLike[str]")
    try:
        ast.parse(text, mode="eval")
    except SyntaxError:
        return "Any"
    return text


def _split(text):
    """At commas outside of brackets and quotes."""
    parts, depth, start, quote = [], 0, 0, None
    for i, c in enumerate(text):
        if quote:
            quote = None if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "([{<":
            depth += 1
        elif c in ")]}" or (c == ">" and text[i - 1] != "-"):
            depth -= 1
        elif c == "," and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    return [part.strip() for part in [*parts, text[start:]] if part.strip()]


def _parameter(text):
    if text.startswith(("*", "/")):
        return {"*args": "*args: Any", "**kwargs": "**kwargs: Any"}.get(text, text)
    name, _, rest = text.partition(":")
    if name == "self":
        return "self"
    kind, default, _ = rest.partition(" = ")
    return f"{name}: {_type(kind, True)}{' = ...' if default else ''}"


def _signature(line):
    """Name, parameters and result of "name(a: int, b: float = 1.0) -> str"."""
    found = re.fullmatch(r"(?:\d+\. )?(\w*)\((.*)\) -> (.*)", line.strip())
    if found is None:
        return None
    name, parameters, result = found.groups()
    return name, [_parameter(p) for p in _split(parameters)], _type(result, False)


def _doc(text, indent):
    lines = text.strip().replace("(self: handle)", "(self: object)").splitlines()  # of pybind11 before 2.12
    if not lines:
        return " ..."
    body = f"\n{indent}".join(line.rstrip().replace("\\", "\\\\") for line in lines)
    body = re.sub(r"[ ]+\n", "\n", body)
    end = f"\n{indent}" if len(lines) > 1 or body.endswith('"') else ""
    return f'\n{indent}"""{body}{end}"""'


def _function(name, doc, indent, static=False):
    """One definition, or several with @overload."""
    doc = doc or f"{name}(*args, **kwargs) -> object"
    first, _, rest = doc.partition("\n")
    overloads = re.findall(rf"^\d+\. ({re.escape(name)}\(.*)$", doc, re.M) if "Overloaded function" in doc else []
    signatures_of = [_signature(line) for line in (overloads or [first])]
    lines = []
    for signature in signatures_of:
        _, parameters, result = signature or (name, ["*args: Any", "**kwargs: Any"], "Any")
        if parameters == ["**kwargs: Any"]:
            keywords = re.findall(r"^(\w+): .*?(if not given|must be given)$", rest, re.M)
            if keywords:
                parameters = ["*"] + [f"{k}: npt.ArrayLike{' = ...' if how == 'if not given' else ''}" for k, how in keywords]
        if len(overloads) > 1:
            lines.append(f"{indent}@overload")
        if static:
            lines.append(f"{indent}@staticmethod")
        text = "" if overloads else rest
        lines.append(f"{indent}def {name}({', '.join(parameters)}) -> {result}:{_doc(text, indent + '    ')}")
    return lines


def _class(name, kind):
    bases = [base.__name__ for base in kind.__bases__ if base.__module__ == "builtins" and base not in (object,)]
    bases = [base for base in bases if base != "pybind11_object"]
    lines = [f"class {name}{'(' + ', '.join(bases) + ')' if bases else ''}:"]
    if kind.__doc__ and not issubclass(kind, Exception):
        lines.append("    " + _doc(kind.__doc__.split("\n\nMembers:")[0], "    ").strip())
    for word, member in sorted(kind.__dict__.items()):
        if word == "__doc__":
            continue  # a property of enumerations: no attribute of a class is one for a type checker
        if isinstance(member, property):
            signatures_of = member.fget.__doc__ or ""
            signature = _signature(signatures_of.split("\n")[0])
            result = signature[2] if signature else "Any"
            doc = member.__doc__ or ""
            lines.append("    @property")
            lines.append(f"    def {word}(self) -> {result}:{_doc(doc, '        ')}")
        elif isinstance(member, kind):
            lines.append(f"    {word}: ClassVar[{name}]")
        elif word.startswith(("__", "_pybind11")) and word not in _operators:
            continue
        elif isinstance(member, staticmethod):
            lines += _function(word, member.__func__.__doc__, "    ", static=True)
        elif isinstance(member, types.FunctionType):  # of the package: its text has all
            lines.append(f"    def {word}{inspect.signature(member)}:{_doc(member.__doc__, '        ')}".replace("(log", "(self"))
        elif callable(member) and (word != "__init__" or _signature((member.__doc__ or "").split("\n")[0])):
            lines += _function(word, member.__doc__, "    ")
    if len(lines) == 1:
        lines[0] += " ..."
    return lines


_operators = {"__init__", "__getitem__", "__len__", "__call__", "__add__", "__radd__", "__sub__", "__rsub__", "__mul__", "__rmul__",
              "__truediv__", "__rtruediv__", "__pow__", "__neg__"}


def written():
    """The text of the stubs."""
    from sightline import _sightline as module

    blocks = []
    for name in sorted(vars(module)):
        member = getattr(module, name)
        if isinstance(member, type):
            blocks.append("\n".join(_class(name, member)))
        elif callable(member):
            blocks.append("\n".join(_function(name, member.__doc__, "")))
        elif not name.startswith("__") or name == "__version__":
            words = {"tuple": "tuple[str, ...]"}.get(type(member).__name__, type(member).__name__)
            blocks.append(f"{name}: {words}")
    text = "\n\n".join(blocks)
    extra = "overload, " if "@overload" in text else ""
    return head.replace("Optional\n", f"Optional{', overload' if extra else ''}\n", 1) + "\n" + text + "\n"


if __name__ == "__main__":
    file.write_text(written())
    sys.stdout.write(f"{file}\n")
