"""The programs that generated code is measured against."""
