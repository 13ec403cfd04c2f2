"""The page that follows a machine file: it shows the saved file, and writes back single cells."""
