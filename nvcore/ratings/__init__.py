"""Ratings of clips by people, and how well saliency follows them (paper, figure 9).

`reading`: CSV of participant, clip, rating. `store`: sessions in which people rate clips.
`agreement`: ranks of each participant, Kendall's W, who disagrees with the others. `validation`:
saliency against the mean rank. `fit`: saliency parameters fitted to the ratings, judged on clips
left out.
"""

from typing import Final

from nvcore.subjects import Subject

SUBJECT: Final = Subject(name="ratings", ui="ui.ratings")
