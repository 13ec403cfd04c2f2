"""The machine as data, its names and its checks; the scenes and motions that its file requests."""
