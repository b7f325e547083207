"""Would a driver have seen this pedestrian? A study with people, as the paper did it.

A run: bright light, a coarse picture in which the pedestrian cannot be seen, a cross, dark at
once, after some seconds the picture for half a second, an answer, and a second picture without a
new change of light. `settings`: decisions of the conductor. `plan`: which picture after how many
seconds. `pictures`: the folder, coarse pictures, practice. `touch_task`: studies and answers in
their file, and the tables that the driver's estimators are trained on.
"""
