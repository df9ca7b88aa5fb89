"""TOML to checked structs to an open house."""
