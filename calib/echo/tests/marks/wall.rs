//! The line of a wall in images whose truth is known.

use crate::made::{COLUMNS, Made, ROWS};
use echo::{Grey, WallError, WallOptions, wall};

fn found(made: &Made) -> Result<echo::Wall, WallError> {
    let grey = made.grey();
    wall(&Grey::new(COLUMNS, ROWS, &grey).unwrap(), &WallOptions::default())
}

#[test]
fn the_first_of_parallel_lines_is_found_within_its_error() {
    let (mut within, mut worst) = (0, 0.0_f64);
    for seed in 0..30 {
        let mut made = Made::new(seed);
        let (row, slope) = (made.between(120.0, 220.0), made.between(-0.15, 0.15));
        let middle = 0.5 * (COLUMNS as f64 - 1.0);
        made.medium(8.0);
        // The wall and its echo at twice the depth; dots of dirt.
        made.band(row - slope * middle, slope, 3.0, 180.0, 0.3);
        made.band(2.0 * row - slope * middle, slope, 3.0, 120.0, 0.3);
        for _ in 0..4 {
            let at = [made.between(30.0, 610.0), made.between(30.0, 450.0)];
            made.dot(at, [10.0, 4.0], 250.0, 0.3);
        }
        let wall = found(&made).unwrap();
        let off = (wall.row[0] - row).abs();
        within += usize::from(off <= 1.96 * wall.row[1]);
        worst = worst.max(off);
        assert!((wall.slope - slope).abs() < 0.01 && wall.points.len() >= 6, "{wall:?}");
        for point in &wall.points {
            let truth = row + slope * (point.px[0] - middle);
            assert!(
                (point.px[1] - truth).abs() < 5.0 * point.sigma_px + 0.3,
                "{point:?} {truth}"
            );
        }
    }
    println!("{within} of 30 within 1.96 deviations, at most {worst:.2} pixels off");
    // 95 % of 30, less three deviations of that count (3.6); an eighth of the band's width.
    assert!(within >= 25 && worst < 0.8, "{within}, {worst}");
}

#[test]
fn an_image_without_a_line_is_refused() {
    let mut made = Made::new(1);
    made.medium(20.0);
    for k in 0..6 {
        made.dot([60.0 + 100.0 * f64::from(k), 200.0], [8.0, 4.0], 200.0, 0.2);
    }
    let refused = found(&made).unwrap_err();
    assert!(matches!(refused, WallError::NoLine { least: 16, .. }), "{refused}");
    let grey = vec![0; 16 * 16];
    let small = wall(&Grey::new(16, 16, &grey).unwrap(), &WallOptions::default()).unwrap_err();
    assert!(small.to_string().contains("32 strips of an image 16 pixels wide"));
}
