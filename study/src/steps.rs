//! From frames of emitters to the files of a tool and of a registration: each step is a command of `calib` on files.

mod on_base;

use std::fs;
use std::path::{Path, PathBuf};

use bus::message::Practice;
use calib::registration::{Method, Pairs, fit};
use calib_cli::cli::{Hands, answer};
use calib_cli::{BeadsFile, CalibrationFile, Loaded, practice};
use chance::Chance;
use geometry::{Ct, Marker, Point, Rigid, Tool, Vector};
use scene::Scene;
use tracker_proc::chain::Chain;
use tracker_proc::operating_room::Frame;
use tracker_proc::{Markers, chain_of_files};

use crate::Words;
use crate::plan::Stratum;
use crate::room::{DIVOT_MM, TOOL, TrueRoom, farther, parsed, tracker_text};

/// The name of the tool's marker in files.
const MARKER: &str = "ball";
/// How long the tool is left in its seat, s.
const SEATED_S: f64 = 3.0;
/// Where the marker is turned before the localizer, mm in the CT.
const TURNED_AT_MM: [f64; 3] = [0.0, -300.0, 100.0];

/// A step of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Step {
    /// The examination, and the beads in it.
    Ct,
    /// The tool's marker.
    Marker,
    /// The tip.
    Pivot,
    /// The calibration base.
    Base,
    /// The tool in its seat.
    Seat,
    /// A touch of a bead.
    Touch,
    /// Which bead each touch is of, and the registration.
    Match,
    /// The tracker takes tool and registration.
    Chain,
    /// A known point is touched.
    Check,
}

impl Step {
    /// The word in `operations.csv`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Ct => "ct",
            Self::Marker => "marker",
            Self::Pivot => "pivot",
            Self::Base => "base",
            Self::Seat => "seat",
            Self::Touch => "touch",
            Self::Match => "match",
            Self::Chain => "chain",
            Self::Check => "check",
        }
    }
}

/// A step that gave no result.
#[derive(Debug)]
pub(crate) struct Refused {
    pub(crate) step: Step,
    pub(crate) why: String,
}

impl Refused {
    pub(crate) fn at<E: ToString>(step: Step) -> impl Fn(E) -> Self {
        move |error| Self {
            step,
            why: error.to_string(),
        }
    }
}

/// What the words of an error have where the machine failed, not the step: those of every error of the system, and of the loader's
/// room for a volume.
const OF_THE_MACHINE: [&str; 2] = ["(os error ", "MiB are free"];

impl Refused {
    /// Whether the machine failed: a full disk, a file that cannot be read. That says nothing of an operation.
    pub(crate) fn is_of_the_machine(&self) -> bool {
        OF_THE_MACHINE.iter().any(|words| self.why.contains(words))
    }
}

/// What `calib check` says where it was made and refuses the registration.
const FAILED: &str = "do not use this registration";

/// What a check came to.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The registration may be used: `pass` or `warn`.
    Passed(String),
    /// It may not, and why.
    Fail(String),
}

/// The files of an operation.
pub(crate) struct Work<'a> {
    pub(crate) stratum: &'a Stratum,
    pub(crate) seed: u64,
    pub(crate) folder: &'a Path,
}

/// What a registration rests on, and what it is of.
pub(crate) struct Prepared {
    pub(crate) markers: Markers,
    /// The emitters as they were calibrated.
    pub(crate) emitters: Vec<Point<Marker>>,
}

/// What the commands of `calib` are given; volumes are read by `volume-loader`, and there is no run.
pub(crate) const HANDS: Hands = Hands {
    load: |spec| {
        let (volume, told) = volume_loader::load_told(spec)?;
        Ok(Loaded {
            volume,
            modality: told.modality,
            warnings: told.warnings,
        })
    },
    labels: volume_loader::load_labels,
    label_names: |path| Ok(volume_loader::label_names(path)?),
    follow: |_| Err("no run is followed in a study".into()),
};

