"""SVGs of other programs, reduced to elements that draw paths."""

from __future__ import annotations

import numpy as np

from warpvec.svg.measure import draw, file_facts
from warpvec.svg.sanitize import sanitize

NS = 'xmlns="http://www.w3.org/2000/svg"'


def test_a_clean_file_keeps_its_drawing() -> None:
    svg = (
        f'<svg {NS} xmlns:i="http://www.inkscape.org/namespaces/inkscape" viewBox="0 0 40 30" width="40">'
        '<title>A &amp; B</title><g id="layer-1-generation-0" i:label="L &lt; 1" transform="scale(2)">'
        '<path fill="#123" fill-opacity=".5" d="M1 1h9v9z"/><circle r="4"/></g>'
        '<defs><linearGradient id="a"><stop stop-color="red"/></linearGradient></defs></svg>'
    )
    document, clean = sanitize(svg)
    assert document.text == svg
    assert np.array_equal(draw(clean), draw(svg))
    assert file_facts(clean)["paths"] == 2
    assert "<title>A &amp; B</title>" in clean
    assert 'label="L &lt; 1"' in clean


def test_active_and_linked_content_is_removed_and_omissions_are_named() -> None:
    svg = (
        f'<svg {NS} xmlns:x="http://www.w3.org/1999/xlink" xmlns:h="http://www.w3.org/1999/xhtml" width="9" height="9"'
        ' onload="a()" style="fill:red" xml:base="http://e.org/"><script>b()</script><style>path{fill:red}</style>'
        '<a x:href="javascript:c()" href="d"><path onclick="e()" d="M0 0h9"/></a><text>t<tspan>u</tspan></text>'
        '<foreignObject><h:iframe src="f"/></foreignObject><animate onbegin="g()"/><use x:href="#y"/>'
        '<metadata>{"a": 1}<h:script>i()</h:script></metadata><?php j() ?><!-- k -->'
        '<h:img src="l" onerror="m()"/><h:path d="M0 0h9"/><path x:d="M0 0h9"/></svg>'
    )
    assert sanitize(svg)[1] == (
        f'<svg {NS} width="9" height="9" css="fill:red"><css>path{{fill:red}}</css><a><path d="M0 0h9"></path></a>'
        '<left-out name="text"/><left-out name="foreignObject"/><left-out name="use"/>'
        '<metadata>{"a": 1}</metadata><path></path></svg>'
    )


def test_gradients_keep_their_geometry_and_the_name_of_their_template() -> None:
    gradients = (
        '<linearGradient id="a" x1="0" gradientUnits="userSpaceOnUse" gradientTransform="rotate(9)" spreadMethod="pad">'
        '<stop offset=".5" stop-color="red" stop-opacity=".5"/></linearGradient>'
    )
    linked = '<radialGradient id="b" fx="1" fy="2" x:href="{}"/>'
    svg = f'<svg {NS} xmlns:x="http://www.w3.org/1999/xlink" width="9" height="9">{gradients}{linked}</svg>'
    clean = sanitize(svg.format(" #a"))[1]
    assert gradients.replace("/></l", "></stop></l") in clean
    assert '<radialGradient id="b" fx="1" fy="2" template="#a">' in clean and "href" not in clean
    assert "template" not in sanitize(svg.format("javascript:a()"))[1]
