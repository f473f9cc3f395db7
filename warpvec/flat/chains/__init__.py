"""Lines, arcs and cubics along outlines and centre lines, chosen by price."""
