"""One file per thing with a wire or a radio; strangers to each other."""
