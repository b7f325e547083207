"""Does the driver see the pedestrian himself: features of the picture, estimators, trials."""

from nvcore.subjects import Subject

SUBJECT = Subject(name="driver", ui="ui.driver")
