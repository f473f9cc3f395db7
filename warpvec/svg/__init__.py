"""Write, read, sanitize, draw and measure SVGs."""
