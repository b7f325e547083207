"""Does the driver see the pedestrian himself: features of the picture, estimators, trials."""
