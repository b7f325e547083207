"""Test cases of `scripts/same_results.py`: sessions, accompanying files, and command lines."""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True)
class System:
    """System with the path in its session file, the range of its scores, and further keys."""

    path: str
    scores: Range = (0.0, 1.0)
    keys: str = ""


@dataclass(frozen=True)
class Comparison:
    """Inputs to compare.

    Attributes
    ----------
    name
        Name in the table and for `--only`.
    systems
        Systems by name. The first two are compared. Random settings compare any two.
    recording
        One of the recordings, for commands that take a single one.
    head
        Text of the session file without its systems. Empty: `path` is a session of the sample.
    path
        Path of the session file.
    runs
        Names of `RUNS`, in addition to those of every comparison.
    first
        Command lines that write files used by the session.
    """

    name: str
    systems: dict[str, System]
    recording: str
    head: str = ""
    path: str = "session.toml"
    runs: tuple[str, ...] = ()
    first: str = ""

    @property
    def text(self) -> str:
        """Text of the session file with its placeholders, empty for a session of the sample."""
        tables = [
            f'[[system]]\nname = "{name}"\npath = "{system.path}"\n{system.keys}'
            for name, system in self.systems.items()
        ]
        return "\n".join([self.head.strip(), *tables, ""]) if self.head else ""


SCORE = """
compare {session} {flags} --out report ; report {session} {flags} --out report.html
gate {session} {flags} --rules rules.txt --list --junit gate.xml --markdown gate.md
"""

# Placeholders are {session}, {sample} (its folder), {x} and {y} (names of the first two systems),
# {recording}, and {flags} of a setting. "!": the command has to be refused, and its message is
# compared. "python NAME" runs one of SCRIPTS with the checkout's Python.
RUNS = {
    "random": SCORE,
    "default": f"""{SCORE}
        review new ours {{session}} --projects p.sqlite ; review list ours --projects p.sqlite
        review measures ours --projects p.sqlite
        check {{session}} --strict --out audit ; compare {{session}} --json
        matrix {{session}} --out matrix ; plan {{session}} --out plan.json
        alerts {{session}} --out alerts ; changed {{session}} --old FIR --new NIR --out changed
        ! gate report/session.toml --rule "no_such_measure == 0"
    """,
    "corrections": "check {session} {flags} ; compare {session} {flags} --out report",
    "options": """
        compare {session} --tables parquet --matches --strict --out tables
        compare tables/session.toml --alerts policy --operating-point equal-alarms --out again
        compare {session} --protocol reasonable --driver-weighting on --primary mean_similarity
        report {session} --no-stability --operating-point as-set --alerts policy --out short.html \
            --title "A title" --author "An author" --question "A question" --date "A date"
        gate {session} --alerts policy --rule "alerted_in_time_y >= 0" --rule "lamr_worse_y < 5%"
        plan {session} --measure encounters_detected --margin 5% --candidate x --json
        alerts {session} --policy policy.toml --alert-pause-s 5 --own-reaction-s 1
        matrix {session} --alerts policy --json ; python tables
    """,
    "fleet": """
        ingest {session} --store fleet --label {x}=2026-03 ; ingest {session} --store fleet
        scan fleet --x {x} --y {y} --out night --frames --workers 1 --alpha 0.8
        scan --status night ; top night -n 5 ; top night --table intervals --reverse
        top night --table events --where "recording.n_frames > 10" --out worst.csv
        ! top night --where "n_frames >" ; ! top night --by nothing ; ! open night nowhere --out one
        ! scan fleet --x {x}@7 --y {y} --out other ; open night {recording} --out one
        compare one/session.toml --out one_report ; python tables
    """,
    "pictures": """
        models ; models icf ; models hog:daimler --set upscale=2
        detect {session} --only rural_child --frames 100:299:20 --detector icf:sample --out icf
        compare icf/session.toml --out detected
        detect icf/session.toml --only rural_child --frames 100:299:40 --detector hog:daimler \
            --set scale_step=1.3 --against "ICF sample" --name HOG --threshold 0.2 --out hog
        train {session} --only odd_pose --every 10 --set features=300 --set trees_per_round=8,32 \
            --out model.npz ; models model.npz
        detect {session} --only urban_sidewalk --frames 40:80:20 --detector model.npz --out own
    """,
    "people": """
        driver features {session} --only urban_sidewalk --frames 0:299:40 --out features
        driver estimate {session} --only rural_child --frames 100:299:20 --model sample --out seen
        compare seen/session.toml --driver-weighting on --out report
        report seen/session.toml --driver-weighting on --out report.html
        gate seen/session.toml --rules rules.txt --list --driver-weighting on
        python study {sample}
        driver features --images {sample}/study --boxes boxes.csv --out f.csv
        driver train trials.csv --features f.csv --quick --out driver.npz ; models driver.npz
        driver evaluate trials.csv --features f.csv --quick --out evaluation --html evaluation.html
        driver estimate {session} --only rural_child --frames 100:299:40 --model driver.npz \
            --interpolate --out again
        groups means.csv --correlation 0.7 --difference 300 --out groups ; python ratings {sample}
        groups drives.csv --rename control= ; groups drives.csv --measure duration_s --json
    """,
    "files": """
        convert {sample}/truth.csv truth.json --to coco --size 640x480
        convert {sample}/truth.csv truth.parquet
        convert truth.json mot --to mot --frames-out frames
        convert {sample}/fir.csv fir.csv.gz --role detections
        compare --truth truth.parquet --x fir.csv.gz --y {sample}/nir.csv --size 640x480 --fps 20
        compare --truth mot --x {sample}/fir.csv --y {sample}/nir.csv --size 640x480 --fps 20 \
            --threshold-x 0.5 --threshold-y 0.5 --recordings recordings.csv --codes codes.csv
        sample copied ; python tables
    """,
    "errors": """
        ! compare nothing.toml ; ! compare {session} --no-such-flag ; ! compare {session} --alpha 2
        ! compare {session} --proximity horizn ; ! compare {session} --name-x Nobody
        ! compare {session} --only nowhere ; ! compare {session} --tag nothing ; ! top nowhere
        ! compare {session} --alerts-x bad_log.csv --alerts log ; ! groups bad_column.csv
        ! compare --truth {sample}/truth.csv --x {sample}/fir.csv --y {sample}/nir.csv
        ! check --truth {sample}/truth.csv --x bad_column.csv --size 640x480 --fps 20
        ! check --truth {sample}/truth.csv --x bad_number.csv --size 640x480 --fps 20
        ! check --truth empty.csv --x {sample}/fir.csv --size 640x480 --fps 20
        ! check bad_syntax.toml ; ! check bad_key.toml ; ! compare bad_setting.toml
        ! gate {session} --rule "lamr_y <" ; ! plan {session} --only odd_pose ; ! app nothing.toml
        ! report {session} --out report.pdf ; ! alerts {session} --policy reckless
        ! convert {sample}/fir.csv fir.json ; ! convert {sample}/truth.csv truth.xyz
        ! compare {session} --out rules.txt ; ! train bad_pictures.toml --out model.npz
        ! detect bad_pictures.toml --detector hog --out boxes ; ! ingest nothing.toml --store fleet
        ! detect {session} --detector hog --set stride=-1 --out boxes ; ! models nothing
        ! driver estimate {session} --model rules.txt --out driver
        ! scan nowhere --x FIR --y NIR --out night ; compare --help
    """,
}
RUNS_OF_ALL = ("default", "corrections", "options", "fleet")

