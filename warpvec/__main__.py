"""Run ``python -m warpvec`` as the command ``warpvec``."""

from warpvec.cli.main import main

main(prog_name="warpvec")
