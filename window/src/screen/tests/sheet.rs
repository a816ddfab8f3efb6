//! Contact sheets: a screen as the means of its blocks, many screens in one small PNG.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

/// Levels of 255. What is kept and what is found may come from two builds of the painter and of egui's letters. Each keeps within 2
/// levels of the exact picture in each pixel (`tests/paint`), and so do the means of their blocks: 4 apart at most. Both means are
/// rounded to whole levels, half a level each: 5.
pub(crate) const TOLERANCE: u8 = 5;

/// Side of a block, pixels: of every screen the same part, 6.6 mm of a monitor of 24 inches.
fn block([width, _]: [u32; 2]) -> u32 {
    width / 80
}

/// Screens in a row of a sheet.
const COLUMNS: usize = 5;

/// The means of a screen's blocks, RGB.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Thumbnail {
    /// Blocks in a row, and rows.
    pub(super) size: [usize; 2],
    pub(super) rgb: Vec<[u8; 3]>,
}

impl Thumbnail {
    /// Of the pixels 0x00RRGGBB of a screen. Blocks at the right and at the bottom are cut off by its edges.
    pub(crate) fn of(pixels: &[u32], size: [u32; 2]) -> Self {
        let [width, height, block] = [size[0], size[1], block(size)].map(|n| n as usize);
        let size = [width.div_ceil(block), height.div_ceil(block)];
        let mean = |k: usize| {
            let (left, top) = (k % size[0] * block, k / size[0] * block);
            let (right, bottom) = ((left + block).min(width), (top + block).min(height));
            let mut sums = [0_usize; 3];
            for row in pixels.chunks_exact(width).take(bottom).skip(top) {
                for pixel in &row[left..right] {
                    let [_, rgb @ ..] = pixel.to_be_bytes();
                    sums.iter_mut()
                        .zip(rgb)
                        .for_each(|(sum, level)| *sum += usize::from(level));
                }
            }
            let count = (right - left) * (bottom - top);
            sums.map(|sum| ((2 * sum + count) / (2 * count)) as u8)
        };
        Self {
            size,
            rgb: (0..size[0] * size[1]).map(mean).collect(),
        }
    }

    /// The largest difference of a level, and in which block.
    pub(crate) fn difference(&self, other: &Self) -> (u8, [usize; 2]) {
        assert_eq!(self.size, other.size);
        let levels = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        let each = self.rgb.iter().zip(&other.rgb).map(levels).enumerate();
        let (at, most) = each.max_by_key(|(_, levels)| *levels).unwrap();
        (most, [at % self.size[0], at / self.size[0]])
    }
}

/// Holds screens against the sheet of this size in `folder` of the crate, or writes it where that is asked for.
pub(crate) fn assert_as_kept(folder: &str, pixels: [u32; 2], screens: &[(String, Thumbnail)]) {
    let [width, height] = pixels;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let path = folder.join(format!("{width}x{height}.png"));
    let found: Vec<Thumbnail> = screens.iter().map(|(_, found)| found.clone()).collect();
    if std::env::var_os("TROCAR_RENEW_PICTURES").is_some() {
        write(&path, &found);
    }
    let kept = read(&path, found.len(), found[0].size);
    let mut wrong = Vec::new();
    for ((name, found), kept) in screens.iter().zip(&kept) {
        let (levels, [x, y]) = found.difference(kept);
        if levels > TOLERANCE {
            let side = block(pixels) as usize;
            wrong.push(format!("{name}: {levels} levels at pixel ({}, {})", x * side, y * side));
        }
    }
    if !wrong.is_empty() {
        let aside = std::env::temp_dir().join(format!("screens-{width}x{height}.png"));
        write(&aside, &found);
        panic!(
            "not as in {}; painted now: {}\n{}",
            path.display(),
            aside.display(),
            wrong.join("\n")
        );
    }
}

/// Where the screen of this number begins on a sheet.
fn corner(number: usize, size: [usize; 2]) -> [usize; 2] {
    [number % COLUMNS * size[0], number / COLUMNS * size[1]]
}

/// Writes screens of one size.
fn write(path: &Path, screens: &[Thumbnail]) {
    let size = screens[0].size;
    let [width, height] = [COLUMNS * size[0], screens.len().div_ceil(COLUMNS) * size[1]];
    let mut bytes = vec![0; 3 * width * height];
    for (number, screen) in screens.iter().enumerate() {
        let [left, top] = corner(number, size);
        for (row, pixels) in screen.rgb.chunks_exact(size[0]).enumerate() {
            let from = 3 * ((top + row) * width + left);
            bytes[from..from + 3 * size[0]].copy_from_slice(pixels.as_flattened());
        }
    }
    let file = BufWriter::new(File::create(path).unwrap());
    let mut encoder = png::Encoder::new(file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

/// Reads so many screens of this size.
fn read(path: &Path, count: usize, size: [usize; 2]) -> Vec<Thumbnail> {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let found = [info.width, info.height].map(|n| n as usize);
    assert_eq!(
        found,
        [COLUMNS * size[0], count.div_ceil(COLUMNS) * size[1]],
        "{}",
        path.display()
    );
    let pixels: Vec<[u8; 3]> = bytes.as_chunks().0.to_vec();
    let screen = |number: usize| {
        let [left, top] = corner(number, size);
        let rows = pixels.chunks_exact(found[0]).skip(top).take(size[1]);
        Thumbnail {
            size,
            rgb: rows.flat_map(|row| row[left..left + size[0]].to_vec()).collect(),
        }
    };
    (0..count).map(screen).collect()
}
