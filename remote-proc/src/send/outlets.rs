//! What goes out by itself: poses as they come, states as they change and twice a second.

use std::time::Duration;

use bus::clock::{self, monotonic_ns};
use bus::message::{Event, Guide, Identity, MarkerFrame, TissueHeader, Wire, Workflow, node_bytes};
use bus::port::{Headed, Subscriber};
use bus::topic::{EVENT, GUIDE, IDENTITY, MARKERS, WORKFLOW};
use bus::{Bus, BusError};
use scene::{Scene, TrackerSource};
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};

use crate::protocol::{Channel, Envelope};
use crate::session::{Opened, SessionError};

/// Between two tellings of what has not changed: who comes late, or lost it on the way, has it then.
const AGAIN: Duration = Duration::from_millis(500);

/// The link's publishers.
pub(super) struct Outlets {
    publishers: Vec<(Channel, Publisher<'static>, u64)>,
    run: u64,
    sender: u64,
    /// What the link took for nobody, with the first reason.
    refused: (u64, Option<String>),
    told: u64,
}

impl Outlets {
    pub(super) fn open(session: &Opened, (run, sender): (u64, u64)) -> Result<Self, SessionError> {
        let publisher = |channel: Channel| {
            let publisher = session
                .declare_publisher(channel.key())
                // Alone in a packet: nobody waits for more to come.
                .express(true)
                // What cannot go out now is old when it could: the next pose is worth more.
                .congestion_control(CongestionControl::Drop)
                .priority(match channel {
                    Channel::Pose => Priority::RealTime,
                    // A pose never waits behind a state, which is some dozen times as long.
                    Channel::Tissue => Priority::InteractiveLow,
                    _ => Priority::InteractiveHigh,
                })
                .wait();
            let publisher = publisher.map_err(|why| SessionError::declaring(channel.key(), &*why))?;
            Ok((channel, publisher, 0))
        };
        Ok(Self {
            publishers: Channel::ALL
                .into_iter()
                .map(publisher)
                .collect::<Result<_, SessionError>>()?,
            run,
            sender,
            refused: (0, None),
            told: 0,
        })
    }

    /// Sends a message to everybody. What the link refuses is counted: nobody's navigation depends on it.
    pub(super) fn put(&mut self, channel: Channel, body: &[u8]) {
        let (run, sender) = (self.run, self.sender);
        let Some((_, publisher, count)) = self.publishers.iter_mut().find(|(of, ..)| *of == channel) else {
            return;
        };
        let envelope = Envelope {
            run,
            sender,
            count: *count,
        };
        *count += 1;
        if let Err(why) = publisher.put(envelope.around(body)).wait() {
            self.refused.0 += 1;
            self.refused.1.get_or_insert_with(|| why.to_string());
        }
    }

    /// Sends a state of tissue, with its nodes.
    pub(super) fn put_state(&mut self, state: &Headed<TissueHeader, f32>) {
        let body = [state.header().wire_bytes(), node_bytes(state.values())].concat();
        self.put(Channel::Tissue, &body);
    }

    /// Says on stderr what the link refused since the last call.
    pub(super) fn tell_refused(&mut self) {
        if let (count, Some(why)) = &self.refused
            && *count > self.told
        {
            bus::stderr_line!("remote-proc: error: {count} messages did not go out; the first: {why}");
            self.told = *count;
        }
    }
}

/// A topic whose newest message says all.
struct State<T: Wire + bus::port::Message> {
    channel: Channel,
    subscriber: Subscriber<T>,
    newest: Option<T>,
}

impl<T: Wire + bus::port::Message> State<T> {
    fn step(&mut self, outlets: &mut Outlets, again: bool) -> Result<(), BusError> {
        let mut is_new = false;
        while let Some(message) = self.subscriber.next()? {
            outlets.put(self.channel, message.wire_bytes());
            (self.newest, is_new) = (Some(message), true);
        }
        if let Some(newest) = self.newest.filter(|_| again && !is_new) {
            outlets.put(self.channel, newest.wire_bytes());
        }
        Ok(())
    }
}

/// All but poses and tissue, which wake.
pub(super) struct States {
    guide: State<Guide>,
    workflow: State<Workflow>,
    identity: State<Identity>,
    markers: Option<Subscriber<MarkerFrame>>,
    events: Vec<Subscriber<Event>>,
    next_again_ns: i64,
}

impl States {
    pub(super) fn open(bus: &Bus, scene: &Scene) -> Result<Self, BusError> {
        let are_markers = matches!(scene.tracker.source, TrackerSource::Markers(_));
        let localizer = scene.localizer.is_some().then_some("localizer");
        let events = ["pilot"].into_iter().chain(localizer);
        Ok(Self {
            guide: State {
                channel: Channel::Guide,
                subscriber: Subscriber::open(bus, &GUIDE, "", GUIDE.buffer)?,
                newest: None,
            },
            workflow: State {
                channel: Channel::Workflow,
                subscriber: Subscriber::open(bus, &WORKFLOW, "", WORKFLOW.buffer)?,
                newest: None,
            },
            identity: State {
                channel: Channel::Identity,
                subscriber: Subscriber::open(bus, &IDENTITY, "", 1)?,
                newest: None,
            },
            markers: are_markers
                .then(|| Subscriber::open(bus, &MARKERS, "", MARKERS.buffer))
                .transpose()?,
            events: events
                .map(|name| Subscriber::open(bus, &EVENT, name, EVENT.buffer))
                .collect::<Result<_, _>>()?,
            next_again_ns: 0,
        })
    }

    pub(super) fn step(&mut self, outlets: &mut Outlets) -> Result<(), BusError> {
        let now = monotonic_ns();
        let again = now >= self.next_again_ns;
        if again {
            self.next_again_ns = now + clock::ns(AGAIN);
        }
        self.guide.step(outlets, again)?;
        self.workflow.step(outlets, again)?;
        self.identity.step(outlets, again)?;
        if let Some(markers) = &self.markers {
            while let Some(frame) = markers.next()? {
                outlets.put(Channel::Markers, frame.wire_bytes());
            }
        }
        for events in &self.events {
            while let Some(event) = events.next()? {
                outlets.put(Channel::Event, event.wire_bytes());
            }
        }
        Ok(())
    }
}
