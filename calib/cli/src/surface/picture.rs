//! The points on the bone, from three sides: where the tool was, what fits, and what is left out.

use geometry::{Ct, Direction, Point, SlicePlane, letters};
use picture::palette::{ALARM, QUIET, TARGET, TUBE, WARN, WORDS};
use picture::{Anchor, Canvas, Line, Rgb, encode_png};
use surface::{Mesh, ZBuffer};
use surface_registration::Class;

use super::Made;

/// Pixels of a panel, and around it.
const PANEL: u32 = 440;
const GAP: u32 = 8;
const TITLE: u32 = 30;
const FOOT: u32 = 26;
/// The bone's part of a panel.
const FILL: f64 = 0.92;
/// A point that far behind the bone is hidden by it, mm: nearer, it lies on it.
const HIDDEN_MM: f64 = 4.0;
const BONE: [u8; 3] = [150, 146, 138];
const GROUND: [u8; 3] = [16, 18, 22];
/// Axes to the right and downwards: from the front, from the patient's left, from the feet.
const SIDES: [[Direction<Ct>; 2]; 3] = [
    [Direction::X, Direction::Z],
    [Direction::Y, Direction::Z],
    [Direction::X, Direction::Y],
];

/// The picture as PNG, `refused` being why the result is not accepted; in words why there is none.
pub(super) fn png(made: &Made<'_>, refused: Option<&str>) -> Result<Vec<u8>, String> {
    let bone = &made.bone;
    let corners = bone.corners.iter().map(|corner| corner.map(|mm| mm as f32)).collect();
    let mesh =
        Mesh::of_triangles(corners, bone.triangles.clone()).ok_or("a triangle names a corner that is not there")?;
    let width = 3 * PANEL + 4 * GAP;
    let mut canvas = Canvas::new(width, TITLE + PANEL + FOOT + GAP);
    canvas.fill(
        [0.0, 0.0],
        [f64::from(width), f64::from(TITLE + PANEL + FOOT + GAP)],
        Rgb(8, 8, 10),
        255,
    );
    title(&mut canvas, made, refused);
    for (place, axes) in (0_u32..).zip(SIDES) {
        let left = GAP + place * (PANEL + GAP);
        let camera = camera(made, axes).map_err(|error| error.to_string())?;
        panel(&mut canvas, [left, TITLE], &camera, &mesh, made);
    }
    legend(&mut canvas);
    encode_png(&canvas, &[]).map_err(|error| error.to_string())
}

/// One word above everything: a picture is looked at before its numbers are read.
fn title(canvas: &mut Canvas, made: &Made<'_>, refused: Option<&str>) {
    let (words, colour) = match (made.against().first(), refused) {
        (Some(first), _) => (format!("REFUSED: {first}"), ALARM),
        // By a scene's gates.
        (None, Some(refused)) => (format!("REFUSED: {refused}"), ALARM),
        (None, None) => {
            let tre = made.targets.iter().map(|target| made.found.predicted_tre_mm(*target));
            let worst = tre.fold(0.0, f64::max);
            (format!("error predicted at the targets: {worst:.2} mm rms"), WORDS)
        }
    };
    let words: String = words.chars().take(150).collect();
    canvas.text(
        [f64::from(GAP), f64::from(TITLE) / 2.0],
        &words,
        16.0,
        colour,
        Anchor::Left,
    );
}

/// All of the bone, seen along the cross product of two axes; z, where it is downwards, is turned so that the head is above.
fn camera(made: &Made<'_>, [right, down]: [Direction<Ct>; 2]) -> Result<SlicePlane, geometry::PlaneError> {
    let [low, high] = made.bone.surface.facts().bounds_mm;
    let centre = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let side = [0, 1, 2].map(|k| high[k] - low[k]).into_iter().fold(0.0, f64::max);
    let down = if down == Direction::Z { -Direction::Z } else { down };
    let [x, y, z] = centre;
    SlicePlane::centred(
        Point::new(x, y, z),
        [right, down],
        side / (FILL * f64::from(PANEL)),
        [PANEL; 2],
    )
}

