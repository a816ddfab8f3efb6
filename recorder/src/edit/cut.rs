//! A stretch of a recording as a recording of its own.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use mcap::records::Metadata;
use mcap::{McapResult, Message, Writer};
use prost::Message as _;
use scene::Compression;

use crate::edit::progress::Progress;
use crate::edit::recover::put;
use crate::edit::recovered;
use crate::read::damage::OpenError;
use crate::read::info::Info;
use crate::read::reader;
use crate::read::scan::{self, Item, Scan};
use crate::wire::proto::{Identity, MeshFrame};
use crate::wire::schema::{GUIDE, IDENTITY, TISSUE_MESH, WORKFLOW};
use crate::write::file_error::words;
use crate::write::paths;
use crate::write::pose_log;
use crate::write::session_file::synced;

/// The name of the metadata record that says what was cut out of what.
pub const CUT: &str = "cut";

/// A recording is of one person; of more than so many are none of more use.
const PEOPLE: usize = 4;

/// From when to when, ns since the run's epoch, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// First capture.
    pub from_ns: u64,
    /// Last capture.
    pub to_ns: u64,
}

/// Why nothing was cut out.
#[derive(Debug, thiserror::Error)]
pub enum CutError {
    /// Nothing can be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// There is such a file.
    #[error("{0} exists already. Give another name with --out FILE.mcap, or --force to replace it")]
    Exists(PathBuf),
    /// Nothing was captured in that time.
    #[error("{path}: nothing was captured from {from_s} s to {to_s} s; the recording goes {span}")]
    Nothing {
        /// The recording.
        path: PathBuf,
        /// s
        from_s: f64,
        /// s
        to_s: f64,
        /// From when to when it goes.
        span: String,
    },
    /// The new file cannot be written.
    #[error("writing {path}: {why}")]
    Write {
        /// The new file, under its temporary name.
        path: PathBuf,
        /// Why.
        why: String,
    },
}

/// Copies what was captured in `stretch` from `input` to a whole file `out`, with all that is attached.
///
/// # Errors
/// Each variant of [`CutError`]; a new file is then not there.
pub fn cut(input: &Path, stretch: Stretch, out: &Path, force: bool) -> Result<Info, CutError> {
    if out.exists() && !force {
        return Err(CutError::Exists(out.to_owned()));
    }
    let scan = scan::open(input)?;
    let partial = paths::partial(out);
    let done = copy(scan, stretch, input, &partial).map_err(|e| CutError::Write {
        path: partial.clone(),
        why: words(&e),
    });
    let done = done.and_then(|info| match info.tally.messages() {
        0 => Err(nothing(input, stretch)),
        _ => Ok(info),
    });
    let renamed = done.and_then(|info| {
        fs::rename(&partial, out).map(|()| info).map_err(|e| CutError::Write {
            path: partial.clone(),
            why: e.to_string(),
        })
    });
    if renamed.is_err() {
        // Of no use; if it cannot be removed, its name says so.
        let _ = fs::remove_file(&partial);
    }
    renamed
}

fn nothing(path: &Path, stretch: Stretch) -> CutError {
    let s = |ns: u64| ns as f64 / 1e9;
    let span = crate::read::info::info(path).ok().and_then(|info| info.tally.span_ns());
    CutError::Nothing {
        path: path.to_owned(),
        from_s: s(stretch.from_ns),
        to_s: s(stretch.to_ns),
        span: span.map_or("nowhere".to_owned(), |(a, b)| {
            format!("from {:.3} s to {:.3} s", s(a), s(b))
        }),
    }
}

fn copy(scan: Scan<impl Read>, stretch: Stretch, input: &Path, partial: &Path) -> McapResult<Info> {
    let mut out = pose_log::options(Compression::Zstd).create(BufWriter::new(File::create(partial)?))?;
    let info = copy_into(scan, stretch, &mut out)?;
    let facts = [
        (
            "file",
            input.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        ),
        ("from_ns", stretch.from_ns.to_string()),
        ("to_ns", stretch.to_ns.to_string()),
    ];
    out.write_metadata(&Metadata {
        name: CUT.to_owned(),
        metadata: facts.map(|(key, value)| (key.to_owned(), value)).into(),
    })?;
    if let Some(losses) = recovered::record(input, &info.damage) {
        out.write_metadata(&losses)?;
    }
    out.finish()?;
    synced(out.into_inner())?;
    Ok(info)
}

