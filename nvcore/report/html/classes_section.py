"""Section about classes: what the matched boxes were taken for."""

from __future__ import annotations

from nvcore.comparison import Result
from nvcore.figures.classes import NO_CLASS, classes_plot
from nvcore.notes import say
from nvcore.report.html import words
from nvcore.report.html.blocks import Block, Chart, Section, Sentences, table
from nvcore.report.words import classes_read
from nvcore.tables.classes import classes_table, names_classes


def classes_section(result: Result) -> Section:
    """The classes that X and Y read, as matrices; for results with `has_classes`."""
    counted = classes_table(result)
    blocks: list[Block] = []
    for letter, system in result.sides:
        text = say(classes_read(result, counted, letter), result.objects)
        blocks.append(Sentences((text,)))
        rows = counted[counted["system"] == letter]
        if rows.empty or not names_classes(result, system):
            continue
        figure = classes_plot(counted, letter, system.name, theme=result.scheme("light"))
        in_words = f"How many boxes of each class {letter.upper()} read as which"
        cells = rows[["truth_class", "read_class", "n"]].fillna({"read_class": NO_CLASS})
        blocks += [
            Chart(f"classes-{letter}", figure, in_words),
            table(
                f"Classes read by {letter.upper()}",
                ("Class in the truth", "Class read", "Boxes"),
                [(truth, read, f"{n:,}") for truth, read, n in cells.itertuples(index=False)],
                right=(2,),
            ),
        ]
    return Section("classes", "Classes", words.classes(), tuple(blocks))
