"""Postpone modules of other packages until something of them is used.

``import torch`` also loads what exports, compiles and distributes models. A command of this package uses none of it,
and it takes a third of the time of the import. These modules are found and named as usual, but their code runs at the
first use of a name in them. Names that a version of these packages lacks do no harm.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from threading import RLock
from types import ModuleType
from typing import Any

POSTPONED = frozenset({
    "torch._meta_registrations",
    "torch.export",
    "torch.masked",
    "torch.quantization",
    "torch.distributions",
    "numpy.f2py",
    "scipy.spatial.transform",
})  # fmt: skip
"""Modules that take more than a hundredth of a second, and that their packages load without using them."""


_LAST_KNOWN = {"torch": (2, 13), "scipy": (1, 17)}
"""The last versions that were tried with what this module changes in them. Newer ones load as they are."""

_COMPILERS = frozenset({"torch._dynamo", "torch._inductor"})
"""Torch's compilers. Before one is loaded, the postponed modules must have run."""


def postpone() -> None:
    """Have this process load the modules of `POSTPONED` when they are first used, or when torch's compiler is loaded.

    Only for a process that runs a command: tensors of the device "meta" know few functions before.
    """
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())


class _Finder(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname in _COMPILERS:
            _load_now()
        if fullname == _DOCUMENTED and _is_known("scipy"):
            return _with_loader(PathFinder.find_spec(fullname, path, target), _PlainDocs)
        if fullname not in POSTPONED or (fullname.startswith("torch.") and not _is_known("torch")):
            return None
        return _with_loader(PathFinder.find_spec(fullname, path, target), _Loader)


def _with_loader(spec: ModuleSpec | None, make: Callable[[Loader], Loader]) -> ModuleSpec | None:
    """Return ``spec`` with the loader that ``make`` makes of its own."""
    if spec is not None and spec.loader is not None:
        spec.loader = make(spec.loader)
    return spec


def _is_known(package: str) -> bool:
    """Return whether a ``package``, which is being imported, is of a known version."""
    found = re.match(r"(\d+)\.(\d+)", str(getattr(sys.modules.get(package), "__version__", "")))
    return found is not None and (int(found[1]), int(found[2])) <= _LAST_KNOWN[package]


def _load_now() -> None:
    for name in sorted(POSTPONED & sys.modules.keys()):
        module = sys.modules[name]
        if isinstance(module, _Postponed):
            module.run()


class _Loader(Loader):
    """Makes a module whose code has not run yet."""

    def __init__(self, loader: Loader) -> None:
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _Postponed(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        assert module.__spec__ is not None
        module.__loader__ = module.__spec__.loader = self._loader


_DOCUMENTED = "scipy._lib._array_api"
"""The module with which SciPy adds a note to the text of every function for people to read."""


class _PlainDocs(Loader):
    """Has SciPy leave the texts of its functions as they are. Reading them takes a twentieth of a short run."""

    def __init__(self, loader: Loader) -> None:
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        if hasattr(module, "FunctionDoc"):
            module.FunctionDoc = _PlainDoc  # type: ignore[attr-defined]


class _PlainDoc(dict[str, list[str]]):
    """The text of a function, to which notes can be added that nobody reads."""

    def __init__(self, function: object) -> None:
        super().__init__(Notes=[])
        self._text = function.__doc__ or ""

    def __str__(self) -> str:
        return "signature\n" + self._text


class _Postponed(ModuleType):
    """A module that runs its code when a name is asked for that it does not have."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__lock, self.__is_running = RLock(), False

    def __getattr__(self, name: str) -> Any:
        # Functions that look at every module, such as those of `inspect`, ask only for names of this kind.
        if not (name.startswith("__") and name.endswith("__")):
            self.run()
            if name in vars(self):
                return vars(self)[name]
            if "__getattr__" in vars(self):
                return vars(self)["__getattr__"](name)
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")

    def run(self) -> None:
        """Run the code, once. Its own requests for names come here too while it runs."""
        with self.__lock:
            if self.__is_running or not isinstance(self, _Postponed):  # another thread has run it
                return
            assert self.__spec__ is not None and self.__spec__.loader is not None
            self.__is_running = True
            try:
                self.__spec__.loader.exec_module(self)
            finally:
                self.__is_running = False
            self.__class__ = ModuleType  # type: ignore[assignment]
