//! How a scanner's images are made, of a device set's `ScanConversion`: where beams run in them.

use roxmltree::Node;

use super::PlusError;
use super::read::{document, text};
use crate::quoted;

/// The array of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScanArray {
    /// `LINEAR`: beams run down, side by side.
    Linear {
        /// `TransducerWidthMm`.
        width_mm: f64,
    },
    /// `CURVILINEAR`: beams come from one centre.
    Curvilinear {
        /// `RadiusStartMm`: the radius of the face.
        radius_mm: f64,
        /// `ThetaStartDeg` and `ThetaStopDeg`: the outermost beams, from straight down.
        theta_deg: [f64; 2],
    },
}

/// Where beams run in the images of a scanner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanConversion {
    /// The array.
    pub array: ScanArray,
    /// `ImagingDepthMm`; of a curved array `RadiusStopMm - RadiusStartMm`. From the face, mm.
    pub depth_mm: f64,
    /// `TransducerCenterPixel`: the column and row of the middle of the face.
    pub centre_px: [f64; 2],
    /// `OutputImageSpacingMmPerPixel`: sizes of a pixel along a row and along a column.
    pub pixel_mm: [f64; 2],
    /// `OutputImageSizePixel`: columns and rows, where the file says them.
    pub size_px: Option<[usize; 2]>,
    /// `NumberOfScanLines`, where the file says it.
    pub lines: Option<usize>,
}

/// The scan conversion of a device set; `None` where it has none.
///
/// # Errors
/// [`PlusError::TooLong`], [`PlusError::Xml`], [`PlusError::Scan`], and [`PlusError::Twice`] where there are several.
pub fn scan_conversion(bytes: &[u8]) -> Result<Option<ScanConversion>, PlusError> {
    let text = text(bytes)?;
    let document = document(text)?;
    let mut nodes = document.descendants().filter(|node| node.has_tag_name(NAME));
    let Some(node) = nodes.next() else { return Ok(None) };
    if nodes.next().is_some() {
        return Err(PlusError::Twice { name: NAME.to_owned() });
    }
    let line = document.text_pos_at(node.range().start).row;
    read(line, &node).map(Some)
}

const NAME: &str = "ScanConversion";

fn read(line: u32, node: &Node<'_, '_>) -> Result<ScanConversion, PlusError> {
    let of = Attributes { line, node };
    let (array, depth_mm) = match node.attribute("TransducerGeometry").unwrap_or_default() {
        "LINEAR" => {
            let [width_mm] = of.numbers("TransducerWidthMm", [1.0, 200.0], "a width of 1 to 200 mm")?;
            let [depth_mm] = of.numbers("ImagingDepthMm", [1.0, 400.0], "a depth of 1 to 400 mm")?;
            (ScanArray::Linear { width_mm }, depth_mm)
        }
        "CURVILINEAR" => {
            let [radius_mm] = of.numbers("RadiusStartMm", [1.0, 200.0], "a radius of 1 to 200 mm")?;
            let [stop_mm] = of.numbers(
                "RadiusStopMm",
                [radius_mm + 1.0, radius_mm + 400.0],
                "1 to 400 mm more than RadiusStartMm",
            )?;
            let [from] = of.numbers("ThetaStartDeg", [-89.0, 88.0], "an angle of -89 to 88 degrees")?;
            let [to] = of.numbers(
                "ThetaStopDeg",
                [from + 1.0, 89.0],
                "an angle above ThetaStartDeg, to 89 degrees",
            )?;
            let theta_deg = [from, to];
            (ScanArray::Curvilinear { radius_mm, theta_deg }, stop_mm - radius_mm)
        }
        other => {
            return Err(of.refused("TransducerGeometry", other, "LINEAR or CURVILINEAR"));
        }
    };
    let whole = |key, [least, most]: [f64; 2], expected| match node.attribute(key) {
        None => Ok(None),
        Some(_) => of
            .numbers::<1>(key, [least, most], expected)
            .map(|[n]| Some(n as usize)),
    };
    let size_px = match node.attribute("OutputImageSizePixel") {
        None => None,
        Some(_) => {
            let size: [f64; 2] = of.numbers("OutputImageSizePixel", [16.0, 4096.0], "two whole numbers, 16 to 4096")?;
            Some(size.map(|side| side as usize))
        }
    };
    Ok(ScanConversion {
        array,
        depth_mm,
        centre_px: of.numbers("TransducerCenterPixel", [-1e4, 1e4], "two numbers, -10000 to 10000")?,
        pixel_mm: of.numbers(
            "OutputImageSpacingMmPerPixel",
            [0.005, 2.0],
            "two numbers, 0.005 to 2 mm",
        )?,
        size_px,
        lines: whole("NumberOfScanLines", [1.0, 1e5], "a number of lines, 1 to 100000")?,
    })
}

