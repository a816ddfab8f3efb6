//! Numbers of lines that were counted by hand.

use super::*;
use crate::record::sealed;

/// A line: its operation, how it ended, `bump`, the true error, the predicted radius, NEES, the miss, the time, pictures and lost ones.
fn row(number: u64, ended: &str, bump: &str, numbers: [f64; 5], [pictures, lost]: [u64; 2]) -> Row {
    let number_text = |value: f64| {
        if value.is_finite() {
            value.to_string()
        } else {
            String::new()
        }
    };
    let [tre, predicted, nees, miss, time] = numbers.map(number_text);
    let why = if lost > 0 {
        format!("marker-not-seen={lost}")
    } else {
        String::new()
    };
    let fields = format!(
        "a,{number},node,{ended},,pass,{bump},,{tre},{predicted},{nees},{miss},{time},3,{pictures},{lost},{why},1,1,0,1,1,1,1,1,1,1,0,0,,,,,,"
    );
    Row::read(&sealed(&fields)).unwrap()
}

/// Ten operations with one target each, of which one was refused and one has no last pose.
fn ten() -> Vec<Row> {
    let nan = f64::NAN;
    let mut rows: Vec<Row> = [0.5, 0.9, 1.5, 1.9, 2.5, 4.0, 4.9]
        .into_iter()
        .zip(0..)
        .map(|(tre, number)| {
            let times = [6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0];
            let time = times[number as usize];
            row(number, "arrived", "", [tre, 3.0, 2.0, 0.5 * tre, time], [100, 10])
        })
        .collect();
    // Outside of the target: the one that arrived all the same, and the one that was given up.
    rows.push(row(7, "arrived", "before", [6.0, 3.0, 30.0, 5.1, 13.0], [100, 0]));
    rows.push(row(8, "given-up", "", [nan, nan, nan, 80.0, 60.0], [100, 100]));
    rows.push(row(9, "refused", "before", [nan, nan, nan, nan, nan], [0, 0]));
    rows
}

#[test]
fn a_summary_is_what_was_counted() {
    let rows = ten();
    let s = Summary::of("a", &rows.iter().collect::<Vec<_>>(), 5.0);
    assert_eq!((s.operations, s.approached, s.lines), (10, 8, [10, 8, 1, 1]));
    // Of the eight whose error is known two are within 1 mm, four within 2 and seven within 5; five within the radius of 3 mm.
    assert_eq!(s.within.map(|share| share.found), [0.25, 0.5, 0.875]);
    assert_eq!(s.covered.found, 5.0 / 8.0);
    assert_eq!(s.in_ellipsoid.found, 7.0 / 8.0);
    // The fourth and the last of eight: 6, 7 ... 13 s, and half of the errors with 5.1 mm.
    assert_eq!((s.time_s.found, s.miss_mm.map(|miss| miss.found)), (9.0, [0.95, 5.1]));
    assert_eq!(
        s.false_arrivals, 1,
        "the one at 5.1 mm; what was given up at 80 is none"
    );
    // Also the pictures of the way that never showed a pose.
    assert_eq!((s.pictures, s.lost, s.reasons[0]), (900, 170.0 / 900.0, 170));
    assert_eq!(s.reasons[1..].iter().sum::<u64>(), 0);
    // Two were moved before the check, of which one passed it.
    assert_eq!(s.missed, [1, 2]);
}

#[test]
fn an_arrival_is_false_by_the_radius_of_the_target() {
    let rows = ten();
    let of = |radius_mm: f64| Summary::of("a", &rows.iter().collect::<Vec<_>>(), radius_mm).false_arrivals;
    // Misses are 0.25, 0.45, 0.75, 0.95, 1.25, 2, 2.45 and 5.1 mm.
    assert_eq!([of(0.5), of(1.0), of(2.0), of(5.1), of(6.0)], [6, 4, 2, 0, 0]);
}
