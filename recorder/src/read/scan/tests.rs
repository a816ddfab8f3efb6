use std::io::Cursor;

use super::*;
use crate::read::reader::decode_item;
use crate::testing;
use proptest::prelude::*;

const CHUNKS: u64 = 4;
const PER_CHUNK: u64 = 6;

/// The sequence numbers of the tool's poses that can be read, and the damage.
fn read(bytes: &[u8]) -> (Vec<u64>, Vec<Damage>) {
    let (mut seqs, mut damage) = (Vec::new(), Vec::new());
    for item in Scan::new(Cursor::new(bytes), bytes.len() as u64) {
        match item {
            Ok(Item::Message(message)) if message.channel.topic == schema::TOOL_POSE => {
                // Outside a chunk nothing guards a record but the file's own CRC: an index whose opcode is flipped reads as a
                // message. What is no pose is noticed here, as it is by whoever reads poses.
                let Ok(pose) = decode_item(&message) else { continue };
                assert_eq!(testing::bytes(&pose), testing::bytes(&testing::pose(pose.seq)));
                seqs.push(pose.seq);
            }
            Ok(_) => {}
            Err(place) => damage.push(place),
        }
    }
    (seqs, damage)
}

/// Where each chunk of a file ends.
fn chunk_ends(bytes: &[u8]) -> Vec<u64> {
    let mut records = FileRecords::new(Cursor::new(bytes), bytes.len() as u64);
    let mut ends = Vec::new();
    while let Ok(Some((opcode, _))) = records.next() {
        if opcode == op::CHUNK {
            ends.push(records.at());
        }
    }
    // The first holds the schemas only.
    ends.split_off(1)
}

fn all() -> Vec<u64> {
    (0..CHUNKS * PER_CHUNK).collect()
}

#[test]
fn a_finished_file_is_whole() {
    let (seqs, damage) = read(&testing::finished(CHUNKS, PER_CHUNK));
    assert_eq!(seqs, all());
    assert!(damage.is_empty(), "{damage:?}");
}

/// Two recordings one behind the other were one that is whole.
#[test]
fn what_lies_behind_the_end_is_told() {
    let whole = testing::finished(2, 3);
    for more in [&[0][..], &[0; 5000], &whole] {
        let bytes = [&whole[..], more].concat();
        let damage: Vec<Damage> = Scan::new(&bytes[..], bytes.len() as u64)
            .filter_map(Result::err)
            .collect();
        let found = more.len() as u64;
        assert!(
            matches!(&damage[..], [Damage { fault: Fault::Behind { found: told }, stops: true, .. }] if *told == found),
            "{damage:?}"
        );
    }
}

#[test]
fn an_unfinished_file_says_so_at_its_end() {
    let bytes = testing::unfinished(CHUNKS, PER_CHUNK);
    let (seqs, damage) = read(&bytes);
    assert_eq!(seqs, all());
    assert!(
        matches!(&damage[..], [Damage { at, fault: Fault::Unfinished, stops: true, .. }] if *at == bytes.len() as u64)
    );
}

#[test]
fn cut_anywhere_every_whole_chunk_is_read() {
    let bytes = testing::finished(CHUNKS, PER_CHUNK);
    let ends = chunk_ends(&bytes);
    assert_eq!(ends.len() as u64, CHUNKS);
    for cut in (0..bytes.len()).step_by(7).chain(ends.iter().map(|&end| end as usize)) {
        let (seqs, damage) = read(&bytes[..cut]);
        let whole = ends.iter().filter(|&&end| end <= cut as u64).count() as u64;
        assert_eq!(seqs, (0..whole * PER_CHUNK).collect::<Vec<_>>(), "cut at {cut}");
        let last = damage.last().unwrap();
        assert!(last.stops && last.fault.is_mere_ending(), "cut at {cut}: {last}");
    }
}

/// Bytes from the start of a chunk to its CRC: opcode, length, two times, size.
const TO_CRC: usize = 9 + 24;

