"""The exception for wrong input from the caller; any other exception is a failure of the program."""

from __future__ import annotations

import re
from collections.abc import Mapping

_VALUE_MAX = 300
"""Most characters of a value in a message: more than a file name has, and the message stays one line to read."""

_NAME = re.compile(r"(?<![-\w])[a-z]+(?:_[a-z]+)+\b")
"""A name of several words, as Python writes them."""


class InputError(ValueError):
    """Wrong input. The message is one line: "NAME must be RULE, got VALUE; REMEDY".

    Args:
        name: the argument as a Python caller knows it; `renamed` maps it to an option of the command line.
        rule: what is allowed, with its verb: "must be at least 1".
        value: text of the value that was given; None for none in the message.
        remedy: what to do, in the imperative; may be empty.
    """

    def __init__(self, name: str, rule: str, value: str | None = None, remedy: str = "") -> None:
        self.name, self.rule, self.value, self.remedy = name, rule, value, remedy
        given = "" if value is None else f", got {shortened(value)}"
        advice = f"; {remedy}" if remedy else ""
        super().__init__(f"{name} {rule}{given}{advice}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str | None, str]]:
        return type(self), (self.name, self.rule, self.value, self.remedy)

    def renamed(self, names: Mapping[str, str]) -> InputError:
        """Return the same error with the argument, and others that the message mentions, renamed by ``names``.

        Of other arguments only names of several words are replaced: "curves" may be a word of the sentence.
        """
        rule, remedy = (
            _NAME.sub(lambda match: names.get(match[0], match[0]), text) for text in (self.rule, self.remedy)
        )
        return InputError(names.get(self.name, self.name), rule, self.value, remedy)


def shortened(value: str) -> str:
    """Return ``value``, without its middle if that is long: a number can have any number of digits."""
    if len(value) <= _VALUE_MAX:
        return value
    half = _VALUE_MAX // 3
    return f"{value[:half]}... ({len(value)} characters) ...{value[-half:]}"
