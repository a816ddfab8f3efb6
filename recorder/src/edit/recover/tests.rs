use super::*;
use crate::read::reader;
use crate::testing;
use crate::wire::schema::{LIBRARY, TOOL_POSE};
use mcap::records::MessageHeader;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::io::Cursor;

fn recovered(bytes: &[u8]) -> (Vec<u8>, Info) {
    let scan = Scan::new(Cursor::new(bytes), bytes.len() as u64);
    let (out, info) = copy_into(scan, Path::new("s.mcap"), Cursor::new(Vec::new())).unwrap();
    (out.into_inner(), info)
}

fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap.recording");
    fs::write(&path, bytes).unwrap();
    (tmp, path)
}

#[test]
fn cut_anywhere_the_result_is_whole_and_holds_every_whole_chunk() {
    let bytes = testing::finished(4, 6);
    let (tmp, input) = written(&bytes);
    let out = tmp.path().join("out.mcap");
    let mut most = 0;
    for cut in (8..bytes.len()).step_by(97) {
        fs::write(&input, &bytes[..cut]).unwrap();
        let info = recover(&input, &out).unwrap();
        assert!(info.is_intact(), "cut at {cut}: {:?}", info.damage);
        let poses: Result<Vec<_>, _> = reader::poses(&out, TOOL_POSE).unwrap().collect();
        let poses = poses.unwrap();
        assert_eq!(poses, (0..poses.len() as u64).map(testing::pose).collect::<Vec<_>>());
        assert!(
            poses.len() >= most && poses.len() % 6 == 0,
            "cut at {cut}: {}",
            poses.len()
        );
        most = poses.len();
        let again = crate::read::info::info(&out).unwrap();
        assert!(again.damage.is_empty(), "cut at {cut}: {:?}", again.damage);
        assert_eq!(again.tally, info.tally);
    }
    assert_eq!(most, 24);
}

#[test]
fn attachments_metadata_and_empty_channels_are_kept() {
    let (tmp, input) = written(&testing::unfinished(0, 1));
    let out = target(&input, None, false).unwrap();
    assert_eq!(out, tmp.path().join("s.mcap"));
    let info = recover(&input, &out).unwrap();
    assert_eq!(
        (info.tally.messages(), info.tally.topics.len()),
        (0, crate::wire::schema::channels().len())
    );
    let beside = reader::beside(&out).unwrap();
    assert_eq!(beside.scene.as_deref(), Some("seed = 1\n"));
    assert_eq!(beside.run, Some(testing::facts().metadata()));
}

#[test]
fn nothing_is_overwritten_unasked() {
    let (tmp, input) = written(&testing::unfinished(1, 1));
    let out = tmp.path().join("s.mcap");
    fs::write(&out, "precious").unwrap();
    assert!(matches!(target(&input, None, false), Err(RecoverError::Exists(_))));
    assert!(matches!(target(&out, None, false), Err(RecoverError::NoName(_))));
    assert!(matches!(
        target(&input, Some(input.clone()), true),
        Err(RecoverError::Itself(_))
    ));
    assert_eq!(target(&input, None, true).unwrap(), out);
}

#[test]
fn a_failed_copy_leaves_no_half_file() {
    let (tmp, input) = written(&testing::unfinished(1, 1));
    let out = tmp.path().join("missing/out.mcap");
    let text = recover(&input, &out).unwrap_err().to_string();
    assert!(text.contains("missing/out.mcap.partial: No such file"), "{text}");
    fs::write(&input, "").unwrap();
    let text = recover(&input, &tmp.path().join("o.mcap")).unwrap_err().to_string();
    assert!(text.contains("is not an MCAP file"), "{text}");
    assert_eq!(fs::read_dir(tmp.path()).unwrap().count(), 1);
}

#[test]
fn a_file_that_contradicts_the_built_in_schemas_is_named_and_does_no_harm() {
    let mut out = mcap::WriteOptions::new()
        .library(LIBRARY)
        .create(Cursor::new(Vec::new()))
        .unwrap();
    out.add_schema_with_id(1, "other", "protobuf", &[]).unwrap();
    let none = BTreeMap::new();
    out.add_channel_with_id(1, 1, "/tool_pose", "protobuf", &none).unwrap();
    let header = MessageHeader {
        channel_id: 1,
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    out.write_to_known_channel(&header, &[]).unwrap();
    out.flush().unwrap();
    let mut bytes = out.into_inner().into_inner();
    let (_, whole) = recovered(&bytes);
    assert_eq!(whole.tally.messages(), 1);
    // The same, with chunks off, so that the channel's own record can be taken out of the file.
    let options = mcap::WriteOptions::new().library(LIBRARY).use_chunks(false);
    let mut out = options.create(Cursor::new(Vec::new())).unwrap();
    out.add_schema_with_id(1, "other", "protobuf", &[]).unwrap();
    out.add_channel_with_id(1, 1, "/tool_pose", "protobuf", &none).unwrap();
    out.write_to_known_channel(&header, &[]).unwrap();
    bytes = out.into_inner().into_inner();
    let topic = bytes.windows(10).position(|w| w == b"/tool_pose").unwrap();
    // Opcode, length, id, schema, length of the topic: an opcode that nobody knows.
    bytes[topic - 4 - 4 - 8 - 1] = 0x70;
    let (_, info) = recovered(&bytes);
    assert_eq!(info.tally.messages(), 0);
    assert!(
        info.damage[0]
            .to_string()
            .contains("damaged schema: Schema `trocar.ToolPose`"),
        "{}",
        info.damage[0]
    );
}

proptest! {
    #[test]
    fn overwritten_stretches_are_left_out_and_the_rest_is_whole(
        at in any::<prop::sample::Index>(),
        junk in prop::collection::vec(any::<u8>(), 1..40),
    ) {
        let mut bytes = testing::finished(3, 3);
        let start = 8 + at.index(bytes.len() - 8 - junk.len());
        bytes[start..start + junk.len()].copy_from_slice(&junk);
        let (out, _) = recovered(&bytes);
        let (_, again) = recovered(&out);
        prop_assert!(again.damage.is_empty());
    }
}
