//! A message's content, held against its header and against the messages before it.

use std::collections::BTreeMap;

use bus::message::{EmitterFrame, Guide, MarkerFrame, ToolPose};
use mcap::Message;
use prost_types::Timestamp;

use crate::read::reader::{self, Recorded};
use crate::wire::proto::{
    CompressedImage, FrameTransform, Identity, Log, MeshFrame, ProcessStatus, TissueFrame, UsFrame, Workflow,
    file_time, frame_transform_in_metres,
};
use crate::wire::schema::{
    EMITTER_SCHEMA, GUIDE_SCHEMA, IDENTITY_SCHEMA, IMAGE_SCHEMA, LOG_SCHEMA, MARKER_SCHEMA, POSE_SCHEMA,
    RAW_IMAGE_SCHEMA, STATUS_SCHEMA, Source, TF_SCHEMA, TISSUE_MESH_SCHEMA, TISSUE_SCHEMA, US_IMAGE, VIEW,
    WORKFLOW_SCHEMA,
};

/// No run lasts as long: 100 days, ns. A stamp beyond it is not one of its clock.
const LONGEST_NS: u64 = 100 * 86_400 * 1_000_000_000;

/// What a message itself says of its number and its times, which its header repeats.
#[derive(Debug, Clone, Copy, Default)]
struct Stated {
    /// Of those that are numbered.
    seq: Option<u64>,
    /// The header's `log_time`, ns; `None` where the content does not say it.
    log_ns: Option<u64>,
    /// The header's `publish_time`, ns; the same.
    publish_ns: Option<u64>,
    /// What comes in the order of these, ns.
    in_order_ns: Option<u64>,
}

/// The messages that the next ones are held against.
#[derive(Debug, Default)]
pub(super) struct Content {
    /// Number and place in time of the last message of each channel.
    last: BTreeMap<u16, (Option<u64>, u64)>,
    /// The last pose of the tool and of the truth, as Foxglove is told them.
    poses: BTreeMap<&'static str, (u64, Option<FrameTransform>)>,
}

impl Content {
    /// What is wrong with a message, each in words that go on behind `message 4 of /topic`. Those of other schemas than the
    /// recorder's are not looked into; `is_ours`: Trocar's recorder wrote the file, and gives the messages of other schemas its stamps.
    pub(super) fn hold(&mut self, message: &Message<'_>, is_ours: bool) -> Vec<String> {
        let stated = match self.stated(message, is_ours) {
            Ok(Some(stated)) => stated,
            Ok(None) => return Vec::new(),
            Err(words) => return vec![format!(": {words}")],
        };
        let number = stated.seq.map_or(String::new(), |seq| format!(" (number {seq})"));
        let wrong = header(message, &stated).into_iter().chain(self.order(message, &stated));
        wrong.map(|words| format!("{number}: {words}")).collect()
    }

    fn stated(&mut self, message: &Message<'_>, is_ours: bool) -> Result<Option<Stated>, String> {
        let topic = message.channel.topic.as_str();
        let stated = match message.channel.schema.as_ref().map_or("", |schema| &schema.name) {
            POSE_SCHEMA => self.pose(message)?,
            EMITTER_SCHEMA => of::<EmitterFrame>(message, |it| (it.seq, it.t_capture_ns, it.t_publish_ns))?,
            MARKER_SCHEMA => of::<MarkerFrame>(message, |it| (it.seq, it.t_capture_ns, it.t_publish_ns))?,
            TISSUE_SCHEMA => of::<TissueFrame>(message, |it| {
                (it.header.seq, it.header.t_capture_ns, it.header.t_publish_ns)
            })?,
            // Images and lines of a log of other programs have Foxglove's schemas too.
            RAW_IMAGE_SCHEMA if topic == US_IMAGE => of::<UsFrame>(message, |it| {
                (it.header.seq, it.header.t_capture_ns, it.header.t_publish_ns)
            })?,
            // Written down by another clock where time is simulated, and again at the start of a stretch.
            TISSUE_MESH_SCHEMA => decoded::<MeshFrame>(message).map(|_| Stated::default())?,
            GUIDE_SCHEMA => chosen(decoded::<Guide>(message)?.t_ns),
            WORKFLOW_SCHEMA => chosen(of_protobuf::<Workflow>(message)?.t_ns),
            STATUS_SCHEMA => at(of_protobuf::<ProcessStatus>(message)?.t_ns),
            IDENTITY_SCHEMA => at(of_protobuf::<Identity>(message)?.t_ns),
            LOG_SCHEMA if is_ours => stamped(of_protobuf::<Log>(message)?.timestamp),
            IMAGE_SCHEMA if is_ours && topic.starts_with(VIEW) => image(message)?,
            TF_SCHEMA if is_ours => self.transform(message)?,
            _ => return Ok(None),
        };
        Ok(Some(stated))
    }

    fn pose(&mut self, message: &Message<'_>) -> Result<Stated, String> {
        let pose = decoded::<ToolPose>(message)?;
        for source in [Source::Tool, Source::Truth] {
            if source.topic() == message.channel.topic {
                let transform = frame_transform_in_metres(&pose, source.frame());
                self.poses.insert(source.frame(), (pose.seq, transform));
            }
        }
        Ok(numbered(pose.seq, pose.t_capture_ns, pose.t_publish_ns))
    }

