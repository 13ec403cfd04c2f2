"""The machine as data, its names and its checks; scenes and motions that are asked of it."""
