"""Machine files in TOML."""
