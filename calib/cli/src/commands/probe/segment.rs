//! Points that are read off the images themselves: dots of wires with their names, and the line of a wall.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, IsTerminal};
use std::path::Path;

use echo::{DotOptions, Drawing, Grey, Region, WallOptions, WiresOptions, dots, label, wall};
use geometry::{Probe, Reference, Rigid, Vector};
use probe::Mark;

use super::error::SegmentError;
use super::phantom::Told;
use super::sheet::{Sheet, Shown};
use crate::poses::Pixels;

/// Every so many images a line of progress is told to a terminal.
pub(crate) const TOLD_EVERY: u32 = 50;

/// What is looked for.
pub(super) enum Sought<'a> {
    Wires(&'a Told, WiresOptions),
    Wall,
}

/// What was seen in all images.
pub(super) struct Segmented {
    /// Points of each image; the wire of a wall's is 0.
    pub(super) marks: BTreeMap<u32, Vec<Mark>>,
    /// The row of the wall at the middle column, of each image that shows it.
    pub(super) rows: Vec<(u32, f64)>,
    /// How many images there are, and why some gave nothing, with how many.
    images: usize,
    left: BTreeMap<String, usize>,
    /// Names that another labelling contradicted.
    doubtful: usize,
    /// Of each image with names, the phantom's directions of its columns and rows.
    runs: BTreeMap<u32, [[f64; 3]; 2]>,
    picture: Option<Sheet>,
}

/// Looks at each image of a sequence.
pub(super) fn segment(
    path: &Path,
    region: Option<Region>,
    sought: &Sought<'_>,
    with_picture: bool,
) -> Result<Segmented, SegmentError> {
    let mut pixels = Pixels::open(path)?;
    let ([columns, rows], count) = (pixels.size(), pixels.count());
    let name = || path.display().to_string();
    let drawing = match sought {
        Sought::Wires(told, _) => {
            let ends: Vec<[[f64; 3]; 2]> = told.wires.all().iter().map(|w| [w.front.mm(), w.back.mm()]).collect();
            let drawing = Drawing::new(&ends);
            Some(drawing.map_err(|source| SegmentError::Drawing { path: name(), source })?)
        }
        Sought::Wall => None,
    };
    let mut all = Segmented {
        marks: BTreeMap::new(),
        rows: Vec::new(),
        images: count,
        left: BTreeMap::new(),
        doubtful: 0,
        runs: BTreeMap::new(),
        picture: None,
    };
    let mut sheet = with_picture.then(|| Sheet::new([columns, rows], count));
    let is_terminal = io::stderr().is_terminal();
    while let Some((number, grey)) = pixels.next()? {
        if is_terminal && number > 0 && number.is_multiple_of(TOLD_EVERY) {
            bus::stderr_line!("calib: image {number} of {count}");
        }
        let mut image = Grey::new(columns, rows, grey)?;
        if let Some(region) = region {
            image = image.within(region)?;
        }
        let seen = match (sought, &drawing) {
            (Sought::Wires(told, options), Some(drawing)) => all.wires(number, &image, told, drawing, options),
            _ => all.wall(number, &image),
        };
        if let Some(sheet) = &mut sheet {
            sheet.dots(number, grey, &seen);
        }
    }
    all.picture = sheet;
    if all.marks.is_empty() {
        let what = if drawing.is_some() { "the wires" } else { "a wall" };
        return Err(SegmentError::Nothing {
            path: name(),
            images: count,
            what,
            reasons: all
                .reasons()
                .iter()
                .take(3)
                .map(|(why, count)| format!("{count}: {why}"))
                .collect::<Vec<_>>()
                .join("; "),
        });
    }
    Ok(all)
}

