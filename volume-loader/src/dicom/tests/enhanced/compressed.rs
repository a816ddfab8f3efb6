//! Compressed frames: which fragments are whose, and tables that say something else.

use super::*;
use crate::dicom::codec::tests::whole;
use crate::dicom::syntax::{PixelCoding, Syntax};

/// How the fragments of each frame are told from the next one's.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Table {
    None,
    Basic,
    Extended,
    /// Without the lengths.
    Offsets,
}

/// Three frames, each with its pixels, its stream cut into fragments.
struct Frames {
    enhanced: Enhanced,
    want: Vec<i16>,
    fragments: Vec<Vec<Vec<u8>>>,
}

impl Frames {
    fn new(syntax: &str, pieces: usize) -> Self {
        let coding = Syntax::of(&format!("1.2.840.10008.1.2{syntax}")).unwrap().pixels;
        let mut enhanced = Enhanced::of(3);
        let (mut want, mut fragments) = (Vec::new(), Vec::new());
        for seed in 0..3 {
            let ([columns, rows], pixels, mut stream) = whole(coding, seed);
            let bits = if coding == PixelCoding::Jpeg2000 { 16 } else { 12 };
            enhanced.base.us((0x0028, 0x0010), rows).us((0x0028, 0x0011), columns);
            enhanced.base.us((0x0028, 0x0101), bits).us((0x0028, 0x0102), bits - 1);
            want.extend(pixels.iter().map(|&p| (i32::from(p) - 1024).min(32_767) as i16));
            stream.resize(stream.len().next_multiple_of(2), 0);
            let size = stream.len().div_ceil(pieces).next_multiple_of(2);
            fragments.push(stream.chunks(size).map(<[u8]>::to_vec).collect());
        }
        enhanced.base.syntax = format!("1.2.840.10008.1.2{syntax}");
        Self {
            enhanced,
            want,
            fragments,
        }
    }

    /// Offsets of the frames' first fragments, and the lengths of these.
    fn offsets(&self) -> (Vec<u64>, Vec<u64>) {
        let size = |frame: &Vec<Vec<u8>>| frame.iter().map(|fragment| 8 + fragment.len() as u64).sum::<u64>();
        let mut at = 0;
        let offsets = self.fragments.iter().map(|frame| {
            at += size(frame);
            at - size(frame)
        });
        (
            offsets.collect(),
            self.fragments.iter().map(|frame| frame[0].len() as u64).collect(),
        )
    }

