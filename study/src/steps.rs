//! From frames of emitters to the files of a tool and of a registration: each step is a command of `calib` on files.

mod marker;
mod on_base;
mod sequence;
mod surface;
mod wires;

use std::fs;
use std::path::{Path, PathBuf};

use bus::message::Practice;
use calib::registration::{Method, Pairs, fit};
use calib_cli::cli::{Hands, answer};
use calib_cli::{BeadsFile, Loaded, practice};
use chance::Chance;
use geometry::{Ct, Marker, Point, Reference, Rigid, Tool, Uncertain};
use scene::Scene;
use tracker_proc::chain::Chain;
use tracker_proc::chain_of_files;

use crate::Words;
use crate::plan::Stratum;
use crate::room::{DIVOT_MM, TUBE, TrueRoom, tracker_text};
pub(crate) use marker::Prepared;

/// The name of the tool's marker in files.
const MARKER: &str = "ball";
/// How long the tool is left in its seat, s.
const SEATED_S: f64 = 3.0;

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
    /// The ultrasound probe: its marker, and its image.
    Probe,
    /// Bone in the images of a sweep.
    Sweep,
    /// The registration by the bone's surface.
    Surface,
    /// The way to a target.
    Way,
    /// What the tube does to organs on it.
    Organs,
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
            Self::Probe => "probe",
            Self::Sweep => "sweep",
            Self::Surface => "surface",
            Self::Way => "way",
            Self::Organs => "organs",
        }
    }
}

/// A step that gave no result.
#[derive(Debug)]
pub(crate) struct Refused {
    pub(crate) step: Step,
    pub(crate) why: String,
    /// The registration that was refused, where there was one.
    pub(crate) registration: Option<Box<Misplaced>>,
}

/// A registration that was not taken.
#[derive(Debug)]
pub(crate) struct Misplaced {
    /// As it was found.
    pub(crate) found: Uncertain<Ct, Reference>,
    /// Where the marker on the patient truly was.
    pub(crate) truly: Rigid<Ct, Reference>,
}

impl Refused {
    pub(crate) fn at<E: ToString>(step: Step) -> impl Fn(E) -> Self {
        move |error| Self {
            step,
            why: error.to_string(),
            registration: None,
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

    /// The tip in its divot, the base touched with it, the tool in its seat: `tool.json`.
    pub(crate) fn tool(&self, room: &mut TrueRoom, prepared: &mut Prepared) -> Result<(), Refused> {
        let [x, y, z] = DIVOT_MM;
        let pivot = practice::pivot(Point::new(x, y, z));
        let seconds = self.stratum.dials.calibration.pivot_s;
        self.recorded(Step::Pivot, room, prepared, (&pivot, seconds), "pivot.csv")?;
        let (poses, tip) = (self.named("pivot.csv"), self.named("tip.json"));
        let names = ["--tool", TUBE.name, "--marker", MARKER];
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
            return Err(Refused::at(step)(why));
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
        let place = heard.touch((name, TUBE.name, frame), &self.file(tip), &self.file(to), seconds);
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
        let text = tracker_text(&self.stratum.dials, TUBE, &prepared.emitters)
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

/// The tool's true frame in its marker.
pub(crate) fn true_tool(room: &TrueRoom) -> Rigid<Marker, Tool> {
    room.room.marker_from_tool
}