impl Segmented {
    fn wires(
        &mut self,
        number: u32,
        image: &Grey<'_>,
        told: &Told,
        drawing: &Drawing,
        options: &WiresOptions,
    ) -> Shown {
        let dots = dots(image, &DotOptions::default());
        let labelled = match label(&dots, drawing, options) {
            Ok(labelled) => labelled,
            Err(why) => return Err(self.leave(why.to_string())),
        };
        self.doubtful += labelled.doubtful;
        self.runs.insert(number, labelled.runs);
        let marks = labelled.pairs.iter().map(|(wire, dot)| Mark {
            wire: *wire,
            px: dots[*dot].px,
        });
        let marks: Vec<Mark> = marks.collect();
        let names = told.wires.all();
        let shown = marks.iter().map(|mark| (mark.px, names[mark.wire].name.clone()));
        let shown = shown.collect();
        self.marks.insert(number, marks);
        Ok(shown)
    }

    fn wall(&mut self, number: u32, image: &Grey<'_>) -> Shown {
        let found = match wall(image, &WallOptions::default()) {
            Ok(found) => found,
            Err(why) => return Err(self.leave(why.to_string())),
        };
        self.rows.push((number, found.row[0]));
        let marks = found.points.iter().map(|point| Mark { wire: 0, px: point.px });
        self.marks.insert(number, marks.collect());
        Ok(found.points.iter().map(|point| (point.px, String::new())).collect())
    }

    fn leave(&mut self, why: String) -> String {
        *self.left.entry(why.clone()).or_default() += 1;
        why
    }

    /// Leaves out images whose columns or rows run against those of most, in the probe's own axes: the image is fixed
    /// there, however the probe is turned.
    pub(super) fn keep_one_way_round(&mut self, poses: &BTreeMap<u32, Rigid<Reference, Probe>>, told: &Told) {
        let reference_from_phantom = told.reference_from_phantom.transform();
        let turned: Vec<(u32, [[f64; 3]; 2])> = self
            .runs
            .iter()
            .filter_map(|(number, runs)| {
                let back = poses.get(number)?.inverse();
                let one = |[x, y, z]: [f64; 3]| (back * (reference_from_phantom * Vector::new(x, y, z))).mm();
                Some((*number, runs.map(one)))
            })
            .collect();
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let agree = |a: &[[f64; 3]; 2], b: &[[f64; 3]; 2]| (0..2).all(|k| dot(a[k], b[k]) > 0.0);
        let votes = |one: &[[f64; 3]; 2]| turned.iter().filter(|(_, other)| agree(one, other)).count();
        let Some((_, most)) = turned.iter().max_by_key(|(_, one)| votes(one)) else {
            return;
        };
        for (number, _) in turned.iter().filter(|(_, one)| !agree(one, most)) {
            self.marks.remove(number);
            self.leave("named the other way round than most, by the probe's poses".to_owned());
        }
    }

    /// What was seen, in words.
    pub(super) fn words(&self) -> String {
        let points: usize = self.marks.values().map(Vec::len).sum();
        let mut text = format!(
            "images           {points} points in {} of {}\n",
            self.marks.len(),
            self.images
        );
        if self.doubtful > 0 {
            let _ = writeln!(text, "  {} dots that may be two wires have no name", self.doubtful);
        }
        for (why, count) in self.reasons().iter().take(5) {
            let _ = writeln!(text, "  {count} left out: {why}");
        }
        let more: usize = self.reasons().iter().skip(5).map(|(_, count)| **count).sum();
        if more > 0 {
            let _ = writeln!(text, "  {more} left out for such reasons with other numbers");
        }
        text
    }

    /// Why images were left out, the most frequent first.
    fn reasons(&self) -> Vec<(&String, &usize)> {
        let mut all: Vec<(&String, &usize)> = self.left.iter().collect();
        all.sort_by(|a, b| b.1.cmp(a.1));
        all
    }

    /// The points as CSV, with the columns that `--points` reads.
    pub(super) fn csv(&self, names: &[String]) -> String {
        let mut text = "frame,wire,u,v\n".to_owned();
        for (frame, marks) in &self.marks {
            for mark in marks {
                let name = names.get(mark.wire).map_or("", String::as_str);
                let _ = writeln!(text, "{frame},{name},{:.4},{:.4}", mark.px[0], mark.px[1]);
            }
        }
        text
    }

    /// The picture as PNG, where one was asked for.
    pub(super) fn png(&self) -> Option<io::Result<Vec<u8>>> {
        Some(self.picture.as_ref()?.png())
    }
}