impl Work<'_> {
    /// A file of the operation.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Its name for a command line.
    fn named(&self, name: &str) -> String {
        self.file(name).to_string_lossy().into_owned()
    }

    /// What a command of `calib` answers.
    pub(crate) fn calib(&self, step: Step, words: &[&str]) -> Result<String, Refused> {
        let words = std::iter::once("calib").chain(words.iter().copied());
        answer(words, HANDS).map_err(Refused::at(step))
    }

    /// The tool's marker, turned to all sides before the localizer.
    pub(crate) fn marker(&self, room: &mut TrueRoom) -> Result<Prepared, Refused> {
        let refused = Refused::at::<Words>(Step::Marker);
        let marker_from_tool = room.room.marker_from_tool;
        let count = self.stratum.dials.calibration.marker_frames;
        let poses = (0..count).map(|k| turned(k, count) * marker_from_tool);
        let frames = room.held(poses);
        fs::write(self.file("frames.csv"), frames_text(&frames)).map_err(Refused::at(Step::Marker))?;
        let localizer = self.stratum.dials.localizer;
        let (frames, out) = (self.named("frames.csv"), self.named("marker.json"));
        // The deviations where the marker is turned: they grow with the distance, those in depth with its square.
        let times = farther(&localizer, TURNED_AT_MM);
        let [across, depth] =
            [localizer.across_mm * times, localizer.depth_mm * times * times].map(|mm| mm.to_string());
        let count = self.stratum.dials.marker.emitters.to_string();
        let words = [
            "marker",
            &frames,
            "--sigma-mm",
            &across,
            "--depth-sigma-mm",
            &depth,
            "--emitters",
            &count,
            "--tool",
            TOOL,
            "--marker",
            MARKER,
            "--out",
            &out,
        ];
        self.calib(Step::Marker, &words)?;
        let emitters = self.calibrated().map_err(&refused)?;
        let scene = parsed(&tracker_text(&self.stratum.dials, &emitters)).map_err(&refused)?;
        let markers = Markers::of(&scene).map_err(Refused::at(Step::Marker))?;
        Ok(Prepared { markers, emitters })
    }

    /// The emitters of `marker.json`.
    fn calibrated(&self) -> Result<Vec<Point<Marker>>, Words> {
        let text = fs::read_to_string(self.file("marker.json"))?;
        let file: CalibrationFile = serde_json::from_str(&text)?;
        let body = file.marker_body.ok_or("marker.json has no marker")?;
        let place = |emitter: Option<calib_cli::EmitterRecord>| {
            let [x, y, z] = emitter.ok_or("an emitter was seen too seldom")?.at_mm;
            Ok(Point::new(x, y, z))
        };
        body.emitters.into_iter().map(place).collect()
    }

    /// The tip in its divot, the base touched with it, the tool in its seat: `tool.json`.
    pub(crate) fn tool(&self, room: &mut TrueRoom, prepared: &mut Prepared) -> Result<(), Refused> {
        let [x, y, z] = DIVOT_MM;
        let pivot = practice::pivot(Point::new(x, y, z));
        let seconds = self.stratum.dials.calibration.pivot_s;
        self.recorded(Step::Pivot, room, prepared, (&pivot, seconds), "pivot.csv")?;
        let (poses, tip) = (self.named("pivot.csv"), self.named("tip.json"));
        let names = ["--tool", TOOL, "--marker", MARKER];
        let words = [&["pivot", "--poses", &poses, "--out", &tip][..], &names].concat();
        self.calib(Step::Pivot, &words)?;
        self.touched_base(room, prepared)?;
        let (touches, drawing, base) = (self.named("base.csv"), self.named("base.toml"), self.named("base.json"));
        let words = [&["base", &touches, "--drawing", &drawing, "--out", &base][..], &names].concat();
        self.calib(Step::Base, &words)?;
        let seat = practice::seat(on_base::seat(
            &self.stratum.dials.calibration,
            Chance::new(self.seed, 12),
        ));
        self.recorded(Step::Seat, room, prepared, (&seat, SEATED_S), "seated.csv")?;
        let (poses, tool) = (self.named("seated.csv"), self.named("tool.json"));
        let words = [
            &["seat", "--base", &base, "--poses", &poses, "--out", &tool][..],
            &names,
        ]
        .concat();
        self.calib(Step::Seat, &words).map(drop)
    }

    /// Poses of the marker while the hand does something, as a file.
    fn recorded(
        &self,
        step: Step,
        room: &mut TrueRoom,
        prepared: &mut Prepared,
        (practice, seconds): (&Practice, f64),
        name: &str,
    ) -> Result<(), Refused> {
        let heard = room.listen(practice, seconds, &mut prepared.markers);
        let heard = heard.map_err(Refused::at(step))?;
        if heard.poses.is_empty() {
            // The file would say that it is empty, and not why.
            let why = format!(
                "none of {} frames shows the marker; the last: {}",
                heard.lost, heard.why
            );
            return Err(Refused { step, why });
        }
        heard.write(&self.file(name)).map_err(Refused::at(step))
    }

    fn touched_base(&self, room: &mut TrueRoom, prepared: &mut Prepared) -> Result<(), Refused> {
        let failed = Refused::at(Step::Base);
        let drawing = on_base::drawing(&self.stratum.dials.calibration);
        fs::write(self.file("base.toml"), drawing).map_err(Refused::at(Step::Base))?;
        for (count, (name, place)) in (1..).zip(on_base::touches()) {
            let touch = practice::touch_base(place, geometry::Direction::Z, count);
            // The marker on the patient stands for the tracker in all that the tool's calibration is made of.
            self.touch(room, prepared, &touch, (name, "tracker", "base.csv"), "tip.json")
                .map_err(&failed)?;
        }
        Ok(())
    }

    /// One touch, added to a file; where it was, in the frame of the marker on the patient.
    pub(crate) fn touch(
        &self,
        room: &mut TrueRoom,
        prepared: &mut Prepared,
        practice: &Practice,
        (name, frame, to): (&str, &str, &str),
        tip: &str,
    ) -> Result<geometry::UncertainPoint<geometry::Tracker>, String> {
        let seconds = self.stratum.dials.touch.seconds;
        let heard = room.listen(practice, seconds, &mut prepared.markers);
        let heard = heard.map_err(|error| error.to_string())?;
        let place = heard.touch((name, TOOL, frame), &self.file(tip), &self.file(to), seconds);
        place.map_err(|error| error.to_string())
    }

    /// The beads are touched, and found to be which: `registration.json`.
    pub(crate) fn registered(
        &self,
        room: &mut TrueRoom,
        prepared: &mut Prepared,
        (beads, places): (&Path, &[Point<Ct>]),
        target: Point<Ct>,
    ) -> Result<(), Refused> {
        for (count, place) in (1..).zip(places) {
            let (touch, name) = (practice::touch(*place, count), format!("bead-{count}"));
            self.touch(room, prepared, &touch, (&name, "reference", "touched.csv"), "tool.json")
                .map_err(Refused::at(Step::Touch))?;
        }
        let (touched, out) = (self.named("touched.csv"), self.named("registration.json"));
        let stated = self.stratum.dials.touch.stated_mm.to_string();
        let target = format!("--target={}", listed(target));
        let beads = beads.to_string_lossy();
        let words = ["match", &beads, &touched, "--touch-mm", &stated, &target, "--out", &out];
        self.calib(Step::Match, &words).map(drop)
    }

    /// The chain that a tracker makes of the scene with these files, in a run of the CT of this hash.
    pub(crate) fn chain(&self, prepared: &Prepared, ct_hash: &str, region: Point<Ct>) -> Result<Chain, Refused> {
        let text = tracker_text(&self.stratum.dials, &prepared.emitters)
            + "[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n[tracker.registration]\nfile = \"registration.json\"\n";
        let path = self.file("scene.toml");
        fs::write(&path, text).map_err(Refused::at(Step::Chain))?;
        let scene = Scene::load(&path).map_err(Refused::at(Step::Chain))?;
        chain_of_files(&scene, ct_hash, region).map_err(Refused::at(Step::Chain))
    }

    /// A bead that the registration was not made of is touched. What `calib check` says of it.
    ///
    /// # Errors
    /// Where the check could not be made.
    pub(crate) fn checked(
        &self,
        room: &mut TrueRoom,
        prepared: &mut Prepared,
        beads: &BeadsFile,
        place: Point<Ct>,
    ) -> Result<Verdict, Refused> {
        let failed = Refused::at(Step::Check);
        let known =
            found(beads, place).ok_or_else(|| failed("the bead to be checked was not found in the CT".to_owned()))?;
        let touch = practice::touch(place, 40);
        self.touch(room, prepared, &touch, ("known", "reference", "known.csv"), "tool.json")
            .map_err(Refused::at(Step::Check))?;
        let dials = &self.stratum.dials;
        let stated = dials.touch.stated_mm.to_string();
        let (registration, most) = (self.named("registration.json"), dials.check_max_mm.to_string());
        let (known, touched) = (format!("--known={}", listed(known)), self.named("known.csv"));
        let words = [
            "check",
            &registration,
            &known,
            "--touches",
            &touched,
            "--touch-mm",
            &stated,
            "--max-mm",
            &most,
            "--json",
        ];
        let said = match self.calib(Step::Check, &words) {
            Err(refused) if refused.why.contains(FAILED) => return Ok(Verdict::Fail(refused.why)),
            said => said?,
        };
        let said: serde_json::Value = serde_json::from_str(&said).map_err(Refused::at(Step::Check))?;
        Ok(Verdict::Passed(said["verdict"].as_str().unwrap_or_default().to_owned()))
    }
}

