//! The line of a bone in an ultrasound image, an error for each point; or that there is none.
//!
//! Bone sends nearly everything back and lets nothing through: a bright line, dark above, silent below. A fascia is as
//! bright a line, often a brighter one, with tissue below. So lines are found first, whatever they are, and each is
//! then
//! judged **as a whole**: below how much of it there is silence, and whether tissue is missing there.
//!
//! 1. The image is resampled along its beams (`grid`).
//! 2. Each place's contrast to what lies above and below, along the best of a fan of slopes (`ridge`).
//! 3. Whole lines through neighbouring beams, by dynamic programming, one after another (`trace`; dynamic programming
//!    over beams: Foroughi et al., IEEE Ultrasonics Symposium 2007).
//! 4. Each judged by its shadow (`judge`).
//! 5. Places between samples, and their deviations (`place`).
//!
//! **Where in its echo the surface lies.** A point is the *top* of the echo along its beam. The front of a pulse
//! reaches
//! the surface first and the top of its envelope follows half a pulse later, so the surface lies at the top or before
//! it, by up to half of the echo's length; Jain and Taylor (SPIE Medical Imaging 2004) and Daanen, Tonetti and Troccaz
//! (MICCAI 2004), who compared the two, place it in the echo's upper part. The front is not taken because it moves with
//! gain and dynamic range, which an image does not tell; the top does not. What is left is one number for a scanner and
//! setting, [`BonePoint::echo_mm`] its scale, towards the probe: a registration must leave the surface an offset
//! (`surface_registration` has one), and it is no part of the deviations here.

mod grid;
mod judge;
mod place;
mod ridge;
mod trace;

use ultrasound::{Beam, Image};

use grid::Grid;
use judge::Judged;
use ridge::Ridges;
use trace::Line;

/// What is looked for. Levels are grey of 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Above it lie the probe's own echoes and the skin, mm.
    pub least_depth_mm: f64,
    /// From beam to beam at half of the depth, mm: how densely points are told. Neighbours share their speckle.
    pub spacing_mm: f64,
    /// Deviation of the smoothing along the beam, mm: half a pulse or less.
    pub axial_mm: f64,
    /// Deviation of the smoothing along a line, mm.
    pub along_mm: f64,
    /// Deviation of a beam's width, mm: that of a point across its beam, in the image.
    pub lateral_mm: f64,
    /// The least contrast of a line to what lies above and below.
    pub min_contrast: f64,
    /// How far below a line the image must go on, mm.
    pub shadow_mm: f64,
    /// The most contrast of any line below a bone, as a share of the bone's grey.
    pub echo_below: f64,
    /// The same at twice the line's depth, where its own echo comes again, having gone to the face and back twice.
    pub echo_again: f64,
    /// The share of a line's beams that must have nothing brighter below.
    pub min_shadow_share: f64,
    /// The grey left below a bone, as a share of what tissue would have there.
    pub tissue_below: f64,
    /// The most grey of the darkest stretch below a bone: silence is shown black at usual gain.
    pub black: f64,
    /// The shortest line that is told, mm.
    pub shortest_mm: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            least_depth_mm: 4.0,
            spacing_mm: 0.3,
            axial_mm: 0.25,
            along_mm: 0.8,
            lateral_mm: 0.5,
            min_contrast: 15.0,
            shadow_mm: 10.0,
            echo_below: 0.3,
            echo_again: 0.6,
            min_shadow_share: 0.75,
            tissue_below: 0.8,
            black: 18.0,
            shortest_mm: 8.0,
        }
    }
}

/// A point of a bone's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BonePoint {
    /// Column and row.
    pub pixel: [f64; 2],
    /// In the image's plane, mm.
    pub place_mm: [f64; 2],
    /// The beam through it.
    pub beam: Beam,
    /// Standard deviation along the beam, mm: of the scatter about a bow through its neighbours, and of the echo's
    /// width, which neighbours share. The offset of the surface from the echo's top is not in it.
    pub axial_mm: f64,
    /// Standard deviation across the beam in the image, mm.
    pub lateral_mm: f64,
    /// Deviation of the echo's own profile along the beam, mm.
    pub echo_mm: f64,
    /// How far the line leans, mm of depth a mm of width.
    pub slope: f64,
    /// Contrast, grey levels.
    pub contrast: f64,
    /// Which of [`BoneLine::ridges`] it is of.
    pub ridge: usize,
}

/// What a line was found to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Bone.
    Bone,
    /// Below too much of it something shines: a fascia.
    EchoesBelow,
    /// Nothing is bright below, but tissue goes on as above.
    TissueBelow,
    /// Nothing is bright below, and less comes back than from above, but nowhere is it silent.
    NotSilent,
    /// Above it there is no tissue whose absence below could be seen.
    NothingToMiss,
    /// Bone by all else, but shorter than is told.
    Short,
    /// Bone by all else, but a better line lies on the same beams.
    Beaten,
}

