//! Streams made by hand and by encoders of our own, for tests only; damaged streams of every codec.

mod encoders;

use proptest::prelude::*;

use super::*;
use encoders::{jpeg_lossless, jpeg_ls, rle};

const COLUMNS: u16 = 13;
const ROWS: u16 = 9;

fn image(bits: u16) -> Image {
    Image {
        columns: COLUMNS,
        rows: ROWS,
        allocated: 16,
        high_bit: bits - 1,
        signed: false,
    }
}

/// Smooth with noise, within `bits` bits.
fn pixels(bits: u16, seed: u32) -> Vec<u16> {
    noisy(u32::from(COLUMNS) * u32::from(ROWS), bits, seed)
}

fn noisy(count: u32, bits: u16, seed: u32) -> Vec<u16> {
    let noise = |i: u32| (i + 7 * seed).wrapping_mul(2_654_435_761) >> 20;
    let most = (1_u32 << bits) - 1;
    let value = |i: u32| {
        if i % 31 == 30 {
            noise(i) * 97
        } else {
            i * 5 + noise(i) % 9
        }
    };
    (0..count).map(|i| (value(i) & most) as u16).collect()
}

/// 40 x 36 pixels, `noisy(1440, 16, 2)`, in reversible JPEG 2000 by OpenJPEG 2.5; the second with 32000 taken off, signed;
/// the third lossy. OpenJPEG's usual encoder makes none that are smaller.
const J2K: &[u8] = include_bytes!("tests/openjpeg_16_bits.j2k");
const J2K_SIGNED: &[u8] = include_bytes!("tests/openjpeg_16_bits_signed.j2k");
const J2K_LOSSY: &[u8] = include_bytes!("tests/openjpeg_lossy.j2k");

/// Columns, rows, pixels and their stream, for tests of whole files: 12 bits, in JPEG 2000 always the same 16.
pub(in crate::dicom) fn whole(coding: PixelCoding, seed: u32) -> ([u16; 2], Vec<u16>, Vec<u8>) {
    let pixels = pixels(12, seed);
    let stream = match coding {
        PixelCoding::Rle => rle(&pixels),
        PixelCoding::JpegLossless => jpeg_lossless(&pixels, 12, 1, 0, 0),
        PixelCoding::JpegLs => jpeg_ls(&pixels),
        PixelCoding::Jpeg2000 => return ([40, 36], noisy(1440, 16, 2), J2K.to_vec()),
        PixelCoding::Native => pixels.iter().flat_map(|p| p.to_le_bytes()).collect(),
    };
    ([COLUMNS, ROWS], pixels, stream)
}

fn j2k_image() -> Image {
    Image {
        columns: 40,
        rows: 36,
        ..image(16)
    }
}

proptest! {
    #[test]
    fn rle_round_trip(seed: u32, bits in 8_u16..=16) {
        let pixels = pixels(bits, seed % 1000);
        prop_assert_eq!(decode(PixelCoding::Rle, &rle(&pixels), &image(bits)).unwrap(), pixels);
    }

    #[test]
    fn jpeg_lossless_round_trip(
        seed in 0..1000_u32,
        precision in 2_u8..=16,
        selection in 1_u8..=7,
        shift in 0_u8..3,
        rows_between in 0_u16..4,
    ) {
        let shift = shift.min(precision - 1);
        let pixels: Vec<u16> = pixels(precision.into(), seed).iter().map(|p| p >> shift << shift).collect();
        let stream = jpeg_lossless(&pixels, precision, selection, shift, rows_between);
        let decoded = decode(PixelCoding::JpegLossless, &stream, &image(precision.into()));
        prop_assert_eq!(decoded.unwrap(), pixels);
    }

    #[test]
    fn jpeg_ls_round_trip(seed in 0..1000_u32, bits in 9_u16..=16) {
        let pixels = pixels(bits, seed);
        let decoded = decode(PixelCoding::JpegLs, &jpeg_ls(&pixels), &image(8));
        prop_assert_eq!(decoded.unwrap(), pixels);
    }

    #[test]
    fn damaged_streams_never_panic(at: usize, flip in 1..=255_u8, codec in 0..4_usize) {
        let pixels = pixels(12, 3);
        let (coding, mut stream) = [
            (PixelCoding::Rle, rle(&pixels)),
            (PixelCoding::JpegLossless, jpeg_lossless(&pixels, 12, 6, 0, 0)),
            (PixelCoding::JpegLs, jpeg_ls(&pixels)),
            (PixelCoding::Jpeg2000, J2K.to_vec()),
        ][codec].clone();
        let at = at % stream.len();
        stream[at] ^= flip;
        let size = if coding == PixelCoding::Jpeg2000 { j2k_image() } else { image(12) };
        let _ = decode(coding, &stream, &size);
        let _ = is_lossy(coding, &stream);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), codec in 0..4_usize) {
        let codings = [PixelCoding::Rle, PixelCoding::JpegLossless, PixelCoding::JpegLs, PixelCoding::Jpeg2000];
        prop_assert!(decode(codings[codec], &bytes, &image(12)).is_err());
        let _ = is_lossy(codings[codec], &bytes);
    }
}

