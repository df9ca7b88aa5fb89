"""Takes, preprocessing, models, live spotting: from the bands on both wrists to a gesture."""