fn copy_into<W: Write + Seek>(mut scan: Scan<impl Read>, stretch: Stretch, out: &mut Writer<W>) -> McapResult<Info> {
    let mut info = Info::default();
    let mut progress = Progress::new("cutting");
    // What was chosen before the stretch holds in it, and organs at rest are of all states; written with the first message of it.
    // So does how far the run had come, of which the last word counts. Whose examination it shows is the same at any time too.
    let (mut chosen, mut meshes, mut reached) = (Vec::new(), Meshes::default(), None);
    let mut people = BTreeSet::new();
    while let Some(item) = scan.next() {
        let (read, length) = scan.progress();
        progress.at(read, length);
        match item {
            Ok(Item::Message(message)) if [GUIDE, TISSUE_MESH].contains(&message.channel.topic.as_str()) => {
                // Organs at rest are the same at any time, and were written down by another clock where time was simulated.
                let is_wanted = match message.channel.topic == TISSUE_MESH {
                    true => meshes.takes(&message),
                    false => message.publish_time <= stretch.to_ns,
                };
                if is_wanted {
                    let log_time = message.log_time.clamp(stretch.from_ns, stretch.to_ns);
                    chosen.push(Item::Message(Message { log_time, ..message }));
                }
            }
            Ok(Item::Message(message)) if message.channel.topic == WORKFLOW && message.log_time < stretch.from_ns => {
                let log_time = stretch.from_ns;
                reached = Some(Item::Message(Message { log_time, ..message }));
            }
            Ok(Item::Message(message)) if message.channel.topic == IDENTITY => {
                if people.len() < PEOPLE && people.insert(person(&message.data)) {
                    let log_time = message.log_time.clamp(stretch.from_ns, stretch.to_ns);
                    chosen.push(Item::Message(Message { log_time, ..message }));
                }
            }
            Ok(Item::Message(message)) if !(stretch.from_ns..=stretch.to_ns).contains(&message.log_time) => {}
            Ok(item) => {
                let (before, reached) = match item {
                    Item::Message(_) => (std::mem::take(&mut chosen), reached.take()),
                    _ => (Vec::new(), None),
                };
                for item in before.iter().chain(&reached).chain([&item]) {
                    put(out, item)?;
                    info.take(Ok(item));
                }
            }
            Err(damage) => info.take(Err(damage)),
        }
    }
    // What was chosen at the very end of it, behind the last message of another kind.
    if info.tally.messages() > 0 {
        for item in &chosen {
            put(out, item)?;
            info.take(Ok(item));
        }
    }
    Ok(info)
}

/// What a message says of a person, whenever it was heard of.
fn person(data: &[u8]) -> Vec<u8> {
    let known = Identity::decode(data).map(|identity| Identity { t_ns: 0, ..identity });
    known.map_or_else(|_| data.to_vec(), |identity| identity.encode_to_vec())
}

/// Meshes of organs, each taken once, and none beyond what may wait in memory.
#[derive(Default)]
struct Meshes {
    known: BTreeSet<[u8; 32]>,
    bytes: usize,
}

impl Meshes {
    /// Bytes of all meshes that are taken.
    const MOST: usize = 64 << 20;