/// A line that was looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ridge {
    /// What it is.
    pub verdict: Verdict,
    /// Its first and last beam.
    pub beams: [f64; 2],
    /// Depth at its middle, mm.
    pub depth_mm: f64,
    /// Length across the beams, mm.
    pub length_mm: f64,
    /// How much of that is bright enough and has a shadow.
    pub told_mm: f64,
    /// The share of its beams with nothing bright below.
    pub shadow_share: f64,
    /// Grey of the tissue above.
    pub tissue_above: f64,
    /// What it would be below if nothing happened at the line.
    pub tissue_expected: f64,
    /// What it is below.
    pub left_below: f64,
    /// And in the darkest stretch below, over all beams.
    pub darkest_below: f64,
    /// Mean contrast of what is told, grey levels.
    pub contrast: f64,
}

impl Ridge {
    /// How much speaks for bone: grey levels times mm of the part that is told, weighted by what is missing below.
    #[must_use]
    pub fn score(&self) -> f64 {
        let missing = (1.0 - self.left_below / self.tissue_expected.max(1.0)).clamp(0.0, 1.0);
        self.contrast * self.told_mm * self.shadow_share * missing
    }
}

/// The line of a bone in an image, in pieces where it has gaps; no points where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct BoneLine {
    /// From the first beam to the last.
    pub points: Vec<BonePoint>,
    /// All lines that were looked at, in the order in which they were found: those that are no bone as well.
    pub ridges: Vec<Ridge>,
    /// The share of beams with a shadow, over all that is told; 0 without points.
    pub shadow_share: f64,
    /// By how much the best line is better than the next best that was refused for its shadow or beaten, as a share
    /// of its own: 1 where nothing else speaks for bone at all, 0 without points.
    pub margin: f64,
}

impl BoneLine {
    /// Why there are no points, in words; `None` where there are.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        if !self.points.is_empty() {
            return None;
        }
        let longest = self.ridges.iter().max_by(|a, b| a.length_mm.total_cmp(&b.length_mm));
        let best = self
            .ridges
            .iter()
            .max_by(|a, b| a.score().total_cmp(&b.score()))
            .filter(|best| best.score() > 0.0);
        let Some(ridge) = best.or(longest) else {
            return Some("no line in it is bright and long enough".to_owned());
        };
        let at = format!(
            "the best of {} lines ({:.1} mm deep)",
            self.ridges.len(),
            ridge.depth_mm
        );
        Some(match ridge.verdict {
            Verdict::EchoesBelow => {
                format!(
                    "{at} has a shadow below {:.0} % of its beams only",
                    100.0 * ridge.shadow_share
                )
            }
            Verdict::TissueBelow => format!(
                "below {at} the grey is {:.0}, and {:.0} would be expected of tissue: it goes on",
                ridge.left_below, ridge.tissue_expected
            ),
            Verdict::NotSilent => format!(
                "below {at} it is nowhere silent: the darkest has a grey of {:.0}",
                ridge.darkest_below
            ),
            Verdict::NothingToMiss => format!("above {at} there is no tissue, so its absence below says nothing"),
            Verdict::Short | Verdict::Beaten | Verdict::Bone => {
                format!("{at} is told along {:.1} mm only", ridge.told_mm)
            }
        })
    }
}

/// Why an image was not searched.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BoneError {
    /// An option is out of its range.
    #[error("{what} is {found}; {least} to {most} are allowed")]
    Option {
        /// Which.
        what: &'static str,
        /// What was given.
        found: f64,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
    /// The image ends before a shadow could be seen.
    #[error("the image is {found:.1} mm deep; {needed:.1} mm and more are needed for a line and its shadow")]
    Shallow {
        /// Its depth, mm.
        found: f64,
        /// What is needed, mm.
        needed: f64,
    },
    /// Beams so dense that nothing is gained.
    #[error("beams every {spacing_mm} mm make more samples than are searched; ask for fewer")]
    Dense {
        /// As asked, mm.
        spacing_mm: f64,
    },
}

/// The line of a bone.
///
/// # Errors
/// [`BoneError`]. An image without bone is no error: [`BoneLine::reason`] says why it has no points.
pub fn find(image: &Image<'_>, options: &Options) -> Result<BoneLine, BoneError> {
    check(options)?;
    let shape = image.shape();
    let needed = options.least_depth_mm + options.shadow_mm + 4.0;
    if shape.depth_mm() < needed {
        return Err(BoneError::Shallow {
            found: shape.depth_mm(),
            needed,
        });
    }
    let spacing_mm = options.spacing_mm;
    let grid = Grid::new(image, spacing_mm, options.axial_mm).ok_or(BoneError::Dense { spacing_mm })?;
    let ridges = Ridges::new(&grid, options.along_mm);
    // Pieces shorter than what is told are traced as well: what a shadow lies below may be a part of a line only.
    let lines = trace::lines(
        &grid,
        &ridges,
        options.least_depth_mm,
        options.min_contrast,
        options.shortest_mm,
    );
    let mut judged: Vec<Judged> = lines
        .iter()
        .map(|line| judge::judge(&grid, &ridges, line, options))
        .collect();
    beat(&lines, &mut judged);
    let mut points = Vec::new();
    for (ridge, (line, judged)) in lines.iter().zip(&judged).enumerate() {
        if judged.ridge.verdict == Verdict::Bone {
            tell(image, &grid, line, judged, options, ridge, &mut points);
        }
    }
    points.sort_by(|a: &BonePoint, b| a.beam.share.total_cmp(&b.beam.share));
    Ok(whole(points, judged.iter().map(|judged| judged.ridge).collect()))
}

