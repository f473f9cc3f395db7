"""Run ``python -m warpvec``, and the installed script ``warpvec``."""

from warpvec.cli.loading import end_quickly
from warpvec.cli.signals import run_command


def main() -> None:
    """Run the command ``warpvec`` with the arguments of the process."""
    end_quickly()
    run_command(_command)


def _command() -> None:
    # Imported here, so that a signal during these imports is handled too.
    from warpvec.cli.main import main

    main(prog_name="warpvec")


if __name__ == "__main__":
    main()
