//! The content of one recording: poses into chunks, with the scene and the run's facts beside them.
//!
//! Chunks are compressed with zstd: the poses of a second differ in few bytes, zstd makes a fifth less of them than lz4
//! does, and at tracker rates a chunk of half a second takes well under a millisecond either way. Compression runs on
//! this thread; a pool of threads per recorder would cost more than it saves.
//!
//! A chunk is put together in memory and then appended in one go, never written back to: a killed recorder leaves whole
//! chunks and at most one that is cut off.

use std::borrow::Cow;
use std::io::{Seek, Write};

use bus::message::ToolPose;
use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, McapResult, WriteOptions, Writer};

use crate::proto::{self, file_time, frame_transform_in_metres};
use crate::schema::{self, LIBRARY, RunFacts, SCENE, Source, TF_CHANNEL};

/// A recording that grows.
pub struct PoseLog<W: Write + Seek> {
    mcap: Writer<W>,
    unwritten: Unwritten,
    written: u64,
    buffer: Vec<u8>,
}

/// Poses that were taken but are not in a closed chunk yet.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Unwritten {
    /// How many, of both topics.
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

pub(crate) fn options() -> WriteOptions {
    WriteOptions::new()
        .library(LIBRARY)
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .disable_seeking(true)
}

impl<W: Write + Seek> PoseLog<W> {
    /// A new recording with its schemas and channels, in a chunk of their own.
    ///
    /// # Errors
    /// Those of writing to `sink`.
    pub fn new(sink: W) -> McapResult<Self> {
        let mut mcap = options().create(sink)?;
        for (id, name, data) in schema::schemas() {
            mcap.add_schema_with_id(id, name, "protobuf", &data)?;
        }
        for channel in schema::channels() {
            let (topic, encoding) = (&channel.topic, &channel.message_encoding);
            mcap.add_channel_with_id(channel.id, channel.schema_id, topic, encoding, &channel.metadata)?;
        }
        mcap.flush()?;
        Ok(Self {
            mcap,
            unwritten: Unwritten::default(),
            written: 0,
            buffer: Vec::new(),
        })
    }

    /// Attaches the scene file; `created_ns` is its wall-clock time, ns since 1970, for people.
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn scene(&mut self, toml: &str, created_ns: u64) -> McapResult<()> {
        self.mcap.attach(&Attachment {
            log_time: 0,
            create_time: created_ns,
            name: SCENE.to_owned(),
            media_type: "application/toml".to_owned(),
            data: Cow::Borrowed(toml.as_bytes()),
        })
    }

    /// Writes down what is known of the run. Closes the chunk.
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn facts(&mut self, facts: &RunFacts) -> McapResult<()> {
        self.mcap.write_metadata(&facts.metadata())
    }

    /// Takes a pose; it is on disk after the next [`PoseLog::flush`].
    ///
    /// # Errors
    /// Those of writing to the sink.
    pub fn pose(&mut self, source: Source, pose: &ToolPose) -> McapResult<()> {
        self.unwritten.add(pose.seq);
        self.message(source.channel(), pose, &proto::ToolPose::from(pose))?;
        match frame_transform_in_metres(pose, source.frame()) {
            Some(transform) => self.message(TF_CHANNEL, pose, &transform),
            None => Ok(()),
        }
    }

    fn message(&mut self, channel_id: u16, pose: &ToolPose, message: &impl prost::Message) -> McapResult<()> {
        self.buffer.clear();
        // Cannot fail: the buffer grows.
        let _ = message.encode(&mut self.buffer);
        let header = MessageHeader {
            channel_id,
            // MCAP has 32 bits for it; the message has all 64.
            sequence: pose.seq as u32,
            log_time: file_time(pose.t_capture_ns),
            publish_time: file_time(pose.t_publish_ns),
        };
        self.mcap.write_to_known_channel(&header, &self.buffer)
    }

    /// Closes the chunk and hands everything to the operating system: a killed process loses none of it.
    ///
    /// # Errors
    /// Those of writing to the sink; the poses stay in [`PoseLog::unwritten`].
    pub fn flush(&mut self) -> McapResult<()> {
        self.mcap.flush()?;
        self.written += self.unwritten.messages;
        self.unwritten = Unwritten::default();
        Ok(())
    }

    /// What a kill would lose now.
    pub fn unwritten(&self) -> Unwritten {
        self.unwritten
    }

    /// Poses in closed chunks, of both topics.
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

    #[test]
    fn only_closed_chunks_count_as_written() {
        let mut log = testing::log(1, 10);
        assert_eq!((log.written(), log.unwritten().messages), (20, 0));
        log.pose(Source::Tool, &testing::pose(10)).unwrap();
        log.pose(Source::Tool, &testing::pose(11)).unwrap();
        assert_eq!(log.written(), 20);
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
        let error = PoseLog::new(BufWriter::new(full)).unwrap_err();
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
