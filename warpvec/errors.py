"""The one exception that means: the caller's input was wrong, not the program."""


class InputError(ValueError):
    """Bad input, told in one line: the argument, the rule, the value, and what to do.

    The command line prints it as it stands and exits with code 2.
    """
