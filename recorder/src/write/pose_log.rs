//! The content of one recording: messages into chunks, with the scene and the run's facts beside them.
//!
//! Compression runs on this thread; a pool of threads per recorder would cost more than it saves. What zstd, lz4 and none
//! cost and save is measured by `cargo bench -p recorder --bench recording`.
//!
//! A chunk is put together in memory and then appended in one go, never written back to: a killed recorder leaves whole
//! chunks and at most one that is cut off.

use std::borrow::Cow;
use std::io::{Seek, Write};

use bus::message::ToolPose;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapResult, WriteOptions, Writer};
use scene::Compression;

use crate::wire::proto::{self, file_time, frame_transform_in_metres};
use crate::wire::schema::{
    self, EMITTER_CHANNEL, GUIDE_CHANNEL, IDENTITY_CHANNEL, LIBRARY, LOG_CHANNEL, MARKER_CHANNEL, RunFacts, SCENE,
    STATUS_CHANNEL, Source, TF_CHANNEL, TISSUE_CHANNEL, TISSUE_MESH_CHANNEL, US_IMAGE_CHANNEL, VIEW_CHANNEL,
    WORKFLOW_CHANNEL,
};

/// A recording that grows.
pub struct PoseLog<W: Write + Seek> {
    mcap: Writer<W>,
    unwritten: Unwritten,
    written: u64,
    /// Whether anything came since the last flush, also what is not counted.
    dirty: bool,
    buffer: Vec<u8>,
}

