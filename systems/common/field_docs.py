"""The texts of the fields of a class: the strings below them, read on demand.

A configuration documents each field, with its unit, by a string below it, which
code editors and the docs site show. Help at a prompt, the JSON schema and the
pages that are made from it take their texts from there.
"""

from collections.abc import Callable
import dataclasses
from enum import EnumType
import functools
import inspect
import textwrap
import types
from typing import (
    Annotated,
    Any,
    Literal,
    Self,
    SupportsIndex,
    Union,
    get_args,
    get_origin,
)

_UNIONS = (Union, types.UnionType)


def field_docs(cls: type[Any]) -> dict[str, str]:
    """Returns the texts of the fields of a class and its bases, one line each.

    There are none where its source is not kept, as at a prompt.
    """
    docs: dict[str, str] = {}
    for base in reversed(cls.__mro__[:-1]):
        docs.update(_own_docs(base))
    return docs


@functools.cache
def _own_docs(cls: type[Any]) -> dict[str, str]:
    # Imported only on demand.
    import ast

    if cls.__module__ == "builtins":
        return {}
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(cls)))
    except (OSError, TypeError, SyntaxError):
        return {}
    docs: dict[str, str] = {}
    name = ""
    for node in getattr(tree.body[0], "body", []):
        match node:
            case ast.Expr(value=ast.Constant(value=str(text))) if name:
                docs[name] = " ".join(text.split())
                name = ""
            case (
                ast.AnnAssign(target=ast.Name(id=field))
                | ast.Assign(targets=[ast.Name(id=field)])
            ):
                name = field
            case _:
                name = ""
    return docs


def class_doc(cls: type[Any]) -> str:
    """Returns the docstring of a class as it is written."""
    return inspect.cleandoc(str(vars(cls).get("__doc__") or ""))


def explain[T: type[Any]](cls: T) -> T:
    """Adds the fields, or the members of an enum, to the help of a class.

    The help is composed on demand, so that importing takes no longer.
    """
    known: Any = cls
    text = class_doc(cls)
    if text.startswith(f"{cls.__name__}("):
        # A dataclass without a docstring has its signature.
        text = ""
    known.__doc__ = _Doc(text, cls)
    if (signature := vars(cls).get("__signature__")) is not None:
        known.__signature__ = _Signature(signature)
    return cls


class _Doc(str):
    """The docstring of a class, to which a section on its fields is added.

    The attribute of the class is the whole text. `help` bypasses a metaclass,
    and gets this text itself, of which it first expands the tabs.
    """

    owner: type[Any]

    def __new__(cls, text: str, owner: type[Any]) -> Self:
        """Makes the docstring of a class."""
        made = super().__new__(cls, text)
        made.owner = owner
        return made

    def __get__(self, instance: Any, owner: type[Any]) -> str:
        docs = field_docs(owner)
        if instance is not None and isinstance(owner, EnumType):
            # The text of a member.
            return docs.get(instance.name, "")
        is_data = dataclasses.is_dataclass(owner)
        names = (
            [field.name for field in dataclasses.fields(owner)]
            if is_data
            else list(owner.__dict__)
        )
        told = [
            textwrap.fill(
                f"{name}: {docs[name]}",
                width=80,
                initial_indent="    ",
                subsequent_indent="        ",
                break_long_words=False,
                break_on_hyphens=False,
            )
            for name in names
            if name in docs
        ]
        return "\n".join([self, "", "Attributes:", *told]) if told else self

    def expandtabs(self, tabsize: SupportsIndex = 8) -> str:
        """Returns the whole docstring of the class."""
        return self.__get__(None, self.owner)


class _Signature:
    """The signature of a class, with readable types."""

    def __init__(self, signature: Any) -> None:
        self._signature = signature

    def __get__(self, instance: Any, owner: type[Any]) -> Any:
        signature = self._signature
        get: Callable[..., Any] | None = getattr(signature, "__get__", None)
        if get is not None:
            signature = get(None, owner)
        return signature.replace(
            parameters=[
                parameter.replace(
                    annotation=_Shown(_said(parameter.annotation))
                )
                for parameter in signature.parameters.values()
            ],
            return_annotation=inspect.Signature.empty,
        )


class _Shown(str):
    """A text that signatures show without quotes."""

    def __repr__(self) -> str:
        return str(self)


def _said(annotation: Any) -> str:
    """Returns a type as text, without rules and modules."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _said(parts[0])
    if origin is Literal:
        return " | ".join(repr(part) for part in parts)
    if origin in _UNIONS:
        return " | ".join(dict.fromkeys(_said(part) for part in parts))
    if annotation is type(None):
        return "None"
    if annotation is ...:
        return "..."
    name = getattr(origin or annotation, "__name__", str(annotation))
    return f"{name}[{', '.join(map(_said, parts))}]" if parts else name
