"""The one exception that means: the caller's input is wrong, not the program."""

from __future__ import annotations

from collections.abc import Mapping


class InputError(ValueError):
    """Bad input, told in one line: "NAME must be RULE, got VALUE; REMEDY".

    Args:
        name: the argument, as the caller of Python knows it: a keyword, or what the message calls the input.
        rule: what is allowed, with its verb: "must be at least 1".
        value: what was given instead, as it is to be printed; None where there is nothing to print.
        remedy: what to do, in the imperative.
    """

    def __init__(self, name: str, rule: str = "", value: str | None = None, remedy: str = "") -> None:
        self.name, self.rule, self.value, self.remedy = name, rule, value, remedy
        given = "" if value is None else f", got {value}"
        advice = f"; {remedy}" if remedy else ""
        super().__init__(f"{name}{' ' if rule else ''}{rule}{given}{advice}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str | None, str]]:
        return type(self), (self.name, self.rule, self.value, self.remedy)

    def renamed(self, names: Mapping[str, str]) -> InputError:
        """The same error, with the name that ``names`` gives to its argument: the option of a command, say."""
        name, space, rest = self.name.partition(" ")  # TODO: until every error has its fields
        return InputError(names.get(name, name) + space + rest, self.rule, self.value, self.remedy)
