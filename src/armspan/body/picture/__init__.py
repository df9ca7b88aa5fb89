"""A person in a picture: where the body points are, how large a pixel is."""
