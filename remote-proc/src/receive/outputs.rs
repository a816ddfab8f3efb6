//! The messages on this machine's bus, bit for bit as the sender had them on its own.

use bus::message::{Counters, Event, Guide, Identity, MarkerFrame, ToolPose, Wire, Workflow};
use bus::port::{Message, Publisher};
use bus::topic::{EVENT, GUIDE, IDENTITY, MARKERS, TOOL_POSE, WORKFLOW};
use bus::{Bus, BusError};

use super::organs::Organs;
use crate::protocol::{Channel, Envelope};

/// A state that is told again and again, and published where it is another.
struct State<T: Message> {
    publisher: Publisher<T>,
    last: Option<Vec<u8>>,
}

impl<T: Message + Wire> State<T> {
    fn of(publisher: Publisher<T>) -> Self {
        Self { publisher, last: None }
    }

    fn send(&mut self, body: &[u8]) -> Result<Option<String>, BusError> {
        if self.last.as_deref() == Some(body) {
            return Ok(None);
        }
        let sent = send(&self.publisher, body)?;
        self.last = Some(body.to_vec());
        Ok(sent)
    }
}

/// Publishes what `body` is; why it is nothing, in words.
fn send<T: Message + Wire>(publisher: &Publisher<T>, body: &[u8]) -> Result<Option<String>, BusError> {
    match T::from_wire(body) {
        Ok(message) => publisher.send(message).map(|()| None),
        Err(error) => Ok(Some(error.to_string())),
    }
}

/// The ends of the topics.
pub(super) struct Outputs {
    poses: Publisher<ToolPose>,
    markers: Publisher<MarkerFrame>,
    events: Publisher<Event>,
    guide: State<Guide>,
    workflow: State<Workflow>,
    identity: State<Identity>,
    pub(super) organs: Organs,
    /// Sender and number of the newest message of each channel.
    newest: [Option<(u64, u64)>; Channel::ALL.len()],
    lost: Lost,
    rate: Rate,
}

/// Messages that did not come, by the gaps in their numbers.
#[derive(Debug, Default)]
struct Lost {
    poses: u64,
    states: u64,
    others: u64,
}

impl Lost {
    fn add(&mut self, channel: Channel, missing: u64) {
        let count = match channel {
            Channel::Pose => &mut self.poses,
            Channel::Tissue => &mut self.states,
            _ => &mut self.others,
        };
        *count = count.saturating_add(missing);
    }

    /// In words, which are few as a note has 96 bytes; `None` where nothing was lost.
    fn words(&self) -> Option<String> {
        let each = [(self.poses, "poses"), (self.states, "states"), (self.others, "others")];
        let each = each.into_iter().filter(|(count, _)| *count > 0);
        let words: Vec<String> = each.map(|(count, what)| format!("{count} {what}")).collect();
        (!words.is_empty()).then(|| format!("{} lost on the way", words.join(", ")))
    }
}

/// Poses a second, over the last whole second.
#[derive(Debug, Default)]
struct Rate {
    count: u64,
    began_ns: i64,
    hz: Option<f64>,
}

impl Rate {
    fn step(&mut self, now: i64) {
        let passed_s = bus::clock::ms(now.saturating_sub(self.began_ns)) / 1e3;
        if passed_s >= 1.0 {
            self.hz = (self.began_ns != 0).then(|| self.count as f64 / passed_s);
            (self.count, self.began_ns) = (0, now);
        }
    }
}

impl Outputs {
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            poses: Publisher::open(bus, &TOOL_POSE, "")?,
            markers: Publisher::open(bus, &MARKERS, "")?,
            events: Publisher::open(bus, &EVENT, super::NAME)?,
            guide: State::of(Publisher::open(bus, &GUIDE, "")?),
            workflow: State::of(Publisher::open(bus, &WORKFLOW, "")?),
            identity: State::of(Publisher::open(bus, &IDENTITY, "")?),
            organs: Organs::default(),
            newest: [None; Channel::ALL.len()],
            lost: Lost::default(),
            rate: Rate::default(),
        })
    }

    /// Publishes a message; counts those before it that did not come. Why it is not published, in words.
    pub(super) fn send(
        &mut self,
        channel: Channel,
        envelope: Envelope,
        body: &[u8],
        counters: &mut Counters,
    ) -> Result<Option<String>, BusError> {
        let newest = &mut self.newest[channel as usize];
        match *newest {
            Some((sender, count)) if sender == envelope.sender => {
                // Two sessions may bring one message, where a line came back beside a new one.
                if envelope.count <= count {
                    return Ok(None);
                }
                // A state that is told again and again is not lost where the next telling comes.
                if matches!(
                    channel,
                    Channel::Pose | Channel::Markers | Channel::Event | Channel::Tissue
                ) {
                    let missing = envelope.count.saturating_sub(count).saturating_sub(1);
                    counters.dropped = counters.dropped.saturating_add(missing);
                    self.lost.add(channel, missing);
                }
            }
            _ => {}
        }
        *newest = Some((envelope.sender, envelope.count));
        match channel {
            Channel::Pose => {
                counters.published += 1;
                self.rate.count += 1;
                send(&self.poses, body)
            }
            Channel::Markers => send(&self.markers, body),
            Channel::Event => send(&self.events, body),
            Channel::Guide => self.guide.send(body),
            Channel::Workflow => self.workflow.send(body),
            Channel::Identity => self.identity.send(body),
            Channel::Tissue => self.organs.state(body),
        }
    }

    pub(super) fn serve_late_joiners(&self) {
        self.poses.serve_late_joiners();
        self.guide.publisher.serve_late_joiners();
        self.workflow.publisher.serve_late_joiners();
        self.identity.publisher.serve_late_joiners();
        self.events.serve_late_joiners();
        self.organs.serve_late_joiners();
    }

    /// Counts the poses of each second.
    pub(super) fn step(&mut self, now: i64) {
        self.rate.step(now);
    }

    /// What did not come, in words.
    pub(super) fn lost(&self) -> Option<String> {
        self.lost.words()
    }

    /// How many poses come, in words.
    pub(super) fn words(&self) -> Option<String> {
        Some(format!("{:.0} poses a second", self.rate.hz?))
    }
}
