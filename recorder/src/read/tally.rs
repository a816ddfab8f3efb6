//! Counts per topic, as a table.

use std::collections::BTreeMap;
use std::fmt;

use mcap::{Channel, Message};
use prost::Message as _;

use crate::wire::proto::PoseSeq;
use crate::wire::schema::{EMITTER_SCHEMA, MARKER_SCHEMA, POSE_SCHEMA, TISSUE_SCHEMA};
use crate::wire::seq::SeqWatch;

/// What was found of one topic.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct TopicTally {
    /// The name of its schema; empty where it has none.
    pub schema: String,
    /// How many messages.
    pub messages: u64,
    /// The earliest and the latest capture, ns since the run's epoch.
    pub span_ns: Option<(u64, u64)>,
    /// Sequence numbers; poses and frames of the localizer only.
    pub seqs: SeqWatch,
}

/// What was found of each topic.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Tally {
    /// By the topic's name.
    pub topics: BTreeMap<String, TopicTally>,
}

impl Tally {
    /// Takes note of a channel, that has no messages yet.
    pub fn declare(&mut self, channel: &Channel<'_>) -> &mut TopicTally {
        self.topics.entry(channel.topic.clone()).or_insert_with(|| TopicTally {
            schema: channel
                .schema
                .as_ref()
                .map(|schema| schema.name.clone())
                .unwrap_or_default(),
            ..TopicTally::default()
        })
    }

    /// Takes note of a message.
    pub fn count(&mut self, message: &Message<'_>) {
        let topic = self.declare(&message.channel);
        let time = message.log_time;
        let (first, last) = topic.span_ns.unwrap_or((time, time));
        topic.messages += 1;
        topic.span_ns = Some((first.min(time), last.max(time)));
        // The number is the first field of all four.
        if matches!(
            topic.schema.as_str(),
            POSE_SCHEMA | EMITTER_SCHEMA | MARKER_SCHEMA | TISSUE_SCHEMA
        ) && let Ok(pose) = PoseSeq::decode(&*message.data)
        {
            topic.seqs.saw(pose.seq);
        }
    }

    /// Messages of all topics.
    pub fn messages(&self) -> u64 {
        self.topics.values().map(|topic| topic.messages).sum()
    }

    /// The earliest and the latest capture of all topics, ns since the run's epoch.
    pub fn span_ns(&self) -> Option<(u64, u64)> {
        let spans = self.topics.values().filter_map(|topic| topic.span_ns);
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.span_ns() {
            Some((from, to)) => {
                let (from, to) = (seconds(from), seconds(to));
                writeln!(f, "from {from:.3} s to {to:.3} s of the run: {:.3} s", to - from)?;
            }
            None => writeln!(f, "no messages")?,
        }
        writeln!(
            f,
            "{:<16} {:>10} {:>9} {:>10} {:>10} {:>6} {:>8} {:>8}  schema",
            "topic", "messages", "per s", "first seq", "last seq", "gaps", "missing", "restarts"
        )?;
        self.topics.iter().try_for_each(|(name, topic)| row(f, name, topic))
    }
}

fn row(f: &mut fmt::Formatter<'_>, name: &str, topic: &TopicTally) -> fmt::Result {
    let lasts = topic.span_ns.map(|(from, to)| seconds(to - from)).filter(|&s| s > 0.0);
    let rate = lasts.map_or("-".to_owned(), |s| {
        format!("{:.1}", topic.messages.saturating_sub(1) as f64 / s)
    });
    write!(f, "{name:<16} {:>10} {rate:>9} ", topic.messages)?;
    let SeqWatch {
        range,
        gaps,
        missing,
        restarts,
        ..
    } = topic.seqs;
    match range {
        Some((first, last)) => write!(f, "{first:>10} {last:>10} {gaps:>6} {missing:>8} {restarts:>8}")?,
        None => write!(f, "{:>10} {:>10} {:>6} {:>8} {:>8}", "-", "-", "-", "-", "-")?,
    }
    writeln!(f, "  {}", topic.schema)
}
