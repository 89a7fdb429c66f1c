"""Human safety, the python side: the detector model (detector and merger are C++)."""
