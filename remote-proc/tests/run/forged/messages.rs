//! A message of each channel that a receiver would show, and who listens for it on a bus.

use bus::Bus;
use bus::message::{Event, Guide, Identity, Level, MarkerFrame, TissueHeader, ToolPose, Tracked, Wire, Workflow};
use bus::port::{HeadedSubscriber, Message, Subscriber};
use bus::topic::{EVENT, GUIDE, IDENTITY, MARKERS, TISSUE, TOOL_POSE, Topic, WORKFLOW};
use geometry::Rigid;
use remote_proc::protocol::Channel;

/// In every forged message, and in none of the room's.
const MARK: u64 = 0x00f0_f0f0;

/// Everything that came on a topic since the last call, as bytes.
pub(super) type Drain = Box<dyn Fn() -> Vec<Vec<u8>>>;

fn stream<T: Message + Wire>(bus: &Bus, topic: &'static Topic, part: &str) -> Drain {
    let subscriber = Subscriber::<T>::open(bus, topic, part, topic.buffer).unwrap();
    Box::new(move || {
        std::iter::from_fn(|| subscriber.next().unwrap())
            .map(|one| one.wire_bytes().to_vec())
            .collect()
    })
}

fn states(bus: &Bus) -> Drain {
    let subscriber = HeadedSubscriber::<TissueHeader, f32>::open(bus, &TISSUE, TISSUE.buffer).unwrap();
    let header = |state: bus::port::Headed<TissueHeader, f32>| state.header().wire_bytes().to_vec();
    Box::new(move || std::iter::from_fn(|| subscriber.next().unwrap()).map(header).collect())
}

/// Listens to a channel's topics on a bus.
pub(super) fn ears(bus: &Bus, channel: Channel) -> Vec<Drain> {
    match channel {
        Channel::Pose => vec![stream::<ToolPose>(bus, &TOOL_POSE, "")],
        Channel::Guide => vec![stream::<Guide>(bus, &GUIDE, "")],
        Channel::Workflow => vec![stream::<Workflow>(bus, &WORKFLOW, "")],
        Channel::Identity => vec![stream::<Identity>(bus, &IDENTITY, "")],
        Channel::Markers => vec![stream::<MarkerFrame>(bus, &MARKERS, "")],
        Channel::Event => ["pilot", "localizer", "remote"]
            .map(|part| stream::<Event>(bus, &EVENT, part))
            .into(),
        Channel::Tissue => vec![states(bus)],
    }
}

/// A message of the channel that a receiver would publish, or act on.
pub(super) fn forged(channel: Channel) -> Vec<u8> {
    let zeros = |bytes: usize| vec![0; bytes];
    match channel {
        Channel::Pose => {
            let mut pose = ToolPose {
                seq: MARK,
                ..ToolPose::EMPTY
            };
            pose.set(Tracked::Valid(Rigid::identity()));
            pose.wire_bytes().to_vec()
        }
        Channel::Guide => {
            let plan_id = MARK;
            let guide = Guide {
                plan_id,
                ..Guide::default()
            };
            guide.wire_bytes().to_vec()
        }
        Channel::Workflow => {
            let mut workflow = Workflow::from_wire(&zeros(size_of::<Workflow>())).unwrap();
            workflow.stage = 3;
            workflow.wire_bytes().to_vec()
        }
        Channel::Identity => {
            let mut identity = Identity::from_wire(&zeros(size_of::<Identity>())).unwrap();
            identity.volume_hash = [0xf0; 32];
            identity.wire_bytes().to_vec()
        }
        Channel::Markers => {
            let mut frame = MarkerFrame::EMPTY;
            frame.seq = MARK;
            frame.wire_bytes().to_vec()
        }
        Channel::Event => Event::new(MARK, 1, Level::Info, "forged").wire_bytes().to_vec(),
        Channel::Tissue => {
            let header = TissueHeader {
                seq: MARK,
                mesh_id: [0xf0; 32],
                ..TissueHeader::default()
            };
            header.wire_bytes().to_vec()
        }
    }
}
