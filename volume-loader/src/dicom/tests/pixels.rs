//! Stored pixels, slope, intercept, padding.

use super::*;

const PIXELS: usize = 12;

fn each(files: &mut [File], change: impl Fn(usize, &mut File)) {
    files.iter_mut().enumerate().for_each(|(k, file)| change(k, file));
}

#[test]
fn each_slice_has_its_own_slope_and_intercept() {
    let mut files = stack(3);
    each(&mut files, |k, file| {
        file.text((0x0028, 0x1053), "DS", ["1", "2", "0.5"][k]);
        file.text((0x0028, 0x1052), "DS", ["0", "-10", "0.25"][k]);
    });
    let (voxels, conversion) = drink(&mut Folder::of(&files).open().unwrap()).unwrap();
    // 203 / 2 + 0.25 = 101.75.
    assert_eq!([voxels[3], voxels[PIXELS + 3], voxels[2 * PIXELS + 3]], [3, 196, 102]);
    assert_eq!(conversion.rounded, 12);
}

#[test]
fn signs_and_high_bits_are_what_the_header_says() {
    let mut files = stack(3);
    each(&mut files, |_, file| {
        file.us((0x0028, 0x0103), 1).text((0x0028, 0x1052), "DS", "0");
        // Twelve bits above four of something else.
        file.us((0x0028, 0x0102), 15)
            .pixels(&[0x800F, 0x7FF3, 0xFFF1, 0x0010, 0, 0, 0, 0, 0, 0, 0, 0]);
    });
    let (voxels, _) = drink(&mut Folder::of(&files).open().unwrap()).unwrap();
    assert_eq!(voxels[..4], [-2048, 2047, -1, 1]);
}

#[test]
fn cells_of_8_and_32_bits_are_read() {
    for (bits, width) in [(8_u16, 1_usize), (32, 4)] {
        let mut files = stack(3);
        each(&mut files, |k, file| {
            file.us((0x0028, 0x0100), bits)
                .us((0x0028, 0x0101), bits)
                .us((0x0028, 0x0102), bits - 1);
            let pixels = (0..PIXELS as u32).flat_map(|i| (i + 50 * k as u32).to_le_bytes()[..width].to_vec());
            file.raw((0x7FE0, 0x0010), "OW", &pixels.collect::<Vec<u8>>());
        });
        let (voxels, _) = drink(&mut Folder::of(&files).open().unwrap()).unwrap();
        assert_eq!(voxels[PIXELS + 5], 55 - 1024, "{bits}");
    }
}

#[test]
fn what_does_not_fit_is_held_and_counted() {
    let mut files = stack(3);
    each(&mut files, |_, file| {
        file.us((0x0028, 0x0101), 16)
            .us((0x0028, 0x0102), 15)
            .text((0x0028, 0x1052), "DS", "-1000");
        file.pixels(&[0, 65_535, 33_767, 33_768, 0, 0, 0, 0, 0, 0, 0, 0]);
    });
    let (voxels, conversion) = drink(&mut Folder::of(&files).open().unwrap()).unwrap();
    assert_eq!(voxels[..4], [-1000, 32_767, 32_767, 32_767]);
    assert_eq!(conversion.clamped_high, 6);
}

#[test]
fn declared_padding_is_rescaled() {
    let mut files = stack(3);
    each(&mut files, |_, file| {
        file.us((0x0028, 0x0103), 1).us((0x0028, 0x0120), -2000_i16 as u16);
    });
    let source = Folder::of(&files).open().unwrap();
    assert_eq!(
        (source.padding_hu(), source.series_facts().padding_known),
        (-3024, true)
    );
    files[1]
        .us((0x0028, 0x0120), -1999_i16 as u16)
        .us((0x0028, 0x0121), -1500_i16 as u16);
    let warnings = Folder::of(&files).open().unwrap().series_facts().warnings.clone();
    assert!(
        warnings[0].contains("not the same in every slice; -3024"),
        "{warnings:?}"
    );
    assert!(warnings[1].contains("from -3024 to -2524 HU"), "{warnings:?}");
}

#[test]
fn padding_shows_in_the_corners_or_is_the_usual() {
    let mut files = stack(3);
    assert_eq!(Folder::of(&files).open().unwrap().padding_hu(), -1024);
    each(&mut files, |_, file| {
        file.us((0x0028, 0x0103), 1)
            .us((0x0028, 0x0101), 16)
            .us((0x0028, 0x0102), 15);
        let mut pixels = [1000_u16; PIXELS];
        [0, 3, 8, 11]
            .iter()
            .for_each(|&corner| pixels[corner] = -2000_i16 as u16);
        file.pixels(&pixels);
    });
    let source = Folder::of(&files).open().unwrap();
    assert_eq!(
        (source.padding_hu(), source.series_facts().padding_known),
        (-3024, true)
    );
}

#[test]
fn padding_is_not_mixed_into_neighbours() {
    let heights = [0.0, 2.0, 4.0, 8.0];
    let mut files: Vec<File> = heights.iter().enumerate().map(|(k, &z)| File::slice(k, z)).collect();
    each(&mut files, |_, file| {
        file.us((0x0028, 0x0120), 5);
    });
    files[3].pixels(&[5, 400, 5, 400, 400, 400, 400, 400, 400, 400, 400, 400]);
    let folder = Folder::of(&files);
    let mut source = folder.open_with(Options { regrid: true }).unwrap();
    let (voxels, _) = drink(&mut source).unwrap();
    // Between 200 and the padding; between 201 and 400, half away from zero.
    assert_eq!(voxels[3 * PIXELS..3 * PIXELS + 2], [5 - 1024, 300 - 1024]);
}

#[test]
fn slices_read_in_any_order_are_the_same() {
    let folder = Folder::of(&stack(5));
    let mut source = folder.open().unwrap();
    let (voxels, _) = drink(&mut source).unwrap();
    let (mut out, mut scratch) = (vec![0; PIXELS], Scratch::default());
    for k in [4, 0, 3, 3, 1] {
        source.read(k, &mut out, &mut scratch).unwrap();
        assert_eq!(out, voxels[PIXELS * k as usize..][..PIXELS]);
    }
    assert!(matches!(
        source.read(5, &mut out, &mut scratch),
        Err(ReadError::Order { .. })
    ));
    assert!(matches!(
        source.read(0, &mut out[1..], &mut scratch),
        Err(ReadError::Buffer { .. })
    ));
}
