"""What a session shows: pure, from records, never from files."""
