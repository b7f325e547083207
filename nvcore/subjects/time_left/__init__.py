"""Time left: whether the car could still have stopped when a system confirmed a pedestrian."""

from __future__ import annotations

from nvcore.common import subject


class TimeLeft(subject.Subject):
    """The time left to brake."""

    name = "time_left"

    def settings(self) -> subject.AddedSettings:
        from nvcore.subjects.time_left.settings import TIME_LEFT, TimeLeftSettings

        return subject.AddedSettings((TimeLeftSettings,), shown=(TIME_LEFT,))

    def scores(self) -> subject.AddedScores:
        from nvcore.subjects.time_left.measures import COUNTS, MEASURES
        from nvcore.subjects.time_left.steps import STEPS, TimeLeftView, only_urgent_of

        return subject.AddedScores(STEPS, TimeLeftView, MEASURES, COUNTS, restrict=only_urgent_of)

    def tables(self) -> subject.AddedTables:
        from nvcore.subjects.time_left.columns import COLUMNS, ENTRIES

        return subject.AddedTables(COLUMNS, ENTRIES)

    def figures(self) -> subject.AddedFigures:
        from nvcore.subjects.time_left.figures import FIGURES, LANES

        return subject.AddedFigures(FIGURES, (LANES,))

    def report(self) -> subject.AddedReport:
        from nvcore.subjects.time_left.notes import POINTS
        from nvcore.subjects.time_left.section import SECTIONS

        return subject.AddedReport(POINTS, SECTIONS)