    /// Holds what Foxglove is told of a pose against the pose, which comes before it.
    fn transform(&self, message: &Message<'_>) -> Result<Stated, String> {
        let transform = of_protobuf::<FrameTransform>(message)?;
        let stated = stamped(transform.timestamp);
        match self.poses.get(transform.child_frame_id.as_str()) {
            // A pose whose chunk is damaged is told of as such.
            Some((seq, pose)) if message.sequence == *seq as u32 && pose.as_ref() != Some(&transform) => {
                Err(format!("it is not pose {seq} of {}", transform.child_frame_id))
            }
            _ => Ok(stated),
        }
    }

    /// Holds a message against the one before it of its channel.
    fn order(&mut self, message: &Message<'_>, stated: &Stated) -> Option<String> {
        let t_ns = stated.in_order_ns?;
        let (last_seq, last_ns) = self.last.insert(message.channel.id, (stated.seq, t_ns))?;
        match (stated.seq, last_seq) {
            (Some(seq), Some(last)) if seq == last => Some("the number of the one before it".to_owned()),
            // A publisher that was restarted counts anew, and goes on in time.
            (_, Some(last)) if t_ns < last_ns => {
                Some(format!("captured at {t_ns} ns, before number {last} at {last_ns} ns"))
            }
            _ if t_ns < last_ns => Some(format!("it is of {t_ns} ns, and the one before it of {last_ns} ns")),
            _ => None,
        }
    }
}

/// Holds a message's header against its content.
fn header(message: &Message<'_>, stated: &Stated) -> Option<String> {
    let (sequence, log_time, publish_time) = (message.sequence, message.log_time, message.publish_time);
    let is = |stated: Option<u64>, found: u64| stated.is_none_or(|stated| stated == found);
    let is_number = stated.seq.is_none_or(|seq| seq as u32 == sequence);
    if !is_number || !is(stated.log_ns, log_time) || !is(stated.publish_ns, publish_time) {
        let times =
            [stated.log_ns, stated.publish_ns].map(|ns| ns.map_or("any time".to_owned(), |ns| format!("{ns} ns")));
        return Some(format!(
            "its header says number {sequence}, {log_time} ns and published at {publish_time} ns instead of {} and {}",
            times[0], times[1]
        ));
    }
    let latest = stated.log_ns.or(stated.publish_ns).unwrap_or_default();
    (latest > LONGEST_NS).then(|| format!("its stamp of {latest} ns is more than 100 days behind the run's start"))
}

fn numbered(seq: u64, t_capture_ns: i64, t_publish_ns: i64) -> Stated {
    Stated {
        seq: Some(seq),
        log_ns: Some(file_time(t_capture_ns)),
        publish_ns: Some(file_time(t_publish_ns)),
        in_order_ns: Some(file_time(t_capture_ns)),
    }
}

fn at(t_ns: i64) -> Stated {
    Stated {
        log_ns: Some(file_time(t_ns)),
        publish_ns: Some(file_time(t_ns)),
        ..Stated::default()
    }
}

/// What holds from its moment on is written down when the file begins too, long after it.
fn chosen(t_ns: i64) -> Stated {
    Stated {
        publish_ns: Some(file_time(t_ns)),
        in_order_ns: Some(file_time(t_ns)),
        ..Stated::default()
    }
}

/// A message with a stamp of Foxglove's, whose header has the same as the time of its capture.
fn stamped(stamp: Option<Timestamp>) -> Stated {
    let stamp = stamp.unwrap_or_default();
    // Not a stamp of the recorder's: no header can have it.
    let seconds = u64::try_from(stamp.seconds).unwrap_or(u64::MAX);
    let nanos = u64::try_from(stamp.nanos).unwrap_or(u64::MAX);
    let ns = seconds.saturating_mul(1_000_000_000).saturating_add(nanos);
    Stated {
        log_ns: Some(ns),
        ..Stated::default()
    }
}

fn image(message: &Message<'_>) -> Result<Stated, String> {
    const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
    let image = of_protobuf::<CompressedImage>(message)?;
    match image.format == "png" && image.data.starts_with(PNG) {
        true => Ok(stamped(image.timestamp)),
        false => Err("it is no PNG image".to_owned()),
    }
}

fn of<T: Recorded>(message: &Message<'_>, stamps: impl Fn(&T) -> (u64, i64, i64)) -> Result<Stated, String> {
    let (seq, t_capture_ns, t_publish_ns) = stamps(&decoded(message)?);
    Ok(numbered(seq, t_capture_ns, t_publish_ns))
}

fn decoded<T: Recorded>(message: &Message<'_>) -> Result<T, String> {
    reader::decode(message).map_err(|error| error.to_string())
}

fn of_protobuf<T: prost::Message + Default>(message: &Message<'_>) -> Result<T, String> {
    T::decode(&*message.data).map_err(|error| error.to_string())
}
