//! A recorded bone (PLUS, `BoneUltrasound_L14`): 21 frames of an arc below a skin fascia, a deeper fascia and muscle.
//!
//! There is no truth. What was seen in the frames, drawn and looked at one by one: the arc's top lies at a depth of
//! 22.3 to
//! 22.9 mm, its left flank runs out of the image, its right one ends in bright tissue 36 mm deep; the skin fascia lies
//! at 3 to 7 mm, the deep one at 11 to 20 mm.

use std::io::Read;
use std::path::PathBuf;

use echo::bone::{BoneLine, Options, Verdict, find};
use flate2::read::ZlibDecoder;
use ultrasound::{Beams, Shape};

use super::scan::of;

const SIZE: [usize; 2] = [820, 616];
const PIXEL: f64 = 0.085;

/// The frames one after another; `None` where the recording is not there.
fn frames() -> Option<Vec<u8>> {
    let Some(folder) = std::env::var_os("TROCAR_SHARED").map(PathBuf::from) else {
        println!("SKIPPED: no TROCAR_SHARED");
        return None;
    };
    let Ok(bytes) = std::fs::read(folder.join("data/plus-ultrasound/BoneUltrasound_L14.igs.mha")) else {
        println!("SKIPPED: no recording");
        return None;
    };
    let key = b"ElementDataFile = LOCAL";
    let end = bytes.windows(key.len()).position(|part| part == key).unwrap() + key.len();
    let end = end + bytes[end..].iter().position(|byte| *byte == b'\n').unwrap() + 1;
    let mut pixels = Vec::new();
    ZlibDecoder::new(&bytes[end..]).read_to_end(&mut pixels).unwrap();
    assert_eq!(pixels.len(), 21 * SIZE[0] * SIZE[1]);
    Some(pixels)
}

/// The image is in the columns 176 to 642; the face is the bright line in its third row.
fn shape(depth_mm: f64) -> Shape {
    let beams = Beams::Linear {
        from_mm: 175.5 * PIXEL,
        to_mm: 642.5 * PIXEL,
        face_mm: 3.0 * PIXEL,
    };
    Shape::new(SIZE, [PIXEL, PIXEL], beams, depth_mm).unwrap()
}

fn lines(pixels: &[u8], depth_mm: f64) -> Vec<BoneLine> {
    let shape = shape(depth_mm);
    let frames = pixels.chunks(SIZE[0] * SIZE[1]);
    frames
        .map(|grey| find(&of(&shape, grey), &Options::default()).unwrap())
        .collect()
}

#[test]
fn the_arc_is_told_in_every_frame_and_no_fascia_in_any() {
    let Some(pixels) = frames() else {
        return;
    };
    let lines = lines(&pixels, 52.0);
    for (frame, line) in lines.iter().enumerate() {
        let bones = line.ridges.iter().filter(|ridge| ridge.verdict == Verdict::Bone);
        assert_eq!(bones.count(), 1, "frame {frame}");
        let top = line
            .points
            .iter()
            .map(|point| point.beam.depth_mm)
            .fold(f64::INFINITY, f64::min);
        // A fascia would lie at 20 mm or above.
        assert!((22.0..23.2).contains(&top), "frame {frame}: {top}");
        println!(
            "frame {frame} of 21: top {top:.2} mm, {} points, shadow {:.2}",
            line.points.len(),
            line.shadow_share
        );
        let [first, last] = [line.points[0], line.points[line.points.len() - 1]].map(|point| point.beam.share);
        assert!(
            first < 0.02 && (0.65..0.9).contains(&last),
            "frame {frame}: {first} to {last}"
        );
        assert!(
            line.shadow_share > 0.95 && line.margin > 0.9,
            "frame {frame}: {} {}",
            line.shadow_share,
            line.margin
        );
        // Left of the top it falls to the left, right of it to the right.
        let lean = |share: f64| {
            let near = line.points.iter().find(|point| point.beam.share > share);
            near.unwrap().slope
        };
        assert!(
            lean(0.05) < -0.6 && lean(0.6) > 0.1,
            "frame {frame}: {} {}",
            lean(0.05),
            lean(0.6)
        );
    }
    println!("{} frames of 21 with the arc", lines.len());
}

/// The probe moves by tenths of a mm a frame: what a cubic across the beams leaves of the difference is of the method.
#[test]
fn neighbouring_frames_show_one_line_within_what_is_told() {
    let Some(pixels) = frames() else {
        return;
    };
    let lines = lines(&pixels, 52.0);
    let (mut squares, mut ratios, mut n) = (0.0, 0.0, 0.0);
    for two in lines.windows(2) {
        let pairs: Vec<(f64, f64, f64)> = two[0]
            .points
            .iter()
            .filter_map(|a| {
                let b = two[1].points.iter().find(|b| b.beam.share == a.beam.share)?;
                let told = a.axial_mm.hypot(b.axial_mm);
                Some((2.0 * a.beam.share - 1.0, b.beam.depth_mm - a.beam.depth_mm, told))
            })
            .collect();
        for (left, told) in without_cubic(&pairs).into_iter().zip(pairs.iter().map(|pair| pair.2)) {
            squares += left * left;
            ratios += (left / told).powi(2);
            n += 1.0;
        }
    }
    let (rms, ratio) = ((squares / n).sqrt(), (ratios / n).sqrt());
    println!("{n} pairs in 20 frames: rms {rms:.3} mm, {ratio:.2} of what is told");
    // Some of each point's deviation is where in the echo a surface lies, which both frames share: less than told.
    assert!(rms < 0.15 && ratio < 1.0, "{rms} {ratio}");
}

/// Least squares by normal equations, as in any book.
fn without_cubic(pairs: &[(f64, f64, f64)]) -> Vec<f64> {
    let basis = |x: f64| [1.0, x, x * x, x * x * x];
    let mut rows = [[0.0; 5]; 4];
    for (x, y, _) in pairs {
        for i in 0..4 {
            (0..4).for_each(|j| rows[i][j] += basis(*x)[i] * basis(*x)[j]);
            rows[i][4] += basis(*x)[i] * y;
        }
    }
    for i in 0..4 {
        for k in i + 1..4 {
            let part = rows[k][i] / rows[i][i];
            (i..5).for_each(|j| rows[k][j] -= part * rows[i][j]);
        }
    }
    let mut curve = [0.0; 4];
    for i in (0..4).rev() {
        let known: f64 = (i + 1..4).map(|j| rows[i][j] * curve[j]).sum();
        curve[i] = (rows[i][4] - known) / rows[i][i];
    }
    let value = |x: f64| basis(x).iter().zip(curve).map(|(b, c)| b * c).sum::<f64>();
    pairs.iter().map(|(x, y, _)| y - value(*x)).collect()
}

/// The same frames cut above the bone: real tissue without bone.
#[test]
fn the_same_frames_cut_off_above_the_bone_have_no_line() {
    let Some(pixels) = frames() else {
        return;
    };
    for depth in [18.1, 19.0, 20.0, 21.0, 21.7] {
        let told = lines(&pixels, depth)
            .iter()
            .filter(|line| !line.points.is_empty())
            .count();
        println!("cut at {depth} mm: {told} false of 21 frames");
        assert_eq!(told, 0, "{depth} mm");
    }
}