/// Where a bead was found in the CT that truly lies at `place`.
fn found(beads: &BeadsFile, place: Point<Ct>) -> Option<Point<Ct>> {
    let centres = beads.beads.iter().map(|bead| {
        let [x, y, z] = bead.centre_mm;
        Point::new(x, y, z)
    });
    let nearest = centres.min_by(|a: &Point<Ct>, b| a.distance(place).total_cmp(&b.distance(place)))?;
    (nearest.distance(place) < 5.0).then_some(nearest)
}

/// The true marker from the calibrated one: what lays the calibrated emitters best on the true ones. Frames of markers are
/// each calibration's own, and mean nothing until they are held against the truth.
pub(crate) fn true_from_calibrated(
    truth: &[Point<Marker>],
    found: &[Point<Marker>],
) -> Result<Rigid<Marker, Marker>, Words> {
    let pairs = Pairs::new(truth, found).map_err(|refused| refused.to_string())?;
    let fitted = fit(pairs, Method::HornQuaternion).map_err(|refused| refused.to_string())?;
    Ok(fitted.transform)
}

fn listed<F>(p: Point<F>) -> String {
    let [x, y, z] = p.mm();
    format!("{x},{y},{z}")
}

/// The marker's pose in the `k`-th of so many views, to all sides in small steps.
fn turned(k: u64, count: u64) -> Rigid<Ct, Marker> {
    let share = k as f64 / count as f64;
    let none = Vector::new(0.0, 0.0, 0.0);
    let about = |axis: [f64; 3]| {
        let [x, y, z] = axis;
        // Any vector of finite numbers is a rotation.
        Rigid::<Marker, Marker>::from_rotation_vector(Vector::new(x, y, z), none).unwrap_or(Rigid::identity())
    };
    let pi = std::f64::consts::PI;
    let turn = about([pi * share, 0.0, 0.0]) * about([0.0, 0.0, 12.0 * pi * share]);
    let [x, y, z] = TURNED_AT_MM;
    Rigid::from_parts(turn.rotation(), Vector::new(x, y, z))
}

/// Frames as `calib marker` reads them.
fn frames_text(frames: &[Frame]) -> String {
    let mut text = "frame,emitter,x,y,z\n".to_owned();
    for (number, frame) in frames.iter().enumerate() {
        for sighting in &frame.tool {
            let [x, y, z] = sighting.place.mm();
            text += &format!("{number},{},{x},{y},{z}\n", sighting.emitter);
        }
    }
    text
}

/// The tool's true frame in its marker.
pub(crate) fn true_tool(room: &TrueRoom) -> Rigid<Marker, Tool> {
    room.room.marker_from_tool
}