fn panel(canvas: &mut Canvas, [left, top]: [u32; 2], camera: &SlicePlane, mesh: &Mesh, made: &Made<'_>) {
    let mut seen = ZBuffer::new([PANEL; 2]);
    seen.draw(mesh, camera, &[BONE]);
    let shade = seen.depths().iter().zip(seen.colours());
    let rgba: Vec<u8> = shade
        .flat_map(|(depth, colour)| {
            let [r, g, b] = if depth.is_finite() { *colour } else { GROUND };
            [r, g, b, 255]
        })
        .collect();
    canvas.paste(&rgba, PANEL, left, top);
    let at = |p: Point<Ct>| {
        let seen = camera.project(p);
        let inside = [seen.x, seen.y].iter().all(|c| (0.0..f64::from(PANEL)).contains(c));
        inside.then_some((seen, [f64::from(left) + seen.x, f64::from(top) + seen.y]))
    };
    for (point, result) in made.measured.points.points().iter().zip(&made.found.points) {
        let [x, y, z] = (made.found.transform.transform() * point.place).mm();
        let Some((flat, place)) = at(Point::new(x, y, z)) else {
            continue;
        };
        let before = seen.depths()[flat.y as usize * PANEL as usize + flat.x as usize];
        let is_hidden = flat.depth_mm > f64::from(before) + HIDDEN_MM;
        mark(canvas, place, result.class, result.deviations, is_hidden);
    }
    for target in &made.targets {
        let [x, y, z] = target.mm();
        if let Some((_, [x, y])) = at(Point::new(x, y, z)) {
            let line = Line::solid(TARGET, 2.0);
            canvas.line([x - 7.0, y], [x + 7.0, y], line);
            canvas.line([x, y - 7.0], [x, y + 7.0], line);
        }
    }
    frame(canvas, [left, top], camera);
}

/// A point that has a say is a dot, the warmer the further it is from the bone; one that is left out is a cross.
fn mark(canvas: &mut Canvas, [x, y]: [f64; 2], class: Class, deviations: f64, is_hidden: bool) {
    let (colour, size) = match class {
        Class::Kept => (colour(deviations), 2.5),
        _ => (ALARM, 3.5),
    };
    let width = if is_hidden { 0.6 } else { 1.8 };
    let line = Line::solid(colour, width);
    if class == Class::Kept {
        canvas.circle([x, y], if is_hidden { 1.5 } else { size }, line);
    } else {
        canvas.line([x - size, y - size], [x + size, y + size], line);
        canvas.line([x - size, y + size], [x + size, y - size], line);
    }
}

fn colour(deviations: f64) -> Rgb {
    match deviations.abs() {
        d if d <= 1.0 => WORDS,
        d if d <= 2.0 => TUBE,
        _ => WARN,
    }
}

/// Which way the patient lies, and how large things are.
fn frame(canvas: &mut Canvas, [left, top]: [u32; 2], camera: &SlicePlane) {
    let (left, top, size) = (f64::from(left), f64::from(top), f64::from(PANEL));
    let middle = size / 2.0;
    let sides = [
        (-camera.right(), [left + 10.0, top + middle]),
        (camera.right(), [left + size - 10.0, top + middle]),
        (-camera.down(), [left + middle, top + 12.0]),
        (camera.down(), [left + middle, top + size - 12.0]),
    ];
    for (towards, at) in sides {
        canvas.text(at, &letters(towards), 15.0, QUIET, Anchor::Centre);
    }
    let bar = 50.0 / camera.pixel_mm();
    let (x, y) = (left + 12.0, top + size - 14.0);
    canvas.line([x, y], [x + bar, y], Line::solid(QUIET, 2.0));
    canvas.text([x, y - 10.0], "50 mm", 12.0, QUIET, Anchor::Left);
}

fn legend(canvas: &mut Canvas) {
    let y = f64::from(TITLE + PANEL + FOOT / 2 + GAP / 2);
    let mut x = f64::from(GAP) + 6.0;
    for (deviations, words) in [(0.5, "within 1 deviation"), (1.5, "within 2"), (3.0, "beyond 2")] {
        mark(canvas, [x, y], Class::Kept, deviations, false);
        canvas.text([x + 10.0, y], words, 13.0, QUIET, Anchor::Left);
        x += 160.0;
    }
    mark(canvas, [x, y], Class::InFront, 9.0, false);
    canvas.text([x + 10.0, y], "left out", 13.0, QUIET, Anchor::Left);
    mark(canvas, [x + 120.0, y], Class::Kept, 0.5, true);
    canvas.text([x + 130.0, y], "thin: behind the bone", 13.0, QUIET, Anchor::Left);
    canvas.text([x + 320.0, y], "+  target", 13.0, TARGET, Anchor::Left);
}
