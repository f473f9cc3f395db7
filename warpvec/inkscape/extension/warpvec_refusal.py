"""The exception for what the user has to put right."""


class Refusal(Exception):
    """The work cannot be done. The message is one line for the user, who sees nothing else."""
