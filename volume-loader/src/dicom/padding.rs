//! HU of what the scanner did not measure.

use super::header::Header;
use super::slice::Slice;

/// What scanners write outside their circle where they say nothing.
const USUAL_HU: i16 = -1024;

/// The padding of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Padding {
    pub hu: i16,
    /// Whether the files say so, or show it.
    pub known: bool,
}

impl Padding {
    /// PixelPaddingValue, as HU of the first slice that has one; what was doubtful about it is added to `warnings`.
    pub(crate) fn declared(headers: &[&Header], slices: &[Slice], warnings: &mut Vec<String>) -> Option<Self> {
        let all: Vec<Option<f64>> = headers
            .iter()
            .zip(slices)
            .map(|(header, slice)| declared_hu(header, slice))
            .collect();
        let first = all.iter().flatten().next().copied()?;
        if all.iter().any(|&hu| hu != Some(first)) {
            warnings.push(format!("the padding is not the same in every slice; {first} is taken"));
        }
        let held = first.round().clamp(f64::from(i16::MIN), f64::from(i16::MAX));
        if held != first {
            warnings.push(format!("the padding is {first}, taken as {held}"));
        }
        let limit = |(header, slice): (&&Header, &Slice)| header.padding[1].map(|raw| hu_of(raw, slice));
        if let Some(limit) = headers.iter().zip(slices).find_map(limit) {
            warnings.push(format!(
                "everything from {first} to {limit} HU is padding too, and stays what it is"
            ));
        }
        Some(Self {
            hu: held as i16,
            known: true,
        })
    }

    /// Where nothing is declared: one implausible value in all four corners of a slice is what lies outside the circle.
    pub(crate) fn of_corners(voxels: &[i16], columns: usize) -> Self {
        let last_row = voxels.len().saturating_sub(columns);
        let corners = [0, columns.saturating_sub(1), last_row, voxels.len().saturating_sub(1)];
        let [a, rest @ ..] = corners.map(|at| voxels.get(at).copied().unwrap_or(USUAL_HU));
        if a < USUAL_HU && rest.iter().all(|&b| b == a) {
            return Self { hu: a, known: true };
        }
        Self {
            hu: USUAL_HU,
            known: false,
        }
    }
}

fn declared_hu(header: &Header, slice: &Slice) -> Option<f64> {
    let [raw, _] = header.padding;
    raw.map(|raw| hu_of(raw, slice))
}

/// A whole cell, of which not only the stored bits count.
fn hu_of(raw: u16, slice: &Slice) -> f64 {
    let signed = slice.to_hu.cell.signed;
    let number = if signed { i64::from(raw as i16) } else { i64::from(raw) };
    slice.to_hu.hu(number)
}
