"""Findings: messages of the program as data; their words stand in files, one for each language.

    finding   a code, its gravity and its values
    tell      sentence and advice of a finding in a language
    words/    LANGUAGE/TOPIC.toml: sentence and advice of every code that begins with the topic

Numeric code yields findings, and refusals carry one. Terminal, page and PDF word them by `told`;
JSON has code, gravity and values beside the English sentence, and the browser app words the same
values by the same files.
"""

from limbgram.findings.finding import Finding, Gravity, Value, doubt, fault, note
from limbgram.findings.tell import LANGUAGES, advice, as_json, sentence, told

__all__ = [
    "LANGUAGES",
    "Finding",
    "Gravity",
    "Value",
    "advice",
    "as_json",
    "doubt",
    "fault",
    "note",
    "sentence",
    "told",
]
