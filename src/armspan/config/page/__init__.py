"""What stands behind the page: sessions, takes, training, logs."""
