"""A virtual person, virtual bands, virtual robots: the truth that estimators must find. Knows no estimator."""
