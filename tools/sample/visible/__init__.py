"""The sample's drives as a visible-light colour camera shows them, at dusk.

view, light             where the camera is; what shines, in lux
wardrobe                colours of clothes, cars and walls
paint, stage            coloured polygons; each in the light of its place
ground, sky             what does not stand up
things, cars, people    what does
sensor, render          exposure and noise; pictures in frame order
recordings              which recordings have them, and what a light sensor measured
"""
