"""The page that follows a machine file: it shows what is saved, and writes back single cells."""
