"""Reports: a diagnosis, a comparison or bushings as one self-contained page; the fitted model."""
