"""Alerts: which detections reach the driver as alerts, and which of these were worth it."""
