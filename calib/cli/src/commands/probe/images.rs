//! The images that a calibration of a probe holds for: what is known of them, and whether others are the same.

use std::path::{Path, PathBuf};

use clap::Args;
use exchange::plus::scan_conversion;
use serde::{Deserialize, Serialize};
use ultrasound::Shape;

use super::array::ArrayRecord;
use super::error::ProbeCommandError;
use crate::input_files::source::Source;
use crate::poses::Pictured;
use crate::values::Positive;

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

/// Where beams run in the images.
#[derive(Debug, Args)]
pub(crate) struct ArrayArgs {
    /// Where beams run, pixels: linear:U,U,V (columns of the first and the last beam, row of the probe's face) or
    /// curved:U,V,R,DEG (centre of the face's curve, its radius in rows, angle between the outermost beams)
    #[arg(long, value_name = "KIND:NUMBERS", value_parser = array)]
    pub(crate) array: Option<ArrayRecord>,
    /// How far beams are shown from the probe's face
    #[arg(long, value_name = "MM")]
    pub(crate) depth_mm: Option<Positive>,
    /// A device set of PLUS whose <ScanConversion> says both
    #[arg(long, value_name = "FILE.xml")]
    pub(crate) scan: Option<PathBuf>,
}

/// What is known of where beams run.
#[derive(Debug, Default)]
pub(crate) struct Beamed {
    pub(crate) array: Option<ArrayRecord>,
    pub(crate) depth_mm: Option<f64>,
    pub(crate) lines: Option<usize>,
    /// Why a device set was not taken.
    pub(crate) left: Option<String>,
}

impl ArrayArgs {
    /// What the command line says, and else --scan or `config`, where that is of images of this size.
    pub(crate) fn read(&self, config: Option<&Path>, size_px: Option<[usize; 2]>) -> Result<Beamed, ProbeCommandError> {
        let scan = match self.scan.as_deref().or(config) {
            Some(path) => {
                let source = Source::read_whole(path)?;
                let scan = scan_conversion(source.text.as_bytes());
                scan.map_err(|source| ProbeCommandError::Plus {
                    path: path.to_owned(),
                    source: Box::new(source),
                })?
            }
            None => None,
        };
        if let (Some(path), None) = (&self.scan, &scan) {
            return Err(ProbeCommandError::NoScan { path: path.to_owned() });
        }
        let mut beamed = Beamed::default();
        if let Some(scan) = scan {
            match (scan.size_px, size_px) {
                (Some([a, b]), Some([c, d])) if [a, b] != [c, d] => {
                    beamed.left = Some(format!(
                        "the device set's ScanConversion is of images of {a} x {b} pixels and these have {c} x {d}: it is not taken"
                    ));
                }
                _ => {
                    beamed.array = Some(ArrayRecord::scanned(&scan));
                    (beamed.depth_mm, beamed.lines) = (Some(scan.depth_mm), scan.lines);
                }
            }
        }
        beamed.array = self.array.or(beamed.array);
        beamed.depth_mm = self.depth_mm.map(|mm| mm.0).or(beamed.depth_mm);
        Ok(beamed)
    }
}

/// `linear:U,U,V` or `curved:U,V,R,DEG`.
fn array(text: &str) -> Result<ArrayRecord, String> {
    let wrong = || {
        "expected linear:U,U,V with the second column above the first, or curved:U,V,R,DEG with a radius above 0 and 1 to 170 \
         degrees; for instance linear:175.5,642.5,3 or curved:200,-280,300,56"
            .to_owned()
    };
    let (kind, numbers) = text.split_once(':').ok_or_else(wrong)?;
    let number = |word: &str| word.trim().parse::<f64>().ok().filter(|x| x.abs() <= 1e5);
    let numbers: Option<Vec<f64>> = numbers.split(',').map(number).collect();
    match (kind, numbers.as_deref()) {
        ("linear", Some([from_px, to_px, face_px])) if to_px > from_px => Ok(ArrayRecord::Linear {
            from_px: *from_px,
            to_px: *to_px,
            face_px: *face_px,
        }),
        ("curved", Some([u, v, radius_px, angle_deg])) if *radius_px > 0.0 && (1.0..=170.0).contains(angle_deg) => {
            Ok(ArrayRecord::Curved {
                centre_px: [*u, *v],
                radius_px: *radius_px,
                angle_deg: *angle_deg,
            })
        }
        _ => Err(wrong()),
    }
}

/// What a recording tells of its images; `transform` is the one from the probe's marker, `tool` what the command line says.
pub(super) fn record(pictured: Pictured, beamed: &Beamed, transform: &str, tool: Option<&str>) -> ImagesRecord {
    let (marker, reference) = frames(transform).unzip();
    ImagesRecord {
        size_px: pictured.size_px,
        orientation: pictured.orientation,
        array: beamed.array,
        lines: beamed.lines,
        depth_mm: beamed.depth_mm,
        tool: tool.map(str::to_owned).or_else(|| marker.clone()),
        marker,
        reference,
    }
}

/// The two frames of `ProbeToReference`.
pub(crate) fn frames(transform: &str) -> Option<(String, String)> {
    let name = transform.strip_suffix("Transform").unwrap_or(transform);
    let at = name.match_indices("To").map(|(at, _)| (&name[..at], &name[at + 2..]));
    let mut two = at.filter(|(from, to)| !from.is_empty() && to.starts_with(|c: char| c.is_ascii_uppercase()));
    two.next().map(|(from, to)| (from.to_owned(), to.to_owned()))
}
