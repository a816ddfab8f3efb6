//! Which dot of an image is which wire of a phantom.
//!
//! Nothing is known beforehand of where the probe is. Each three dots taken for each three parallel wires give an
//! affine map of the phantom's cross-section to the image; the map that explains most dots tells their wires, where no
//! other labelling explains nearly as many. A dot counts where it must fall in one place: two equations for each
//! parallel wire beyond the three that hold the map, one for each wire that runs across.

mod drawing;
mod map;

pub use drawing::Drawing;

use crate::dots::Dot;
use drawing::Along;
use map::Map;

/// Bounds of a labelling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WiresOptions {
    /// The least and the largest size of a pixel along either axis, mm.
    pub pixel_mm: [f64; 2],
    /// By how much the longest way in the image of 1 mm may exceed the shortest: pixels that are no squares, and the
    /// tilt of the image about an axis across the wires.
    pub most_stretch: f64,
    /// How far a dot may lie from where its wire is cut, mm.
    pub most_off_mm: f64,
    /// The least number of equations that agree.
    pub least: usize,
    /// A name stands where every labelling that contradicts it is worse by this: in equations, each less the square of
    /// what it is off in `most_off_mm`.
    pub margin: f64,
    /// The direction of the phantom along which columns run, within a quarter turn, where it is known.
    pub right: Option<[f64; 3]>,
    /// The same of rows: down in the image.
    pub down: Option<[f64; 3]>,
}

impl Default for WiresOptions {
    fn default() -> Self {
        Self {
            pixel_mm: [0.02, 0.5],
            most_stretch: 2.0,
            most_off_mm: 0.5,
            least: 6,
            margin: 1.5,
            right: None,
            down: None,
        }
    }
}

/// The dots' wires.
#[derive(Debug, Clone, PartialEq)]
pub struct Labelled {
    /// Wire and dot by their indices, in the order of the wires.
    pub pairs: Vec<(usize, usize)>,
    /// Dots that had a name which another labelling, as good, contradicts: they have none.
    pub doubtful: usize,
    /// Equations that agree.
    pub equations: usize,
    /// Root mean square distance of dots from where their wires are cut, mm.
    pub off_mm: f64,
    /// The directions of the phantom in which columns and rows run, unit vectors as seen along its parallel wires:
    /// what the image's tilt along them adds is left out, so they are not quite square to one another.
    pub runs: [[f64; 3]; 2],
}

/// Why no dot has a name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WiresError {
    /// Too few wires, or more than any phantom has.
    #[error("a drawing of {found} wires; 4 to 32 can be told from one another")]
    Count {
        /// How many there are.
        found: usize,
    },
    /// A wire that is none.
    #[error("wire {wire} of the drawing is {found} mm long, or far away; 1 to 1000 mm are allowed")]
    Wire {
        /// Its index.
        wire: usize,
        /// Its length, mm.
        found: f64,
    },
    /// Wires that cannot be told without a known image.
    #[error(
        "the drawing has {found} parallel wires; dots are told from one another by three or more that are not in one plane"
    )]
    Parallel {
        /// The largest family.
        found: usize,
    },
    /// Too few dots are where wires can be.
    #[error("of {dots} dots, {equations} equations agree with the drawing; at least {least} must")]
    Few {
        /// Dots of the image.
        dots: usize,
        /// The best labelling's.
        equations: usize,
        /// As bounded.
        least: usize,
    },
    /// Two labellings fit alike.
    #[error("two ways to name the dots fit alike: {} equations agree with one, and {} with the names that both give; wires are missing, or the drawing is symmetric",
        .0[0], .0[1])]
    Ambiguous([usize; 2]),
    /// The cuts of wires that run across lie in no plane that an image could be.
    #[error(
        "the wires that run across say that rows and columns are {degrees:.0} degrees apart, not 90: a dot is no wire"
    )]
    Plane {
        /// The angle, degrees.
        degrees: f64,
    },
}

