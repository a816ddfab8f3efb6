//! Everything that a report says, as it was found; the page and the JSON are made of it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::basis::Basis;
use super::localizer::LocalizerFacts;
use super::marks::Mark;
use super::organs::OrganFacts;
use super::quantity::{Quantity, Spread};
use super::short::List;
use super::states::{LostSpan, States};
use super::story::Story;

/// What a report says. Times are ns since the run's epoch. Keys of the JSON are only ever added.
#[derive(Debug, Serialize)]
pub(super) struct Facts {
    /// The program that made the report.
    pub(super) made_by: &'static str,
    pub(super) recording: Recording,
    /// What must be known before anything else is believed, in the order of its weight.
    pub(super) notices: Vec<Notice>,
    pub(super) damage: DamageFacts,
    pub(super) identity: Whose,
    pub(super) basis: Basis,
    pub(super) poses: PoseFacts,
    /// The time of each state, ns; together they are the recording's.
    pub(super) states_ns: Vec<(String, u64)>,
    /// The same of the workflow's stages, by the stage's word; before the first one is told, `not told`.
    pub(super) stages_ns: Vec<(String, u64)>,
    pub(super) lost_times: u64,
    /// The longest times without a pose.
    pub(super) lost_longest: Vec<LostSpan>,
    pub(super) tip: TipFacts,
    /// From capture to publication, ms; `null`: no pose says.
    pub(super) latency_ms: Option<Spread>,
    /// Poses that were published before they were captured.
    pub(super) latency_unknown: u64,
    pub(super) localizers: LocalizerFacts,
    pub(super) organs: OrganFacts,
    pub(super) marks: MarkFacts,
    pub(super) story: Story,
    #[serde(skip)]
    pub(super) curves: Curves,
}

/// A word in capitals, and what it means here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Notice {
    pub(super) word: &'static str,
    pub(super) words: String,
}

/// The file.
#[derive(Debug, Default, Serialize)]
pub(super) struct Recording {
    /// Its name, without its folder.
    pub(super) name: String,
    pub(super) bytes: u64,
    /// Of all its bytes.
    pub(super) blake3: String,
    /// The program that wrote it, by its header.
    pub(super) written_by: Option<String>,
    /// The first and the last capture.
    pub(super) span_ns: Option<(i64, i64)>,
    pub(super) topics: BTreeMap<String, Topic>,
}

/// The messages of a topic.
#[derive(Debug, Default, Serialize)]
pub(super) struct Topic {
    pub(super) schema: String,
    pub(super) messages: u64,
    /// Numbers that were left out.
    pub(super) missing: u64,
    /// How often the numbers began anew.
    pub(super) restarts: u64,
}

/// What could not be read.
#[derive(Debug, Default, Serialize)]
pub(super) struct DamageFacts {
    /// Places of the file that are damaged; an end that is missing is none.
    pub(super) places: u64,
    /// The file ends before its recording did.
    pub(super) is_cut_off: bool,
    /// The byte behind which nothing could be read.
    pub(super) stops_at: Option<u64>,
    /// Messages that are known to be lost, by topic.
    pub(super) lost: BTreeMap<String, u64>,
    /// Messages that were there and are not what they should be, or of a time that no clock shows.
    pub(super) unreadable: u64,
    /// Each of them, in words.
    pub(super) words: List<String>,
}

/// Whose examination it is.
#[derive(Debug, Serialize)]
#[serde(tag = "known", rename_all = "snake_case")]
pub(super) enum Whose {
    /// Nobody asked: it is not said, nor whether it is known.
    NotAsked,
    /// The recording does not say.
    NotRecorded,
    /// The recording says so.
    Said {
        name: String,
        patient_id: String,
        birth_date: String,
        study_date: String,
        description: String,
        /// Who says it: `unknown`, `examination`, `scene` or `phantom`.
        source: String,
    },
}

/// The samples of the tool.
#[derive(Debug, Default, Serialize)]
pub(super) struct PoseFacts {
    pub(super) samples: u64,
    pub(super) valid: u64,
    /// Without a pose, by reason.
    pub(super) lost: BTreeMap<&'static str, u64>,
    /// Samples that are no pose, or do not go on from the one before.
    pub(super) refused: u64,
    /// Numbers that never came.
    pub(super) missing: u64,
    /// How often the numbers began anew.
    pub(super) counted_anew: u64,
    /// Tip outside the examination, as the source found it.
    pub(super) outside: u64,
    /// From when on which registration was in use, 16 hexadecimal digits.
    pub(super) registrations: List<(i64, String)>,
}

/// Errors at the tip, mm.
#[derive(Debug, Serialize)]
pub(super) struct TipFacts {
    /// That 95 % of errors are below, predicted with each pose; `null`: nothing was predicted.
    pub(super) predicted_95_mm: Option<Spread>,
    /// Poses without a prediction.
    pub(super) unknown: u64,
    /// From the simulated tool's true tip; `null`: no truth is recorded.
    pub(super) true_mm: Option<Spread>,
    /// Poses with truth and prediction.
    pub(super) compared: u64,
    /// Of these, those further off than they predicted.
    pub(super) beyond: u64,
}

/// What was marked.
#[derive(Debug, Serialize)]
pub(super) struct MarkFacts {
    pub(super) count: u64,
    pub(super) listed: Vec<Mark>,
    /// Small images in the recording.
    pub(super) pictures: u64,
    /// Of these, those that are no usable PNG.
    pub(super) pictures_refused: u64,
    /// For each mark without a picture, why.
    #[serde(skip)]
    pub(super) why_none: Vec<String>,
}

/// What is drawn.
#[derive(Debug)]
pub(super) struct Curves {
    pub(super) states: States,
    pub(super) predicted: Quantity,
    pub(super) found: Quantity,
    pub(super) latency: Quantity,
}

impl Facts {
    /// How long the recording goes, ns.
    pub(super) fn length_ns(&self) -> u64 {
        let span = self.recording.span_ns;
        span.map_or(0, |(from, to)| to.saturating_sub(from).unsigned_abs())
    }
}
