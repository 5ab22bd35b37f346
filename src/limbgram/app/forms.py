"""Forms: what a request or an edit says of its own fields, for the client to make a form of.

A body of the API has no fields beside its own (`RequestBody`, `REQUEST`), and one that is a request
of `services` has its fields' meanings in the description of the API (`REQUEST`).
"""

from dataclasses import MISSING
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from limbgram.core.request_fields import Declared, declared
from limbgram.core.typed import tree_of, words_of_type


def _with_meanings(schema: dict[str, Any], kind: type) -> None:
    for one in declared(kind):
        if one.meaning and one.name in schema["properties"]:
            schema["properties"][one.name].setdefault("description", one.meaning)


REQUEST = ConfigDict(
    extra="forbid", use_attribute_docstrings=True, json_schema_extra=_with_meanings
)
"""`__pydantic_config__` of a request that comes as a body."""


class RequestBody(BaseModel):
    """A body, or a part of one: a field that it does not have is refused."""

    model_config = ConfigDict(extra="forbid")


class FieldReply(BaseModel):
    """One field."""

    name: str
    expected: str = Field(description="Its type, for people.")
    meaning: str
    unit: str = ""
    needed: bool = Field(description="Has no default.")
    default: Any = None
    usual: float | None = Field(
        default=None,
        description="Taken where the default is null and neither a file nor a preset says it.",
    )
    least: float | None = None
    most: float | None = None
    above: bool = Field(default=False, description="The least itself is not taken.")
    choices: list[str] = Field(default=[], description="Words to choose from; empty: any.")
    several: bool = False

    @classmethod
    def of(cls, one: Declared) -> "FieldReply":
        return cls(
            name=one.name,
            expected=words_of_type(one.hint),
            meaning=one.meaning,
            unit=one.unit,
            needed=one.required,
            default=None if one.default is MISSING else tree_of(one.default),
            usual=one.usual,
            least=None if one.within is None else one.within.least,
            most=None if one.within is None else one.within.most,
            above=one.within is not None and one.within.above,
            choices=list(one.choices),
            several=one.several,
        )