#[test]
fn a_flipped_byte_costs_its_chunk_and_is_named() {
    let whole = testing::finished(CHUNKS, PER_CHUNK);
    let ends = chunk_ends(&whole);
    let start = whole.len() - whole[ends[0] as usize..].len();
    // The message indices between two chunks are of no interest here: the next chunk is found by its opcode.
    let start = start + whole[start..].windows(4).position(|w| w == b"zstd").unwrap() - 4 - 4 - TO_CRC;
    assert_eq!(whole[start], op::CHUNK);
    for (at, words) in [
        (start + TO_CRC, "Chunk CRC failed"),
        (start + TO_CRC + 200, "damaged chunk"),
    ] {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        let (seqs, damage) = read(&bytes);
        assert_eq!(
            seqs,
            all().into_iter().filter(|seq| seq / PER_CHUNK != 1).collect::<Vec<_>>()
        );
        let texts: Vec<_> = damage.iter().map(ToString::to_string).collect();
        assert!(
            texts[0].starts_with(&format!("at byte {start}: ")) && texts[0].contains(words),
            "{texts:?}"
        );
        // Poses 6 to 11 at 60 Hz.
        let times = "numbers 6 to 11, captured from 100000000 ns to 183333333 ns";
        for topic in ["/tool_pose", "/ground_truth", "/emitters"] {
            assert!(texts[0].contains(&format!("6 of {topic} ({times})")), "{texts:?}");
        }
        assert!(texts[1].contains("Data section CRC failed"), "{texts:?}");
    }
}

#[test]
fn neighbouring_chunks_are_named_together_and_the_last_one_by_what_is_before_it() {
    let whole = testing::finished(CHUNKS, PER_CHUNK);
    let ends = chunk_ends(&whole);
    let chunk = |n: usize| ends[n] as usize - 50;
    let texts = |at: &[usize]| -> Vec<String> {
        let mut bytes = whole.clone();
        at.iter().for_each(|&at| bytes[at] ^= 0x10);
        read(&bytes).1.iter().map(ToString::to_string).collect()
    };
    let two = texts(&[chunk(1), chunk(2)]);
    assert!(two[0].contains("6 of /tool_pose (numbers 6 to 11, "), "{two:?}");
    assert!(two[1].contains("6 of /tool_pose (numbers 12 to 17, "), "{two:?}");
    let last = texts(&[chunk(3)]);
    assert!(last[0].contains("6 of /tool_pose (behind number 17, "), "{last:?}");
    let first = texts(&[chunk(0)]);
    assert!(first[0].contains("6 of /tool_pose (before number 6, "), "{first:?}");
}

#[test]
fn a_damaged_first_chunk_does_not_take_the_channels_with_it() {
    let mut bytes = testing::finished(CHUNKS, PER_CHUNK);
    let library = bytes
        .windows(LIBRARY.len())
        .position(|w| w == LIBRARY.as_bytes())
        .unwrap();
    bytes[library + LIBRARY.len() + 60] ^= 0x40;
    let (seqs, damage) = read(&bytes);
    assert_eq!(seqs, all());
    assert!(damage[0].to_string().contains("damaged chunk"), "{}", damage[0]);
}

#[test]
fn every_flipped_byte_is_noticed_or_harmless() {
    let bytes = testing::finished(2, 3);
    for at in 0..bytes.len() {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 8);
        // No wrong pose comes out: `read` compares each with the one that was written.
        read(&flipped);
    }
}

fn file_of(opcode: u8, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u64).to_le_bytes();
    [MAGIC, &[opcode], &length, body].concat()
}

#[test]
fn an_uncompressed_chunk_whose_record_overruns_it_is_refused() {
    // Times, size, no CRC, no compression, 9 bytes: a message said to have 200. They are there, behind the chunk's end:
    // taking them makes mcap's count of what is left overflow.
    let nine = 9_u64.to_le_bytes();
    let times_and_size = [&[0; 16], &nine[..]].concat();
    let message = [&[op::MESSAGE], &200_u64.to_le_bytes()[..]].concat();
    let body = [&times_and_size, &[0; 8][..], &nine, &message, &[0; 300]].concat();
    let (_, damage) = read(&file_of(op::CHUNK, &body));
    let text = damage[0].to_string();
    assert!(
        text.contains("damaged chunk: Chunk ended in the middle of a record"),
        "{text}"
    );
}

#[test]
fn an_attachment_without_room_for_its_crc_is_refused() {
    // Times, no name, no media type, no data, and then nothing: mcap's parser would cut behind the end.
    let (_, damage) = read(&file_of(op::ATTACHMENT, &[0; 32]));
    let text = damage[0].to_string();
    assert!(text.contains("ask for more than its 32 bytes"), "{text}");
}

proptest! {
    #[test]
    fn hostile_bytes_behind_the_magic_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut file = MAGIC.to_vec();
        file.extend(&bytes);
        for item in Scan::new(Cursor::new(&file), file.len() as u64) {
            drop(item);
        }
    }

    #[test]
    fn overwritten_stretches_never_panic(
        at in 0..3000_usize,
        junk in prop::collection::vec(any::<u8>(), 1..40),
    ) {
        let mut file = testing::finished(2, 3);
        let at = at % (file.len() - junk.len());
        file[at..at + junk.len()].copy_from_slice(&junk);
        for item in Scan::new(Cursor::new(&file), file.len() as u64) {
            drop(item);
        }
    }
}
