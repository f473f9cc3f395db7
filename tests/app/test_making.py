"""What the page hands to machines that cut."""

from __future__ import annotations

import pytest

from warpvec.app.export import encode
from warpvec.app.making import cut_facts
from warpvec.errors import InputError
from warpvec.making import packages

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
SQUARE = f'{HEAD}<rect fill="#00f" x="10" y="10" width="40" height="40"/></svg>'


def test_without_the_extra_sheets_and_warnings_are_refused_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packages, "find_spec", lambda name: None)
    for ask in (lambda: encode(SQUARE, "zip"), lambda: cut_facts(SQUARE)):
        with pytest.raises(InputError, match=r"need the packages of the extra cut.*pip install 'warpvec\[cut\]'"):
            ask()
