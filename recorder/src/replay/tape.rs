//! The messages of a recording in the order in which they were published.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::iter::Peekable;
use std::path::Path;
use std::rc::Rc;

use bus::message::{EmitterFrame, MarkerFrame, ToolPose};

use crate::read::damage::OpenError;
use crate::read::reader::{Messages, ReadError, Recorded};
use crate::read::seek::Session;
use crate::wire::proto::{TissueFrame, UsFrame};
use crate::wire::schema::{GROUND_TRUTH, TISSUE, TOOL_POSE, US_IMAGE};

/// True poses that are kept behind one pose at most: a recording without poses of the tool does not fill the memory.
const MOST_TRUTHS: usize = 4096;
/// Ultrasound images that are kept behind one pose at most, for the same reason.
const MOST_IMAGES: usize = 16;
/// A place is looked for among what was captured from this long before it on, as a pose is published after its capture, ns;
/// where that was not enough, from [`WIDER`] times as long before.
const BEFORE_NS: i64 = 50_000_000;
const WIDER: i64 = 8;

/// What is published together.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// The tool's pose.
    pub pose: ToolPose,
    /// What the localizer delivered for it; `None` where that is not read, or not in the recording.
    pub frame: Option<Delivered>,
    /// The true poses that were published from then on, up to the next pose; with the first pose also those before it.
    pub truths: Vec<ToolPose>,
    /// The ultrasound images of the same stretch.
    pub images: Vec<UsFrame>,
    /// Where organs were for this very pose; `None` where that is not read, or not in the recording.
    pub tissue: Option<Box<TissueFrame>>,
}

/// What a localizer delivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Delivery {
    /// Places of emitters.
    Emitters,
    /// Poses of markers.
    Markers,
}

/// One frame of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Delivered {
    /// Places of emitters.
    Emitters(Box<EmitterFrame>),
    /// Poses of markers.
    Markers(Box<MarkerFrame>),
}

impl Moment {
    /// When it was published, ns on the clock of the recorded run.
    pub fn due_ns(&self) -> i64 {
        self.pose.t_publish_ns
    }
}

/// A recording being replayed. A place in it is found through its index ([`crate::read::seek`]): what lies before is not read.
#[derive(Debug)]
pub struct Tape {
    session: Session,
    poses: Peekable<Readable<ToolPose>>,
    truths: Peekable<Readable<ToolPose>>,
    /// Where the recording has any.
    images: Option<Box<Peekable<Readable<UsFrame>>>>,
    /// Where the recording has any, and poses are those that they are of.
    tissue: Option<Box<Peekable<Readable<TissueFrame>>>>,
    /// Where poses are made again.
    frames: Option<Frames>,
    next: Option<Moment>,
    unread: Log,
}

/// What the localizer delivered, as far as it can be read.
#[derive(Debug)]
enum Frames {
    Emitters(Box<Peekable<Readable<EmitterFrame>>>),
    Markers(Box<Peekable<Readable<MarkerFrame>>>),
}

/// The messages that can be read; what cannot is noted.
#[derive(Debug)]
struct Readable<T> {
    messages: Messages<T>,
    unread: Log,
}

/// What could not be read, in words, by its place: each once, whoever came by.
type Log = Rc<RefCell<BTreeMap<String, String>>>;
/// More are not noted.
const NOTED: usize = 100;

/// A message of the bus with its stamps.
trait Stamped {
    /// Its number, and when it was captured and published, ns.
    fn stamps(&self) -> (u64, [i64; 2]);
}

impl Stamped for ToolPose {
    fn stamps(&self) -> (u64, [i64; 2]) {
        (self.seq, [self.t_capture_ns, self.t_publish_ns])
    }
}

impl Stamped for EmitterFrame {
    fn stamps(&self) -> (u64, [i64; 2]) {
        (self.seq, [self.t_capture_ns, self.t_publish_ns])
    }
}

impl Stamped for MarkerFrame {
    fn stamps(&self) -> (u64, [i64; 2]) {
        (self.seq, [self.t_capture_ns, self.t_publish_ns])
    }
}

impl Stamped for TissueFrame {
    fn stamps(&self) -> (u64, [i64; 2]) {
        (self.header.seq, [self.header.t_capture_ns, self.header.t_publish_ns])
    }
}

impl Stamped for UsFrame {
    fn stamps(&self) -> (u64, [i64; 2]) {
        (self.header.seq, [self.header.t_capture_ns, self.header.t_publish_ns])
    }
}

/// The stamp of a pose that no clock shows.
pub(crate) fn impossible_stamp(pose: &ToolPose) -> Option<(&'static str, i64)> {
    let stamps = [("captured", pose.t_capture_ns), ("published", pose.t_publish_ns)];
    stamps.into_iter().find(|&(_, ns)| !is_possible(ns))
}

