//! Listening to a run.

use bus::BusError;
use bus::clock;
use bus::message::{EmitterFrame, MarkerFrame};
use bus::port::{Subscriber, UsImageSubscriber};
use bus::run::RunLock;
use bus::topic::{EMITTERS, MARKERS};
use geometry::{Direction, Marker, Rigid, Tool, Tracker, Uncertain, Vector};
use scene::TrackerSource;

use super::images::{Looked, look};
use super::{Against, Delivered, Follow, FollowMarkers, Heard, Lacks, LiveArgs, LiveError, Watch};
use crate::poses::MAX_POSES;
use crate::scene_context::{Going, SceneContext};

/// Frames that may wait between two looks, a quarter of a second at 4000 Hz.
const DEPTH: usize = 1024;
/// Between two looks, ns.
const LOOK_NS: i64 = 5_000_000;
/// Between two words of progress, ns: to a terminal, and to who watches.
const TELL_NS: [i64; 2] = [1_000_000_000, 100_000_000];

/// A run that is listened to.
pub(crate) struct Run<'a> {
    pub(crate) scened: &'a SceneContext,
    pub(crate) follow: Box<dyn Follow>,
    pub(crate) against: Against,
    going: &'a Going,
    watch: Watch,
    frames: Frames,
    /// Where its ultrasound probe is listened to.
    images: Option<UsImageSubscriber>,
}

/// What the run's localizer delivers.
enum Frames {
    Emitters(Subscriber<EmitterFrame>),
    Markers(Subscriber<MarkerFrame>),
}

/// One frame of it.
enum Frame {
    Emitters(Box<EmitterFrame>),
    Markers(Box<MarkerFrame>),
}

impl Frames {
    fn open(going: &Going, source: &TrackerSource) -> Result<Self, BusError> {
        Ok(match source {
            TrackerSource::Markers(_) => Self::Markers(Subscriber::open(&going.bus, &MARKERS, "", DEPTH)?),
            _ => Self::Emitters(Subscriber::open(&going.bus, &EMITTERS, "", DEPTH)?),
        })
    }

    fn next(&self) -> Result<Option<Frame>, BusError> {
        Ok(match self {
            Self::Emitters(frames) => frames.next()?.map(|frame| Frame::Emitters(Box::new(frame))),
            Self::Markers(frames) => frames.next()?.map(|frame| Frame::Markers(Box::new(frame))),
        })
    }
}

impl Frame {
    fn t_capture_ns(&self) -> i64 {
        match self {
            Self::Emitters(frame) => frame.t_capture_ns,
            Self::Markers(frame) => frame.t_capture_ns,
        }
    }

    fn delivered(&self) -> Delivered<'_> {
        match self {
            Self::Emitters(frame) => Delivered::Emitters(frame),
            Self::Markers(frame) => Delivered::Markers(frame),
        }
    }
}

/// What was heard of the marker.
#[derive(Debug, Default)]
pub(crate) struct Listened {
    /// Frames that were captured and came while it was listened.
    pub(crate) frames: usize,
    /// Frames that came and were captured before.
    earlier: usize,
    /// Why the last frame without a pose had none.
    pub(crate) why: String,
    /// Poses of the marker in the frame of [`Against`], which the tracker stands for.
    pub(crate) poses: Vec<Uncertain<Tracker, Marker>>,
    /// When each was captured, s from the first.
    pub(crate) times_s: Vec<f64>,
    /// What the images of the run's ultrasound probe showed, where it is listened to.
    pub(crate) images: Vec<Looked>,
    first_ns: i64,
}

impl Listened {
    /// What a recording holds: poses with their times, s, and what its images showed, with stamps of the same clock.
    pub(crate) fn recorded(poses: Vec<Uncertain<Tracker, Marker>>, times_s: Vec<f64>, images: Vec<Looked>) -> Self {
        Self {
            frames: poses.len(),
            poses,
            times_s,
            images,
            ..Self::default()
        }
    }

    /// The time of a stamp of the run's clock, s from the first pose.
    pub(crate) fn seconds_of(&self, t_ns: i64) -> f64 {
        clock::ms(t_ns.saturating_sub(self.first_ns)) / 1e3
    }
}

impl<'a> Run<'a> {
    /// Listens to the run that a scene is of; `None` where it is of none.
    pub(crate) fn open(
        scened: Option<&'a SceneContext>,
        args: &LiveArgs,
        follow: FollowMarkers,
    ) -> Result<Option<Self>, LiveError> {
        let Some((scened, going)) = scened.and_then(|scened| Some((scened, scened.going.as_ref()?))) else {
            return Ok(None);
        };
        let follow = follow(&scened.scene).map_err(|error| LiveError::Follow {
            run: going.name.clone(),
            why: error.to_string(),
        })?;
        let against = match (args.against, follow.has_reference()) {
            (Some(Against::Reference), false) => return Err(LiveError::NoReference(going.name.clone())),
            (Some(against), _) => against,
            (None, true) => Against::Reference,
            (None, false) => Against::Tracker,
        };
        let frames = Frames::open(going, &scened.scene.tracker.source)?;
        Ok(Some(Self {
            scened,
            follow,
            against,
            going,
            watch: args.watch.clone(),
            frames,
            images: None,
        }))
    }