SCRIPTS = {
    # tables of stores, results and Parquet files as CSV, without file names and times
    "tables": """
import shutil
from pathlib import Path
import pyarrow.parquet
from deltalake import DeltaTable

def write(table, path):
    kinds = {field.name: f"{field.name} ({field.type})" for field in table.schema}
    frame = table.to_pandas().drop(columns=["ingested_at", "file"], errors="ignore")
    header, *rows = frame.rename(columns=kinds).to_csv(index=False).splitlines(keepends=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(header + "".join(sorted(rows)))

folders = [log.parent for log in Path().rglob("_delta_log")]
for folder in folders:
    write(DeltaTable(folder).to_pyarrow_table(), Path("tables_of", f"{folder}.csv"))
    shutil.rmtree(folder)
for path in list(Path().rglob("*.parquet")):
    write(pyarrow.parquet.read_table(path), Path("tables_of", f"{path}.csv"))
    path.unlink()
for store in {folder.parent for folder in folders}:
    shutil.rmtree(store)  # plans and leases, which name program, process and time
""",
    # a study of nine pedestrians, which takes seconds
    "study": """
import sys
from pathlib import Path
for name, written in (("trials_simulated.csv", "trials.csv"), ("study/boxes.csv", "boxes.csv")):
    header, *lines = Path(sys.argv[1], name).read_text().splitlines(keepends=True)
    Path(written).write_text(header + "".join(line for line in lines if "study_0" in line))
""",
    # no command reads ratings, so this does the same as the dashboard's page
    "ratings": r"""
import sys
from pathlib import Path
import nvcore as nv
from nvcore.subjects.ratings.agreement import measure_agreement, rank_ratings
from nvcore.subjects.ratings.drivers import find_drivers
from nvcore.subjects.ratings.fit import fit_saliency
from nvcore.subjects.ratings.reading import read_ratings
from nvcore.subjects.ratings.validation import clip_saliency, correlate, join_clips
comparison = nv.compare(Path(sys.argv[1], "session.toml"))
ranks = rank_ratings(read_ratings(Path(sys.argv[1], "ratings_simulated.csv")))
clips = join_clips(ranks, clip_saliency(comparison.result))
correlations = correlate(clips["saliency_s"].to_numpy(), clips["mean_rank"].to_numpy())
fit = fit_saliency(comparison.result, clips)
agreement, drivers = measure_agreement(ranks), find_drivers(ranks, clips)
print(comparison, agreement, *correlations, drivers, drivers.with_alpha.to_string(), fit, sep="\n")
""",
}

