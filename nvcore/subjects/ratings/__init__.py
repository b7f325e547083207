"""Ratings of clips by people, and how well saliency follows them (paper, figure 9).

`reading`: CSV of participant, clip, rating. `clips`: parts of recordings that are rated.
`clip_task`: sessions in which people rate clips, and say whether alerts were worth it (`worth`).
`agreement`: ranks of each participant, Kendall's W, participants who disagree with the others.
`validation`: saliency against the mean rank. `fit`: saliency parameters fitted to the ratings,
judged on held-out clips. `drivers`: losses that drive the ratings, and the alpha that people use.
"""

from nvcore.common.subject import Subject


class Ratings(Subject):
    """Ratings by people."""

    name = "ratings"
    needs = ("alerts",)