    /// Listens to the images of the run's ultrasound probe too.
    pub(crate) fn hear_images(&mut self) -> Result<(), LiveError> {
        self.images = Some(UsImageSubscriber::open(&self.going.bus)?);
        Ok(())
    }

    /// The run's name.
    pub(crate) fn name(&self) -> &str {
        &self.going.name
    }

    /// The direction from the handle to the tip in the marker, by the scene's own drawing.
    pub(crate) fn drawn_axis(&self) -> Option<Direction<Marker>> {
        let drawn: Rigid<Marker, Tool> = match &self.scened.scene.tracker.source {
            TrackerSource::OperatingRoom(room) => room.marker_from_tool,
            TrackerSource::Emitters(spec) => spec.marker_from_tool,
            TrackerSource::Markers(spec) => spec.markers.marker_from_tool,
            _ => return None,
        };
        Some(drawn * Direction::Z)
    }

    /// Listens for so long. `advise` says of what was heard what it still lacks: to who watches, or else to stderr, where words are
    /// only written of a motion that takes its time.
    ///
    /// Only what was captured from now on counts, by the localizer's own stamps.
    pub(crate) fn listen(
        &mut self,
        seconds: f64,
        advise: Option<&dyn Fn(&Listened) -> Lacks>,
    ) -> Result<Listened, LiveError> {
        let clock = self.going.bus.clock().clone();
        let began = clock.now_ns();
        let until = began.saturating_add(clock::seconds(seconds));
        let between = TELL_NS[usize::from(self.watch.is_there())];
        let (mut heard, mut tell_ns) = (Listened::default(), began.saturating_add(between));
        loop {
            let now = clock.now_ns();
            while let Some(frame) = self.frames.next()? {
                // It may show the instrument as it was held before.
                if frame.t_capture_ns() < began {
                    heard.earlier += 1;
                    continue;
                }
                self.take(&frame, clock.now_ns(), &mut heard);
            }
            if let Some(images) = &self.images {
                heard.images.extend(look(images, began)?);
            }
            let passed_s = clock::ms(now - began) / 1e3;
            if now >= until || heard.poses.len() >= MAX_POSES {
                self.tell(&heard, [passed_s, seconds], advise)?;
                return self.checked(heard, seconds);
            }
            if now >= tell_ns {
                if !RunLock::is_held(&self.going.dir) {
                    let run = self.going.name.clone();
                    return Err(LiveError::Ended {
                        run,
                        seconds: passed_s,
                        asked: seconds,
                    });
                }
                self.tell(&heard, [passed_s, seconds], advise)?;
                // What is said of many poses takes its time: a fifth of all at most, the rest is for frames.
                let told = clock.now_ns();
                let rest = told.saturating_sub(now).saturating_mul(4);
                tell_ns = tell_ns.saturating_add(between).max(told.saturating_add(rest));
            }
            clock.sleep_until((now + LOOK_NS).min(until));
        }
    }

    fn tell(
        &self,
        heard: &Listened,
        [passed_s, asked_s]: [f64; 2],
        advise: Option<&dyn Fn(&Listened) -> Lacks>,
    ) -> Result<(), LiveError> {
        let (frames, poses) = (heard.frames, heard.poses.len());
        match (self.watch.is_there(), advise) {
            (true, advise) => {
                let words = heard.why.clone();
                let lacks = advise.map_or_else(|| Lacks { words, motion: None }, |advise| advise(heard));
                let told = Heard {
                    passed_s,
                    asked_s,
                    frames,
                    poses,
                    advice: lacks.words,
                    motion: lacks.motion,
                };
                match self.watch.tell(&told).is_break() {
                    true => Err(LiveError::Cancelled),
                    false => Ok(()),
                }
            }
            (false, Some(advise)) => {
                let advice = advise(heard).words;
                bus::stderr_line!("calib: {passed_s:.0} s of {asked_s}, {poses} poses of {frames} frames: {advice}");
                Ok(())
            }
            (false, None) => Ok(()),
        }
    }

    fn take(&mut self, frame: &Frame, now_ns: i64, heard: &mut Listened) {
        heard.frames += 1;
        match self.follow.see(frame.delivered(), now_ns) {
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
                    heard.first_ns = frame.t_capture_ns();
                }
                heard.poses.push(pose);
                heard
                    .times_s
                    .push(clock::ms(frame.t_capture_ns().saturating_sub(heard.first_ns)) / 1e3);
            }
            Err(why) => heard.why = why,
        }
    }

    fn checked(&self, heard: Listened, seconds: f64) -> Result<Listened, LiveError> {
        let run = self.going.name.clone();
        match (heard.frames, heard.poses.is_empty()) {
            (0, _) if heard.earlier == 0 => Err(LiveError::Silent { run, seconds }),
            (0, _) => Err(LiveError::NotSeen {
                run,
                frames: heard.earlier,
                seconds,
                why: "all were captured before it was listened to".to_owned(),
            }),
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
