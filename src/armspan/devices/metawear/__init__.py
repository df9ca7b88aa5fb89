"""MbientLab's MetaWear bands: their bytes, the host's side, and an emulated board."""
