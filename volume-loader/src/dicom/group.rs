//! Which slices belong together.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use super::header::{Header, Placed};
use super::text::Label;

/// Cosines of one orientation agree to this.
const SAME_ORIENTATION: f64 = 1e-4;
/// Pixel spacings that are the same agree to this, mm: 0.005 mm over 512 pixels.
const SAME_SPACING_MM: f64 = 1e-5;
/// More series in one folder are not listed but refused.
pub(crate) const MAX_SERIES: usize = 1000;

/// Sorts headers into groups; `None` where there are more than [`MAX_SERIES`].
pub(crate) fn group(headers: Vec<Header>) -> Option<Vec<(Vec<Header>, bool)>> {
    let mut exact: BTreeMap<_, Vec<Header>> = BTreeMap::new();
    for header in headers {
        let key = (
            header.series.clone(),
            header.series.is_none().then(|| unnamed(&header)),
            header.localizer,
            [header.columns, header.rows],
            header.modality.clone(),
            header.placed.is_err(),
            header.frame.as_ref().map(|frame| frame.part.clone()),
        );
        exact.entry(key).or_default().push(header);
    }
    let mut groups = Vec::new();
    for headers in exact.into_values() {
        for headers in by_orientation(headers)? {
            groups.push(merged(headers));
        }
        if groups.len() > MAX_SERIES {
            return None;
        }
    }
    Some(groups)
}

fn compare(a: &Header, b: &Header) -> Ordering {
    let (Ok(a), Ok(b)) = (a.placed, b.placed) else {
        return Ordering::Equal;
    };
    let numbers = |p: Placed| p.orientation.into_iter().chain(p.spacing).chain(p.position);
    let pairs = numbers(a).zip(numbers(b));
    pairs
        .map(|(x, y)| x.total_cmp(&y))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

fn by_orientation(mut headers: Vec<Header>) -> Option<Vec<Vec<Header>>> {
    headers.sort_by(compare);
    let mut groups: Vec<Vec<Header>> = Vec::new();
    for header in headers {
        let same = |group: &Vec<Header>| group.first().is_some_and(|first| same_plane(first, &header));
        let known = groups.iter().position(same);
        if known.is_none() && groups.len() == MAX_SERIES {
            return None;
        }
        match known.and_then(|index| groups.get_mut(index)) {
            Some(group) => group.push(header),
            None => groups.push(vec![header]),
        }
    }
    Some(groups)
}

fn same_plane(a: &Header, b: &Header) -> bool {
    let (Ok(a), Ok(b)) = (a.placed, b.placed) else {
        return a.placed.is_err() && b.placed.is_err();
    };
    let near = |x: &[f64], y: &[f64], most: f64| x.iter().zip(y).all(|(x, y)| (x - y).abs() <= most);
    near(&a.orientation, &b.orientation, SAME_ORIENTATION) && near(&a.spacing, &b.spacing, SAME_SPACING_MM)
}

/// What keeps slices apart that name no series: two of one study, of one frame of reference and orientation, would else be
/// laid into one another where their slices alternate.
fn unnamed(header: &Header) -> ([Option<String>; 3], Option<Label>) {
    let texts = [
        Some(header.study.clone()),
        Some(header.frame_of_reference.clone()),
        header.series_number.clone(),
    ];
    (texts, header.kernel.clone())
}

/// A series has one frame of reference (PS3.3, A.1.2.5), which [`alike::check`](super::alike::check) asks for. Where each of
/// three or more slices names another one, they were replaced image by image when names were taken out, and tell nothing; the
/// flag says so.
fn merged(headers: Vec<Header>) -> (Vec<Header>, bool) {
    let frames: BTreeSet<&str> = headers
        .iter()
        .map(|header| header.frame_of_reference.as_str())
        .collect();
    let merged = frames.len() == headers.len() && headers.len() > 2;
    (headers, merged)
}
