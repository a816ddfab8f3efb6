use super::*;
use proptest::prelude::*;

const SIDE: u32 = 40;
const WHITE: Rgb = Rgb(255, 255, 255);

/// The red of white lines on a black image whose rim is as black, row by row.
fn drawn(points: &[[f64; 2]], width: f64, end: End, dashes: Option<[f32; 4]>) -> Vec<u8> {
    let mut strokes = Strokes::default();
    let widths = Widths { line: width, rim: 0.0 };
    strokes.add([SIDE; 2], points, (widths, end), dashes);
    let mut rgba = vec![0; (4 * SIDE * SIDE) as usize];
    strokes.paint(&mut rgba, WHITE);
    // Nothing is left for the next.
    assert!(strokes.touched.is_empty() && strokes.cover.iter().all(|cover| *cover == [0; 2]));
    rgba.chunks_exact(4).map(|pixel| pixel[0]).collect()
}

/// The part of a pixel that lies within `half` of the segment, by 16 x 16 points of it; straight ends cut off what is beyond.
fn sampled([x, y]: [u32; 2], from: [f64; 2], to: [f64; 2], half: f64, end: End) -> f64 {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let d = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    let mut inside = 0;
    for k in 0..256 {
        let p = [
            f64::from(x) - 0.5 + (f64::from(k % 16) + 0.5) / 16.0 - from[0],
            f64::from(y) - 0.5 + (f64::from(k / 16) + 0.5) / 16.0 - from[1],
        ];
        let (s, t) = (p[0] * d[0] + p[1] * d[1], p[1] * d[0] - p[0] * d[1]);
        let over = (-s).max(s - length).max(0.0);
        let is_in = match end {
            End::Round => t.hypot(over) <= half,
            End::Straight => t.abs() <= half && over == 0.0,
        };
        inside += u32::from(is_in);
    }
    f64::from(inside) / 256.0
}

proptest! {
    /// Lines of any direction, also from and to far outside.
    #[test]
    fn what_a_pixel_is_covered_by_is_its_part_within_the_line(
        from in prop::array::uniform2(-30.0..70.0), to in prop::array::uniform2(-30.0..70.0), half in 0.5..3.0, is_round: bool
    ) {
        let (to, from): ([f64; 2], [f64; 2]) = (to, from);
        prop_assume!((to[0] - from[0]).hypot(to[1] - from[1]) > 4.0 * half);
        let end = if is_round { End::Round } else { End::Straight };
        let found = drawn(&[from, to], 2.0 * half, end, None);
        for (at, level) in (0..).zip(found) {
            let pixel = [at % SIDE, at / SIDE];
            let expected = sampled(pixel, from, to, half, end);
            // The distance stands for the part: off by 0.1 along diagonals, more at the corners of an end that is cut straight.
            let most = if is_round { 0.16 } else { 0.3 };
            prop_assert!((f64::from(level) / 255.0 - expected).abs() < most, "{pixel:?}: {level} of 255, {expected}");
        }
    }

    /// Whatever comes, an image is drawn and nothing beyond it.
    #[test]
    fn places_that_are_none_draw_nothing_and_far_ones_no_longer_than_near_ones(
        points in prop::collection::vec(prop::array::uniform2(prop::num::f64::ANY), 0..5), dash in 0.0_f32..9.0
    ) {
        let dashes = Some([dash, 3.0, dash, 3.0]).filter(|_| points.iter().flatten().all(|c| c.abs() < 1e5));
        drawn(&points, 2.0, End::Round, dashes);
    }
}

#[test]
fn along_rows_and_columns_it_is_exact() {
    for y in [10.0, 10.25, 10.5] {
        let found = drawn(&[[-5.0, y], [50.0, y]], 1.3, End::Straight, None);
        for row in 8..14 {
            let distance = (f64::from(row) - y).abs();
            let expected = (0.65 + 0.5 - distance).clamp(0.0, 1.0);
            let level = found[(row * SIDE + 20) as usize];
            assert!(
                (f64::from(level) / 255.0 - expected).abs() < 0.003,
                "{y}, row {row}: {level}"
            );
        }
    }
}

#[test]
fn joints_are_no_darker_and_dashes_go_round_corners() {
    let straight = drawn(&[[5.0, 20.0], [35.0, 20.0]], 1.0, End::Straight, None);
    let joined = drawn(&[[5.0, 20.0], [20.0, 20.0], [35.0, 20.0]], 1.0, End::Straight, None);
    assert_eq!(straight, joined);
    // 4 on, 4 off: the second dash is 8 to 12 from the beginning, of which the corner is the middle.
    let corner = drawn(
        &[[10.0, 10.0], [20.0, 10.0], [20.0, 30.0]],
        1.0,
        End::Straight,
        Some([4.0; 4]),
    );
    let level = |x: u32, y: u32| corner[(y * SIDE + x) as usize];
    assert_eq!(
        [level(12, 10), level(16, 10), level(19, 10), level(20, 11)],
        [255, 0, 255, 255]
    );
    assert_eq!([level(20, 14), level(20, 18)], [0, 255]);
}

/// A rim is seen beside the line on every ground, and a line over its own rim is the line.
#[test]
fn the_rim_lies_under_the_line() {
    let mut strokes = Strokes::default();
    let widths = Widths { line: 2.0, rim: 1.5 };
    strokes.add([SIDE; 2], &[[2.0, 20.5], [37.0, 20.5]], (widths, End::Round), None);
    let mut rgba = vec![200; (4 * SIDE * SIDE) as usize];
    strokes.paint(&mut rgba, WHITE);
    let red = |y: u32| rgba[4 * (y * SIDE + 20) as usize];
    let Rgb(rim, ..) = palette::RIM;
    assert_eq!(
        [red(17), red(19), red(20), red(21), red(22), red(24)],
        [200, rim, 255, 255, rim, 200]
    );
}
