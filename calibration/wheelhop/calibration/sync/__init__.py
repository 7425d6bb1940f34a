"""Are the channels in step? A driven cantilever, measured against beam theory."""
