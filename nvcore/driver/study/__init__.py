"""Would a driver have seen this pedestrian? A study with people, as the paper did it.

A run: bright light, a coarse picture in which the pedestrian cannot be seen, a cross, dark at
once, after some seconds the picture for half a second, an answer, and a second picture without a
new change of light. `settings`: what the conductor decides. `plan`: which picture after how many
seconds. `pictures`: the folder, and coarse pictures. `records`: a study, its
participants, their answers. `store`: the file that keeps them. `tables`: trials as the CSV that the
driver's estimators are trained on.
"""