/// Something to record.
#[derive(Debug, Clone, Copy)]
pub enum Entry<'a> {
    /// A pose.
    Pose(Source, &'a ToolPose),
    /// What the localizer saw.
    Emitters(&'a proto::EmitterFrame),
    /// The markers that it followed.
    Markers(&'a proto::MarkerFrame),
    /// What an ultrasound probe saw.
    UsImage(&'a proto::RawImage),
    /// Where organs are.
    Tissue(&'a proto::TissueState),
    /// The organs, at rest.
    TissueMesh(&'a proto::TissueMesh),
    /// The state of a process.
    Status(&'a proto::ProcessStatus),
    /// Whose examination it is; only after [`PoseLog::with_identity`].
    Identity(&'a proto::Identity),
    /// What a person chose, and when that is written down, ns: it may have been chosen before this file.
    Guide(i64, &'a proto::Guide),
    /// How far the run has come.
    Workflow(&'a proto::Workflow),
    /// A line of the log, and when, ns.
    Log(i64, &'a proto::Log),
    /// A small image.
    Image {
        /// Which view, by its place in the scene.
        view: u16,
        /// The pose that it shows.
        seq: u64,
        /// When it was handed over, ns.
        t_ns: i64,
        /// The image.
        image: &'a proto::CompressedImage,
    },
}

impl Entry<'_> {
    /// The sequence number of what must not be lost: poses, what was delivered to them, and what was made of them.
    pub fn counted(&self) -> Option<u64> {
        match self {
            Self::Pose(_, pose) => Some(pose.seq),
            Self::Emitters(frame) => Some(frame.seq),
            Self::Markers(frame) => Some(frame.seq),
            Self::UsImage(image) => Some(image.seq),
            Self::Tissue(state) => Some(state.seq),
            _ => None,
        }
    }

    /// Gives each message that it is, with its place and its bytes; `buffer` is of no meaning before and after.
    ///
    /// # Errors
    /// The first of `give`.
    pub(crate) fn encoded<E>(
        &self,
        buffer: &mut Vec<u8>,
        mut give: impl FnMut(Place, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut one = |channel, seq, times, message: &dyn Message| {
            buffer.clear();
            message.put(buffer);
            give(Place { channel, seq, times }, buffer)
        };
        match *self {
            Entry::Pose(source, pose) => {
                let times = [pose.t_capture_ns, pose.t_publish_ns];
                one(source.channel(), pose.seq, times, &proto::ToolPose::from(pose))?;
                match frame_transform_in_metres(pose, source.frame()) {
                    Some(transform) => one(TF_CHANNEL, pose.seq, times, &transform),
                    None => Ok(()),
                }
            }
            Entry::Emitters(frame) => one(
                EMITTER_CHANNEL,
                frame.seq,
                [frame.t_capture_ns, frame.t_publish_ns],
                frame,
            ),
            Entry::Markers(frame) => one(
                MARKER_CHANNEL,
                frame.seq,
                [frame.t_capture_ns, frame.t_publish_ns],
                frame,
            ),
            Entry::UsImage(image) => one(
                US_IMAGE_CHANNEL,
                image.seq,
                [image.t_capture_ns, image.t_publish_ns],
                image,
            ),
            Entry::Tissue(state) => one(
                TISSUE_CHANNEL,
                state.seq,
                [state.t_capture_ns, state.t_publish_ns],
                state,
            ),
            Entry::TissueMesh(mesh) => one(TISSUE_MESH_CHANNEL, 0, [mesh.t_ns; 2], mesh),
            Entry::Status(status) => one(STATUS_CHANNEL, 0, [status.t_ns; 2], status),
            Entry::Identity(identity) => one(IDENTITY_CHANNEL, 0, [identity.t_ns; 2], identity),
            Entry::Guide(now_ns, guide) => one(GUIDE_CHANNEL, 0, [now_ns, guide.t_ns], guide),
            Entry::Workflow(workflow) => one(WORKFLOW_CHANNEL, 0, [workflow.t_ns; 2], workflow),
            Entry::Log(t_ns, log) => one(LOG_CHANNEL, 0, [t_ns; 2], log),
            Entry::Image { view, seq, t_ns, image } => one(VIEW_CHANNEL + view, seq, [t_ns; 2], image),
        }
    }
}

/// Where a message belongs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub channel: u16,
    pub seq: u64,
    /// Of the capture and of the publication, ns on the run's clock.
    pub times: [i64; 2],
}

/// Any message of protobuf.
trait Message {
    fn put(&self, buffer: &mut Vec<u8>);
}

impl<M: prost::Message> Message for M {
    fn put(&self, buffer: &mut Vec<u8>) {
        // Cannot fail: the buffer grows.
        let _ = self.encode(buffer);
    }
}

/// Who takes what is to be recorded, or shown elsewhere.
pub(crate) trait Take {
    /// Takes a message; what does not take it counts it.
    fn put(&mut self, now_ns: i64, entry: Entry<'_>);

    /// Takes what a person chose.
    fn guide(&mut self, now_ns: i64, guide: &proto::Guide) {
        self.put(now_ns, Entry::Guide(now_ns, guide));
    }

    /// Takes how far the run has come.
    fn workflow(&mut self, now_ns: i64, workflow: &proto::Workflow) {
        self.put(now_ns, Entry::Workflow(workflow));
    }
}

/// Poses and frames of the localizer that were taken but are not in a closed chunk yet.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Unwritten {
    /// How many, of all topics.
    pub messages: u64,
    /// The sequence numbers of the first and the last.
    pub seqs: (u64, u64),
}

impl Unwritten {
    fn add(&mut self, seq: u64) {
        let first = if self.messages == 0 { seq } else { self.seqs.0 };
        self.seqs = (first, seq);
        self.messages += 1;
    }
}

pub(crate) fn options(compression: Compression) -> WriteOptions {
    WriteOptions::new()
        .library(LIBRARY)
        .compression(match compression {
            Compression::Zstd => Some(mcap::Compression::Zstd),
            Compression::Lz4 => Some(mcap::Compression::Lz4),
            Compression::None => None,
        })
        .compression_threads(0)
        .disable_seeking(true)
}

impl<W: Write + Seek> PoseLog<W> {
    /// A new recording with its schemas and channels, in a chunk of their own; `views` are the names of those that have
    /// small images.
    ///
    /// # Errors
    /// Those of writing to `sink`.
    pub fn new(sink: W, compression: Compression, views: &[String]) -> McapResult<Self> {
        let mut mcap = options(compression).create(sink)?;
        for (id, name, data) in schema::schemas() {
            mcap.add_schema_with_id(id, name, "protobuf", data)?;
        }
        let views = schema::view_channels(views.iter().map(String::as_str));
        for channel in schema::channels().into_iter().chain(views) {
            let (topic, encoding) = (&channel.topic, &channel.message_encoding);
            mcap.add_channel_with_id(channel.id, channel.schema_id, topic, encoding, &channel.metadata)?;
        }
        mcap.flush()?;
        Ok(Self {
            mcap,
            unwritten: Unwritten::default(),
            written: 0,
            dirty: false,
            buffer: Vec::new(),
        })
    }

    /// Makes room for [`Entry::Identity`].
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn with_identity(&mut self) -> McapResult<()> {
        let ((id, name, data), channel) = schema::identity();
        self.mcap.add_schema_with_id(id, name, "protobuf", data)?;
        let (topic, encoding) = (&channel.topic, &channel.message_encoding);
        self.mcap
            .add_channel_with_id(channel.id, channel.schema_id, topic, encoding, &channel.metadata)?;
        self.mcap.flush()
    }

    /// Attaches the scene file; `created_ns` is its wall-clock time, ns since 1970, for people.
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn scene(&mut self, toml: &str, created_ns: u64) -> McapResult<()> {
        self.attach(SCENE, "application/toml", toml.as_bytes(), created_ns)
    }

    /// Attaches a file. Closes the chunk.
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8], created_ns: u64) -> McapResult<()> {
        self.mcap.attach(&Attachment {
            log_time: 0,
            create_time: created_ns,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(bytes),
        })
    }

    /// Writes down what is known of the run. Closes the chunk.
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn facts(&mut self, facts: &RunFacts) -> McapResult<()> {
        self.metadata(&facts.metadata())
    }

    /// Writes a metadata record. Closes the chunk.
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn metadata(&mut self, metadata: &Metadata) -> McapResult<()> {
        self.mcap.write_metadata(metadata)
    }

    /// Takes a pose; see [`PoseLog::put`].
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn pose(&mut self, source: Source, pose: &ToolPose) -> McapResult<()> {
        self.put(Entry::Pose(source, pose))
    }

    /// Takes a message; it is on disk after the next [`PoseLog::flush`].
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn put(&mut self, entry: Entry<'_>) -> McapResult<()> {
        self.dirty = true;
        if let Some(seq) = entry.counted() {
            self.unwritten.add(seq);
        }
        let mut buffer = std::mem::take(&mut self.buffer);
        let put = entry.encoded(&mut buffer, |place, bytes| {
            let [log_time, publish_time] = place.times.map(file_time);
            let header = MessageHeader {
                channel_id: place.channel,
                // MCAP has 32 bits for it; the message has all 64.
                sequence: place.seq as u32,
                log_time,
                publish_time,
            };
            self.mcap.write_to_known_channel(&header, bytes)
        });
        self.buffer = buffer;
        put
    }

    /// Closes the chunk and hands everything to the operating system: a killed process loses none of it.
    ///
    /// # Errors
    /// Those of writing to the sink; the poses stay in [`PoseLog::unwritten`].
    pub fn flush(&mut self) -> McapResult<()> {
        self.mcap.flush()?;
        self.written += self.unwritten.messages;
        self.unwritten = Unwritten::default();
        self.dirty = false;
        Ok(())
    }

    /// What a kill would lose now.
    pub fn unwritten(&self) -> Unwritten {
        self.unwritten
    }

    /// Whether anything came since the last flush.
    pub fn is_dirty(&self) -> bool {
        self.dirty
    }

    /// Poses and frames of the localizer in closed chunks, of all topics.
    pub fn written(&self) -> u64 {
        self.written
    }

    /// Completes the recording with its index and gives the sink back.
    ///
    /// # Errors
    /// Those of writing to the sink. Flush first, to know what is on disk.
    pub fn finish(mut self) -> McapResult<W> {
        self.flush()?;
        self.mcap.finish()?;
        Ok(self.mcap.into_inner())
    }

    /// Gives the sink back as it is, without an index.
    pub fn abandon(self) -> W {
        self.mcap.into_inner()
    }
}

impl<W: Write + Seek> std::fmt::Debug for PoseLog<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PoseLog")
            .field("written", &self.written)
            .field("unwritten", &self.unwritten)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::fs::File;
    use std::io::BufWriter;

    const ZSTD: Compression = Compression::Zstd;

    #[test]
    fn only_closed_chunks_count_as_written() {
        let mut log = testing::log(1, 10);
        assert_eq!((log.written(), log.unwritten().messages), (30, 0));
        log.pose(Source::Tool, &testing::pose(10)).unwrap();
        log.pose(Source::Tool, &testing::pose(11)).unwrap();
        assert_eq!(log.written(), 30);
        let unwritten = Unwritten {
            messages: 2,
            seqs: (10, 11),
        };
        assert_eq!(log.unwritten(), unwritten);
    }

    #[test]
    fn a_full_disk_is_an_error_and_nothing_counts_as_written() {
        // Every write to this device fails with "no space left".
        let Ok(full) = File::options().write(true).open("/dev/full") else {
            return;
        };
        let error = PoseLog::new(BufWriter::new(full), ZSTD, &[]).unwrap_err();
        assert!(
            matches!(&error, mcap::McapError::Io(e) if e.kind() == std::io::ErrorKind::StorageFull),
            "{error}"
        );
    }

    #[test]
    fn what_is_flushed_is_a_prefix_that_never_changes() {
        let one = testing::unfinished(1, 10);
        let two = testing::unfinished(2, 10);
        assert!(two.starts_with(&one));
        assert!(testing::finished(2, 10).starts_with(&two));
    }
}
