//! What happened during a run, for people: states of the processes, lines of the log, small images.

use bus::message::{Heartbeat, Level, ProcessState};
use prost_types::Timestamp;

use super::{file_time, timestamp};

/// `trocar.ProcessStatus`: a sign of life that differs from the one before.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ProcessStatus {
    /// When, ns on the run's clock.
    #[prost(sint64, tag = "1")]
    pub t_ns: i64,
    /// The process's name.
    #[prost(string, tag = "2")]
    pub process: String,
    /// Its number.
    #[prost(uint32, tag = "3")]
    pub pid: u32,
    /// `starting`, `ready` or `stopping`.
    #[prost(string, tag = "4")]
    pub state: String,
    /// Why it waits or what it does.
    #[prost(string, tag = "5")]
    pub note: String,
    /// See [`bus::message::Counters::published`].
    #[prost(uint64, tag = "6")]
    pub published: u64,
    /// See [`bus::message::Counters::lost`].
    #[prost(uint64, tag = "7")]
    pub lost: u64,
    /// See [`bus::message::Counters::dropped`].
    #[prost(uint64, tag = "8")]
    pub dropped: u64,
    /// See [`bus::message::Counters::refused`].
    #[prost(uint64, tag = "9")]
    pub refused: u64,
    /// See [`bus::message::Counters::recorded`].
    #[prost(uint64, tag = "10")]
    pub recorded: u64,
}

impl ProcessStatus {
    /// The sign of life of the process of this name.
    pub fn new(process: &str, beat: &Heartbeat) -> Self {
        let state = match beat.process_state() {
            ProcessState::Starting => "starting",
            ProcessState::Ready => "ready",
            ProcessState::Stopping => "stopping",
        };
        Self {
            t_ns: beat.t_ns,
            process: process.to_owned(),
            pid: beat.pid,
            state: state.to_owned(),
            note: beat.note_text(),
            published: beat.counters.published,
            lost: beat.counters.lost,
            dropped: beat.counters.dropped,
            refused: beat.counters.refused,
            recorded: beat.counters.recorded,
        }
    }
}

/// `foxglove.Log`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Log {
    /// Since the run's epoch.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// 2 info, 3 warning, 4 error.
    #[prost(int32, tag = "2")]
    pub level: i32,
    /// What happened.
    #[prost(string, tag = "3")]
    pub message: String,
    /// Who says so.
    #[prost(string, tag = "4")]
    pub name: String,
    /// Not used.
    #[prost(string, tag = "5")]
    pub file: String,
    /// Not used.
    #[prost(fixed32, tag = "6")]
    pub line: u32,
}

impl Log {
    /// A line of the log.
    pub fn new(t_ns: i64, level: Level, name: &str, message: String) -> Self {
        Self {
            timestamp: Some(timestamp(file_time(t_ns))),
            level: match level {
                Level::Info => 2,
                Level::Warning => 3,
                Level::Error => 4,
            },
            message,
            name: name.to_owned(),
            file: String::new(),
            line: 0,
        }
    }
}

/// `foxglove.CompressedImage`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct CompressedImage {
    /// Since the run's epoch: when the image was handed over.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The whole file.
    #[prost(bytes = "vec", tag = "2")]
    pub data: Vec<u8>,
    /// `png`.
    #[prost(string, tag = "3")]
    pub format: String,
    /// The view.
    #[prost(string, tag = "4")]
    pub frame_id: String,
}

impl CompressedImage {
    /// A PNG of the view of this name.
    pub fn png(t_ns: i64, view: &str, data: Vec<u8>) -> Self {
        Self {
            timestamp: Some(timestamp(file_time(t_ns))),
            data,
            format: "png".to_owned(),
            frame_id: view.to_owned(),
        }
    }
}