/// 2^61 ns are 73 years. Differences of such times never overflow.
fn is_possible(ns: i64) -> bool {
    ns.unsigned_abs() < 1 << 61
}

impl<T: Recorded + Stamped> Iterator for Readable<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        loop {
            match self.messages.next()? {
                Ok(message) if message.stamps().1.into_iter().all(is_possible) => return Some(message),
                Ok(_) => self.note("stamps", "a message whose stamps show on no clock"),
                Err(ReadError::Damage(damage)) => {
                    self.note(&format!("{:020}", damage.at), &damage.to_string());
                    if damage.stops {
                        return None;
                    }
                }
                Err(error) => self.note(&error.to_string(), &error.to_string()),
            }
        }
    }
}

impl<T> Readable<T> {
    fn note(&self, place: &str, words: &str) {
        let mut unread = self.unread.borrow_mut();
        if unread.len() < NOTED {
            unread.entry(place.to_owned()).or_insert_with(|| words.to_owned());
        }
    }
}

fn readable<T: Recorded + Stamped>(messages: Messages<T>, unread: &Log) -> Peekable<Readable<T>> {
    let unread = Rc::clone(unread);
    Readable { messages, unread }.peekable()
}

impl Tape {
    /// Opens a recording at its start, for its poses.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        Self::of(path, None)
    }

    /// The same with the frames that the poses were made of.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn with_frames(path: &Path, delivery: Delivery) -> Result<Self, OpenError> {
        Self::of(path, Some(delivery))
    }

    fn of(path: &Path, delivery: Option<Delivery>) -> Result<Self, OpenError> {
        let session = Session::open(path)?;
        let unread = Log::default();
        let open = |topic| session.poses_of(topic, i64::MIN).map(|poses| readable(poses, &unread));
        let mut tape = Self {
            poses: open(TOOL_POSE)?,
            truths: open(GROUND_TRUTH)?,
            images: images_of(&session, i64::MIN, &unread)?,
            tissue: match delivery {
                // States are of the recorded poses, and of none that are made again.
                Some(_) => None,
                None => tissue_of(&session, i64::MIN, &unread)?,
            },
            frames: delivery
                .map(|delivery| Frames::from(&session, delivery, i64::MIN, &unread))
                .transpose()?,
            next: None,
            session,
            unread: Log::clone(&unread),
        };
        tape.next = tape.read();
        Ok(tape)
    }

    /// Goes to where the first pose that was published at `at_ns` or later is near: from there on it comes, and what comes
    /// before it is little.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn near(&mut self, at_ns: i64) -> Result<(), OpenError> {
        let mut before_ns = BEFORE_NS;
        loop {
            let from_ns = at_ns.saturating_sub(before_ns);
            self.start(from_ns)?;
            // Of poses in the order of their publication, one that is earlier says that none is left out.
            if from_ns <= 0 || self.peek().is_some_and(|next| next.due_ns() < at_ns) {
                return Ok(());
            }
            before_ns = before_ns.saturating_mul(WIDER);
        }
    }

    /// When the last pose before `at_ns` was published; `None` where there is none. Goes to `at_ns`.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn before(&mut self, at_ns: i64) -> Result<Option<i64>, OpenError> {
        self.near(at_ns)?;
        let mut last_ns = None;
        while let Some(due_ns) = self.peek().map(Moment::due_ns).filter(|due_ns| *due_ns < at_ns) {
            last_ns = Some(due_ns);
            self.take();
        }
        Ok(last_ns)
    }

    /// Reads on from what was captured at `from_ns` or later.
    fn start(&mut self, from_ns: i64) -> Result<(), OpenError> {
        let open = |topic| self.session.poses_of(topic, from_ns);
        self.poses = readable(open(TOOL_POSE)?, &self.unread);
        self.truths = readable(open(GROUND_TRUTH)?, &self.unread);
        self.images = images_of(&self.session, from_ns, &self.unread)?;
        if self.tissue.is_some() {
            self.tissue = tissue_of(&self.session, from_ns, &self.unread)?;
        }
        if let Some(frames) = &mut self.frames {
            *frames = Frames::from(&self.session, frames.delivery(), from_ns, &self.unread)?;
        }
        self.next = self.read();
        Ok(())
    }

    /// The recording with its index.
    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    /// What could not be read so far, and is left out: in words, by its place.
    pub fn unread(&self) -> Vec<String> {
        self.unread.borrow().values().cloned().collect()
    }

    /// What comes next, without taking it.
    pub fn peek(&self) -> Option<&Moment> {
        self.next.as_ref()
    }

    /// Takes what comes next.
    pub fn take(&mut self) -> Option<Moment> {
        let next = self.read();
        std::mem::replace(&mut self.next, next)
    }

    fn read(&mut self) -> Option<Moment> {
        let pose = self.poses.next()?;
        let until_ns = self.poses.peek().map_or(i64::MAX, |next| next.t_publish_ns);
        let mut truths = Vec::new();
        while let Some(truth) = self.truths.next_if(|truth| truth.t_publish_ns < until_ns) {
            truths.push(truth);
            if truths.len() == MOST_TRUTHS {
                break;
            }
        }
        let mut images = Vec::new();
        if let Some(of_probe) = &mut self.images {
            while images.len() < MOST_IMAGES
                && let Some(image) = of_probe.next_if(|image| image.header.t_publish_ns < until_ns)
            {
                images.push(image);
            }
        }
        let frame = self.frames.as_mut().and_then(|frames| frames.of(&pose));
        let tissue = self.tissue.as_mut().and_then(|states| state_of(states, &pose));
        Some(Moment {
            pose,
            frame,
            truths,
            images,
            tissue,
        })
    }
}

