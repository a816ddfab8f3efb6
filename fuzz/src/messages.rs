//! Messages of the bus, and the facts of a run in its folder.

use std::mem::size_of;

use bus::continuity::Continuity;
use bus::message::{
    Ages, ClockLaw, Command, EmitterFrame, Event, FrameHeader, Guide, Heartbeat, Identity, MarkerFrame, Plan,
    ReplyHeader, Steps, Timeline, ToolPose, VolumeHeader, Workflow,
};
use bus::run::RunContext;

use crate::{Failure, Folder};

/// A message that is nothing but numbers, for which any bits are a value.
trait Numbers: Copy + 'static {}

impl Numbers for ClockLaw {}
impl Numbers for Command {}
impl Numbers for EmitterFrame {}
impl Numbers for Event {}
impl Numbers for FrameHeader {}
impl Numbers for Guide {}
impl Numbers for Heartbeat {}
impl Numbers for Identity {}
impl Numbers for MarkerFrame {}
impl Numbers for Plan {}
impl Numbers for ReplyHeader {}
impl Numbers for Steps {}
impl Numbers for Timeline {}
impl Numbers for ToolPose {}
impl Numbers for VolumeHeader {}
impl Numbers for Workflow {}

/// The message that lies at the start of `bytes`.
#[allow(unsafe_code, reason = "what shared memory does: bytes of anybody become a message")]
fn taken<T: Numbers>(bytes: &[u8]) -> Option<T> {
    let held = bytes.get(..size_of::<T>())?;
    // SAFETY: `held` has as many bytes as a `T`, read at any alignment; every pattern of bits is a `T`, whose fields are numbers.
    Some(unsafe { held.as_ptr().cast::<T>().read_unaligned() })
}

fn bytes_of<T: Numbers>(message: &T) -> Vec<u8> {
    let at = std::ptr::from_ref(message).cast::<u8>();
    // SAFETY: as many bytes as a `T` has; the messages have no padding, by their asserted sizes.
    #[allow(unsafe_code, reason = "a message as it lies in shared memory")]
    unsafe { std::slice::from_raw_parts(at, size_of::<T>()) }.to_vec()
}

/// The first byte says of which kind; what follows is one message, for poses as many as there are.
pub(crate) fn message(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    match kind % 13 {
        0 => poses(bytes),
        1 => drop(taken::<ClockLaw>(bytes).map(|m| (m.law().map(|law| law.at(i64::MAX)).ok(), m.replay_state()))),
        2 => drop(taken::<Command>(bytes).map(|m| m.command_kind())),
        3 => drop(taken::<EmitterFrame>(bytes).map(|m| {
            let _ = (m.tool().map(<[_]>::len), m.reference().map(<[_]>::len));
            recorder::wire::proto::EmitterFrame::try_from(&m).is_ok()
        })),
        4 => drop(taken::<Event>(bytes).map(|m| (m.level(), m.words()))),
        5 => drop(taken::<FrameHeader>(bytes).map(|m| {
            let ages = Ages {
                stale_ns: 100,
                lost_ns: 1000,
            };
            let states = [i64::MIN, 0, i64::MAX].map(|now| m.stamp.state_at(now, ages));
            (states, m.stamp.texts(), m.slice_plane().is_ok())
        })),
        6 => drop(taken::<Heartbeat>(bytes).map(|m| (m.process_state(), m.note_text()))),
        7 => drop(taken::<ReplyHeader>(bytes).map(|m| format!("{m:?}"))),
        8 => drop(taken::<Plan>(bytes).map(|m| m.plan().map_err(|error| error.to_string()).is_ok())),
        9 => drop(taken::<Steps>(bytes).map(|m| {
            let names: Vec<String> = m.points().iter().map(bus::message::StepPoint::name).collect();
            let gates: Vec<String> = m.gates().iter().map(bus::message::StepGate::name).collect();
            (
                m.task(),
                m.phase(),
                names,
                gates,
                m.figures().len(),
                Steps::text(&m.title),
            )
        })),
        10 => drop(taken::<Timeline>(bytes).map(|m| {
            let columns = m.columns().filter(|(span, _)| span[0] <= span[1]).count();
            let marks: Vec<String> = m.marks().iter().map(bus::message::TimelineMark::words).collect();
            (columns, marks, m.is_read(), m.why())
        })),
        11 => drop(taken::<MarkerFrame>(bytes).map(|m| {
            let of = |marker| {
                m.sight::<geometry::Marker>(marker)
                    .map_err(|error| error.to_string())
                    .is_ok()
            };
            let door = [MarkerFrame::TOOL, MarkerFrame::REFERENCE, 2].map(of);
            let again =
                recorder::wire::proto::MarkerFrame::try_from(&m).map(|frame| MarkerFrame::try_from(&frame).is_ok());
            (door, again.ok(), m.device_name(), m.capture_clock())
        })),
        _ => drop(taken::<VolumeHeader>(bytes).map(|m| {
            let _ = (m.grid().map(|g| g.voxels()), m.layout().is_ok());
            (m.marks(), m.volume_hash().to_string())
        })),
    }
}

