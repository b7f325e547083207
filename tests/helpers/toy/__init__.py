"""A subject for the tests: how many encounters are long, and who detects those."""

from nvcore.common import subject


class Toy(subject.Subject):
    name = "toy"

    def settings(self):
        from toy.settings import LONG, ToySettings

        return subject.AddedSettings((ToySettings,), shown=(LONG,))

    def scores(self):
        from toy.measures import MEASURES, STEPS, is_long

        return subject.AddedScores(STEPS, is_long, MEASURES)

    def tables(self):
        from toy.shown import COLUMNS

        return subject.AddedTables(COLUMNS)

    def figures(self):
        from toy.shown import FIGURES

        return subject.AddedFigures(FIGURES)

    def report(self):
        from toy.shown import POINTS

        return subject.AddedReport(POINTS)
