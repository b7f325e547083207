"""COCO: truth and results."""
