"""The types of the public names, which `warpvec/__init__.py` loads when they are first used."""

from warpvec import edit as edit
from warpvec.api import refine as refine
from warpvec.api import vectorize as vectorize
from warpvec.config.fit_config import FitConfig as FitConfig
from warpvec.config.presets import PRESETS as PRESETS
from warpvec.config.presets import make_config as make_config
from warpvec.errors import InputError as InputError
from warpvec.geometry.scene import Scene as Scene
from warpvec.placeholders.placeholder import placeholder as placeholder
from warpvec.rendering.operator import render as render
from warpvec.result import Result as Result

__version__: str