/// One way to name dots.
#[derive(Debug, Clone, PartialEq)]
struct Candidate {
    pairs: Vec<(usize, usize)>,
    equations: usize,
    /// Sum of squared distances, mm^2.
    off: f64,
    /// Equations, each less the square of what it is off in the most that is allowed.
    score: f64,
    map: Map,
}

/// Names the dots of an image.
///
/// # Errors
/// [`WiresError::Few`], [`WiresError::Ambiguous`], [`WiresError::Plane`].
pub fn label(dots: &[Dot], drawing: &Drawing, options: &WiresOptions) -> Result<Labelled, WiresError> {
    let places: Vec<[f64; 2]> = dots.iter().map(|dot| dot.px).collect();
    let mut kept: Vec<Candidate> = Vec::new();
    for triple in drawing.triples() {
        for a in 0..places.len() {
            for b in (0..places.len()).filter(|b| *b != a) {
                // A pair already bounds the scale: most pairs end here.
                if !map::is_likely_pair(&triple, [places[a], places[b]], options) {
                    continue;
                }
                for c in (0..places.len()).filter(|c| *c != a && *c != b) {
                    let from = triple.map(|(_, at)| at);
                    let Some(map) = Map::through(from, [places[a], places[b], places[c]]) else {
                        continue;
                    };
                    if map.is_likely(drawing, options) {
                        consider(&map, &places, drawing, options, &mut kept);
                    }
                }
            }
        }
    }
    choose(kept, &places, drawing, options)
}

/// Keeps what a map explains, where that is not much less than the best so far.
fn consider(map: &Map, places: &[[f64; 2]], drawing: &Drawing, options: &WiresOptions, kept: &mut Vec<Candidate>) {
    let best = kept.iter().map(|one| one.score).fold(options.least as f64, f64::max);
    // Three dots alone place the others less well than a fit to all of them; the fit may gain all that is off.
    let Some(mut found) = explain(map, places, drawing, 2.0 * options.most_off_mm, options) else {
        return;
    };
    let is_worth = |equations: usize| equations as f64 + options.margin > best;
    if !is_worth(found.equations) || kept.iter().any(|one| one.pairs == found.pairs) {
        return;
    }
    for _ in 0..3 {
        let Some(map) = fitted(&found.pairs, places, drawing) else {
            return;
        };
        if !map.is_likely(drawing, options) {
            return;
        }
        let Some(next) = explain(&map, places, drawing, options.most_off_mm, options) else {
            return;
        };
        let is_same = next.pairs == found.pairs;
        found = next;
        if is_same {
            break;
        }
    }
    match kept.iter_mut().find(|one| one.pairs == found.pairs) {
        Some(same) if found.score > same.score => *same = found,
        Some(_) => {}
        None => kept.push(found),
    }
    let best = kept.iter().map(|one| one.score).fold(0.0, f64::max);
    kept.retain(|one| one.score + options.margin > best);
}

/// The map of all parallel wires that have a dot.
fn fitted(pairs: &[(usize, usize)], places: &[[f64; 2]], drawing: &Drawing) -> Option<Map> {
    let points = pairs.iter().filter_map(|(wire, dot)| match drawing.seen[*wire] {
        Along::Point(at) => Some((at, places[*dot])),
        Along::Line { .. } => None,
    });
    Map::fitted(&points.collect::<Vec<_>>())
}

