"""Would a driver have seen this pedestrian? A study with people, as the paper did it.

A run shows bright light, a coarse picture in which the pedestrian cannot be seen, a cross, sudden
darkness, after some seconds the picture for half a second, an answer, and a second picture without
a new change of light. `settings` holds the conductor's decisions, `plan` the schedule of pictures
and times, `pictures` the folder, coarse pictures and practice, and `touch_task` the file with
studies and answers, and the tables for training the driver's estimators.
"""
