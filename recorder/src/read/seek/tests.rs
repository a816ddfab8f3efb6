use std::fs;

use super::*;
use crate::testing;
use crate::wire::schema::{GROUND_TRUTH, RUN, SCENE};

const CHUNKS: u64 = 12;
const PER_CHUNK: u64 = 7;
const ALL: u64 = CHUNKS * PER_CHUNK;

fn session(bytes: &[u8]) -> (tempfile::TempDir, Session) {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    fs::write(&path, bytes).unwrap();
    let session = Session::open(&path).unwrap();
    (tmp, session)
}

/// The sequence numbers from `t_ns` on, and whether anything could not be read.
fn seqs(session: &Session, t_ns: i64) -> (Vec<u64>, usize) {
    let poses: Vec<_> = session.poses_from(t_ns).unwrap().collect();
    let damage = poses.iter().filter(|pose| pose.is_err()).count();
    (poses.into_iter().flatten().map(|pose| pose.seq).collect(), damage)
}

/// The same by reading everything.
fn expected(t_ns: i64) -> Vec<u64> {
    (0..ALL)
        .filter(|&seq| testing::pose(seq).t_capture_ns >= t_ns)
        .collect()
}

#[test]
fn every_moment_gives_what_a_reading_of_everything_gives() {
    for bytes in [
        testing::finished(CHUNKS, PER_CHUNK),
        testing::unfinished(CHUNKS, PER_CHUNK),
    ] {
        let (_tmp, session) = session(&bytes);
        for seq in 0..=ALL + 2 {
            let t_ns = testing::pose(seq).t_capture_ns;
            for t_ns in [t_ns - 1, t_ns, t_ns + 1] {
                let (found, damage) = seqs(&session, t_ns);
                assert_eq!(found, expected(t_ns), "from {t_ns}");
                assert_eq!(damage, usize::from(!session.is_indexed()), "from {t_ns}");
            }
        }
        assert_eq!(seqs(&session, i64::MIN).0, expected(0));
        assert!(seqs(&session, i64::MAX).0.is_empty());
        let truth = session.poses_of(GROUND_TRUTH, 500_000_000).unwrap().flatten();
        assert_eq!(truth.map(|pose| pose.seq).collect::<Vec<_>>(), expected(500_000_000));
        let emitters = session.emitters_from(0).unwrap().flatten();
        assert_eq!(emitters.map(|frame| frame.seq).collect::<Vec<_>>(), expected(0));
    }
}

/// A replay went on with another recording under the first one's index, and called its poses those of the same examination.
#[test]
fn another_file_under_the_name_of_a_recording_is_refused() {
    let (tmp, session) = session(&testing::finished(CHUNKS, PER_CHUNK));
    let (path, other) = (tmp.path().join("s.mcap"), tmp.path().join("o.mcap"));
    fs::write(&other, testing::finished(CHUNKS, PER_CHUNK)).unwrap();
    // Taken away and written anew, and moved there; its own under its own name again is the same.
    let kept = tmp.path().join("kept.mcap");
    fs::rename(&path, &kept).unwrap();
    fs::rename(&other, &path).unwrap();
    let error = session.poses_from(0).err().unwrap().to_string();
    assert!(error.contains("replaced by another file"), "{error}");
    fs::remove_file(&path).unwrap();
    fs::write(&path, testing::finished(CHUNKS, PER_CHUNK)).unwrap();
    assert!(session.poses_from(0).is_err());
    fs::rename(&kept, &path).unwrap();
    assert_eq!(seqs(&session, 0).0, expected(0));
}

#[test]
fn the_index_is_used_and_the_span_is_known() {
    let (_tmp, finished) = session(&testing::finished(CHUNKS, PER_CHUNK));
    assert!(finished.is_indexed());
    let last = testing::pose(ALL - 1).t_capture_ns.cast_unsigned();
    assert_eq!(finished.span_ns(), Some((0, last)));
    // The last chunk starts far behind the first.
    let (read, length) = finished.items_from(last).unwrap().progress();
    assert!(read > length / 2, "{read} of {length}");
    let (_tmp, unfinished) = session(&testing::unfinished(CHUNKS, PER_CHUNK));
    assert!(!unfinished.is_indexed());
    assert_eq!(unfinished.span_ns(), Some((0, last)));
    let (_tmp, empty) = session(&testing::finished(0, 1));
    assert_eq!(empty.span_ns(), None);
}

#[test]
fn what_lies_beside_is_found_without_reading_the_rest() {
    for bytes in [testing::finished(3, 3), testing::unfinished(3, 3)] {
        let (_tmp, session) = session(&bytes);
        assert_eq!(session.attachment(SCENE).unwrap().as_deref(), Some(&b"seed = 1\n"[..]));
        assert_eq!(session.attachment("other").unwrap(), None);
        assert_eq!(session.metadata(RUN).unwrap(), Some(testing::facts().metadata()));
        assert_eq!(session.metadata("other").unwrap(), None);
    }
}

#[test]
fn a_file_cut_off_anywhere_gives_its_whole_chunks() {
    let bytes = testing::finished(4, 3);
    let mut most = 0;
    for cut in (8..bytes.len()).step_by(11) {
        let (_tmp, session) = session(&bytes[..cut]);
        let (found, _) = seqs(&session, 0);
        assert_eq!(found, (0..found.len() as u64).collect::<Vec<_>>(), "cut at {cut}");
        assert!(found.len() >= most && found.len() % 3 == 0, "cut at {cut}");
        most = found.len();
    }
    assert_eq!(most, 12);
}

#[test]
fn a_flipped_byte_never_panics_and_gives_no_wrong_pose() {
    let bytes = testing::finished(1, 2);
    for at in (8..bytes.len()).step_by(5) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        let (_tmp, session) = session(&flipped);
        for pose in session.poses_from(0).unwrap().flatten() {
            // A message outside a chunk is guarded by nothing that can be checked from the middle.
            assert_eq!(
                testing::bytes(&pose),
                testing::bytes(&testing::pose(pose.seq)),
                "flipped at {at}"
            );
        }
    }
}

#[test]
fn a_file_of_another_program_that_has_no_index_is_read_from_a_moment_on_too() {
    let options = mcap::WriteOptions::new().library("another program");
    let mut out = options.create(std::io::Cursor::new(Vec::new())).unwrap();
    let schema = crate::wire::descriptor::TOOL_POSE;
    let schema = out.add_schema(schema::POSE_SCHEMA, "protobuf", schema).unwrap();
    let none = std::collections::BTreeMap::new();
    let channel_id = out.add_channel(schema, TOOL_POSE, "protobuf", &none).unwrap();
    for seq in 0..ALL {
        let pose = testing::pose(seq);
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: file_time(pose.t_capture_ns),
            publish_time: file_time(pose.t_publish_ns),
        };
        let bytes = prost::Message::encode_to_vec(&crate::wire::proto::ToolPose::from(&pose));
        out.write_to_known_channel(&header, &bytes).unwrap();
        if (seq + 1).is_multiple_of(PER_CHUNK) {
            out.flush().unwrap();
        }
    }
    // Its channels are declared in the first chunk only, and it ends without an index.
    let (_tmp, session) = session(&out.into_inner().into_inner());
    assert!(!session.is_indexed());
    for t_ns in [0, 300_000_000, 900_000_000] {
        assert_eq!(seqs(&session, t_ns).0, expected(t_ns), "from {t_ns}");
    }
}
