"""Sony toio core cubes over Bluetooth LE: the bytes, a robot's core, the driver, and an emulated cube."""