FILES = {
    "rules.txt": """\
frames >= 100
newly_missed == 0
lamr_y <= 0.10
lamr_difference >= -0.01
longest_episode_s_y <= 1 or undefined
mean_similarity_x > 0.9
audit_warnings <= 1
""",
    "policy.toml": 'base = "eager"\nalert_k = 0.4\n',
    "alerts.csv": "recording,start_s,end_s,kind\nodd_pose,1.2,3.4,sign\nrural_child,6,8.5,tone\n",
    "codes.csv": "recording,start_s,end_s,code\nrural_child,4,9,glare\nodd_pose,0,7.5,glare\n",
    "recordings.csv": "recording,context,speed_kmh,horizon,tags,title,unit\n"
    "urban_crossing,urban,29,236,night;route=A,Crossing,drive 1\n"
    "urban_sidewalk,urban,,234,route=A,,drive 1\nwinter_frost,0.25,28.8,235,night,Frost,drive 2\n",
    "gaze.csv": "frame,x,y\n0,320,240\n60,500,200\n200,100,260\n",
    "speed.csv": "time_s,speed_kmh\n0,50\n5,52.5\n10,30\n",
    "means.csv": "condition,n,mean,sd\nvisual,11,1678,755\naudio,11,2171,766\nhaptic,11,1245,389\n",
    "drives.csv": "participant,condition,duration_s,violations\n"
    "V1,visual,282,4\nV2,visual,250,7\nV3,visual,283,2\nA1,audio,310,2\nA2,audio,303,3\n"
    "A3,audio,271,3\nN1,none,219,19\nN2,none,282,7\nN3,none,217,17\nC1,control,292,\n",
    "bad_column.csv": "recording,frame,x,y,width,score\nodd_pose,0,1,2,3,0.5\n",
    "bad_number.csv": "recording,frame,x,y,w,h,score\nodd_pose,0,1,two,3,4,0.5\n",
    "bad_log.csv": "recording,start_s,end_s,kind\nodd_pose,3,2,sign\n",
    "bad_syntax.toml": '[truth\npath = "truth.csv"\n',
    "bad_key.toml": 'truth = {path = "{sample}/truth.csv", formt = "csv"}\n'
    'system = [{name = "FIR", path = "{sample}/fir.csv"}]\n',
    "bad_setting.toml": 'truth.path = "{sample}/truth.csv"\nparameters.alhpa = 0.5\n'
    'system = [{name = "FIR", path = "{sample}/fir.csv"}]\n',
    "bad_pictures.toml": 'truth.path = "{sample}/truth.csv"\ndefaults = {size="640x480", fps=20}\n',
    "empty.csv": "",
}
"""Files beside every session, by name."""

EVERYTHING = """
defaults = {size = "640x480", fps = 20, frames = "0:299"}
recordings.path = "recordings.csv"
truth.path = "{sample}/truth.csv"
driver = {detectability = "driver/detectability.csv", provenance = "driver/driver.json"}
codes.path = "codes.csv"
code = [{recording = "rural_road", start_s = 2, end_s = 9, code = "bend"}]
compare = {accept = ["no-match"], operating_point = "equal-alarms"}
primary = {measure = "encounters_detected", fixed_at = "2026-03-01T17:40:12+00:00"}
protocol = {name = "reasonable", height_px = [30, inf]}
parameters = {alerts = "log", driver_weighting = "on", own_reaction_s = 1.1}
published = [
    {name = "Report 2015", recall = 0.939, precision = 0.215},
    {name = "Paper", miss_rate = 0.2, fppi = 0.1},
]
[[recording]]
name = "urban_sidewalk"
pictures = "{sample}/urban_sidewalk.mp4"
visible = "{sample}/urban_sidewalk_visible.mp4"
visible_map = [1.25, 1.25, 72, -46]
light = "{sample}/urban_sidewalk_light.csv"
gaze = "gaze.csv"
recorded_at = "2026-03-01T18:20:00+01:00"
[[recording]]
name = "rural_child"
context = "rural"
speed = "speed.csv"
unit = "drive 2"
tags = ["rural", "autumn"]
pictures = "{sample}/rural_child.mp4"
visible = "{sample}/rural_child_visible.mp4"
light = "{sample}/rural_child_light.csv"
[[recording]]
name = "oncoming_glare"
frames = "0:298:2"
pictures = "{sample}/oncoming_glare.mp4"
first_picture = 1
"""

