"""Does the driver see the pedestrian himself: features of the picture, estimators, trials."""

from nvcore.subjects import Subject

SUBJECT = Subject(
    name="driver",
    settings="comparison.settings:DriverSettings",
    results="comparison.settings:RESULTS",
    steps="comparison.steps:STEPS",
    view="comparison.steps:driver_view",
    miss_weights="comparison.judging:weigh_unseen",
    models="estimators.listing:MODELS",
    formats={
        "nvcore-driver": "an estimator of what the driver sees, which nvcore driver estimate takes"
    },
    extras={"driver": ("av", "cv2", "sklearn")},
    ui="ui.driver",
)
