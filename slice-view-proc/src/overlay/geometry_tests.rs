//! Lines over the slice against points of what they stand for: each point is placed by the pose and by the plane, and by nothing that
//! draws.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::cuts::CutLine;
use super::ruler::place_words;
use super::tube::{Part, Tube};
use super::way::Way;
use super::*;
use geometry::{Affine, Direction, Point, Vector, VolumeGrid, letters};
use proptest::prelude::*;
use scene::{Extent, Scene};

use crate::view;

const RADIUS: f64 = 6.0;
const LENGTH: f64 = 180.0;
/// A ring of 24 corners is off by 0.9 % of its radius, and a circle of 360 points by 0.004 %.
const RING_MM: f64 = 0.06;
/// By how much the cut may be off across the tube, mm: 0.2 % of the radius, and a rounding.
const CUT_MM: f64 = 0.02;

fn tool() -> ToolSpec {
    ToolSpec {
        name: "tube".to_owned(),
        length_mm: LENGTH,
        diameter_mm: 2.0 * RADIUS,
    }
}

/// Angles of the tube's axis out of the plane: level, pointing at the viewer and away, and beside each.
fn tilts() -> Vec<f64> {
    let half: Vec<f64> = [
        0.0,
        1e-9,
        1e-6,
        1e-3,
        0.02,
        0.2,
        0.5,
        1.0,
        1.4,
        FRAC_PI_2 - 1e-3,
        FRAC_PI_2 - 1e-6,
        FRAC_PI_2,
    ]
    .into();
    half.iter().copied().chain(half.iter().map(|tilt| -tilt)).collect()
}

/// A tool with its tip at (3, -7, 11) and this tilt out of an axial plane; a positive one points into the screen.
fn tilted(tilt: f64, turn: f64) -> Rigid<Ct, Tool> {
    let axis = Vector::new(tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin());
    let beside = Vector::new(-turn.sin(), turn.cos(), 0.0);
    let (axis, beside) = (axis.direction().unwrap(), beside.direction().unwrap());
    Rigid::from_axes(Point::new(3.0, -7.0, 11.0), axis, beside).unwrap()
}

/// An axial plane so far behind the tip, mm, on which the whole tube is seen.
fn axial(behind_tip: f64) -> SlicePlane {
    let middle = Point::new(3.0, -7.0, 11.0 + behind_tip);
    SlicePlane::centred(middle, [Direction::X, Direction::Y], 0.5, [1024, 1024]).unwrap()
}

/// A point of the tube's wall or of its ends, by its distance behind the mouth.
fn wall(pose: Rigid<Ct, Tool>, s: f64, angle: f64) -> Point<Ct> {
    pose * Point::<Tool>::new(RADIUS * angle.cos(), RADIUS * angle.sin(), -s)
}

fn mm(plane: &SlicePlane, p: Point<Ct>) -> [f64; 2] {
    let at = plane.project(p);
    [at.x * plane.pixel_mm(), at.y * plane.pixel_mm()]
}

fn angles(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TAU * i as f64 / count as f64)
}

/// How far points reach in each of 36 directions, mm.
fn reach(points: &[[f64; 2]]) -> Vec<f64> {
    let far = |angle: f64| points.iter().map(move |[x, y]| x * angle.cos() + y * angle.sin());
    angles(36).map(|angle| far(angle).fold(f64::MIN, f64::max)).collect()
}

#[test]
fn the_outline_is_that_of_the_points_of_the_cylinder() {
    for tilt in tilts() {
        for (turn, behind) in [(0.3, 0.0), (2.0, 4.0), (-2.5, -50.0)] {
            let (pose, plane) = (tilted(tilt, turn), axial(behind));
            let cylinder: Vec<[f64; 2]> = (0..=12)
                .flat_map(|i| angles(360).map(move |angle| (LENGTH * f64::from(i) / 12.0, angle)))
                .map(|(s, angle)| mm(&plane, wall(pose, s, angle)))
                .collect();
            let lines = Tube::of(&plane, pose, &tool()).lines();
            let outline = lines.iter().filter(|(_, part)| *part != Part::Cut || lines.len() == 1);
            let rings = lines.iter().filter(|(points, _)| points.len() > 2);
            let drawn: Vec<[f64; 2]> = outline
                .chain(rings)
                .flat_map(|(points, _)| points.iter().map(|p| p.map(|c| c * plane.pixel_mm())))
                .collect();
            for (drawn, wanted) in reach(&drawn).into_iter().zip(reach(&cylinder)) {
                // A tube that is less than a pixel long on the image has no edges.
                let has_edges = LENGTH * tilt.cos() > plane.pixel_mm();
                let bound = RING_MM + if has_edges { 0.0 } else { plane.pixel_mm() };
                assert!(
                    (drawn - wanted).abs() <= bound,
                    "{tilt} {turn} {behind}: {drawn}, not {wanted}"
                );
            }
        }
    }
}

