"""The person's measures: typed, from anthropometry, from a skeleton file, from a picture."""
