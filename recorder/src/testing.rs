//! Poses and files for the tests.

use std::io::Cursor;

use bus::message::{EmitterFrame, EmitterSight, ToolPose, Tracked, UsImageHeader};
use geometry::{Ct, Rigid, Tool, Vector};
use scene::Compression;

use crate::wire::proto;
use crate::wire::schema::{RunFacts, STATUS_CHANNEL, Source};
use crate::write::pose_log::{Entry, PoseLog};

/// The pose of sample `seq` at 60 Hz; every field differs from zero and from the others.
pub(crate) fn pose(seq: u64) -> ToolPose {
    let s = seq as f64 / 60.0;
    let ct_from_tool: Rigid<Ct, Tool> = Rigid::from_rotation_vector(
        Vector::new(0.3 * s.sin(), -1.2, 0.7),
        Vector::new(12.5, -40.0 + 10.0 * s.cos(), 300.0 - s),
    )
    .unwrap();
    let t_ns = bus::clock::seconds(s);
    let mut pose = ToolPose {
        seq,
        t_device_ns: t_ns + 1,
        t_capture_ns: t_ns,
        t_publish_ns: t_ns + 1_500_000,
        registration_id: 0xfeed_0000_0000_0042,
        visible: 24,
        fre_rms_mm: 0.21 + 0.01 * s.sin(),
        tip_mm: 0.9 + 0.01 * s.cos(),
        delay_ns: 12,
        used: 23,
        flags: ToolPose::TIP_KNOWN,
        covariance: std::array::from_fn(|i| 1e-4 * (i as f64 + 1.0)),
        ..ToolPose::EMPTY
    };
    pose.set(Tracked::Valid(ct_from_tool));
    pose
}

/// What the localizer saw for sample `seq`: every third emitter of 24, and two on the patient.
pub(crate) fn frame(seq: u64) -> EmitterFrame {
    let sight = |emitter: u32| EmitterSight {
        place_mm: [f64::from(emitter).sin(), -40.5, 2000.0 + seq as f64 / 7.0],
        emitter,
        reserved: 0,
    };
    let pose = pose(seq);
    let mut frame = EmitterFrame {
        seq,
        t_device_ns: pose.t_device_ns,
        t_capture_ns: pose.t_capture_ns,
        t_publish_ns: pose.t_publish_ns,
        ..EmitterFrame::EMPTY
    };
    let tool: Vec<_> = (0..24).filter(|i| i % 3 == 0).map(sight).collect();
    frame.set(tool.into_iter(), [sight(1), sight(2)].into_iter()).unwrap();
    frame
}

/// An ultrasound image that was published `after_ns` behind pose `seq`: 5 x 4 pixels, each image of its own.
pub(crate) fn us_frame(number: u64, seq: u64, after_ns: i64) -> proto::UsFrame {
    let pose = pose(seq);
    let header = UsImageHeader {
        seq: number,
        t_device_ns: -7,
        t_capture_ns: pose.t_capture_ns + after_ns,
        t_arrival_ns: pose.t_publish_ns + after_ns - 1,
        t_publish_ns: pose.t_publish_ns + after_ns,
        pixel_mm: [0.1, 0.2],
        depth_mm: 45.0,
        beams: [0.0, 40.0, -0.0, 0.0],
        array: UsImageHeader::LINEAR,
        clock: 0,
        width: 5,
        height: 4,
        ..UsImageHeader::default()
    };
    proto::UsFrame {
        header: header.with_device("simulated"),
        grey: (0..20).map(|i| (number * 31 + i) as u8).collect(),
    }
}

/// The fields of a message as bits, in order: equality that tells NaNs and zeros apart.
pub(crate) fn bytes(pose: &ToolPose) -> Vec<u64> {
    let mut bits = vec![
        pose.seq,
        pose.t_device_ns.cast_unsigned(),
        pose.t_capture_ns.cast_unsigned(),
    ];
    bits.extend([pose.t_publish_ns.cast_unsigned(), pose.registration_id]);
    bits.extend([pose.status, pose.visible, pose.used, pose.flags].map(u64::from));
    bits.push(pose.delay_ns.cast_unsigned());
    let doubles = pose.q.iter().chain(&pose.t_mm).chain(&pose.covariance);
    bits.extend(doubles.chain([&pose.fre_rms_mm, &pose.tip_mm]).map(|x| x.to_bits()));
    bits
}

