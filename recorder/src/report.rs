//! A session on paper: one HTML file that says what was done, on what it rested and what went wrong, for a surgeon and for a
//! researcher after the operation.
//!
//! A recording is read once, whole or not, and in bounded memory. What was found (`report/facts.rs`) is what the page and the JSON say;
//! neither computes anything. The page needs no other file, no network and no script, and is well-formed XML too, so that any reader
//! of either kind can check it.

pub(crate) mod basis;
mod columns;
mod expected;
mod facts;
mod gather;
mod hashed;
mod html;
mod localizer;
mod marks;
mod navigated;
mod notices;
mod organs;
mod output;
mod quantity;
mod run_report;
mod short;
mod stage_times;
mod states;
mod story;
pub(crate) mod timeline;
mod tip;

use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use crate::read::damage::OpenError;
use crate::read::scan;
use crate::read::tally::Tally;
use crate::report::facts::{Curves, Facts, MarkFacts, Notice, Recording, TipFacts, Topic, Whose};
use crate::report::gather::Gathered;
use crate::report::hashed::Hashed;
use crate::report::short::short;
use crate::report::states::State;
use crate::wire::proto::Identity;
use crate::wire::schema::LIBRARY;

/// What a person wants of a report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Whose examination it is, where the recording says so.
    pub identity: bool,
    /// The same facts as JSON, beside the page.
    pub json: bool,
    /// Replace the files if they exist.
    pub force: bool,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Made {
    /// The page, and the JSON.
    pub files: Vec<PathBuf>,
    /// What stands at its top, a line each.
    pub notices: Vec<String>,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// Nothing can be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// There is such a file.
    #[error("{0} exists already. Give another name with --out FILE, or --force to replace it")]
    Exists(PathBuf),
    /// The report would replace the recording, or its JSON the page.
    #[error("{0} would be replaced by the report of it, or by its JSON. Give another name with --out FILE.html")]
    Itself(PathBuf),
    /// The file holds nothing of a session.
    #[error("{path} holds nothing that a report could tell of. It holds: {found}. {damage}")]
    Nothing {
        /// The file.
        path: PathBuf,
        /// Its topics.
        found: String,
        /// What could not be read.
        damage: String,
    },
    /// It is of more than one run, or holds more than one scene.
    #[error("{path}: {why}; only a recording of one run, with its scene, can be reported")]
    TwoRuns {
        /// The recording.
        path: PathBuf,
        /// What was found and expected.
        why: String,
    },
    /// A topic holds something else.
    #[error(
        "{path}: topic {topic} holds {found:?} where {wanted:?} is needed: another program wrote it, or a version of this one that \
         can report it"
    )]
    Schema {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The schema found.
        found: String,
        /// The schema needed.
        wanted: &'static str,
    },
    /// Its messages have fields that this version would leave out.
    #[error(
        "{path}: the messages of topic {topic} have fields that this version does not know ({unknown}), and would be reported \
         without them. Make the report with the version that recorded it, or a later one"
    )]
    Newer {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The unknown fields: names and numbers.
        unknown: String,
    },
    /// The report cannot be written.
    #[error("writing {path}: {source}. Name a place that you may write to, with --out FILE")]
    Write {
        /// The new file, under its temporary name.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Makes the report of the recording `input` in the file `out`. Files that its user alone may read: they may say whose examination it
/// is.
///
/// # Errors
/// Each variant of [`ReportError`]; a new file is then not there.
pub fn report(input: &Path, out: &Path, wanted: Wanted) -> Result<Made, ReportError> {
    let files = output::targets(input, out, wanted)?;
    let facts = read(input, wanted.identity)?;
    let mut texts = vec![html::page(&facts)];
    if wanted.json {
        texts.push(serde_json::to_string_pretty(&facts).unwrap_or_default() + "\n");
    }
    output::write(&files, &texts)?;
    let line = |notice: &Notice| format!("{}: {}", notice.word, notice.words);
    Ok(Made {
        files,
        notices: facts.notices.iter().map(line).collect(),
    })
}

fn read(path: &Path, with_identity: bool) -> Result<Facts, ReportError> {
    let fail = |source| OpenError::Io {
        path: path.to_owned(),
        source,
    };
    let (mut file, bytes) = scan::open_file(path)?;
    file.rewind().map_err(fail)?;
    // A file that still grows is read as far as it went.
    let mut input = Hashed::new(BufReader::new(file.take(bytes)));
    let found = gather::gather(path, &mut input, bytes)?;
    if !is_a_session(&found) {
        return Err(nothing(path, &found));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let recording = Recording {
        name: short(&name),
        bytes,
        blake3: input.finish().map_err(fail)?,
        written_by: found.library.clone(),
        span_ns: found.span_ns,
        topics: topics(&found.tally),
    };
    Ok(facts(found, recording, with_identity))
}

fn is_a_session(found: &Gathered) -> bool {
    let told =
        |(name, topic): (&String, &crate::read::tally::TopicTally)| topic.messages > 0 && expected::is_told(name);
    !found.basis.run.is_empty() || found.tally.topics.iter().any(told)
}

fn nothing(path: &Path, found: &Gathered) -> ReportError {
    let topics = found
        .tally
        .topics
        .iter()
        .filter(|(_, topic)| topic.messages > 0)
        .take(20);
    let names: Vec<String> = topics
        .map(|(name, topic)| format!("{name} ({})", topic.schema))
        .collect();
    ReportError::Nothing {
        path: path.to_owned(),
        found: match names.is_empty() {
            true => "no messages".to_owned(),
            false => names.join(", "),
        },
        damage: found.damage.words.listed.first().cloned().unwrap_or_default(),
    }
}

fn topics(tally: &Tally) -> std::collections::BTreeMap<String, Topic> {
    let topic = |of: &crate::read::tally::TopicTally| Topic {
        schema: short(&of.schema),
        messages: of.messages,
        missing: of.seqs.missing,
        restarts: of.seqs.restarts,
    };
    tally.topics.iter().map(|(name, of)| (short(name), topic(of))).collect()
}

fn facts(mut found: Gathered, recording: Recording, with_identity: bool) -> Facts {
    let notices = notices::notices(&found, recording.bytes);
    let (from_ns, to_ns) = recording.span_ns.unwrap_or_default();
    let stages_ns = found.story.stage_times.finish(from_ns, to_ns);
    let states = found.timeline.finish(from_ns, to_ns, found.between);
    let time = |state: State| (state.words(), states.totals.of(state));
    Facts {
        made_by: LIBRARY,
        notices,
        damage: found.damage,
        identity: whose(found.identity, with_identity),
        basis: found.basis,
        poses: found.poses,
        states_ns: State::all().map(time).filter(|(_, ns)| *ns > 0).collect(),
        stages_ns,
        lost_times: states.lost_times,
        lost_longest: states.longest.clone(),
        tip: TipFacts {
            predicted_95_mm: found.tip.predicted.spread(),
            unknown: found.tip.predicted.unknowns(),
            true_mm: found.tip.found.spread(),
            compared: found.tip.compared.0,
            beyond: found.tip.compared.1,
        },
        latency_ms: found.latency.spread(),
        latency_unknown: found.latency.unknowns(),
        localizers: found.localizers.facts(),
        organs: found.organs.finish(),
        marks: MarkFacts {
            why_none: (0..found.marks.all.len())
                .map(|place| found.marks.why_none(place))
                .collect(),
            count: found.marks.count,
            pictures: found.marks.pictures,
            pictures_refused: found.marks.refused,
            listed: found.marks.all,
        },
        story: found.story,
        curves: Curves {
            states,
            predicted: found.tip.predicted,
            found: found.tip.found,
            latency: found.latency,
        },
        recording,
    }
}

fn whose(identity: Option<Identity>, is_asked: bool) -> Whose {
    match (is_asked, identity) {
        (false, _) => Whose::NotAsked,
        (true, None) => Whose::NotRecorded,
        (true, Some(identity)) => Whose::Said {
            name: short(&identity.name),
            patient_id: short(&identity.patient_id),
            birth_date: short(&identity.birth_date),
            study_date: short(&identity.study_date),
            description: short(&identity.description),
            source: short(&identity.source),
        },
    }
}

#[cfg(test)]
mod tests;
