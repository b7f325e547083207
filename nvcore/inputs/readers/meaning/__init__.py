"""What names, classes, tracks and occlusion in files mean."""