/// The dots that a map explains, each within `most` mm; `None` where fewer than three parallel wires have one.
fn explain(map: &Map, places: &[[f64; 2]], drawing: &Drawing, most: f64, options: &WiresOptions) -> Option<Candidate> {
    let back: Vec<[f64; 2]> = places.iter().map(|at| map.back(*at)).collect();
    let mut taken = vec![false; places.len()];
    let (mut pairs, mut off, mut points, mut lines) = (Vec::new(), 0.0, 0, 0);
    for (wire, at) in drawing.points() {
        let near = back.iter().enumerate().filter(|(i, _)| !taken[*i]);
        let near = near.map(|(i, p)| ((p[0] - at[0]).hypot(p[1] - at[1]), i));
        if let Some((distance, dot)) = near.filter(|(d, _)| *d <= most).min_by(|a, b| a.0.total_cmp(&b.0)) {
            taken[dot] = true;
            pairs.push((wire, dot));
            off += distance * distance;
            points += 1;
        }
    }
    if points < 3 {
        return None;
    }
    for (wire, seen) in drawing.seen.iter().enumerate() {
        let Along::Line { ends, .. } = seen else { continue };
        let near = back.iter().enumerate().filter(|(i, _)| !taken[*i]);
        let mut near = near
            .map(|(i, p)| (from_segment(*p, ends), i))
            .filter(|(d, _)| *d <= most);
        // Two dots where one wire may be: nothing says which, so it has none.
        if let (Some((distance, dot)), None) = (near.next(), near.next()) {
            pairs.push((wire, dot));
            off += distance * distance;
            lines += 1;
        }
    }
    // Two wires seen as lines that cross may claim one dot: it tells neither.
    let claimed: Vec<usize> = pairs.iter().map(|(_, dot)| *dot).collect();
    let before = pairs.len();
    pairs.retain(|(_, dot)| claimed.iter().filter(|other| *other == dot).count() == 1);
    lines -= before - pairs.len();
    pairs.sort_unstable();
    let equations = 2 * (points - 3) + lines;
    Some(Candidate {
        equations,
        pairs,
        off,
        score: equations as f64 - off / (options.most_off_mm * options.most_off_mm),
        map: *map,
    })
}

/// The distance of a place from a line between two ends.
fn from_segment(p: [f64; 2], ends: &[[f64; 2]; 2]) -> f64 {
    let ([a, b], share) = (ends, map::share_of(p, ends));
    (p[0] - a[0] - share * (b[0] - a[0])).hypot(p[1] - a[1] - share * (b[1] - a[1]))
}

/// The best labelling, without the names that another one as good contradicts.
fn choose(
    mut kept: Vec<Candidate>,
    places: &[[f64; 2]],
    drawing: &Drawing,
    options: &WiresOptions,
) -> Result<Labelled, WiresError> {
    kept.sort_by(|a, b| b.score.total_cmp(&a.score).then_with(|| a.pairs.cmp(&b.pairs)));
    let few = |equations| WiresError::Few {
        dots: places.len(),
        equations,
        least: options.least,
    };
    let best = kept.first().ok_or_else(|| few(0))?;
    if best.equations < options.least {
        return Err(few(best.equations));
    }
    // A dot with another name, or a wire with another dot; less of the same is no contradiction.
    let clash = |(wire, dot): (usize, usize), (w, d): (usize, usize)| (w == wire) != (d == dot);
    let is_agreed = |pair: &(usize, usize)| {
        let mut others = kept[1..].iter().flat_map(|other| &other.pairs);
        !others.any(|other| clash(*pair, *other))
    };
    let pairs: Vec<(usize, usize)> = best.pairs.iter().copied().filter(is_agreed).collect();
    let agreed = equations(&pairs, drawing);
    if agreed < options.least {
        return Err(WiresError::Ambiguous([best.equations, agreed]));
    }
    map::check_plane(&best.map, &pairs, places, drawing)?;
    Ok(Labelled {
        off_mm: (best.off / best.pairs.len() as f64).sqrt(),
        doubtful: best.pairs.len() - pairs.len(),
        runs: best.map.runs(drawing),
        pairs,
        equations: agreed,
    })
}

/// The equations that must agree for these dots to have these names: 2 for each parallel wire after three, 1 for each
/// other one.
fn equations(pairs: &[(usize, usize)], drawing: &Drawing) -> usize {
    let is_point = |(wire, _): &&(usize, usize)| matches!(drawing.seen[*wire], Along::Point(_));
    match pairs.iter().filter(is_point).count() {
        0..=2 => 0,
        points => 2 * (points - 3) + pairs.len() - points,
    }
}