/// The ultrasound images from `from_ns` on. A recording without any is not read once more for them.
fn images_of(
    session: &Session,
    from_ns: i64,
    unread: &Log,
) -> Result<Option<Box<Peekable<Readable<UsFrame>>>>, OpenError> {
    if !session.may_hold(US_IMAGE) {
        return Ok(None);
    }
    Ok(Some(Box::new(readable(session.us_images_from(from_ns)?, unread))))
}

/// The states of organs of poses from `from_ns` on; a recording without any is not read once more for them.
fn tissue_of(
    session: &Session,
    from_ns: i64,
    unread: &Log,
) -> Result<Option<Box<Peekable<Readable<TissueFrame>>>>, OpenError> {
    if !session.may_hold(TISSUE) {
        return Ok(None);
    }
    Ok(Some(Box::new(readable(session.tissue_from(from_ns)?, unread))))
}

/// The state of `pose`; those of earlier poses are passed over.
fn state_of(states: &mut Peekable<Readable<TissueFrame>>, pose: &ToolPose) -> Option<Box<TissueFrame>> {
    let is_of = |state: &TissueFrame| {
        let header = &state.header;
        (header.pose_seq, header.registration_id) == (pose.seq, pose.registration_id)
    };
    loop {
        let state = states.next_if(|state| state.header.t_capture_ns <= pose.t_capture_ns)?;
        if state.header.t_capture_ns == pose.t_capture_ns && is_of(&state) {
            // A model that was started again may have answered it anew: views show the last.
            let is_again = |next: &TissueFrame| next.header.t_capture_ns == pose.t_capture_ns && is_of(next);
            let mut last = state;
            while let Some(again) = states.next_if(is_again) {
                last = again;
            }
            return Some(Box::new(last));
        }
    }
}

impl Frames {
    fn from(session: &Session, delivery: Delivery, from_ns: i64, unread: &Log) -> Result<Self, OpenError> {
        Ok(match delivery {
            Delivery::Emitters => Self::Emitters(Box::new(readable(session.emitters_from(from_ns)?, unread))),
            Delivery::Markers => Self::Markers(Box::new(readable(session.markers_from(from_ns)?, unread))),
        })
    }

    fn delivery(&self) -> Delivery {
        match self {
            Self::Emitters(_) => Delivery::Emitters,
            Self::Markers(_) => Delivery::Markers,
        }
    }

    fn of(&mut self, pose: &ToolPose) -> Option<Delivered> {
        match self {
            Self::Emitters(frames) => frame_of(frames, pose).map(|frame| Delivered::Emitters(Box::new(frame))),
            Self::Markers(frames) => frame_of(frames, pose).map(|frame| Delivered::Markers(Box::new(frame))),
        }
    }
}

/// The frame that `pose` was made of. Frames before it of which the tracker made no pose (they came twice, or too late) are passed
/// over, as it did.
fn frame_of<T: Recorded + Stamped>(frames: &mut Peekable<Readable<T>>, pose: &ToolPose) -> Option<T> {
    let (seq, [t_capture_ns, t_publish_ns]) = pose.stamps();
    let is_it = |frame: &T| {
        let (number, [captured_ns, _]) = frame.stamps();
        (number, captured_ns) == (seq, t_capture_ns)
    };
    loop {
        let frame = frames.next_if(|frame| is_it(frame) || frame.stamps().1[1] <= t_publish_ns)?;
        if is_it(&frame) {
            return Some(frame);
        }
    }
}

#[cfg(test)]
mod tests;
