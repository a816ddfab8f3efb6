//! Compressed pixels in fragments.

use super::*;

const RLE: &str = ".5";
const PIXELS: usize = 12;

/// RLE of pixels below 256: one run of zeros, and literals.
fn rle(pixels: [u8; PIXELS]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for word in [2_u32, 64, 66].into_iter().chain([0; 13]) {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend([(257 - PIXELS) as u8, 0, PIXELS as u8 - 1]);
    bytes.extend(pixels);
    bytes.push(0);
    bytes
}

/// Three slices, each in this many fragments.
fn files(fragments: usize) -> Vec<File> {
    let mut files = stack(3);
    for (k, file) in files.iter_mut().enumerate() {
        let stream = rle(std::array::from_fn(|i| (50 * k + i) as u8));
        let parts: Vec<&[u8]> = stream
            .chunks(stream.len().div_ceil(fragments).next_multiple_of(2))
            .collect();
        file.fragments(RLE, &parts);
    }
    files
}

fn refused(change: impl Fn(&mut Vec<u8>)) -> String {
    let mut files = files(1);
    for file in &mut files {
        if let Some((_, Value::Raw(_, bytes, _))) = file.elements.iter_mut().find(|row| row.0.0 == 0x7FE0) {
            change(bytes);
        }
    }
    Folder::of(&files).refused()
}

#[test]
fn fragments_are_joined() {
    for count in [1, 2, 5] {
        let folder = Folder::of(&files(count));
        let mut source = folder.open().unwrap();
        assert_eq!(source.series_facts().codec, "RLE lossless");
        let (voxels, _) = drink(&mut source).unwrap();
        let want: Vec<i16> = (0..36).map(|i| 50 * (i / 12) + i % 12 - 1024).collect();
        assert_eq!(voxels, want, "{count} fragments");
    }
}

#[test]
fn broken_fragments_are_refused_by_name() {
    let error = refused(|bytes| bytes.truncate(8));
    assert!(
        error.contains("the file ends in element (7FE0,0010) PixelData"),
        "{error}"
    );
    let error = refused(|bytes| bytes.truncate(60));
    assert!(error.contains("the file ends in element"), "{error}");
    // A fragment of 4 GiB.
    let error = refused(|bytes| bytes[12..16].copy_from_slice(&[0xFE, 0xFF, 0xFF, 0xFF]));
    assert!(error.contains("the file ends in element"), "{error}");
    let error = refused(|bytes| bytes[8] = 7);
    assert!(error.contains("closes nothing that is open there"), "{error}");
    let error = refused(|bytes| {
        bytes.drain(8..bytes.len() - 8);
    });
    assert!(error.contains("empty"), "{error}");
    // A stream that ends before its pixels.
    let error = refused(|bytes| bytes[16 + 66] = 1);
    assert!(error.contains("RLE stream cannot be decoded: segment 1"), "{error}");
}

#[test]
fn every_truncation_of_a_compressed_file_is_refused() {
    let whole = files(2)[1].bytes();
    let folder = Folder::of(&[files(2)[0].clone(), files(2)[2].clone()]);
    for length in 300..whole.len() {
        folder.put("cut.dcm", &whole[..length]);
        let read = folder.open().and_then(|mut source| {
            drink(&mut source).map_err(|error| match error {
                ReadError::Dicom(error) => *error,
                other => panic!("{other}"),
            })
        });
        assert!(read.is_err(), "{length} of {}", whole.len());
    }
}

#[test]
fn compression_with_loss_is_said() {
    let mut files = files(1);
    assert!(!Folder::of(&files).open().unwrap().describe().contains("with loss"));
    files[1].text((0x0028, 0x2110), "CS", "01");
    let told = Folder::of(&files).open().unwrap().describe();
    assert!(told.contains("warning: the slices were compressed with loss"), "{told}");
}