#[test]
fn every_truncation_is_refused() {
    let pixels = pixels(12, 5);
    let streams = [
        (PixelCoding::Rle, rle(&pixels)),
        (PixelCoding::JpegLossless, jpeg_lossless(&pixels, 12, 1, 0, 0)),
        (PixelCoding::JpegLossless, jpeg_lossless(&pixels, 12, 7, 0, 2)),
        (PixelCoding::JpegLs, jpeg_ls(&pixels)),
        (PixelCoding::Jpeg2000, J2K.to_vec()),
    ];
    for (coding, stream) in streams {
        let size = if coding == PixelCoding::Jpeg2000 {
            j2k_image()
        } else {
            image(12)
        };
        decode(coding, &stream, &size).unwrap();
        // The byte that makes RLE's length even may go.
        for length in 0..stream.len() - 1 {
            assert!(decode(coding, &stream[..length], &size).is_err(), "{coding:?} {length}");
        }
    }
}

#[test]
fn jpeg_lossless_with_rows_missing_before_its_end_is_refused() {
    let stream = jpeg_lossless(&pixels(12, 5), 12, 1, 0, 0);
    // The last coded bytes go, the end of image stays: a lenient decoder would fill up with zeros.
    let mut short = stream[..stream.len() - 12].to_vec();
    short.extend([0xFF, 0xD9]);
    let error = decode(PixelCoding::JpegLossless, &short, &image(12)).unwrap_err();
    assert!(error.to_string().contains("the coded pixels end in row 8"), "{error}");
    let mut long = stream[..stream.len() - 2].to_vec();
    long.extend([1, 2, 3, 0xFF, 0xD9]);
    let error = decode(PixelCoding::JpegLossless, &long, &image(12)).unwrap_err();
    assert!(error.to_string().contains("left over"), "{error}");
}

#[test]
fn streams_of_another_size_are_refused_before_they_are_decoded() {
    let pixels = pixels(12, 1);
    let streams = [
        (PixelCoding::JpegLossless, jpeg_lossless(&pixels, 12, 1, 0, 0)),
        (PixelCoding::JpegLs, jpeg_ls(&pixels)),
        (PixelCoding::Jpeg2000, J2K.to_vec()),
    ];
    for (coding, stream) in streams {
        let other = Image {
            columns: 500,
            rows: 500,
            ..image(12)
        };
        let error = decode(coding, &stream, &other).unwrap_err();
        assert!(matches!(error, FileError::Mismatch { .. }), "{error}");
        let deeper = Image {
            allocated: 8,
            high_bit: 7,
            ..image(12)
        };
        assert!(matches!(
            decode(coding, &stream, &deeper),
            Err(FileError::Mismatch { .. })
        ));
    }
}

#[test]
fn jpeg_2000_is_exact_to_16_bits_of_either_sign() {
    let want = noisy(1440, 16, 2);
    assert_eq!(decode(PixelCoding::Jpeg2000, J2K, &j2k_image()).unwrap(), want);
    let signed = Image {
        signed: true,
        ..j2k_image()
    };
    let shifted: Vec<u16> = want.iter().map(|p| p.wrapping_sub(32_000)).collect();
    assert_eq!(decode(PixelCoding::Jpeg2000, J2K_SIGNED, &signed).unwrap(), shifted);
    assert!(matches!(
        decode(PixelCoding::Jpeg2000, J2K, &signed),
        Err(FileError::Mismatch { .. })
    ));
    let loss = [J2K, J2K_SIGNED, J2K_LOSSY].map(|stream| is_lossy(PixelCoding::Jpeg2000, stream).unwrap());
    assert_eq!(loss, [false, false, true]);
}

#[test]
fn jpeg_2000_streams_made_to_exhaust_memory_are_refused() {
    let refused = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut stream = J2K.to_vec();
        change(&mut stream);
        decode(PixelCoding::Jpeg2000, &stream, &j2k_image())
            .unwrap_err()
            .to_string()
    };
    let cod = J2K.windows(2).position(|pair| pair == [0xFF, 0x52]).unwrap();
    // 65535 layers of 4 x 4 code blocks.
    let layers = refused(&|stream| {
        stream[cod + 6..cod + 8].fill(0xFF);
        stream[cod + 10..cod + 12].fill(0);
    });
    assert!(layers.contains("65535 layers"), "{layers}");
    // Tiles of one pixel in an image of 2^31 columns.
    let tiles = refused(&|stream| stream[24..32].copy_from_slice(&[0, 0, 0, 1, 0, 0, 0, 0]));
    assert!(tiles.contains("unusable image size"), "{tiles}");
    let mut large = J2K.to_vec();
    large[8..16].copy_from_slice(&[0, 0, 0x10, 0, 0, 0, 0x10, 0]);
    large[24..32].copy_from_slice(&[0, 0, 0, 1, 0, 0, 0, 1]);
    let many = Image {
        columns: 4096,
        rows: 4096,
        ..image(16)
    };
    let error = decode(PixelCoding::Jpeg2000, &large, &many).unwrap_err().to_string();
    assert!(error.contains("tiles"), "{error}");
}
