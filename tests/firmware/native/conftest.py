collect_ignore = ["test_custom_runner.py"]  # PlatformIO's, not pytest's