fn check(options: &Options) -> Result<(), BoneError> {
    let rows = [
        ("the least depth, mm", options.least_depth_mm, 0.0..=100.0),
        ("the spacing of beams, mm", options.spacing_mm, 0.05..=2.0),
        ("the smoothing along the beam, mm", options.axial_mm, 0.05..=2.0),
        ("the smoothing along a line, mm", options.along_mm, 0.1..=5.0),
        ("the deviation across the beam, mm", options.lateral_mm, 0.05..=10.0),
        ("the least contrast", options.min_contrast, 3.0..=250.0),
        ("the depth of a shadow, mm", options.shadow_mm, 2.0..=100.0),
        ("the brightest echo below, a share,", options.echo_below, 0.0..=1.0),
        ("the echo that comes again, a share,", options.echo_again, 0.0..=1.0),
        ("the share with a shadow", options.min_shadow_share, 0.5..=1.0),
        ("the grey left below, a share,", options.tissue_below, 0.0..=0.95),
        ("the grey of silence", options.black, 0.0..=100.0),
        ("the shortest line, mm", options.shortest_mm, 2.0..=100.0),
    ];
    match rows.into_iter().find(|(_, found, range)| !range.contains(found)) {
        None => Ok(()),
        Some((what, found, range)) => Err(BoneError::Option {
            what,
            found,
            least: *range.start(),
            most: *range.end(),
        }),
    }
}

/// Of lines that are told on the same beams the best one stays: nothing is seen through bone.
fn beat(lines: &[Line], judged: &mut [Judged]) {
    let mut order: Vec<usize> = (0..judged.len())
        .filter(|i| judged[*i].ridge.verdict == Verdict::Bone)
        .collect();
    order.sort_by(|a, b| judged[*b].ridge.score().total_cmp(&judged[*a].ridge.score()));
    let told = |i: usize, judged: &[Judged]| -> Vec<usize> {
        let beams = (lines[i].first..).zip(&judged[i].is_told);
        beams.filter(|(_, told)| **told).map(|(beam, _)| beam).collect()
    };
    let mut taken = std::collections::BTreeSet::new();
    for i in order {
        let beams = told(i, judged);
        if beams.iter().any(|beam| taken.contains(beam)) {
            judged[i].ridge.verdict = Verdict::Beaten;
        } else {
            taken.extend(beams);
        }
    }
}

/// Adds the points of a line that is bone.
fn tell(
    image: &Image<'_>,
    grid: &Grid,
    line: &Line,
    judged: &Judged,
    options: &Options,
    ridge: usize,
    points: &mut Vec<BonePoint>,
) {
    let shape = image.shape();
    let places = place::places(grid, line, options.along_mm);
    for (i, placed) in places.iter().enumerate() {
        let (true, Some(placed)) = (judged.is_told[i], placed) else {
            continue;
        };
        let share = grid.share((line.first + i) as f64);
        let (place_mm, direction) = shape.along(share, placed.depth_mm);
        points.push(BonePoint {
            pixel: shape.pixel_at(place_mm),
            place_mm,
            beam: Beam {
                direction,
                depth_mm: placed.depth_mm,
                share,
            },
            axial_mm: placed.sigma_mm,
            lateral_mm: options.lateral_mm,
            echo_mm: placed.echo_mm,
            slope: placed.slope,
            contrast: judged.contrast[i],
            ridge,
        });
    }
}

fn whole(points: Vec<BonePoint>, ridges: Vec<Ridge>) -> BoneLine {
    let bones = || ridges.iter().filter(|ridge| ridge.verdict == Verdict::Bone);
    let length: f64 = bones().map(|ridge| ridge.length_mm).sum();
    let shadowed: f64 = bones().map(|ridge| ridge.length_mm * ridge.shadow_share).sum();
    let best = bones().map(Ridge::score).fold(0.0, f64::max);
    let others = ridges.iter().filter(|ridge| ridge.verdict != Verdict::Bone);
    let next = others.map(Ridge::score).fold(0.0, f64::max);
    let has_any = !points.is_empty();
    BoneLine {
        points,
        shadow_share: if has_any { shadowed / length } else { 0.0 },
        margin: if has_any { 1.0 - next / best } else { 0.0 },
        ridges,
    }
}