    fn takes(&mut self, message: &Message<'_>) -> bool {
        let Ok(mesh) = reader::decode::<MeshFrame>(message) else {
            return false;
        };
        let bytes = self.bytes + mesh.bytes.len();
        let takes = bytes <= Self::MOST && self.known.insert(mesh.header.mesh_id);
        self.bytes = if takes { bytes } else { self.bytes };
        takes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use crate::wire::proto;
    use crate::wire::schema::{EMITTERS, SCENE, TOOL_POSE};
    use crate::write::pose_log::Entry;
    use bus::message::Guide;

    #[test]
    fn a_stretch_is_a_whole_recording_with_what_is_attached() {
        let tmp = tempfile::tempdir().unwrap();
        let [input, out] = ["s.mcap", "cut.mcap"].map(|name| tmp.path().join(name));
        fs::write(&input, testing::finished(6, 10)).unwrap();
        let [from_ns, to_ns] = [13, 41].map(|seq| testing::pose(seq).t_capture_ns.cast_unsigned());
        let info = cut(&input, Stretch { from_ns, to_ns }, &out, false).unwrap();
        assert_eq!(info.tally.topics[EMITTERS].messages, 29);
        let seqs: Vec<_> = reader::poses(&out, TOOL_POSE)
            .unwrap()
            .map(|pose| pose.unwrap().seq)
            .collect();
        assert_eq!(seqs, (13..=41).collect::<Vec<_>>());
        let found = crate::read::verify::verify(&out).unwrap();
        assert!(found.findings.is_empty(), "{:?}", found.findings);
        let session = crate::read::seek::Session::open(&out).unwrap();
        assert!(session.attachment(SCENE).unwrap().is_some());
        assert_eq!(session.metadata(CUT).unwrap().unwrap().metadata["file"], "s.mcap");
    }

    #[test]
    fn what_was_chosen_before_a_stretch_holds_in_it() {
        let tmp = tempfile::tempdir().unwrap();
        let [input, out] = ["s.mcap", "cut.mcap"].map(|name| tmp.path().join(name));
        let mut log = testing::log(0, 0);
        let stamp = |seq: u64| testing::pose(seq).t_publish_ns;
        for seq in 0..60 {
            // At the start, before the stretch, in it, and behind it.
            if [0, 10, 30, 50].contains(&seq) {
                let guide = Guide {
                    t_ns: stamp(seq),
                    plan_id: seq,
                    ..Guide::default()
                };
                log.put(Entry::Guide(stamp(seq), &proto::Guide::from(&guide))).unwrap();
            }
            log.pose(crate::wire::schema::Source::Tool, &testing::pose(seq))
                .unwrap();
        }
        for (flags, seq) in [(1, 5), (2, 15), (4, 30)] {
            let t_ns = testing::pose(seq).t_capture_ns;
            let workflow = proto::Workflow {
                t_ns,
                flags,
                ..proto::Workflow::default()
            };
            log.put(Entry::Workflow(&workflow)).unwrap();
        }
        fs::write(&input, log.finish().unwrap().into_inner()).unwrap();
        // A choice behind the last pose of a stretch was left out.
        let [from_ns, to_ns] = [45, 50].map(stamp).map(i64::cast_unsigned);
        let stretch = Stretch {
            from_ns,
            to_ns: to_ns + 1,
        };
        cut(&input, stretch, &out, false).unwrap();
        let guides = reader::guides(&out).unwrap().map(|guide| guide.unwrap().plan_id);
        assert_eq!(guides.collect::<Vec<_>>(), [0, 10, 30, 50]);
        fs::remove_file(&out).unwrap();
        let [from_ns, to_ns] = [20, 40].map(|seq| testing::pose(seq).t_capture_ns.cast_unsigned());
        let info = cut(&input, Stretch { from_ns, to_ns }, &out, false).unwrap();
        assert_eq!(info.tally.span_ns(), Some((from_ns, to_ns)));
        let guides = reader::guides(&out).unwrap().map(|guide| guide.unwrap().plan_id);
        assert_eq!(guides.collect::<Vec<_>>(), [0, 10, 30]);
        // A cut lost that its run navigated unchecked: the last word before the stretch, and all within it.
        let flags = scan::open(&out).unwrap().filter_map(|item| match item.unwrap() {
            Item::Message(message) if message.channel.topic == WORKFLOW => Some(
                <proto::Workflow as prost::Message>::decode(&*message.data)
                    .unwrap()
                    .flags,
            ),
            _ => None,
        });
        assert_eq!(flags.collect::<Vec<_>>(), [2, 4]);
        let found = crate::read::verify::verify(&out).unwrap();
        assert!(found.findings.is_empty(), "{:?}", found.findings);
        // Of a stretch in which nothing was captured it makes no recording.
        let nowhere = Stretch {
            from_ns: u64::MAX - 1,
            to_ns: u64::MAX,
        };
        assert!(matches!(
            cut(&input, nowhere, &out, true),
            Err(CutError::Nothing { .. })
        ));
    }

    /// It is written down once, at the beginning, and in simulated time by a clock that may be far ahead.
    #[test]
    fn whose_examination_it_is_is_in_every_stretch() {
        let tmp = tempfile::tempdir().unwrap();
        let [input, out] = ["s.mcap", "cut.mcap"].map(|name| tmp.path().join(name));
        for t_ns in [0, i64::MAX / 2] {
            let mut log = testing::log(0, 0);
            log.with_identity().unwrap();
            let identity = proto::Identity {
                name: "SMITH^A".to_owned(),
                t_ns,
                ..proto::Identity::default()
            };
            log.put(Entry::Identity(&identity)).unwrap();
            for seq in 0..60 {
                log.pose(crate::wire::schema::Source::Tool, &testing::pose(seq))
                    .unwrap();
            }
            fs::write(&input, log.finish().unwrap().into_inner()).unwrap();
            let [from_ns, to_ns] = [20, 40].map(|seq| testing::pose(seq).t_capture_ns.cast_unsigned());
            let info = cut(&input, Stretch { from_ns, to_ns }, &out, true).unwrap();
            assert_eq!(info.tally.topics[IDENTITY].messages, 1, "{t_ns}");
        }
    }

    /// Of a run in simulated time: the mesh was written down by a clock that is far ahead.
    #[test]
    fn organs_at_rest_are_in_every_stretch_and_each_once() {
        let tmp = tempfile::tempdir().unwrap();
        let [input, out] = ["s.mcap", "cut.mcap"].map(|name| tmp.path().join(name));
        let mut log = testing::log(0, 0);
        for id in [5, 5, 6] {
            let header = bus::message::TissueMeshHeader {
                mesh_id: [id; 32],
                ..Default::default()
            };
            let mesh = MeshFrame {
                header,
                bytes: vec![id],
            };
            log.put(Entry::TissueMesh(&proto::TissueMesh::of(i64::MAX / 2, &mesh)))
                .unwrap();
        }
        for seq in 0..60 {
            log.pose(crate::wire::schema::Source::Tool, &testing::pose(seq))
                .unwrap();
        }
        fs::write(&input, log.finish().unwrap().into_inner()).unwrap();
        let [from_ns, to_ns] = [20, 40].map(|seq| testing::pose(seq).t_capture_ns.cast_unsigned());
        cut(&input, Stretch { from_ns, to_ns }, &out, false).unwrap();
        let found = crate::read::seek::Session::open(&out).unwrap().meshes().unwrap();
        let ids: Vec<u8> = found.messages.iter().map(|mesh| mesh.header.mesh_id[0]).collect();
        assert_eq!(ids, [5, 6]);
        let count = crate::read::info::info(&out).unwrap().tally.topics[TISSUE_MESH].messages;
        assert_eq!(count, 2, "the file holds each once");
    }

    #[test]
    fn a_stretch_without_anything_is_refused_with_what_there_is() {
        let tmp = tempfile::tempdir().unwrap();
        let [input, out] = ["s.mcap", "cut.mcap"].map(|name| tmp.path().join(name));
        fs::write(&input, testing::finished(1, 61)).unwrap();
        let stretch = Stretch {
            from_ns: 5_000_000_000,
            to_ns: 6_000_000_000,
        };
        let text = cut(&input, stretch, &out, false).unwrap_err().to_string();
        assert!(
            text.contains("nothing was captured from 5 s to 6 s; the recording goes from 0.000 s to 1.000 s"),
            "{text}"
        );
        assert_eq!(fs::read_dir(tmp.path()).unwrap().count(), 1);
    }
}
