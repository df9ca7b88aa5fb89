"""The page: see, calibrate, record, train and steer in a browser. It needs NiceGUI, and is loaded when it is opened."""
