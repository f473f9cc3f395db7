"""Write React components: JSX whose <svg> takes the props."""

from __future__ import annotations

from warpvec.writers.writer import Target, Writer


def _encode(svg: str, target: Target) -> bytes:
    from warpvec.svg.on_pages import as_component, component_name  # not above: it loads what the help does without

    return as_component(svg, component_name(target.name)).encode()


WRITER = Writer(".jsx", "text/jsx", _encode)
