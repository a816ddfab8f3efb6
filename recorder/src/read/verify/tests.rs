//! Files that are whole, and files that are not what they claim.

use super::*;
use crate::testing;
use crate::wire::proto::{self, Log, ProcessStatus, frame_transform_in_metres};
use crate::wire::schema;
use crate::wire::schema::Source;
use crate::write::pose_log::Entry;
use crate::write::pose_log::{self, PoseLog};
use bus::message::{Level, ToolPose};
use prost::Message as _;

fn verified(bytes: &[u8]) -> Verified {
    let tmp = tempfile::tempdir().unwrap();
    let path = tmp.path().join("s.mcap");
    std::fs::write(&path, bytes).unwrap();
    verify(&path).unwrap()
}

#[test]
fn a_whole_file_has_no_findings() {
    let found = verified(&testing::finished(3, 5));
    assert_eq!(
        (found.messages, found.attachments, found.found),
        (15 * 5, 1, 0),
        "{:?}",
        found.findings
    );
}

#[test]
fn every_flipped_bit_of_the_data_is_found() {
    let bytes = testing::finished(2, 4);
    let data = bytes.windows(4).rposition(|w| w == b"zstd").unwrap();
    for at in 8..data {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(verified(&flipped).found > 0, "byte {at}");
    }
}

/// Where each chunk has the name of its compression.
fn compressed(bytes: &[u8]) -> Vec<usize> {
    let words = bytes.windows(4).enumerate();
    words.filter(|(_, w)| w == b"zstd").map(|(at, _)| at).collect()
}

#[test]
fn a_chunk_whose_head_is_flipped_is_named_with_its_messages() {
    let bytes = testing::finished(3, 5);
    // The chunk of poses 5 to 9: its opcode, and a byte of its length.
    let chunks = compressed(&bytes);
    // Opcode, length, two times, size, CRC, length of this word. The first chunk holds the schemas.
    let head = chunks[2] - (1 + 8 + 16 + 8 + 4 + 4);
    for (at, bit) in [(head, 0x40), (head + 1 + 3, 0x20)] {
        let mut flipped = bytes.clone();
        flipped[at] ^= bit;
        let found = verified(&flipped).findings.join("\n");
        let words = format!("the chunk that the index has at byte {head} is not readable; lost are 5 of /tool_pose");
        assert!(found.contains(&words), "{found}");
        assert!(found.contains("captured from 83333333 ns to 150000000 ns"), "{found}");
    }
}

#[test]
fn every_flipped_bit_of_a_chunks_content_names_its_messages() {
    let bytes = testing::finished(3, 2);
    let chunks = compressed(&bytes);
    // Behind the word is the length of what is compressed.
    let from = chunks[2] + 4;
    let length = u64::from_le_bytes(bytes[from..from + 8].try_into().unwrap()) as usize;
    let (whole, mut harmless) = (verified(&bytes).messages, 0);
    for at in from + 8..from + 8 + length {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        let found = verified(&flipped);
        // A bit that the compression does not need: every message is there, and only the sum over the file is wrong.
        if found.messages == whole {
            harmless += 1;
            continue;
        }
        let found = found.findings.join("\n");
        let words = "2 of /tool_pose (numbers 2 to 3, captured from 33333333 ns to 50000000 ns)";
        assert!(found.contains(words), "byte {at}: {found}");
    }
    assert!(harmless < length / 10, "{harmless} of {length}");
}

#[test]
fn an_attachment_whose_bytes_changed_is_named() {
    let mut bytes = testing::finished(1, 1);
    let at = bytes.windows(8).position(|w| w == b"seed = 1").unwrap();
    bytes[at] ^= 1;
    let found = verified(&bytes).findings;
    assert!(
        found[0].contains("damaged attachment") && found[0].contains("CRC"),
        "{found:?}"
    );
}

#[test]
fn messages_out_of_order_are_named() {
    let mut log = testing::log(1, 3);
    let mut early = testing::pose(3);
    early.t_capture_ns = 5;
    log.put(Entry::Pose(Source::Tool, &early)).unwrap();
    log.put(Entry::Pose(Source::Tool, &early)).unwrap();
    let found = verified(&log.finish().unwrap().into_inner()).findings;
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found[0].starts_with("message 4 of /tool_pose (number 3): captured at 5 ns, before number 2"),
        "{found:?}"
    );
    assert!(found[1].contains("the number of the one before it"), "{found:?}");
}

/// The file without its index, as a program would write it that writes none; the sum over its data stays right.
fn without_index(bytes: &[u8]) -> Vec<u8> {
    let footer = bytes.len() - 8 - 20;
    let start = u64::from_le_bytes(bytes[footer..footer + 8].try_into().unwrap()) as usize;
    let head = [&[2][..], &20_u64.to_le_bytes(), &[0; 16]].concat();
    let sum = crc32fast::hash(&head);
    [&bytes[..start], &head, &sum.to_le_bytes(), mcap::MAGIC].concat()
}