/// The facts of a run.
pub(crate) fn facts() -> RunFacts {
    RunFacts {
        name: "demo".to_owned(),
        epoch_ns: 123_456,
        registration_id: None,
        volume_hash: None,
        remade_from: None,
    }
}

/// A log in memory with `chunks` chunks of `per_chunk` poses, truths and frames of emitters each, scene and facts in front.
pub(crate) fn log(chunks: u64, per_chunk: u64) -> PoseLog<Cursor<Vec<u8>>> {
    let mut log = PoseLog::new(Cursor::new(Vec::new()), Compression::Zstd, &[]).unwrap();
    log.scene("seed = 1\n", 0).unwrap();
    log.facts(&facts()).unwrap();
    log.flush().unwrap();
    for seq in 0..chunks * per_chunk {
        log.pose(Source::Tool, &pose(seq)).unwrap();
        log.pose(Source::Truth, &pose(seq)).unwrap();
        let emitters = proto::EmitterFrame::try_from(&frame(seq)).unwrap();
        log.put(Entry::Emitters(&emitters)).unwrap();
        if (seq + 1) % per_chunk == 0 {
            log.flush().unwrap();
        }
    }
    log
}

/// The bytes of a finished file of such a log.
pub(crate) fn finished(chunks: u64, per_chunk: u64) -> Vec<u8> {
    log(chunks, per_chunk).finish().unwrap().into_inner()
}

/// A file of three chunks of five poses, of which the second cannot be read.
pub(crate) fn damaged() -> Vec<u8> {
    let mut bytes = finished(3, 5);
    // The chunk of the schemas comes first. Behind the word is the length of what is compressed.
    let word = bytes.windows(4).enumerate().filter(|(_, w)| w == b"zstd").nth(2);
    let at = word.unwrap().0 + 4 + 8 + 10;
    bytes[at] ^= 1;
    bytes
}

/// The bytes of an unfinished file of such a log, as a kill leaves it right after a chunk.
pub(crate) fn unfinished(chunks: u64, per_chunk: u64) -> Vec<u8> {
    log(chunks, per_chunk).abandon().into_inner()
}

/// A file with five poses in its last chunk but one and five states of processes in its last, and each chunk's list says that it
/// holds the other's: the sums over the file are right.
pub(crate) fn swapped_lists() -> Vec<u8> {
    let mut log = log(2, 5);
    (10..15).for_each(|seq| log.pose(Source::Tool, &pose(seq)).unwrap());
    log.flush().unwrap();
    for k in 0..5 {
        let status = proto::ProcessStatus {
            t_ns: pose(15 + k).t_capture_ns,
            ..proto::ProcessStatus::default()
        };
        log.put(Entry::Status(&status)).unwrap();
    }
    let mut bytes = log.finish().unwrap().into_inner();
    let [tool, status] = [Source::Tool.channel(), STATUS_CHANNEL];
    let mut chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    for (chunk, from, to) in chunks
        .iter()
        .rev()
        .zip([(status, tool), (tool, status)])
        .map(|(c, (f, t))| (c, f, t))
    {
        let list = chunk.message_index_offsets[&from];
        let named = [&from.to_le_bytes()[..], &list.to_le_bytes()].concat();
        let in_index = bytes.windows(10).rposition(|window| window == named).unwrap();
        for at in [list as usize + 9, in_index] {
            bytes[at..at + 2].copy_from_slice(&to.to_le_bytes());
        }
    }
    sealed(bytes)
}

/// The file with right sums over its data and its index.
pub(crate) fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let footer = bytes.len() - mcap::MAGIC.len() - 20;
    let start = u64::from_le_bytes(bytes[footer..footer + 8].try_into().unwrap()) as usize;
    let data_end = start - (1 + 8 + 4);
    for (from, sum_at) in [(0, data_end + 9), (start, footer + 16)] {
        let end = if from == 0 { data_end } else { sum_at };
        let sum = crc32fast::hash(&bytes[from..end]);
        bytes[sum_at..sum_at + 4].copy_from_slice(&sum.to_le_bytes());
    }
    bytes
}
