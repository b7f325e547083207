"""Compare two pedestrian-detection systems by what the driver notices."""
