"""The command line: thin; it parses, calls the other packages and prints."""
