"""Settings of a fit: fields, rules, presets and TOML files."""
