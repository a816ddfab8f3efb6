//! Is a whole line bone? Bone lets nothing through: below it there is silence, below a fascia there is tissue.

use super::grid::Grid;
use super::ridge::{FLANK_MM, Ridges};
use super::trace::Line;
use super::{Options, Ridge, Verdict};

/// Tissue is seen this far above a line, mm.
const ABOVE_MM: f64 = 8.0;
/// The stretch below a line whose level is held against it, mm: as far as echoes of tissue still come back, not more.
const BELOW_MM: f64 = 15.0;
/// Where the echo itself has ended, in flanks.
const CLEAR: f64 = 2.2;
/// An echo that has gone twice comes at twice the depth, to within one part in so many: the skin is thick.
const AGAIN: usize = 16;
/// A shadow is black somewhere between the echoes that go to and fro in it: a stretch that long, mm.
const DARK_MM: f64 = 3.0;
/// And no more there than this share of what tissue would have: at low gain all is nearly black.
const SILENT: f64 = 0.5;
/// Grey levels that tissue above must have for its absence below to say anything.
const LEAST_TISSUE: f64 = 12.0;
/// Beams so far to each side have a say in whether there is a shadow below one, mm.
const NEIGHBOURS_MM: f64 = 2.0;
/// How far a line's end is drawn in, in deviations of the smoothing along it.
const BLURRED: f64 = 1.5;
/// The shortest piece that is told of a line with gaps, as a share of the shortest line.
const SHORTEST_PIECE: f64 = 0.4;

/// What was found of a line.
pub(super) struct Judged {
    pub(super) ridge: Ridge,
    /// For each of its beams, whether the line is told there: bright enough, and most beams about it have a shadow.
    pub(super) is_told: Vec<bool>,
    /// For each of its beams the contrast, grey levels.
    pub(super) contrast: Vec<f64>,
}

pub(super) fn judge(grid: &Grid, ridges: &Ridges, line: &Line, options: &Options) -> Judged {
    let contrast: Vec<f64> = (line.first..)
        .zip(&line.rows)
        .map(|(beam, row)| f64::from(ridges.contrast[beam * grid.depths + row]))
        .collect();
    let near = (NEIGHBOURS_MM / grid.wide_mm).round() as usize;
    let about = |i: usize| i.saturating_sub(near)..(i + near + 1).min(contrast.len());
    let is_silent: Vec<bool> = (0..contrast.len())
        .map(|i| {
            // Its grey, not its contrast: tissue lies above a bone, and nothing about an echo that goes to and fro
            // below.
            let own: f64 = about(i)
                .map(|j| f64::from(grid.beam(line.first + j)[line.rows[j]]))
                .sum();
            let own = own / about(i).len() as f64;
            let (beam, row) = (line.first + i, line.rows[i]);
            let slope = ridges.slope(beam * grid.depths + row);
            let from = row + samples(grid, CLEAR * FLANK_MM * slope.hypot(1.0));
            let to = grid.shown[beam].end;
            // Where the image ends nothing is known of a shadow.
            let is_seen = row + samples(grid, options.shadow_mm) < to;
            let again = again(row);
            let is_faint = |at: usize| {
                let most = if again.contains(&at) {
                    options.echo_again
                } else {
                    options.echo_below
                };
                f64::from(ridges.contrast[beam * grid.depths + at]) < most * own
            };
            is_seen && (from..to).all(is_faint)
        })
        .collect();
    let share = is_silent.iter().filter(|silent| **silent).count() as f64 / contrast.len() as f64;
    let tissue = Tissue::about(grid, ridges, line, &is_silent, options);
    let mut is_told: Vec<bool> = (0..contrast.len())
        .map(|i| {
            let silent = is_silent[about(i)].iter().filter(|silent| **silent).count();
            2 * silent > about(i).len() && contrast[i] >= options.min_contrast
        })
        .collect();
    let blurred = (BLURRED * options.along_mm / grid.wide_mm).round() as usize;
    draw_in(
        &mut is_told,
        blurred,
        [line.first == 0, line.first + contrast.len() == grid.beams],
    );
    drop_short(
        &mut is_told,
        (SHORTEST_PIECE * options.shortest_mm / grid.wide_mm).round() as usize,
    );
    let told = is_told.iter().filter(|told| **told).count() as f64;
    let bright: f64 = contrast
        .iter()
        .zip(&is_told)
        .filter(|(_, told)| **told)
        .map(|(c, _)| c)
        .sum();
    let length_mm = contrast.len() as f64 * grid.wide_mm;
    let verdict = verdict(told * grid.wide_mm, share, &tissue, options);
    let middle = line.rows.len() / 2;
    Judged {
        ridge: Ridge {
            verdict,
            beams: [
                grid.share(line.first as f64),
                grid.share((line.first + contrast.len() - 1) as f64),
            ],
            depth_mm: line.rows[middle] as f64 * grid.step_mm,
            length_mm,
            told_mm: told * grid.wide_mm,
            shadow_share: share,
            tissue_above: tissue.above,
            tissue_expected: tissue.expected,
            left_below: tissue.below,
            darkest_below: tissue.darkest,
            contrast: if told > 0.0 { bright / told } else { 0.0 },
        },
        is_told,
        contrast,
    }
}

