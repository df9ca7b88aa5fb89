"""Where pointing errors come from: the report's simulation drawn afresh, and the errors no calibration absorbs."""
