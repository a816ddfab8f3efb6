//! Reads a recording once from start to end, whole or not, and keeps what a report says of it, in bounded memory.

use std::io::Read;
use std::ops::ControlFlow;
use std::path::Path;

use bus::continuity::Continuity;
use bus::message::{Ages, Guide, Lost, MarkerFrame, ToolPose, Tracked, Workflow};
use mcap::Message;
use prost::Message as _;

use super::ReportError;
use super::basis::{Basis, Limits};
use super::expected;
use super::facts::{DamageFacts, PoseFacts};
use super::localizer::Localizers;
use super::marks::Marks;
use super::organs::Organs;
use super::quantity::Quantity;
use super::short::short;
use super::states::{Between, Timeline};
use super::story::{Check, Meaning, Story};
use super::tip::Tip;
use crate::edit::progress::Progress;
use crate::read::damage::Damage;
use crate::read::one_run::OneRun;
use crate::read::reader;
use crate::read::scan::{Item, Scan};
use crate::read::tally::Tally;
use crate::replay::tape::impossible_stamp;
use crate::wire::proto::{self, Identity, Log, ProcessStatus, TissueFrame};
use crate::wire::schema::{GROUND_TRUTH, GUIDE, IDENTITY, LOG, MARKERS, STATUS, TISSUE, TOOL_POSE, VIEW, WORKFLOW};

/// Latencies from a tenth of a microsecond to three hours are told apart, ms.
const LATENCY_MS: (f64, f64) = (1e-4, 1e7);
/// Stamps of this size show on no clock: 2^61 ns are 73 years.
const NO_CLOCK: u64 = 1 << 61;

/// What has been found so far.
#[derive(Debug)]
pub(super) struct Gathered {
    pub(super) library: Option<String>,
    pub(super) tally: Tally,
    pub(super) damage: DamageFacts,
    pub(super) basis: Basis,
    pub(super) story: Story,
    pub(super) marks: Marks,
    pub(super) poses: PoseFacts,
    pub(super) tip: Tip,
    pub(super) latency: Quantity,
    pub(super) localizers: Localizers,
    pub(super) organs: Organs,
    pub(super) timeline: Timeline,
    /// The newest word on whose examination it is.
    pub(super) identity: Option<Identity>,
    /// The first and the last capture, ns.
    pub(super) span_ns: Option<(i64, i64)>,
    /// The limits that hold, where no scene says: those of one that says nothing.
    limits: Limits,
    /// They are those of who asked, whatever the recording's scene says.
    are_given: bool,
    /// What lies behind the last sample so far.
    pub(super) between: Between,
    continuity: Continuity,
    last_seq: Option<u64>,
    registration_id: Option<u64>,
    one_run: OneRun,
}

/// What every scene has that says nothing of it.
fn plain_limits() -> Limits {
    let never = Limits {
        ages: Ages {
            stale_ns: 0,
            lost_ns: 0,
        },
        frozen_ns: None,
    };
    scene::Scene::parse("", Path::new("scene.toml")).map_or(never, |scene| Limits::of(&scene))
}

impl Gathered {
    fn new(given: Option<Limits>) -> Self {
        let limits = given.unwrap_or_else(plain_limits);
        Self {
            library: None,
            tally: Tally::default(),
            damage: DamageFacts::default(),
            basis: Basis::default(),
            story: Story::default(),
            marks: Marks::default(),
            poses: PoseFacts::default(),
            tip: Tip::default(),
            latency: Quantity::new(LATENCY_MS.0, LATENCY_MS.1),
            localizers: Localizers::default(),
            organs: Organs::default(),
            timeline: Timeline::new(limits.ages),
            identity: None,
            span_ns: None,
            limits,
            are_given: given.is_some(),
            between: Between::Nothing,
            continuity: Continuity::default(),
            last_seq: None,
            registration_id: None,
            one_run: OneRun::default(),
        }
    }

    /// The limits that were taken, ms: stale and lost.
    pub(super) fn limits_ms(&self) -> [f64; 2] {
        [self.limits.ages.stale_ns, self.limits.ages.lost_ns].map(bus::clock::ms)
    }

