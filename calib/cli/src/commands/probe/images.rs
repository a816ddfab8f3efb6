//! The images that a calibration of a probe holds for: what is known of them, and whether others are the same.

use serde::{Deserialize, Serialize};
use ultrasound::Shape;

use super::array::ArrayRecord;

/// Depths that differ by more than this share are two: what scanners round is less.
const OTHER_DEPTH: f64 = 0.02;

/// The images that a calibration holds for, as far as its recording and the command line told. The size of a pixel is the
/// calibration's own.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ImagesRecord {
    /// Columns and rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_px: Option<[usize; 2]>,
    /// `UltrasoundImageOrientation` of PLUS, such as `MF`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<String>,
    /// Where beams run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub array: Option<ArrayRecord>,
    /// Beams of an image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lines: Option<usize>,
    /// How far beams are shown from the face, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// The tool of a run that the marker is on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<String>,
    /// The name of the probe's marker in the recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marker: Option<String>,
    /// The name of what stood still there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

impl ImagesRecord {
    /// What is not known of them and would be compared: in words, with the option that tells it.
    pub(crate) fn unknown(&self) -> Vec<&'static str> {
        let all = [
            (self.size_px.is_none(), "the size of the images"),
            (self.array.is_none(), "the array (--array or --scan)"),
            (self.depth_mm.is_none(), "the depth (--depth-mm or --scan)"),
            (self.tool.is_none(), "the tool (--tool)"),
        ];
        all.into_iter().filter(|(is, _)| *is).map(|(_, what)| what).collect()
    }

    /// In what an image is another one than those of the calibration, with both; `None` where nothing that is known differs.
    pub(crate) fn differs(&self, shape: &Shape) -> Option<String> {
        let size = [shape.columns(), shape.rows()];
        if let Some(expected) = self.size_px.filter(|expected| *expected != size) {
            let [[a, b], [c, d]] = [size, expected];
            return Some(format!("{a} x {b} pixels, and the probe was calibrated with {c} x {d}"));
        }
        let found = ArrayRecord::of(shape);
        let side_px = size[0].max(size[1]) as f64;
        if let Some(expected) = self.array.filter(|expected| expected.is_other(&found, side_px)) {
            let other = if found.kind() == expected.kind() {
                "where its beams run: "
            } else {
                ""
            };
            return Some(format!("{other}{found}, and the probe was calibrated with {expected}"));
        }
        let (found, expected) = (shape.depth_mm(), self.depth_mm?);
        ((found / expected - 1.0).abs() > OTHER_DEPTH)
            .then(|| format!("a depth of {found:.1} mm, and the probe was calibrated at {expected:.1} mm"))
    }

    /// A line of the report, and one with what is not known.
    pub(super) fn words(&self) -> String {
        let mut words = Vec::new();
        words.extend(self.size_px.map(|[u, v]| format!("{u} x {v} pixels")));
        words.extend(self.orientation.as_ref().map(|turned| format!("turned {turned}")));
        words.extend(self.array.map(|array| array.to_string()));
        words.extend(self.lines.map(|lines| format!("{lines} beams")));
        words.extend(self.depth_mm.map(|mm| format!("{mm:.1} mm deep")));
        words.extend(self.tool.as_ref().map(|tool| format!("tool {tool}")));
        let mut text = format!("holds for        {}\n", words.join("; "));
        let unknown = self.unknown();
        if !unknown.is_empty() {
            text += &format!(
                "  not told: {}. calib sweep --probe refuses what it cannot check, but with --unchecked-images\n",
                unknown.join(", ")
            );
        }
        text
    }
}