/// Poses one after the other, as a view and the recorder take them.
fn poses(bytes: &[u8]) {
    let mut continuity = Continuity::default();
    for bytes in bytes.chunks_exact(size_of::<ToolPose>()) {
        let Some(pose) = taken::<ToolPose>(bytes) else { return };
        let _ = recorder::wire::proto::frame_transform_in_metres(&pose, "tool");
        match pose.tracked_at(1_000_000_000) {
            Ok(tracked) => drop(continuity.judge(&pose, tracked, Some(500_000_000))),
            Err(error) => drop(error.to_string()),
        }
        let _ = (pose.tip_95_mm(), pose.said_outside());
    }
}

pub(crate) fn seeds() -> Result<Vec<Vec<u8>>, Failure> {
    let pose = |seq: u64| ToolPose {
        seq,
        t_capture_ns: 16_666_667 * seq as i64,
        q: [1.0, 0.0, 0.0, 0.0],
        status: 0,
        ..ToolPose::EMPTY
    };
    let three: Vec<u8> = (0..3).flat_map(|seq| bytes_of(&pose(seq))).collect();
    let one = |kind: u8, bytes: Vec<u8>| [vec![kind], bytes].concat();
    let zeros = |kind: u8, size: usize| one(kind, vec![0; size]);
    Ok(vec![
        one(0, three),
        one(
            1,
            bytes_of(&ClockLaw {
                rate: 1.0,
                ..ClockLaw::default()
            }),
        ),
        one(2, bytes_of(&Command::render(pose(7)))),
        one(3, bytes_of(&EmitterFrame::EMPTY)),
        one(11, bytes_of(&MarkerFrame::EMPTY)),
        zeros(4, size_of::<Event>()),
        zeros(5, size_of::<FrameHeader>()),
        zeros(6, size_of::<Heartbeat>()),
        zeros(7, size_of::<ReplyHeader>()),
        zeros(8, size_of::<Plan>()),
        one(9, bytes_of(&Steps::none(&[]))),
        one(10, bytes_of(&Timeline::default())),
        zeros(12, size_of::<VolumeHeader>()),
    ])
}

/// The facts of a run, in a folder as a pilot makes it.
pub(crate) fn run(bytes: &[u8]) {
    let Ok(folder) = Folder::new() else { return };
    folder.file("run.json", bytes);
    match RunContext::load(folder.path()) {
        Ok(run) => drop(run.scene_path()),
        Err(error) => drop(error.to_string()),
    }
}

pub(crate) fn runs() -> Result<Vec<Vec<u8>>, Failure> {
    let folder = Folder::new()?;
    RunContext::new(folder.path(), 12345)?.store()?;
    Ok(vec![std::fs::read(folder.path().join("run.json"))?])
}
