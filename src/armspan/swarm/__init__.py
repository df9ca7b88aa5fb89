"""Label or place to commands that are safe to send."""
