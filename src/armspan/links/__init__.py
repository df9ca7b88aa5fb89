"""Bytes in and out: radios, serial lines, servers. What the bytes mean is the devices' affair."""