    fn folder(&self, table: Table, change: impl Fn(&mut Vec<u64>, &mut Vec<u64>)) -> Folder {
        let (mut offsets, mut lengths) = self.offsets();
        change(&mut offsets, &mut lengths);
        let basic: Vec<u8> = offsets.iter().flat_map(|&o| (o as u32).to_le_bytes()).collect();
        let wide = |numbers: &[u64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
        let mut bytes = writer::item(if table == Table::Basic { &basic } else { &[] });
        self.fragments
            .iter()
            .flatten()
            .for_each(|fragment| bytes.extend(writer::item(fragment)));
        bytes.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
        let mut enhanced = self.enhanced.clone();
        enhanced.pixels = Some(Value::Raw("OB", bytes, u32::MAX));
        if [Table::Extended, Table::Offsets].contains(&table) {
            enhanced.base.raw((0x7FE0, 0x0001), "OV", &wide(&offsets));
        }
        if table == Table::Extended {
            enhanced.base.raw((0x7FE0, 0x0002), "OV", &wide(&lengths));
        }
        enhanced.folder()
    }

    fn refused(&self, table: Table, change: impl Fn(&mut Vec<u64>, &mut Vec<u64>)) -> String {
        self.folder(table, change).refused()
    }
}

#[test]
fn each_codec_and_each_table_gives_the_pixels_of_each_frame() {
    for syntax in [".5", ".4.57", ".4.70", ".4.80", ".4.90"] {
        for (table, pieces) in [
            (Table::None, 1),
            (Table::Basic, 1),
            (Table::Basic, 3),
            (Table::Extended, 1),
            (Table::Offsets, 1),
        ] {
            let frames = Frames::new(syntax, pieces);
            let folder = frames.folder(table, |_, _| ());
            let mut source = folder.open().unwrap();
            let (voxels, _) = drink(&mut source).unwrap();
            assert!(voxels == frames.want, "{syntax} {table:?} in {pieces} pieces");
        }
    }
}

#[test]
fn frames_in_several_fragments_without_a_table_are_refused() {
    let error = Frames::new(".5", 2).refused(Table::None, |_, _| ());
    assert!(
        error.contains("table of offsets") && error.contains("3, one for each frame"),
        "{error}"
    );
    let mut frames = Frames::new(".5", 1);
    frames.fragments.pop();
    let error = frames.refused(Table::None, |_, _| ());
    assert!(
        error.contains("found 2 fragments") && error.contains("expected 3 fragments"),
        "{error}"
    );
}

#[test]
fn offsets_that_are_not_those_of_fragments_are_refused() {
    for table in [Table::Basic, Table::Extended] {
        let frames = Frames::new(".5", 1);
        let error = frames.refused(table, |offsets, _| offsets[1] -= 2);
        assert!(
            error.contains("for frame 2") && error.contains("the beginning of a fragment"),
            "{error}"
        );
        let error = frames.refused(table, |offsets, _| offsets[2] = 1 << 31);
        assert!(error.contains("a fragment at each of 3 offsets"), "{error}");
        for order in [[1, 0, 2], [0, 0, 2], [0, 2, 1]] {
            let error = frames.refused(table, |offsets, _| *offsets = order.map(|k| offsets[k]).to_vec());
            assert!(error.contains("do not ascend from 0"), "{order:?}: {error}");
        }
        let error = frames.refused(table, |offsets, _| offsets.truncate(2));
        assert!(error.contains("for 3 frames"), "{error}");
        let error = frames.refused(table, |offsets, _| offsets.push(1 << 20));
        assert!(error.contains("for 3 frames"), "{error}");
    }
    let error = Frames::new(".5", 1).refused(Table::Offsets, |offsets, _| offsets[2] = u64::MAX);
    assert!(error.contains("a fragment at each of 3 offsets"), "{error}");
}

#[test]
fn an_extended_table_has_one_fragment_and_its_length_for_each_frame() {
    let error = Frames::new(".5", 2).refused(Table::Offsets, |_, _| ());
    assert!(error.contains("a fragment at each of 3 offsets"), "{error}");
    let frames = Frames::new(".5", 1);
    let error = frames.refused(Table::Extended, |_, lengths| lengths[1] += 2);
    assert!(error.contains("for frame 2, expected"), "{error}");
    let error = frames.refused(Table::Extended, |_, lengths| lengths.truncate(2));
    assert!(error.contains("16 bytes of (7FE0,0002)"), "{error}");
}

#[test]
fn two_tables_are_refused() {
    let mut frames = Frames::new(".5", 1);
    let (offsets, _) = frames.offsets();
    let wide: Vec<u8> = offsets.iter().flat_map(|offset| offset.to_le_bytes()).collect();
    frames.enhanced.base.raw((0x7FE0, 0x0001), "OV", &wide);
    let error = frames.refused(Table::Basic, |_, _| ());
    assert!(error.contains("a basic and an extended one"), "{error}");
}

#[test]
fn a_damaged_frame_is_named() {
    let mut frames = Frames::new(".5", 1);
    frames.fragments[2][0].truncate(70);
    let folder = frames.folder(Table::Basic, |_, _| ());
    let error = drink(&mut folder.open().unwrap()).unwrap_err().to_string();
    assert!(error.contains("frame 3: the RLE stream cannot be decoded"), "{error}");
}

#[test]
fn fragments_without_end_are_refused() {
    let mut frames = Frames::new(".5", 1);
    frames.fragments[2].extend(vec![Vec::new(); 1 << 20]);
    let error = frames.refused(Table::Basic, |_, _| ());
    assert!(error.contains("more than 1048576 elements"), "{error}");
}

#[test]
fn every_truncation_of_the_fragments_is_refused() {
    let folder = Frames::new(".5", 2).folder(Table::Basic, |_, _| ());
    let path = folder.path().join("many.dcm");
    let whole = std::fs::read(&path).unwrap();
    let first = whole
        .windows(4)
        .rposition(|four| four == [0xE0, 0x7F, 0x10, 0x00])
        .unwrap();
    for length in first + 12..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(folder.open().is_err(), "{length} of {}", whole.len());
    }
}