#[test]
fn only_what_trocar_wrote_must_have_an_index() {
    let bytes = without_index(&testing::finished(2, 4));
    let found = verified(&bytes).findings;
    assert_eq!(found, ["the file has no index, and Trocar's recorder writes one"]);
    // The same of another program: its name is in the header, and the sum over the data at their end.
    let mut other = bytes;
    let name = other
        .windows(LIBRARIES.len())
        .position(|w| w == LIBRARIES.as_bytes())
        .unwrap();
    other[name..name + 6].copy_from_slice(b"tricar");
    let end = other.len() - 8 - 29 - 4;
    let sum = crc32fast::hash(&other[..end - 9]);
    other[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    let found = verified(&other);
    assert_eq!(
        (found.found, found.left_out),
        (0, vec!["it has no index".to_owned()]),
        "{:?}",
        found.findings
    );
}

#[test]
fn what_is_no_file_is_refused_at_once() {
    let tmp = tempfile::tempdir().unwrap();
    let pipe = tmp.path().join("pipe.mcap");
    let (kind, mode) = (rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR);
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).unwrap();
    for (path, words) in [
        (pipe.as_path(), "this is a pipe"),
        (Path::new("/dev/zero"), "this is a device"),
    ] {
        let said = verify(path).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
        assert!(crate::read::seek::Session::open(path).is_err() && crate::read::info::info(path).is_err());
        assert!(crate::edit::import::import(path, None, &tmp.path().join("out.mcap"), false).is_err());
        assert!(crate::write::beside::read(path).is_err());
    }
}

#[test]
fn an_unfinished_file_says_so() {
    let found = verified(&testing::unfinished(2, 2)).findings;
    assert!(
        found[0].contains("never finished") && found[1].contains("no index"),
        "{found:?}"
    );
}

/// Such a file was whole, and `pilot replay` ended with the last chunk that is said to hold poses.
#[test]
fn lists_that_name_other_channels_are_found() {
    let found = verified(&testing::swapped_lists()).findings;
    let words = [
        "the list behind it has 0 messages of /tool_pose, and there are 5",
        "the list behind it has 5 messages of /status, and there are 0",
        "the list behind it has 5 messages of /tool_pose, and there are 0",
        "the list behind it has 0 messages of /status, and there are 5",
    ];
    assert_eq!(found.len(), 4, "{found:?}");
    for words in words {
        assert_eq!(
            found.iter().filter(|found| found.ends_with(words)).count(),
            1,
            "{words}: {found:?}"
        );
    }
}

/// Every byte of the index and of the lists, with right sums: nothing that it says of a chunk is believed.
#[test]
fn no_byte_of_an_index_or_of_a_list_is_wrong_unsaid() {
    let bytes = testing::finished(2, 3);
    let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
    let summary = {
        let footer = bytes.len() - 8 - 20;
        u64::from_le_bytes(bytes[footer..footer + 8].try_into().unwrap()) as usize
    };
    let lists = chunks.iter().flat_map(|chunk| {
        let from = chunk.chunk_start_offset + chunk.chunk_length;
        from as usize..(from + chunk.message_index_length) as usize
    });
    let indexes = bytes[summary..].windows(8).enumerate().filter_map(|(at, window)| {
        let is_index = chunks.iter().any(|chunk| (chunk.chunk_length).to_le_bytes() == window);
        // Two times, two places of 8 bytes before; the lists, their length, the compression, two sizes behind.
        is_index.then_some(summary + at - 24..summary + at + 8)
    });
    let places: Vec<usize> = lists.chain(indexes.flatten()).collect();
    assert!(places.len() > 300, "{}", places.len());
    for at in places {
        let mut other = bytes.clone();
        other[at] ^= 1;
        assert!(verified(&testing::sealed(other)).found > 0, "byte {at}");
    }
}

/// Poses that were written backwards, or two that changed places, were taken for a tracker that began anew.
#[test]
fn poses_in_another_order_are_no_restart() {
    for order in [[4, 3, 2, 1, 0], [0, 2, 1, 3, 4]] {
        let mut log = testing::log(0, 1);
        order
            .into_iter()
            .for_each(|seq| log.pose(Source::Tool, &testing::pose(seq)).unwrap());
        let found = verified(&log.finish().unwrap().into_inner()).findings;
        assert!(
            found[0].contains("ns, before number 2 at") || found[0].contains("before number 4"),
            "{found:?}"
        );
    }
    // One that did begin anew, later.
    let mut log = testing::log(1, 3);
    for seq in 0..3 {
        let again = ToolPose {
            seq,
            ..testing::pose(seq + 10)
        };
        log.pose(Source::Tool, &again).unwrap();
    }
    let found = verified(&log.finish().unwrap().into_inner());
    assert_eq!(found.found, 0, "{:?}", found.findings);
}

