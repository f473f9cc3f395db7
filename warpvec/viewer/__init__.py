"""The HTML page to view, compare and edit an SVG."""
