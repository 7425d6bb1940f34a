"""The command line: thin; it parses, calls the rooms and prints."""
