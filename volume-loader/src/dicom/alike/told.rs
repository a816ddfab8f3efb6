//! What slices of one series say differently, and may with reason: told with how many slices say what. Several scans in one series
//! are one even stack where their slices alternate or follow one another, and no geometry shows it.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crate::dicom::header::Header;
use crate::dicom::header::scanned::number;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::Label;

/// So many values are told, those of most slices first.
const MOST_TOLD: usize = 4;

/// An element, whether its values may be shown, and what it means where slices differ in it.
struct Row(Tag, bool, &'static str);

const SCANS: &str = "they may be of several scans, between which a patient moves, breathes or takes up contrast";
const SERIES: &str = "slices of several series may be mixed";

const ROWS: [Row; 19] = [
    // Scanners that scan slice by slice may count each (PS3.3, C.7.6.1.1: one continuous gathering of data).
    Row(
        el::ACQUISITION_NUMBER,
        true,
        "they may be of several scans, between which a patient moves, breathes or takes up contrast, or of a scanner that counts each turn",
    ),
    Row(el::FRAME_ACQUISITION, true, SCANS),
    Row(el::ACQUISITION_UID, false, SCANS),
    Row(el::STUDY_DATE, false, SCANS),
    Row(el::SERIES_DATE, false, SCANS),
    Row(
        el::ACQUISITION_DATE,
        false,
        "they may be of several scans, or of one over midnight",
    ),
    Row(el::CONTENT_DATE, false, "some were made on another day"),
    Row(
        el::ACCESSION,
        false,
        "they may be of several examinations, or of several patients",
    ),
    Row(el::SERIES_DESCRIPTION, false, SERIES),
    Row(el::SERIES_NUMBER, true, SERIES),
    Row(el::SCANNER_MODEL, false, "images of several scanners may be mixed"),
    Row(el::SCANNER_SERIAL, false, "images of several scanners may be mixed"),
    Row(
        el::CONTRAST_AGENT,
        false,
        "scans with and without contrast may be mixed",
    ),
    Row(el::KVP, true, "the same tissue has other HU in some of them"),
    Row(el::IMAGE_TYPE, true, "images that were made in several ways are mixed"),
    Row(
        el::SLICE_THICKNESS,
        true,
        "some are the mean of more tissue than others",
    ),
    Row(el::RESCALE_TYPE, true, "numbers of several kinds are mixed"),
    Row(
        el::INTERCEPT,
        true,
        "each slice's own is taken: HU step from slice to slice where one is wrong",
    ),
    Row(
        el::SLOPE,
        true,
        "each slice's own is taken: HU step from slice to slice where one is wrong",
    ),
];

/// A sentence for each element that is not the same in all slices, which are in order along the stack.
pub(crate) fn differences(headers: &[&Header]) -> Vec<String> {
    ROWS.iter().filter_map(|row| difference(headers, row)).collect()
}

fn difference(headers: &[&Header], Row(tag, is_shown, meaning): &Row) -> Option<String> {
    let values: Vec<Option<Label>> = headers.iter().map(|header| value(header, *tag)).collect();
    let mut counts: BTreeMap<&Option<Label>, usize> = BTreeMap::new();
    for value in &values {
        *counts.entry(value).or_default() += 1;
    }
    if counts.len() < 2 {
        return None;
    }
    let changes = values.iter().zip(values.iter().skip(1)).filter(|(a, b)| a != b).count();
    let order = match changes >= counts.len() {
        true => ", in turns along the stack",
        false => "",
    };
    Some(format!(
        "{tag} is not the same in all slices: {}{order}: {meaning}",
        in_words(counts, *is_shown)
    ))
}

/// How many slices have each value, most first.
fn in_words(counts: BTreeMap<&Option<Label>, usize>, is_shown: bool) -> String {
    let mut counts: Vec<(&Option<Label>, usize)> = counts.into_iter().collect();
    // Equal ones stay in the order of their values, so that the words are always the same.
    counts.sort_by_key(|(_, count)| Reverse(*count));
    let first = counts.iter().position(|(value, _)| value.is_some());
    let told = counts.iter().take(MOST_TOLD).enumerate().map(|(at, (value, count))| {
        let words = match value {
            None => "none".to_owned(),
            Some(label) if is_shown && !label.is_hidden() => label.to_string(),
            Some(_) if first == Some(at) => "one value".to_owned(),
            Some(_) => "another".to_owned(),
        };
        format!("{words} in {count}")
    });
    let told: Vec<String> = told.collect();
    let more = match counts.len().saturating_sub(MOST_TOLD) {
        0 => String::new(),
        more => format!(" and {more} more values"),
    };
    format!("{}{more}", told.join(", "))
}

fn value(header: &Header, tag: Tag) -> Option<Label> {
    let is_ct = header.modality == "CT";
    match tag {
        el::FRAME_ACQUISITION => header.frame.as_ref()?.acquisition.map(f64::from).and_then(number),
        el::SLICE_THICKNESS => header.thickness_mm.and_then(number),
        // Without one the numbers of a CT are HU (PS3.3, C.11.1.1.2).
        el::RESCALE_TYPE if is_ct => header.rescale_type.clone().or_else(|| Label::of(b"HU")),
        el::RESCALE_TYPE => header.rescale_type.clone(),
        // Other scanners than those of CT scale each slice for itself.
        el::INTERCEPT if is_ct => header.intercept.and_then(number),
        el::SLOPE if is_ct => header.slope.and_then(number),
        el::INTERCEPT | el::SLOPE => None,
        _ => header.scan.get(tag).cloned(),
    }
}
