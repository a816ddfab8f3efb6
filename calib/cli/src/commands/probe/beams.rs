//! What a recording and the command line tell of the images: size, names, where beams run.

use std::path::{Path, PathBuf};

use clap::Args;
use exchange::plus::scan_conversion;

use super::array::ArrayRecord;
use super::error::ProbeCommandError;
use super::images::ImagesRecord;
use crate::input_files::source::Source;
use crate::poses::Pictured;
use crate::values::Positive;

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
