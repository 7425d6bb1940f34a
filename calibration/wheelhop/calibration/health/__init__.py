"""Is what was recorded fit for use? Recorder, channels, spectra, and how channels go together."""
