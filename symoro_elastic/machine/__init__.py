"""The machine as data, its checks and its file formats."""