MOT15 = """
[[recording]]
name = "TUD-Campus"
pictures = "{realdata}/videos/TUD-Campus.mp4"
[[recording]]
name = "TUD-Stadtmitte"
pictures = "{realdata}/videos/TUD-Stadtmitte.mp4"
[[recording]]
name = "PETS09-S2L1"
pictures = "{realdata}/videos/vtest.avi"
[[recording]]
name = "ETH-Sunnyday"
[truth]
path = "{realdata}/mot15"
"""

# 16 recordings, the sets from set09 by night
KAIST_SETS = {"set06": 5, "set07": 3, "set08": 3, "set09": 1, "set10": 2, "set11": 2}
KAIST = "\n".join(
    [
        *(
            f'[[recording]]\nname = "{name}/V{index:03}"\n'
            f'tags = ["{"day" if name < "set09" else "night"}"]'
            for name, count in KAIST_SETS.items()
            for index in range(count)
        ),
        '[defaults]\nfps = 20\n[protocol]\nname = "kaist-reasonable"',
        '[truth]\npath = "{realdata}/kaist/KAIST_annotation.json"',
    ]
)

KITTI = """
[[recording]]
name = "0016"
width = 1224
height = 370
fps = 10
pictures = "{realdata}/kitti_tracking/images"
[parameters]
proximity = "distance"
[truth]
path = "{realdata}/kitti_tracking/label_02/0016.txt"
"""

NIGHT = """
[[recording]]
name = "night"
width = 640
height = 512
fps = 20
pictures = "{realdata}/kaist_night_video/set09_V000_I02330-I03499_lwir.mp4"
[truth]
path = "{realdata}/kaist_night_video/gt.csv"
"""

COMPARISONS = (
    Comparison(
        "sample",
        {"FIR": System("fir.csv"), "NIR": System("nir.csv")},
        "odd_pose",
        path="{sample}/session.toml",
        runs=("pictures", "people", "files", "errors"),
    ),
    Comparison(
        "speed-signs",
        {"Mono": System("mono.csv"), "Stereo": System("stereo.csv")},
        "past_school",
        path="{sample}/speed_signs/session.toml",
    ),
    Comparison(
        "everything",
        {
            "FIR": System("{sample}/fir.csv", keys='threshold = 0.5\nalerts = "alerts.csv"\n'),
            "NIR": System("{sample}/nir.csv", keys='scale = 1.01\nalert_policy = "policy.toml"\n'),
            "NIR 2": System("{sample}/nir2.csv", keys="threshold = 0.5\n"),
        },
        "rural_child",
        EVERYTHING,
        first="driver estimate {sample}/session.toml --only rural_child --only urban_sidewalk "
        "--frames 0:299:20 --model sample --out driver",
    ),
    Comparison(
        "mot15",
        {
            "Faster R-CNN": System("{realdata}/mot15/*/det_frcnn/det.txt", (0.5, 1.0)),
            "tracker": System("{realdata}/mot15/*/res_devkit/*.txt"),
        },
        "TUD-Campus",
        MOT15,
    ),
    Comparison(
        "kaist",
        {
            name: System(f"{{realdata}}/kaist/results/{name}_result.txt")
            for name in ("MLPD", "MBNet", "GAFF", "TCDet-thermal", "YOLOv3-visible")
        },
        "set06/V000",
        KAIST,
    ),
    Comparison(
        "kitti-0016",
        {
            "RRC": System("{realdata}/kitti_tracking/rrc_ped/0016.txt"),
            "PointRCNN": System("{realdata}/kitti_tracking/pointrcnn_ped/0016.txt", (-0.9, 8.6)),
        },
        "0016",
        KITTI,
    ),
    Comparison(
        "night-video",
        {
            name: System(f"{{realdata}}/kaist_night_video/detections/{name}.csv")
            for name in ("TCDet-thermal", "YOLOv3-visible", "MLPD", "MBNet")
        },
        "night",
        NIGHT,
    ),
)
