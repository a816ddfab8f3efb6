//! Listening to a run.

use std::path::PathBuf;

use bus::Bus;
use bus::clock;
use bus::message::EmitterFrame;
use bus::port::{Subscriber, VolumeSubscriber};
use bus::run::{RunContext, RunError, RunLock, run_dir};
use bus::scene::tracking::CalibrationGates;
use bus::scene::{Scene, TrackerSource};
use bus::topic::EMITTERS;
use geometry::{Direction, Marker, Rigid, Tool, Tracker, Uncertain, Vector};

use super::{Against, Follow, FollowMarkers, LiveArgs, LiveError};
use crate::cli::Name;
use crate::poses::MAX_POSES;

/// Frames that may wait between two looks, a quarter of a second at 4000 Hz.
const DEPTH: usize = 1024;
/// The volume of a run is shown to whoever joins within this, ns.
const VOLUME_NS: i64 = 2_000_000_000;
/// Between two looks, ns.
const LOOK_NS: i64 = 5_000_000;
/// Between two words of progress, ns.
const TELL_NS: i64 = 1_000_000_000;

/// A run that is listened to.
pub(crate) struct Run {
    pub(crate) name: String,
    pub(crate) bus: Bus,
    pub(crate) scene: Scene,
    pub(crate) follow: Box<dyn Follow>,
    pub(crate) against: Against,
    dir: PathBuf,
    frames: Subscriber<EmitterFrame>,
}

/// What was heard of the marker.
#[derive(Debug, Default)]
pub(crate) struct Heard {
    /// Frames that came.
    pub(crate) frames: usize,
    /// Why the last frame without a pose had none.
    pub(crate) why: String,
    /// Poses of the marker in the frame of [`Against`], which the tracker stands for.
    pub(crate) poses: Vec<Uncertain<Tracker, Marker>>,
    /// When each was captured, s from the first.
    pub(crate) times_s: Vec<f64>,
    first_ns: i64,
}

impl Run {
    /// Joins the run that the command line names; `None` where it names none.
    pub(crate) fn open(args: &LiveArgs, follow: FollowMarkers) -> Result<Option<Self>, LiveError> {
        let Some(name) = args.live.clone() else { return Ok(None) };
        let dir = run_dir(&name)?;
        if !RunLock::is_held(&dir) {
            return Err(RunError::NotRunning { name }.into());
        }
        let context = RunContext::load(&dir)?;
        let scene = Scene::load(&context.scene_path())?;
        let follow = follow(&scene).map_err(|error| LiveError::Follow {
            run: name.clone(),
            why: error.to_string(),
        })?;
        let against = match (args.against, follow.has_reference()) {
            (Some(Against::Reference), false) => return Err(LiveError::NoReference(name)),
            (Some(against), _) => against,
            (None, true) => Against::Reference,
            (None, false) => Against::Tracker,
        };
        let bus = Bus::join(&context)?;
        let frames = Subscriber::open(&bus, &EMITTERS, "", DEPTH)?;
        Ok(Some(Self {
            name,
            bus,
            scene,
            follow,
            against,
            dir,
            frames,
        }))
    }

    /// The tool's name: the scene's, which `given` must be where it is given.
    pub(crate) fn tool(&self, given: Option<&Name>) -> Result<Name, LiveError> {
        self.named("tool", given, Some(&self.scene.tool.name))
    }

    /// The marker's name: the one that the scene asks of calibrations, where it does.
    pub(crate) fn marker(&self, given: Option<&Name>) -> Result<Name, LiveError> {
        let link = self.scene.tracker.links.calibration.as_ref();
        self.named("marker", given, link.and_then(|link| link.file.marker.as_deref()))
    }

    fn named(&self, what: &'static str, given: Option<&Name>, own: Option<&str>) -> Result<Name, LiveError> {
        match (given, own) {
            (Some(given), Some(own)) if given.as_str() != own => Err(LiveError::Other {
                run: self.name.clone(),
                what,
                given: given.as_str().to_owned(),
                expected: own.to_owned(),
            }),
            (Some(given), _) => Ok(given.clone()),
            (None, own) => Ok(Name::told(own.unwrap_or(what))),
        }
    }

