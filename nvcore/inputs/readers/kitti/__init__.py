"""KITTI: tracking, object, detections."""
