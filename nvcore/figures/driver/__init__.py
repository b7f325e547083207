"""Would the driver have seen him: the regions, over the threshold, the course."""
