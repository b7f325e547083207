"""What names of files, classes and values in files mean."""