struct Attributes<'a, 'd, 'i> {
    line: u32,
    node: &'a Node<'d, 'i>,
}

impl Attributes<'_, '_, '_> {
    fn numbers<const N: usize>(
        &self,
        key: &'static str,
        [least, most]: [f64; 2],
        expected: &'static str,
    ) -> Result<[f64; N], PlusError> {
        let words = self.node.attribute(key).unwrap_or_default();
        let numbers: Option<Vec<f64>> = words
            .split_ascii_whitespace()
            .take(N + 1)
            .map(|word| word.parse().ok().filter(|x| (least..=most).contains(x)))
            .collect();
        let numbers: Option<[f64; N]> = numbers.and_then(|numbers| numbers.try_into().ok());
        numbers.ok_or_else(|| self.refused(key, words, expected))
    }

    fn refused(&self, key: &'static str, found: &str, expected: &'static str) -> PlusError {
        PlusError::Scan {
            line: self.line,
            key,
            found: quoted(&format!("{found:?}")),
            expected,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LINEAR: &str = "<ScanConversion TransducerGeometry=\"LINEAR\" ImagingDepthMm=\"60.0\" TransducerWidthMm=\"40.0\" \
        OutputImageSizePixel=\"820 616\" TransducerCenterPixel=\"410 0\" OutputImageSpacingMmPerPixel=\"0.085 0.085\" \
        NumberOfScanLines=\"90\" />";
    const CURVED: &str = "<ScanConversion TransducerGeometry=\"CURVILINEAR\" RadiusStartMm=\"60\" RadiusStopMm=\"140\" \
        ThetaStartDeg=\"-28\" ThetaStopDeg=\"28\" TransducerCenterPixel=\"200 10\" OutputImageSpacingMmPerPixel=\"0.2 0.2\" />";

    fn parsed(scan: &str) -> Result<Option<ScanConversion>, String> {
        let text = format!("<PlusConfiguration>{scan}</PlusConfiguration>");
        scan_conversion(text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn where_beams_run_is_read_of_both_arrays() {
        let linear = ScanConversion {
            array: ScanArray::Linear { width_mm: 40.0 },
            depth_mm: 60.0,
            centre_px: [410.0, 0.0],
            pixel_mm: [0.085; 2],
            size_px: Some([820, 616]),
            lines: Some(90),
        };
        assert_eq!(parsed(LINEAR), Ok(Some(linear)));
        let curved = ScanConversion {
            array: ScanArray::Curvilinear {
                radius_mm: 60.0,
                theta_deg: [-28.0, 28.0],
            },
            depth_mm: 80.0,
            centre_px: [200.0, 10.0],
            pixel_mm: [0.2; 2],
            size_px: None,
            lines: None,
        };
        assert_eq!(parsed(&format!("<A><B>{CURVED}</B></A>")), Ok(Some(curved)));
        assert_eq!(parsed(""), Ok(None));
    }

    #[test]
    fn what_is_no_scan_conversion_is_refused_by_name() {
        for (text, from, to, words) in [
            (LINEAR, "LINEAR", "PHASED", "TransducerGeometry of a ScanConversion is"),
            (LINEAR, "60.0", "nan", "ImagingDepthMm of a ScanConversion is \"nan\""),
            (LINEAR, "40.0", "4000", "TransducerWidthMm"),
            (LINEAR, "410 0", "410", "TransducerCenterPixel"),
            (LINEAR, "0.085 0.085", "0.085 85", "OutputImageSpacingMmPerPixel"),
            (LINEAR, "820 616", "820 616 3", "OutputImageSizePixel"),
            (LINEAR, "\"90\"", "\"-90\"", "NumberOfScanLines"),
            (CURVED, "\"140\"", "\"60\"", "RadiusStopMm"),
            (CURVED, "\"28\"", "\"-28\"", "ThetaStopDeg"),
        ] {
            let error = parsed(&text.replacen(from, to, 1)).unwrap_err();
            assert!(error.contains(words), "{from} {to}: {error}");
        }
        assert!(
            parsed(&format!("{LINEAR}{CURVED}"))
                .unwrap_err()
                .contains("more than once")
        );
    }

    proptest! {
        #[test]
        fn no_bytes_panic(text in "(ScanConversion|<|>|/|=|\"|LINEAR|TransducerGeometry|[ -~]{0,6}){0,30}") {
            let _ = scan_conversion(text.as_bytes());
            let _ = parsed(&text);
        }
    }
}