/// The edges are a diameter apart at every tilt, and are dashed where every point of the tube's width lies behind the plane.
#[test]
fn edges_are_a_diameter_apart_and_dashed_behind_the_plane() {
    for tilt in tilts() {
        for behind in [0.0, 1.0, -1.0, 5.9, -6.1, 20.0, -40.0, -200.0] {
            let (pose, plane) = (tilted(tilt, 0.7), axial(behind));
            let lines = Tube::of(&plane, pose, &tool()).lines();
            let edges: Vec<_> = lines.iter().filter(|(points, _)| points.len() == 2).collect();
            for s in (1..60).map(|i| 3.0 * f64::from(i)) {
                let width: Vec<Point<Ct>> = angles(720).map(|angle| wall(pose, s, angle)).collect();
                let nearest = width
                    .iter()
                    .map(|p| plane.project(*p).depth_mm)
                    .fold(f64::MAX, f64::min);
                if edges.is_empty() || nearest.abs() < 0.01 {
                    continue;
                }
                let wanted = if nearest > 0.0 { Part::Behind } else { Part::Outline };
                // Of the width, the two points that lie furthest from the axis on the image.
                let [from, to] = [0.0, -LENGTH].map(|z| mm(&plane, pose * Point::<Tool>::new(0.0, 0.0, z)));
                let beside = |p: &Point<Ct>| away(mm(&plane, *p), from, to);
                let ends = [1.0, -1.0].map(|sign| {
                    width
                        .iter()
                        .copied()
                        .max_by(|a, b| (sign * beside(a)).total_cmp(&(sign * beside(b))))
                });
                for end in ends {
                    let end = mm(&plane, end.unwrap());
                    let on = |(points, part): &&(Vec<[f64; 2]>, Part)| {
                        let [a, b] = [points[0], points[1]].map(|p| p.map(|c| c * plane.pixel_mm()));
                        (*part == wanted).then(|| distance_to(end, a, b))
                    };
                    let nearest = edges.iter().filter_map(on).fold(f64::MAX, f64::min);
                    assert!(
                        nearest < 0.02,
                        "tilt {tilt}, {behind} behind, {s} mm: {nearest} from a line that is {wanted:?}"
                    );
                }
            }
        }
    }
}

/// The distance of `p` from the line through `a` and `b`, with its side.
fn away(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    ((p[0] - a[0]) * dy - (p[1] - a[1]) * dx) / dx.hypot(dy)
}

fn distance_to(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let t = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}

