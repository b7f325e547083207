"""The sample's drives as seen by a visible-light colour camera, at dusk.

view, light             position of the camera, and light sources in lux
wardrobe                colours of clothes, cars and walls
paint, stage            coloured polygons, each lit according to its place
ground, sky             background
things, cars, people    objects on the ground
sensor, render          exposure and noise, and pictures in frame order
recordings              recordings with visible pictures, and light sensor readings
"""
