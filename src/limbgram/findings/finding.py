"""A finding: one message of the program, as data.

The code names its words: `tape.conflict` stands under `[conflict]` in `words/en/tape.toml`. The
values fill in the sentence; a value's name carries its unit (`height_mm`, `share`). A place is
given by `point_mm` (x, y, z in the shape's frame), `height_mm` (in the limb's frame) or `photo` (a
name), which displays mark.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Union, cast


class Gravity(StrEnum):
    """Severity of a finding, the least first."""

    NOTE = "note"
    """Good to know."""
    DOUBT = "doubt"
    """Weakens the result, or needs somebody to look."""
    FAULT = "fault"
    """Spoils the result, or refuses it."""


Value = Union[None, bool, int, float, str, "Finding", tuple["Value", ...]]
"""A value of a sentence; a finding as a value is the reason of the outer one."""


@dataclass(frozen=True)
class Finding:
    """One message of the program, as data."""

    code: str
    """Topic and name, with dots: `tape.conflict`."""
    gravity: Gravity = Gravity.NOTE
    values: Mapping[str, Value] = field(default_factory=dict[str, Value], hash=False)

    def __str__(self) -> str:
        """Its English sentence and advice."""
        from limbgram.findings.tell import told  # tells findings, and stands above them

        return told(self)

    def tree(self) -> dict[str, Any]:
        """Code, gravity and values, as JSON keeps them."""
        values = {name: _tree_of(value) for name, value in self.values.items()}
        return {"code": self.code, "gravity": self.gravity.value, "values": values}

    def with_texts(self, change: Callable[[str], str]) -> "Finding":
        """The finding with every text among its values changed, such as paths shortened."""
        values = {name: _changed(value, change) for name, value in self.values.items()}
        return Finding(self.code, self.gravity, values)

    def about(self, what: str) -> "Finding":
        """The finding with `what` as the subject of its sentence, unless it has one."""
        return Finding(self.code, self.gravity, {"what": what, **self.values})

    @classmethod
    def from_tree(cls, tree: object) -> "Finding":
        """Inverse of `tree`.

        Raises:
            ValueError: the tree is no finding.
        """
        match tree:
            case {"code": str(code), "gravity": str(gravity), "values": dict(values)}:
                known = cast(dict[str, object], values)
                read = {name: _value_of(value) for name, value in known.items()}
                return cls(code, Gravity(gravity), read)
            case _:
                raise ValueError("it is no finding")

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, _handler: Any) -> Any:
        """Lets dataclasses that hold findings be bodies and answers of the app."""
        from pydantic_core import core_schema as schema

        fields = {
            "code": schema.typed_dict_field(schema.str_schema()),
            "gravity": schema.typed_dict_field(
                schema.literal_schema([one.value for one in Gravity])
            ),
            "values": schema.typed_dict_field(schema.dict_schema(schema.str_schema())),
            "sentence": schema.typed_dict_field(schema.str_schema(), required=False),
        }
        return schema.no_info_after_validator_function(
            cls.from_tree,
            schema.typed_dict_schema(fields, cls_name="Finding"),
            serialization=schema.plain_serializer_function_ser_schema(
                cls.tree, return_schema=schema.typed_dict_schema(fields, cls_name="Finding")
            ),
        )


def note(code: str, /, **values: Value) -> Finding:
    """A finding that is good to know."""
    return Finding(code, Gravity.NOTE, values)


def doubt(code: str, /, **values: Value) -> Finding:
    """A finding that weakens the result, or needs somebody to look."""
    return Finding(code, Gravity.DOUBT, values)


def fault(code: str, /, **values: Value) -> Finding:
    """A finding that spoils the result, or refuses it."""
    return Finding(code, Gravity.FAULT, values)


def _changed(value: Value, change: Callable[[str], str]) -> Value:
    match value:
        case str():
            return change(value)
        case Finding():
            return value.with_texts(change)
        case tuple():
            return tuple(_changed(one, change) for one in value)
        case _:
            return value


def _tree_of(value: Value) -> Any:
    match value:
        case Finding():
            return value.tree()
        case tuple():
            return [_tree_of(one) for one in value]
        case float():
            return value if abs(value) < float("inf") else None  # NaN compares false
        case _:
            return value


def _value_of(tree: object) -> Value:
    match tree:
        case {"code": _}:
            return Finding.from_tree(tree)
        case list():
            return tuple(_value_of(one) for one in cast(list[object], tree))
        case None | bool() | int() | float() | str():
            return tree
        case _:
            raise ValueError(f"{tree!r:.60} is no value of a finding")
