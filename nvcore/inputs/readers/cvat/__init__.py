"""CVAT: video and images."""