/// A file of this recorder's with one message of these bytes on one of its channels.
fn with(channel: u16, t_ns: u64, data: &[u8]) -> Vec<u8> {
    let mut mcap = pose_log::options(scene::Compression::None)
        .create(std::io::Cursor::new(Vec::new()))
        .unwrap();
    for (id, name, data) in schema::schemas() {
        mcap.add_schema_with_id(id, name, "protobuf", data).unwrap();
    }
    let views = schema::view_channels(["axial"].into_iter());
    for it in schema::channels().into_iter().chain(views) {
        mcap.add_channel_with_id(it.id, it.schema_id, &it.topic, &it.message_encoding, &it.metadata)
            .unwrap();
    }
    let header = mcap::records::MessageHeader {
        channel_id: channel,
        sequence: 0,
        log_time: t_ns,
        publish_time: t_ns,
    };
    mcap.write_to_known_channel(&header, data).unwrap();
    mcap.finish().unwrap();
    mcap.into_inner().into_inner()
}

/// Only poses and what they are made of were looked into.
#[test]
fn bytes_that_are_no_message_are_found_on_every_topic() {
    let ids = schema::channels()
        .into_iter()
        .map(|channel| (channel.id, channel.topic));
    for (id, topic) in ids.chain([(schema::VIEW_CHANNEL, format!("{}axial", schema::VIEW))]) {
        let found = verified(&with(id, 0, &[0xff; 40])).findings;
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with(&format!("message 1 of {topic}")), "{found:?}");
    }
}

/// A report spoke of a run of 1e9 s.
#[test]
fn a_stamp_that_is_not_that_of_its_message_or_of_no_run_is_found() {
    let t_ns = 1_u64 << 60;
    let log = |at_ns: u64| {
        let log = Log::new(at_ns.cast_signed(), Level::Info, "pilot", "here".to_owned());
        verified(&with(schema::LOG_CHANNEL, t_ns, &log.encode_to_vec())).findings
    };
    assert!(log(5)[0].contains("instead of 5 ns and any time"), "{:?}", log(5));
    assert!(log(t_ns)[0].contains("more than 100 days behind"), "{:?}", log(t_ns));
    let status = ProcessStatus {
        t_ns: 5,
        ..ProcessStatus::default()
    };
    let found = |t_ns| verified(&with(schema::STATUS_CHANNEL, t_ns, &status.encode_to_vec())).findings;
    assert!(found(6)[0].contains("instead of 5 ns and 5 ns"), "{:?}", found(6));
    assert!(found(5).is_empty());
}

/// Each choice holds from its moment on: the last of the file is not the last that was made.
#[test]
fn choices_in_another_order_are_found() {
    let mut log = testing::log(0, 1);
    for t_ns in [7, 5] {
        let guide = proto::Guide::from(&bus::message::Guide {
            t_ns,
            ..bus::message::Guide::default()
        });
        log.put(Entry::Guide(9, &guide)).unwrap();
    }
    let found = verified(&log.finish().unwrap().into_inner()).findings;
    assert_eq!(
        found,
        ["message 2 of /guide: it is of 5 ns, and the one before it of 7 ns"]
    );
}

/// Foxglove draws the tool where this says.
#[test]
fn a_transform_that_is_not_that_of_its_pose_is_found() {
    let bytes = testing::finished(1, 1);
    let transform = frame_transform_in_metres(&testing::pose(0), "tool").unwrap();
    let x = transform.translation.unwrap().x.to_le_bytes();
    let log = {
        let mut log = PoseLog::new(std::io::Cursor::new(Vec::new()), scene::Compression::None, &[]).unwrap();
        log.pose(Source::Tool, &testing::pose(0)).unwrap();
        log.finish().unwrap().into_inner()
    };
    assert_eq!(verified(&bytes).found + verified(&log).found, 0);
    let at = log.windows(8).position(|window| window == x).unwrap();
    let mut other = log;
    other[at] ^= 1;
    // The sum over the chunk is left out, as the format allows.
    let found = verified(&without_chunk_sums(other)).findings;
    assert!(
        found[0].starts_with("message 1 of /tf: it is not pose 0 of tool"),
        "{found:?}"
    );
}

/// The file with no sums over its chunks, and right ones over the rest.
fn without_chunk_sums(mut bytes: Vec<u8>) -> Vec<u8> {
    for chunk in mcap::Summary::read(&bytes).ok().flatten().unwrap().chunk_indexes {
        let at = chunk.chunk_start_offset as usize + 9 + 16 + 8;
        bytes[at..at + 4].fill(0);
    }
    testing::sealed(bytes)
}