    fn take(&mut self, path: &Path, item: Item) -> Result<(), ReportError> {
        if let Some(why) = self.one_run.beside(&item) {
            let path = path.to_owned();
            return Err(ReportError::TwoRuns { path, why });
        }
        match item {
            Item::Channel(channel) => {
                expected::check(path, &channel)?;
                self.tally.declare(&channel);
            }
            Item::Message(message) => self.message(&message),
            Item::Attachment(file) => {
                self.basis.attachment(&file);
                self.take_limits();
            }
            Item::Metadata(record) => self.basis.metadata(record),
        }
        Ok(())
    }

    /// Those of the scene, where it comes before the first sample, as the recorder writes it.
    fn take_limits(&mut self) {
        if self.are_given || self.timeline.has_begun() {
            return;
        }
        if let Some(scene) = self.basis.scene_facts() {
            self.limits = scene.limits;
            self.timeline.limits(self.limits.ages);
        }
    }

    fn message(&mut self, message: &Message<'_>) {
        let Some(t_ns) = i64::try_from(message.log_time)
            .ok()
            .filter(|_| message.log_time < NO_CLOCK)
        else {
            return self.unreadable(
                message,
                &format!("captured at {} ns, which no clock shows", message.log_time),
            );
        };
        self.tally.count(message);
        self.spans(t_ns);
        let topic = message.channel.topic.as_str();
        let taken = match topic {
            TOOL_POSE => self.decoded(message, Self::pose),
            GROUND_TRUTH => self.decoded(message, |of, truth: ToolPose| of.tip.truth(&truth)),
            GUIDE => self.decoded(message, |of, guide: Guide| of.story.guide(&guide)),
            MARKERS => self.decoded(message, |of, frame: MarkerFrame| of.localizers.take(&frame)),
            TISSUE => self.tissue(message),
            _ => self.words(topic, t_ns, message).map_err(|error| error.to_string()),
        };
        if let Err(words) = taken {
            self.unreadable(message, &words);
        }
    }

    fn spans(&mut self, t_ns: i64) {
        let (first, last) = self.span_ns.unwrap_or((t_ns, t_ns));
        self.span_ns = Some((first.min(t_ns), last.max(t_ns)));
    }

    fn tissue(&mut self, message: &Message<'_>) -> Result<(), String> {
        let state: TissueFrame = reader::decode(message).map_err(|error| error.to_string())?;
        self.organs.take(&state, self.basis.tissue_tolerance())
    }

    fn decoded<T: reader::Recorded>(
        &mut self,
        message: &Message<'_>,
        take: impl FnOnce(&mut Self, T),
    ) -> Result<(), String> {
        let found = reader::decode(message).map_err(|error| error.to_string())?;
        take(self, found);
        Ok(())
    }

    /// A message for people.
    fn words(&mut self, topic: &str, at_ns: i64, message: &Message<'_>) -> Result<(), prost::DecodeError> {
        let data = &*message.data;
        match topic {
            WORKFLOW => {
                let proto::Workflow { t_ns, stage, flags, .. } = proto::Workflow::decode(data)?;
                self.story.workflow(
                    at_ns,
                    Workflow {
                        t_ns,
                        stage,
                        flags,
                        ..Workflow::default()
                    },
                );
            }
            STATUS => self.story.status(&ProcessStatus::decode(data)?),
            LOG => match self.story.log(at_ns, &Log::decode(data)?) {
                Meaning::Mark(words) => self.marks.mark(at_ns, &words),
                Meaning::Ending => self.timeline.ends(at_ns),
                Meaning::Check(said) => self.story.checks.push(Check {
                    t_ns: at_ns,
                    registration: self.registration_id.map(|id| format!("{id:016x}")),
                    said,
                }),
                Meaning::Line => {}
            },
            IDENTITY => self.identity = Some(Identity::decode(data)?),
            _ => {
                if let Some(view) = topic.strip_prefix(VIEW) {
                    self.marks.picture(at_ns, &short(view), data);
                }
            }
        }
        Ok(())
    }