/// Whether a closed polygon holds `p`: how often a ray from it crosses.
fn holds(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crosses =
        sides.filter(|(a, b)| (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
    crosses.count() % 2 == 1
}

#[test]
fn the_cut_holds_the_points_of_the_plane_that_the_cylinder_holds_and_no_others() {
    let mut cuts = 0;
    for tilt in tilts() {
        for behind in [
            0.0, 1e-6, -1e-6, 2.0, -2.0, 5.999, 6.001, -5.999, -6.001, 20.0, -20.0, -170.0, -190.0,
        ] {
            let (pose, plane) = (tilted(tilt, 0.7), axial(behind));
            let lines = Tube::of(&plane, pose, &tool()).lines();
            let sides: Vec<&Vec<[f64; 2]>> = lines
                .iter()
                .filter(|(_, part)| *part == Part::Cut)
                .map(|(points, _)| points)
                .collect();
            let polygon: Vec<[f64; 2]> = match sides[..] {
                [] => Vec::new(),
                [ring] => ring.clone(),
                [upper, lower] => upper.iter().chain(lower.iter().rev()).copied().collect(),
                _ => panic!("{} lines of the cut", sides.len()),
            };
            cuts += usize::from(!polygon.is_empty());
            let (back, at_tip) = (pose.inverse(), plane.project(pose * Point::<Tool>::new(0.0, 0.0, 0.0)));
            for (i, j) in (0..120).flat_map(|i| (0..61).map(move |j| (i, j))) {
                // Along the axis on the image and across it, from behind the other end to beyond the mouth.
                let (along, across) = (8.3 - 1.7 * f64::from(i), 0.25 * f64::from(j - 30));
                let (sin, cos) = 0.7_f64.sin_cos();
                let pixel = [
                    (along * cos - across * sin) / 0.5 + at_tip.x,
                    (along * sin + across * cos) / 0.5 + at_tip.y,
                ];
                let [x, y, z] = (back * plane.point(pixel[0], pixel[1])).mm();
                let inside = (RADIUS - x.hypot(y)).min(-z).min(z + LENGTH);
                // The ring of the mouth stands for the cut through it, of which the tilt takes up to one half.
                let is_ring = sides.len() == 1;
                let enough = if is_ring { 0.25 } else { CUT_MM };
                if inside > enough {
                    assert!(
                        holds(&polygon, pixel),
                        "tilt {tilt}, {behind} behind: {pixel:?} is cut and not in it"
                    );
                } else if inside < -CUT_MM && !(is_ring && x.hypot(y) < RADIUS + 0.25) {
                    assert!(
                        !holds(&polygon, pixel),
                        "tilt {tilt}, {behind} behind: {pixel:?} is not cut and in it"
                    );
                }
            }
        }
    }
    assert!(cuts > 100, "{cuts}");
}

/// Below a quarter of the planes miss the tube in front of its mouth, and are not cut.
#[test]
fn a_plane_that_misses_the_tube_has_no_cut() {
    for (tilt, behind) in [
        (FRAC_PI_2, 0.01),
        (0.0, 6.01),
        (0.0, -6.01),
        (FRAC_PI_2, -180.01),
        (1.0, 40.0),
    ] {
        let lines = Tube::of(&axial(behind), tilted(tilt, 0.2), &tool()).lines();
        assert!(lines.iter().all(|(_, part)| *part != Part::Cut), "{tilt} {behind}");
    }
}

struct Made {
    scene: Scene,
    view: usize,
    pose: Rigid<Ct, Tool>,
    chosen: Option<Chosen>,
    notice: Notice,
}

impl Made {
    fn of(view: usize, pose: Rigid<Ct, Tool>) -> Self {
        Self {
            scene: Scene::parse("", std::path::Path::new("")).unwrap(),
            view,
            pose,
            chosen: None,
            notice: Notice::Live,
        }
    }

    fn grid() -> VolumeGrid {
        let affine = Affine::from_rows([[1.0, 0.0, 0.0, -60.0], [0.0, 1.0, 0.0, -60.0], [0.0, 0.0, 1.0, -60.0]]);
        VolumeGrid::checked([120; 3], affine).unwrap()
    }

    fn plane(&self, view: &View) -> SlicePlane {
        view::plane(view, &Self::grid(), &self.pose).unwrap()
    }

    fn with<T>(&self, look: impl FnOnce(&Overlay<'_>) -> T) -> T {
        let view = &self.scene.views[self.view];
        let lost = matches!(self.notice, Notice::Lost(..));
        look(&Overlay {
            view,
            plane: &self.plane(view),
            is_placed: true,
            views: &self.scene.views,
            pose: (!lost && self.notice != Notice::Look).then_some(self.pose),
            tool: &tool(),
            targets: &[],
            chosen: self.chosen.as_ref(),
            accuracy: None,
            outside: false,
            remarks: &[],
            notice: self.notice,
            origin: Origin::Tracker,
            seq: 7,
            registration_id: 1,
            volume: "01234567",
            marks: Marks::default(),
            caution: "",
            tissue: crate::tissue::Tissues::default(),
        })
    }

    /// Pixels of this colour, also where a line between two rows is mixed with its dark rim.
    fn drawn(&self, colour: Rgb) -> Vec<[usize; 2]> {
        let mut canvas = Canvas::new(512, 512);
        self.with(|overlay| overlay.draw(&mut canvas));
        let Rgb(r, g, b) = colour;
        let pixels = canvas.rgba().chunks_exact(4).enumerate();
        pixels
            .filter(|(_, p)| is_of([p[0], p[1], p[2]], [r, g, b]))
            .map(|(i, _)| [i % 512, i / 512])
            .collect()
    }
}

/// Whether a pixel has this colour, down to 0.4 of its light.
fn is_of(pixel: [u8; 3], colour: [u8; 3]) -> bool {
    let (pixel, colour) = (pixel.map(f64::from), colour.map(f64::from));
    let sum = |c: [f64; 3]| c.iter().sum::<f64>();
    let part = sum(pixel) / sum(colour);
    let is_near = |(p, c): (f64, f64)| (p - part * c).abs() <= 5.0;
    (0.4..=1.01).contains(&part) && pixel.into_iter().zip(colour).all(is_near)
}

fn chosen(centre: [f64; 3], entry: Option<[f64; 3]>) -> Chosen {
    let point = |[x, y, z]: [f64; 3]| Point::new(x, y, z);
    Chosen {
        name: "node".to_owned(),
        centre: point(centre),
        radius_mm: 2.5,
        entry: entry.map(point),
        stop_mm: 5.0,
    }
}

fn pose(turn: [f64; 3], tip: [f64; 3]) -> Rigid<Ct, Tool> {
    let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
    Rigid::from_rotation_vector(vector(turn), vector(tip)).unwrap()
}

/// How a point that lies so far off the plane, and there on the image, is drawn: `None` where it is too close to a border to say.
fn wanted(plane: &SlicePlane, p: Point<Ct>) -> Option<Option<bool>> {
    let (at, size) = (plane.project(p), plane.size().map(f64::from));
    let off = at.depth_mm.abs();
    let inside = (at.x + 0.5)
        .min(at.y + 0.5)
        .min(size[0] - 0.5 - at.x)
        .min(size[1] - 0.5 - at.y);
    if (off - RADIUS).abs() < 1e-6 || (off - 10.0).abs() < 1e-6 || inside.abs() < 1e-6 {
        return None;
    }
    Some((inside > 0.0 && off <= 10.0).then_some(off > RADIUS))
}

/// Every place of a line, of mm `from` its beginning `to` its end, against the point of the patient there.
fn follows(
    plane: &SlicePlane,
    (way, range): (&Way, [f64; 2]),
    at: impl Fn(f64) -> Point<Ct>,
) -> Result<(), TestCaseError> {
    let stretches = way.stretches(range, plane.size(), RADIUS);
    for t in (0..400).map(|i| 0.25 + 0.5 * f64::from(i)) {
        let p = plane.project(at(t));
        let [x, y] = way.pixel(t);
        prop_assert!((x - p.x).hypot(y - p.y) < 1e-6, "{t}: {x} {y} is not {p:?}");
        let drawn = stretches
            .iter()
            .find(|([from, to], _)| (*from..=*to).contains(&t))
            .map(|(_, dashed)| *dashed);
        let is_of_it = (range[0]..=range[1]).contains(&t);
        if let Some(wanted) = wanted(plane, at(t)) {
            prop_assert_eq!(drawn, wanted.filter(|_| is_of_it), "{}", t);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn the_path_follows_the_axis_to_the_depth_of_the_target(
        view in 0..7_usize, turn in prop::array::uniform3(-3.0..3.0), tip in prop::array::uniform3(-50.0..50.0),
        centre in prop::array::uniform3(-60.0..60.0), is_chosen in any::<bool>(),
    ) {
        let mut made = Made::of(view, pose(turn, tip));
        made.chosen = is_chosen.then(|| chosen(centre, None));
        let ahead = |t: f64| made.pose * Point::<Tool>::new(0.0, 0.0, t);
        // The place of the axis that is nearest to the target, by trying.
        let centre = Point::new(centre[0], centre[1], centre[2]);
        let nearest = (0..4000).map(|i| 0.05 * f64::from(i)).min_by(|a, b| ahead(*a).distance(centre).total_cmp(&ahead(*b).distance(centre)));
        made.with(|overlay| {
            let (way, end) = overlay.path(made.pose);
            match nearest.filter(|t| is_chosen && *t > 0.06) {
                Some(nearest) => prop_assert!((end - nearest).abs() < 0.06, "{end}, not {nearest}"),
                None => prop_assert!(end == f64::INFINITY || end < 0.1, "{end}"),
            }
            follows(overlay.plane, (&way, [0.0, end]), ahead)?;
            for t in overlay.path_ticks(&way, [0.0, end]) {
                prop_assert!((t / 10.0).fract() == 0.0 && t > 0.0 && t <= end, "a tick at {t}");
                prop_assert!(wanted(overlay.plane, ahead(t)).is_none_or(|drawn| drawn.is_some()), "a tick beside the path");
            }
            Ok(())
        })?;
    }

    #[test]
    fn the_plan_follows_the_line_from_the_entry_to_the_target(
        view in 0..7_usize, turn in prop::array::uniform3(-3.0..3.0), tip in prop::array::uniform3(-50.0..50.0),
        centre in prop::array::uniform3(-60.0..60.0), entry in prop::array::uniform3(-60.0..60.0),
    ) {
        let mut made = Made::of(view, pose(turn, tip));
        made.chosen = Some(chosen(centre, Some(entry)));
        let (centre, entry) = (Point::<Ct>::new(centre[0], centre[1], centre[2]), Point::new(entry[0], entry[1], entry[2]));
        made.with(|overlay| {
            let (way, length) = overlay.planned().unwrap();
            prop_assert!((length - centre.distance(entry)).abs() < 1e-9);
            follows(overlay.plane, (&way, [0.0, length]), |t| entry.lerp(centre, t / length))
        })?;
    }

    /// By the planes as the other views have them, and by where these change sides along the border of the image.
    #[test]
    fn points_of_a_cut_lie_on_both_planes_and_no_cut_is_missing(
        view in 0..7_usize, turn in prop::array::uniform3(-3.0..3.0), tip in prop::array::uniform3(-50.0..50.0), ahead in -15.0..15.0,
    ) {
        let mut made = Made::of(view, pose(turn, tip));
        let another = View { name: "ahead".to_owned(), ahead_mm: ahead, ..made.scene.views[6].clone() };
        made.scene.views.push(another);
        made.with(|overlay| {
            let lines = overlay.cut_lines();
            for other in &made.scene.views {
                let (mine, plane) = (overlay.plane, made.plane(other));
                let depth = |[x, y]: [f64; 2]| plane.project(mine.point(x, y)).depth_mm;
                let is_it = |line: &&CutLine<'_>| (line.other.plane, line.other.ahead_mm) == (other.plane, other.ahead_mm);
                let found: Vec<_> = lines.iter().filter(is_it).collect();
                let ends: Vec<_> = found.iter().flat_map(|line| line.parts.into_iter().flatten()).collect();
                prop_assert!(found.len() <= 1);
                for p in ends.iter().flatten() {
                    prop_assert!(depth(*p).abs() < 1e-9, "{} mm off {}", depth(*p), other.name);
                    prop_assert!(p.iter().all(|c| (-1e-6..=511.0 + 1e-6).contains(c)), "{p:?}");
                }
                // Where the border of the image changes from one side of the other plane to the other.
                let sine = mine.into_screen().cross(plane.into_screen()).norm();
                let tip = mine.project(made.pose * Point::<Tool>::new(0.0, 0.0, 0.0));
                for (a, b) in border() {
                    let crosses = (depth(a) > 0.0) != (depth(b) > 0.0);
                    let is_open = (a[0] - tip.x).hypot(a[1] - tip.y) < 0.2 * 512.0 + 2.0;
                    if crosses && !is_open && (sine - 0.087).abs() > 1e-6 {
                        let is_there = ends.iter().flatten().any(|end| (end[0] - a[0]).hypot(end[1] - a[1]) < 1.5);
                        prop_assert_eq!(is_there, sine > 0.087, "{} at {:?}", other.name, a);
                    }
                }
            }
            Ok(())
        })?;
    }

    #[test]
    fn the_place_of_a_slice_is_that_of_the_tip_with_the_side_on_which_it_lies(
        view in 0..6_usize, turn in prop::array::uniform3(-3.0..3.0), tip in prop::array::uniform3(-50.0..50.0),
    ) {
        let made = Made::of(view, pose(turn, tip));
        let axis = [2, 2, 1, 1, 0, 0][view];
        let words = made.with(|overlay| place_words(overlay.plane)).unwrap();
        let (name, rest) = words.split_once(' ').unwrap();
        let (number, side) = rest.split_once(" mm").unwrap();
        prop_assert_eq!(name, ["x", "y", "z"][axis]);
        prop_assert!((number.parse::<f64>().unwrap() - tip[axis]).abs() < 0.051, "{words}");
        let mut towards = [0.0; 3];
        towards[axis] = tip[axis];
        let towards = Vector::new(towards[0], towards[1], towards[2]).direction().unwrap();
        prop_assert!(number == "0.0" || side.trim() == letters(towards), "{words}");
    }
}

/// Neighbours along the border of an image of 512 pixels.
fn border() -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let steps = (0..511).map(f64::from);
    steps.flat_map(|i| {
        let j = i + 1.0;
        [
            ([i, 0.0], [j, 0.0]),
            ([i, 511.0], [j, 511.0]),
            ([0.0, i], [0.0, j]),
            ([511.0, i], [511.0, j]),
        ]
    })
}

#[test]
fn places_have_a_sign_and_a_side_and_zero_has_neither() {
    let of = |z: f64| {
        let plane = SlicePlane::centred(Point::new(1.0, 2.0, z), [Direction::X, Direction::Y], 0.5, [64, 64]).unwrap();
        place_words(&plane).unwrap()
    };
    assert_eq!(
        [12.46, -3.0, 0.04, -0.04].map(of),
        ["z +12.5 mm S", "z -3.0 mm I", "z 0.0 mm", "z 0.0 mm"]
    );
    let oblique = pose([0.3, 0.2, 0.1], [0.0; 3]);
    assert_eq!(Made::of(6, oblique).with(|overlay| place_words(overlay.plane)), None);
}

#[test]
fn the_ruler_has_its_ticks_at_round_distances_from_the_middle() {
    for (view, field, short, long) in [
        (1, 100.0, 5.0, 10.0),
        (1, 40.0, 1.0, 10.0),
        (1, 300.0, 5.0, 10.0),
        (1, 2000.0, 50.0, 100.0),
    ] {
        let mut made = Made::of(view, pose([0.0; 3], [0.0; 3]));
        made.scene.views[view].field_mm = field;
        made.with(|overlay| {
            let ticks = overlay.ruler();
            let place = |row: f64| overlay.plane.project(Point::new(0.0, 0.0, 0.0)).y - row;
            assert!(ticks.len() as f64 > 0.9 * field / short, "{field}: {}", ticks.len());
            for (row, is_long) in &ticks {
                let mm = place(*row) * overlay.plane.pixel_mm();
                assert!(
                    (mm / short - (mm / short).round()).abs() < 1e-9,
                    "{field}: a tick at {mm} mm"
                );
                assert_eq!(
                    *is_long,
                    (mm / long - (mm / long).round()).abs() < 1e-9,
                    "{field}: {mm} mm"
                );
                assert!((0.0..512.0).contains(row));
            }
        });
    }
}

/// In an axial image, seen from the feet, with the tool along the patient's +x, to the left: the tube comes from the image's left.
#[test]
fn the_band_is_where_the_tube_is_and_the_path_where_it_goes() {
    let along_x = Rigid::from_axes(Point::new(0.0, 0.0, 0.0), Direction::X, Direction::Z).unwrap();
    let made = Made::of(1, along_x);
    let tube = made.drawn(palette::TUBE);
    // 100 mm on 512 pixels: the walls are 30.7 pixels above and below the middle, 255.5.
    let walls = tube
        .iter()
        .filter(|[x, y]| *x < 250 && ([224, 225, 286].contains(y) || *y == 285));
    assert!(walls.count() > 400);
    let between = tube.iter().filter(|[x, y]| *x < 240 && (230..280).contains(y)).count();
    assert_eq!(between, 0, "nothing lies over the tube's own inside");
    let beyond: Vec<_> = tube.iter().filter(|[x, _]| *x > 275).collect();
    // A line along the middle to the border, and ticks 51.2 pixels apart.
    assert!(beyond.iter().all(|[_, y]| (251..=260).contains(y)), "{beyond:?}");
    assert!(beyond.iter().any(|[x, _]| *x == 511));
    let rows = |x: usize| beyond.iter().filter(|p| p[0] == x).map(|p| p[1]).collect::<Vec<_>>();
    let ticks: Vec<usize> = (276..512).filter(|x| rows(*x).len() > 4).collect();
    for k in 1..5 {
        let at = 255.5 + 51.2 * f64::from(k);
        assert!(
            ticks.iter().any(|x| (*x as f64 - at).abs() <= 1.0),
            "tick {k} at {at}: {ticks:?}"
        );
    }
}

#[test]
fn without_a_valid_pose_there_is_no_tube_path_or_cut_and_the_plan_stays() {
    let level = Rigid::from_axes(Point::new(0.0, 0.0, 0.0), Direction::X, Direction::Z).unwrap();
    let mut made = Made::of(1, level);
    made.chosen = Some(chosen([30.0, 10.0, 1.0], Some([-30.0, -20.0, -2.0])));
    let counts = |made: &Made| {
        let cuts = made.with(|overlay| overlay.cut_lines().len());
        [made.drawn(palette::TUBE).len(), cuts, made.drawn(palette::TARGET).len()]
    };
    let [tube, cut, planned] = counts(&made);
    assert!(tube > 500 && cut == 3 && planned > 150, "{tube} {cut} {planned}");
    for notice in [Notice::Stale(1), Notice::Requested] {
        made.notice = notice;
        let [tube, cut, planned] = counts(&made);
        assert!(
            tube > 500 && cut == 3 && planned > 150,
            "{notice:?}: {tube} {cut} {planned}"
        );
    }
    made.notice = Notice::Lost(Lost::NotSeen, Some(1));
    let [tube, cut, planned] = counts(&made);
    assert!(tube == 0 && cut == 0 && planned > 100, "{tube} {cut} {planned}");
    // Whoever asks for a plane draws her plan over it.
    made.notice = Notice::Look;
    made.chosen.as_mut().unwrap().radius_mm = 0.1;
    let [tube, cut, planned] = counts(&made);
    assert!(tube == 0 && cut == 0 && planned < 100, "{tube} {cut} {planned}");
}

#[test]
fn the_bar_stands_where_the_tip_is_to_stop() {
    let level = Rigid::from_axes(Point::new(0.0, 40.0, 0.0), Direction::Y, Direction::Z).unwrap();
    let mut made = Made::of(1, level);
    // Along x in the plane; the tip is 40 mm away, in the image's middle.
    made.chosen = Some(Chosen {
        stop_mm: 20.0,
        ..chosen([30.0, 20.0, 0.0], Some([-40.0, 20.0, 0.0]))
    });
    let column = |x: f64| (255.5 + 5.12 * x).round() as usize;
    let row = 255.5 - 5.12 * 20.0;
    let drawn = made.drawn(palette::TARGET);
    let off = |x: usize| {
        drawn
            .iter()
            .filter(|p| p[0].abs_diff(x) <= 1 && (3.0..7.0).contains(&(p[1] as f64 - row).abs()))
            .count()
    };
    assert!(off(column(10.0)) >= 4, "{}", off(column(10.0)));
    for elsewhere in [0.0, 5.0, 15.0, 20.0] {
        assert_eq!(off(column(elsewhere)), 0, "{elsewhere}");
    }
}

#[test]
fn the_place_stands_on_the_image_where_a_slice_does() {
    let made = Made::of(1, pose([0.4, 0.3, 0.2], [1.0, 2.0, -7.25]));
    let texts = |overlay: &Overlay<'_>| {
        let placed = overlay.words().layout.placed;
        placed.into_iter().map(|word| word.text).collect::<Vec<_>>()
    };
    let with = made.with(texts);
    assert!(
        with.contains(&"z -7.3 mm I".to_owned()) || with.contains(&"z -7.2 mm I".to_owned()),
        "{with:?}"
    );
    assert!(with.contains(&"W 400 C 40, field 100 mm".to_owned()), "{with:?}");
    for name in ["fro", "sag", "perp"] {
        assert!(with.contains(&name.to_owned()), "{with:?}");
    }
    let without = made.with(|overlay| {
        texts(&Overlay {
            is_placed: false,
            ..*overlay
        })
    });
    assert!(!without.iter().any(|text| text.ends_with("mm I")), "{without:?}");
    assert_eq!(made.scene.views[made.view].extent, Extent::Local);
}

/// Words keep off the ruler's ticks at every size.
#[test]
fn no_word_stands_on_the_ruler() {
    for text in [0.5, 1.0, 2.0, 4.0] {
        let mut made = Made::of(1, pose([0.4, 0.3, 0.2], [1.0, 2.0, -7.25]));
        made.scene.views[1].text = text;
        made.with(|overlay| {
            for word in overlay.words().layout.placed {
                let covered = picture::text_box(word.at, &word.text, word.size, word.anchor).unwrap();
                assert!(
                    f64::from(covered.left) >= overlay.beside_words().min(8.0) - 1.0,
                    "{text}: {:?}",
                    word.text
                );
            }
        });
    }
}