    /// The hash of the run's volume; `None` where it is not there yet.
    pub(crate) fn volume_hash(&self) -> Result<Option<String>, LiveError> {
        let volumes = VolumeSubscriber::open(&self.bus)?;
        let clock = self.bus.clock();
        let until = clock.now_ns().saturating_add(VOLUME_NS);
        loop {
            if let Some(volume) = volumes.poll()? {
                return Ok(Some(volume.hash().to_string()));
            }
            if clock.now_ns() >= until {
                return Ok(None);
            }
            clock.sleep_until(clock.now_ns() + LOOK_NS);
        }
    }

    /// The gates that the scene sets for calibrations.
    pub(crate) fn gates(&self) -> CalibrationGates {
        let link = self.scene.tracker.links.calibration.as_ref();
        link.map(|link| link.gates).unwrap_or_default()
    }

    /// The direction from the handle to the tip in the marker, by the scene's own drawing.
    pub(crate) fn drawn_axis(&self) -> Option<Direction<Marker>> {
        let drawn: Rigid<Marker, Tool> = match &self.scene.tracker.source {
            TrackerSource::OperatingRoom(room) => room.marker_from_tool,
            TrackerSource::Emitters(spec) => spec.marker_from_tool,
            _ => return None,
        };
        Some(drawn * Direction::Z)
    }

    /// Listens for so long, and calls `tell` every second with what was heard and the seconds that have passed.
    pub(crate) fn listen(&mut self, seconds: f64, mut tell: impl FnMut(&Heard, f64)) -> Result<Heard, LiveError> {
        let clock = self.bus.clock().clone();
        let began = clock.now_ns();
        let until = began.saturating_add(clock::seconds(seconds));
        let (mut heard, mut tell_ns) = (Heard::default(), began.saturating_add(TELL_NS));
        loop {
            let now = clock.now_ns();
            while let Some(frame) = self.frames.next()? {
                self.take(&frame, clock.now_ns(), &mut heard);
            }
            let passed_s = clock::ms(now - began) / 1e3;
            if now >= until || heard.poses.len() >= MAX_POSES {
                return self.checked(heard, seconds);
            }
            if now >= tell_ns {
                if !RunLock::is_held(&self.dir) {
                    let run = self.name.clone();
                    return Err(LiveError::Ended {
                        run,
                        seconds: passed_s,
                        asked: seconds,
                    });
                }
                tell(&heard, passed_s);
                tell_ns = tell_ns.saturating_add(TELL_NS);
            }
            clock.sleep_until((now + LOOK_NS).min(until));
        }
    }

    fn take(&mut self, frame: &EmitterFrame, now_ns: i64, heard: &mut Heard) {
        heard.frames += 1;
        match self.follow.see(frame, now_ns) {
            Ok(seen) => {
                // Where the scene has a marker on the patient, a pose has both.
                let Some(pose) = (match (self.against, seen.reference) {
                    (Against::Tracker, _) => Some(seen.marker),
                    (Against::Reference, Some(reference)) => stand_in(reference.inverse() * seen.marker),
                    (Against::Reference, None) => None,
                }) else {
                    return;
                };
                if heard.poses.is_empty() {
                    heard.first_ns = frame.t_capture_ns;
                }
                heard.poses.push(pose);
                heard
                    .times_s
                    .push(clock::ms(frame.t_capture_ns.saturating_sub(heard.first_ns)) / 1e3);
            }
            Err(why) => heard.why = why,
        }
    }

    fn checked(&self, heard: Heard, seconds: f64) -> Result<Heard, LiveError> {
        let run = self.name.clone();
        match (heard.frames, heard.poses.is_empty()) {
            (0, _) => Err(LiveError::Silent { run, seconds }),
            (frames, true) => Err(LiveError::NotSeen {
                run,
                frames,
                seconds,
                why: heard.why,
            }),
            _ => Ok(heard),
        }
    }
}

/// The same pose with the tracker's name on its frame: what the poses of a calibration are in.
fn stand_in<F>(pose: Uncertain<F, Marker>) -> Option<Uncertain<Tracker, Marker>> {
    let [x, y, z] = pose.transform().translation_mm();
    let rigid = Rigid::from_parts(pose.transform().rotation(), Vector::new(x, y, z));
    Uncertain::from_upper(rigid, pose.upper()).ok()
}