/// Takes so many beams off both ends of each run, but where the image itself ends: what is told there rests on beams
/// beyond the end, and goes on past it.
fn draw_in(is_told: &mut [bool], beams: usize, is_border: [bool; 2]) {
    let last = is_told.len();
    let mut from = 0;
    for run in is_told.chunk_by_mut(|a, b| a == b) {
        let (first, to) = (from, from + run.len());
        from = to;
        if !(first == 0 && is_border[0]) {
            run.iter_mut().take(beams).for_each(|told| *told = false);
        }
        if !(to == last && is_border[1]) {
            run.iter_mut().rev().take(beams).for_each(|told| *told = false);
        }
    }
}

/// Lets go of runs of fewer beams: a few beams beyond a gap are of something else as easily.
fn drop_short(is_told: &mut [bool], fewest: usize) {
    for run in is_told.chunk_by_mut(|a, b| a == b) {
        if run.len() < fewest {
            run.fill(false);
        }
    }
}

fn verdict(told_mm: f64, share: f64, tissue: &Tissue, options: &Options) -> Verdict {
    if share < options.min_shadow_share {
        Verdict::EchoesBelow
    } else if tissue.expected < LEAST_TISSUE {
        Verdict::NothingToMiss
    } else if tissue.below > options.tissue_below * tissue.expected {
        Verdict::TissueBelow
    } else if tissue.darkest > options.black.min(SILENT * tissue.expected) {
        Verdict::NotSilent
    } else if told_mm < options.shortest_mm {
        Verdict::Short
    } else {
        Verdict::Bone
    }
}

/// Where the echo of a line at this row comes a second time, having gone to the face and back twice.
fn again(row: usize) -> std::ops::Range<usize> {
    let twice = 2 * row;
    twice - twice / AGAIN..twice + twice / AGAIN
}

fn samples(grid: &Grid, mm: f64) -> usize {
    (mm / grid.step_mm).round() as usize
}

/// Levels of tissue about a line, grey levels, over the beams with silence below.
struct Tissue {
    above: f64,
    /// What would come back from below if the tissue above went on, as it fades with depth.
    expected: f64,
    below: f64,
    /// The darkest stretch of [`DARK_MM`] of the mean over the beams below: one beam's speckle has dark places of
    /// its own.
    darkest: f64,
}

impl Tissue {
    /// A straight line through the grey above, over its place against the line, tells how tissue fades there: display
    /// and time gain differ from scanner to scanner, so nothing is taken from elsewhere in the image. It is not let
    /// rise: a bright layer on the bone would promise more than there is.
    fn about(grid: &Grid, ridges: &Ridges, line: &Line, is_silent: &[bool], options: &Options) -> Self {
        let (mut n, mut z, mut g, mut zz, mut zg) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut below = vec![(0.0, 0.0); grid.depths];
        let (mut below_n, mut below_z, mut below_g) = (0.0, 0.0, 0.0);
        let silent = (line.first..)
            .zip(&line.rows)
            .zip(is_silent)
            .filter(|(_, silent)| **silent);
        for ((beam, row), _) in silent {
            let broad = ridges.slope(beam * grid.depths + row).hypot(1.0) * FLANK_MM;
            let top = row.saturating_sub(samples(grid, ABOVE_MM + broad));
            let top = top
                .max(samples(grid, options.least_depth_mm))
                .max(grid.shown[beam].start);
            let grey = grid.beam(beam);
            let bottom = row.saturating_sub(samples(grid, 1.5 * broad)).max(top);
            for (at, level) in (top..bottom).zip(&grey[top..bottom]) {
                let (place, level) = ((at as f64 - *row as f64) * grid.step_mm, f64::from(*level));
                n += 1.0;
                z += place;
                g += level;
                zz += place * place;
                zg += place * level;
            }
            let from = (row + samples(grid, CLEAR * broad)).min(grid.shown[beam].end);
            // Before the echo that went to and fro twice: so that no second bone, at twice the depth, gives its shadow.
            let end = grid.shown[beam].end;
            for (sum, level) in below.iter_mut().zip(&grey[from..again(*row).start.clamp(from, end)]) {
                sum.0 += f64::from(*level);
                sum.1 += 1.0;
            }
            let to = (from + samples(grid, BELOW_MM)).min(grid.shown[beam].end);
            for (at, level) in (from..to).zip(&grey[from..to]) {
                below_n += 1.0;
                below_z += (at as f64 - *row as f64) * grid.step_mm;
                below_g += f64::from(*level);
            }
        }
        if n < 2.0 || below_n < 1.0 {
            return Self {
                above: 0.0,
                expected: 0.0,
                below: f64::INFINITY,
                darkest: f64::INFINITY,
            };
        }
        let above = g / n;
        let spread = zz - z * z / n;
        let slope = if spread > 0.0 { (zg - z * g / n) / spread } else { 0.0 };
        let expected = above + slope * (below_z / below_n - z / n);
        Self {
            above,
            expected: expected.clamp(0.0, above),
            below: below_g / below_n,
            darkest: darkest(&below, samples(grid, DARK_MM)),
        }
    }
}

/// The least mean of so many neighbouring rows of a profile, given as sums and counts: those that half of the beams
/// have.
fn darkest(profile: &[(f64, f64)], length: usize) -> f64 {
    let most = profile.iter().map(|row| row.1).fold(0.0, f64::max);
    let seen = profile.iter().take_while(|row| row.1 > 0.0 && 2.0 * row.1 >= most);
    let levels: Vec<f64> = seen.map(|(sum, count)| sum / count).collect();
    let means = levels
        .windows(length.max(1))
        .map(|rows| rows.iter().sum::<f64>() / rows.len() as f64);
    means.fold(f64::INFINITY, f64::min)
}
