"""Simulated study of detectability: pictures with one pedestrian each, and who saw whom.

scenes      51 pictures at twilight and the box of the pedestrian in each
observer    chance that a simulated observer sees them, by the time since the light changed
trials      the answers of twelve simulated subjects, in the format of a study's trials
"""
