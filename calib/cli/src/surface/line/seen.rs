//! The images of a sequence, looked at one after another.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal};
use std::path::Path;

use echo::bone::{Options, find};
use ultrasound::{Image, Shape};

use super::super::error::SurfaceCommandError;
use crate::commands::probe::{Sheet, TOLD_EVERY};
use crate::live::Looked;
use crate::poses::Pixels;

/// What all images showed.
pub(super) struct Seen {
    pub(super) images: Vec<Looked>,
    sheet: Option<Sheet>,
}

/// Looks for bone in each image of a sequence, all of which have one shape.
pub(super) fn look(path: &Path, shape: &Shape, with_picture: bool) -> Result<Seen, SurfaceCommandError> {
    let mut pixels = Pixels::open(path)?;
    let count = pixels.count();
    let mut sheet = with_picture.then(|| Sheet::new(pixels.size(), count));
    let is_terminal = io::stderr().is_terminal();
    let mut images = Vec::new();
    while let Some((number, grey)) = pixels.next()? {
        if is_terminal && number > 0 && number.is_multiple_of(TOLD_EVERY) {
            bus::stderr_line!("calib: image {number} of {count}");
        }
        let no_shape = |why: ultrasound::ShapeError| SurfaceCommandError::NoImageShape {
            path: path.to_owned(),
            what: why.to_string(),
        };
        let image = Image::new(shape, grey).map_err(no_shape)?;
        let line = find(&image, &Options::default());
        let line = line.map_err(|source| SurfaceCommandError::Bone { frame: number, source })?;
        if let Some(sheet) = &mut sheet {
            let places: Vec<[f64; 2]> = line.points.iter().map(|point| point.pixel).collect();
            let why = line.reason();
            sheet.line(number, grey, why.as_deref().map_or(Ok(&places[..]), Err));
        }
        images.push(Looked {
            t_capture_ns: 0,
            seq: u64::from(number),
            shape: Ok(*shape),
            // Sequences are read in the orientation MF alone.
            orientation: None,
            is_stamped: true,
            late_ns: 0,
            line: match line.reason() {
                None => Ok(line),
                Some(why) => Err(why),
            },
        });
    }
    Ok(Seen { images, sheet })
}

impl Seen {
    /// In how many images bone was seen, how deep, and why not in the others.
    pub(super) fn words(&self, points: usize) -> String {
        let with: Vec<&Looked> = self.images.iter().filter(|image| image.line.is_ok()).collect();
        let depths = with
            .iter()
            .filter_map(|image| image.line.as_ref().ok())
            .flat_map(|line| &line.points);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in depths {
            least = least.min(point.beam.depth_mm);
            most = most.max(point.beam.depth_mm);
        }
        let mut text = format!(
            "bone             in {} of {} images, {least:.1} to {most:.1} mm deep; {points} points\n",
            with.len(),
            self.images.len()
        );
        let reasons = self.reasons();
        if !reasons.is_empty() {
            text += &format!("  {reasons}\n");
        }
        text
    }

    /// Why images show no bone, the most frequent first; images whose reasons differ in their numbers alone are many.
    pub(super) fn reasons(&self) -> String {
        let mut counted: BTreeMap<&str, usize> = BTreeMap::new();
        for why in self.images.iter().filter_map(|image| image.line.as_ref().err()) {
            *counted.entry(why).or_default() += 1;
        }
        let mut all: Vec<(&str, usize)> = counted.into_iter().collect();
        all.sort_by_key(|one| std::cmp::Reverse(one.1));
        let words = all
            .iter()
            .take(3)
            .map(|(why, count)| format!("without, {count}: {why}"));
        words.collect::<Vec<_>>().join("; ")
    }

    /// The picture as PNG, where one was asked for.
    pub(super) fn png(&self) -> Option<io::Result<Vec<u8>>> {
        self.sheet.as_ref().map(Sheet::png)
    }
}
