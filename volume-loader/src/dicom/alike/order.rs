//! What should go one way along the stack, and does not: the time at which slices were acquired, and what a file says of its place along
//! the table. Slices of several scans between one another show in it where nothing numbers the scans.

use crate::dicom::header::Header;

/// Neighbours of one scan are not farther apart in time, s: a breath between two turns of the tube.
const BREATH_S: f64 = 60.0;
/// Times of one scan do not go back by more, s: a turn's slices, in whatever order.
const TURN_S: f64 = 10.0;
/// Places are printed with one decimal and more, mm.
const PRINTED_MM: f64 = 0.1;

/// A sentence for each of what does not go one way; headers are in order along the stack.
pub(crate) fn told(headers: &[&Header]) -> Vec<String> {
    let times = times(headers, 0).or_else(|| times(headers, 1));
    [times, locations(headers)].into_iter().flatten().collect()
}

/// Of a CT alone: other scanners acquire all slices together, or every second one first.
fn times(headers: &[&Header], by: usize) -> Option<String> {
    let of = |header: &&Header| {
        let is_slice = header.modality == "CT" && header.frame.is_none();
        header.scan.acquired_s.get(by).copied().flatten().filter(|_| is_slice)
    };
    let times: Vec<f64> = headers.iter().map(of).collect::<Option<_>>()?;
    let pairs = times.iter().zip(times.iter().skip(1));
    let most_s = pairs.map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
    let order = match is_both_ways(&times, TURN_S) {
        true => " and go both ways along the stack",
        false if most_s > BREATH_S => "",
        false => return None,
    };
    Some(format!(
        "the times at which neighbouring slices were acquired are up to {most_s:.0} s apart{order}: they may be of several scans, between \
         which a patient moves, breathes or takes up contrast"
    ))
}

fn locations(headers: &[&Header]) -> Option<String> {
    let said: Option<Vec<f64>> = headers.iter().map(|header| header.scan.location_mm).collect();
    is_both_ways(&said?, PRINTED_MM)
        .then(|| "SliceLocation does not follow the slices' positions, which are taken".to_owned())
}

/// Whether numbers rise by more than this somewhere, and fall by more than this elsewhere.
fn is_both_ways(numbers: &[f64], more_than: f64) -> bool {
    let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
    let [mut rise, mut fall] = [0.0_f64; 2];
    for number in numbers {
        (low, high) = (low.min(*number), high.max(*number));
        (rise, fall) = (rise.max(number - low), fall.max(high - number));
    }
    rise > more_than && fall > more_than
}