    fn pose(&mut self, pose: ToolPose) {
        if let Some((what, at_ns)) = impossible_stamp(&pose) {
            self.damage.unreadable += 1;
            let words = format!("pose {}: {what} at {at_ns} ns, which no clock shows", pose.seq);
            return self.damage.words.push(words);
        }
        self.poses.samples += 1;
        // What came before the run's epoch counts as the epoch, as in the file's own times.
        let t_ns = pose.t_capture_ns.max(0);
        let known_ns = [t_ns, pose.t_publish_ns];
        self.spans(t_ns);
        if self.last_seq.replace(pose.seq).and_then(|last| last.checked_add(1)) != Some(pose.seq) {
            self.latency.broken();
        }
        match pose.t_publish_ns - pose.t_capture_ns {
            latency_ns if latency_ns >= 0 => self.latency.add(t_ns, bus::clock::ms(latency_ns)),
            _ => self.latency.unknown(t_ns),
        }
        let Ok(tracked) = pose.tracked() else {
            self.poses.refused += 1;
            let between = self.between(0);
            return self.timeline.sample(known_ns, Some(Lost::Refused), between);
        };
        let judged = self.continuity.judge(&pose, tracked, self.limits.frozen_ns);
        self.poses.missing += judged.missing;
        if judged.broken.is_some_and(|broken| broken.refuses()) {
            self.poses.refused += 1;
            return;
        }
        self.poses.counted_anew += u64::from(judged.broken.is_some());
        let lost = match judged.tracked {
            Tracked::Valid(_) => None,
            Tracked::Lost(reason) => Some(reason),
        };
        let between = self.between(judged.missing);
        self.timeline.sample(known_ns, lost, between);
        match lost {
            Some(reason) => *self.poses.lost.entry(reason.words()).or_default() += 1,
            None => self.valid(t_ns, &pose),
        }
    }

    /// What lies before this sample; behind it there is nothing yet.
    fn between(&mut self, missing: u64) -> Between {
        match std::mem::replace(&mut self.between, Between::Nothing) {
            Between::Nothing if missing > 0 => Between::Missing,
            between => between,
        }
    }

    fn valid(&mut self, t_ns: i64, pose: &ToolPose) {
        self.poses.valid += 1;
        self.poses.outside += u64::from(pose.said_outside());
        self.tip.valid(pose);
        if self.registration_id.replace(pose.registration_id) != Some(pose.registration_id) {
            let id = format!("{:016x}", pose.registration_id);
            self.poses.registrations.push((t_ns, id));
        }
    }

    fn unreadable(&mut self, message: &Message<'_>, words: &str) {
        self.damage.unreadable += 1;
        let (topic, number) = (&message.channel.topic, message.sequence);
        let words = format!("message {number} of {topic}: {words}");
        self.damage.words.push(short(&words));
    }

    fn damaged(&mut self, damage: &Damage) {
        match damage.fault.is_mere_ending() {
            true => self.damage.is_cut_off = true,
            false => self.damage.places += 1,
        }
        // Also behind the end of what can be read: what was there nobody knows.
        self.between = Between::Damage;
        if damage.stops {
            self.damage.stops_at = Some(damage.at);
        }
        for topic in damage.lost.iter().flat_map(|lost| &lost.topics) {
            *self.damage.lost.entry(short(&topic.topic)).or_default() += topic.count;
        }
        self.damage.words.push(short(&damage.to_string()));
    }
}

/// Reads `length` bytes of the recording `path` from `input`.
///
/// # Errors
/// [`ReportError::Schema`], [`ReportError::Newer`].
pub(super) fn gather(path: &Path, input: impl Read, length: u64) -> Result<Gathered, ReportError> {
    let mut progress = Progress::new("reading");
    gather_each(path, input, length, None, &mut |_, (read, length)| {
        progress.at(read, length);
        ControlFlow::Continue(())
    })
}

/// Told what was found so far, and how many bytes of how many were read.
pub(super) type Each<'a> = dyn FnMut(&Gathered, (u64, u64)) -> ControlFlow<()> + 'a;

/// The same, judged by the `given` limits where there are some, else by those of the recording's scene; `each` is called before each
/// item with what was found so far, and how much of how much was read, and may break it off.
///
/// # Errors
/// [`ReportError::Schema`], [`ReportError::Newer`].
pub(super) fn gather_each(
    path: &Path,
    input: impl Read,
    length: u64,
    given: Option<Limits>,
    each: &mut Each<'_>,
) -> Result<Gathered, ReportError> {
    let mut gathered = Gathered::new(given);
    let mut scan = Scan::new(input, length);
    while let Some(item) = scan.next() {
        if each(&gathered, scan.progress()).is_break() {
            break;
        }
        match item {
            Ok(item) => gathered.take(path, item)?,
            Err(damage) => gathered.damaged(&damage),
        }
    }
    gathered.library = scan.library().map(short);
    gathered.basis.hold_report();
    Ok(gathered)
}
