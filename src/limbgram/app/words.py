"""Words: the sentences of all findings in a language, once for a page."""

from typing import Literal

from fastapi import APIRouter, Response
from pydantic import BaseModel, Field

from limbgram.findings.tell import all_words, terms

router = APIRouter(tags=["app"])


class CodeWords(BaseModel):
    """What is said of a code; values stand in braces."""

    says: str = Field(description="What, in one sentence.")
    why: str = Field(default="", description="What follows it, before the advice.")
    do: str = Field(default="", description="What to do about it; empty where nothing is.")
    short: str = Field(
        default="", description="For one line of a list; empty where the sentence is short enough."
    )


class WordsReply(BaseModel):
    """The words of every finding."""

    codes: dict[str, CodeWords]
    terms: dict[str, str] = Field(description="Names of things, by their English ones.")


@router.get("/words/{language}")
def words(language: Literal["en", "de"], response: Response) -> WordsReply:
    """The sentences and the advice of all findings."""
    response.headers["cache-control"] = "private, max-age=0, must-revalidate"
    codes = {
        code: CodeWords(says=entry.says, why=entry.why, do=entry.advice("app"), short=entry.short)
        for code, entry in all_words(language).items()
    }
    return WordsReply(codes=codes, terms=dict(terms(language)))
