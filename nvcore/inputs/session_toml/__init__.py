"""One comparison, one file: a `Session` as TOML, read and written.

    [[recording]]            what the data do not say, by recording (only name is required)
    name = "urban_01"
    width = 640
    height = 480
    fps = 20
    frames = "0:299:1"       first:last[:step], or a file with one number a line
    horizon = 236.0
    context = "urban"        of the traffic: "urban", "rural", or a number from 0 to 1
    speed_kmh = 50           speed of the car
    speed = "speed.csv"      the same over time: time_s,speed_kmh (see nvcore.inputs.speed)
    pictures = "urban_01.mp4" a video, a folder, or an archive
    first_picture = 0        number of the frame that the first picture shows
    tags = ["night", "rain"] words by which recordings can be chosen
    title = "Night drive 1"  what it is called, in place of its name in the data
    unit = "drive 7"         what it is part of: recordings of one unit are one in tests
    visible = "visible.mp4"  pictures of visible light: a video, a folder, or an archive
    visible_map = [1.5, 1.5, 8, -12]  x_visible = 1.5 x + 8, y_visible = 1.5 y - 12

    [recordings]             the same as a table (see nvcore.inputs.recordings_file)
    path = "recordings.csv"

    [defaults]               the same facts for all recordings: size, fps, frames
    size = "640x480"

    [truth]
    path = "truth.csv"       file, folder, glob, or a list of them
    format = "csv"
    classes = ["person"]
    frame_base = 0
    box_base = 1
    boxes = "corners"        what the four numbers of a box are, if not what the format says
    frame_names = "times"    how names of pictures are understood: numbers, times, order, ...

    [[system]]               the first is X, the second Y, unless [compare] says otherwise
    name = "FIR"
    path = "fir.csv"
    threshold = 0.5
    frame_step = 1           by which frame numbers are multiplied
    offset_frames = 0        added to the frame numbers, after that
    offset_px = [0, 0]       added to x and y, after scaling
    scale = 1.0              by which coordinates are multiplied, or [x, y]
    provenance = "fir.json"  a record of how they were made (docs/detectors.md)

    [compare]
    x = "FIR"
    y = "NIR"
    tags = ["night"]         only recordings that have all of these tags
    recordings = ["urban_01"] only these, by title or name, of those with the tags
    objects = "speed sign"   what the boxes are of, if not pedestrians; of kinds that the program
                             does not know singular and plural: ["child", "children"]
    accept = ["no-match"]    errors of the audit that are meant, by their codes: warnings
    operating_point = "as-set"  or "equal-alarms": see nvcore.settings.Settings

    [primary]                the measure by which to decide (nvcore.primary)
    measure = "mean_similarity"

    [parameters]             any of nvcore.params.Params

    [protocol]               which pedestrians count in the detection measures: a named protocol,
    name = "reasonable"      filters of its own (see nvcore.protocols.Protocol), or both
    height_px = [50, inf]
    occlusion = [0, 1]
    border_px = [5, 5, 5, 5]
    aspect = [1.0, inf]
    tags = ["night"]
    recordings = ["drive_1"]
    expand = 1.25

    [codes]                  stretches of recordings with a code: recording,start_s,end_s,code
    path = "codes.csv"       (nvcore.inputs.codes)

    [[code]]                 the same, one by one
    recording = "urban_01"
    start_s = 12.5
    end_s = 18
    code = "glare"

    [[published]]            operating points of others, drawn beside the curves: recall or
    name = "Report 2015"     miss_rate, and precision, fppi or fppw
    recall = 0.939
    precision = 0.215

What subjects read of a session is said in their rooms (`nvcore.driver.inputs.session`).

Paths are relative to the session file. A session written by the program also holds the version,
the sha256 of every input, and which of the paths were pipes.
"""

from nvcore.inputs.session_toml.reading import MAX_BYTES, read_session
from nvcore.inputs.session_toml.writing import write_session

__all__ = ["MAX_BYTES", "read_session", "write_session"]
