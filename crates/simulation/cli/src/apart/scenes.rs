//! Seeded scenes of needles, bars, rings and strips that may touch themselves: the text of each, and its boundaries by formulas of their own.

use std::f64::consts::TAU;

use super::oracle::Contour;

/// Numbers in (0, 1), the same each time.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    pub(super) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// A number of any size between two, of either sign.
    pub(super) fn small(&mut self, low: f64, high: f64) -> f64 {
        let size = low * (high / low).powf(self.next());
        if self.next() < 0.5 { -size } else { size }
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }
}

/// A solid: what a scene says of it, and its boundary, in closed contours.
#[derive(Debug, Clone)]
pub(super) struct Made {
    /// The shape's key and value.
    pub(super) shape: String,
    pub(super) rigid: bool,
    pub(super) contours: Vec<Contour>,
    /// Two parts of it far from one another along it, of which a strip is told to run through itself.
    pub(super) ends: Option<[Contour; 2]>,
}

type Point = [f64; 2];

fn middle(a: Point, b: Point) -> Point {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

fn list(points: &[Point]) -> String {
    format!("{points:?}")
}

/// Arcs through every second of the points, closed.
fn closed(points: &[Point]) -> Contour {
    let n = points.len();
    (0..n / 2)
        .map(|k| [points[2 * k], points[2 * k + 1], points[(2 * k + 2) % n]])
        .collect()
}

/// Corners, counter-clockwise.
pub(super) fn polygon(corners: &[Point]) -> Made {
    let n = corners.len();
    let side = |k: usize| {
        [
            corners[k],
            middle(corners[k], corners[(k + 1) % n]),
            corners[(k + 1) % n],
        ]
    };
    Made {
        shape: format!("polygon = {{ vertices = {} }}", list(corners)),
        rigid: true,
        contours: vec![(0..n).map(side).collect()],
        ends: None,
    }
}

/// A rectangle about a centre, turned.
pub(super) fn bar(centre: Point, half: Point, angle: f64) -> Made {
    let (sin, cos) = angle.sin_cos();
    let corner = |x: f64, y: f64| [centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y];
    let [a, b] = half;
    polygon(&[corner(-a, -b), corner(a, -b), corner(a, b), corner(-a, b)])
}

/// The rounded solid of docs/simulate.md.
pub(super) fn organ(centre: Point, half: Point, angle: f64, elements: [usize; 2]) -> Made {
    let (sin, cos) = angle.sin_cos();
    let place = |xi: f64, eta: f64| {
        let x = half[0] * xi * (1.0 - 0.4 * eta * eta).sqrt();
        let y = half[1] * eta * (1.0 - 0.4 * xi * xi).sqrt();
        [centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y]
    };
    let mut points = Vec::new();
    for side in 0..4 {
        let count = 2 * elements[side % 2];
        for k in 0..count {
            let t = 2.0 * k as f64 / count as f64 - 1.0;
            let [xi, eta] = [[t, -1.0], [1.0, t], [-t, 1.0], [-1.0, -t]][side];
            points.push(place(xi, eta));
        }
    }
    Made {
        shape: format!(
            "rounded = {{ centre = {centre:?}, half_axes = {half:?}, turned = {angle:?}, elements = {elements:?} }}"
        ),
        rigid: false,
        contours: vec![closed(&points)],
        ends: None,
    }
}

/// A ring of `n` elements.
pub(super) fn ring(centre: Point, radii: [f64; 2], n: usize) -> Made {
    let circle = |radius: f64| -> Contour {
        let at = |i: usize| {
            let angle = -TAU * (i as f64 / (2 * n) as f64) - 0.25 * TAU;
            [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
        };
        closed(&(0..2 * n).map(at).collect::<Vec<_>>())
    };
    Made {
        shape: format!("ring = {{ centre = {centre:?}, radii = {radii:?}, elements = [{n}, 1] }}"),
        rigid: false,
        contours: radii.map(circle).to_vec(),
        ends: None,
    }
}

/// A strip of `n` elements along a spiral: from radius 1 to `1 + rise` over `turn` radians, of some thickness.
pub(super) fn strip([turn, rise, thick]: [f64; 3], n: usize) -> Made {
    let columns = 2 * n + 1;
    let at = |i: usize, j: usize| {
        let part = i as f64 / (columns - 1) as f64;
        let radius = 1.0 + rise * part + thick * j as f64 / 2.0;
        // Clockwise, so that outwards lies on the left of the way.
        [radius * (-turn * part).cos(), radius * (-turn * part).sin()]
    };
    let nodes: Vec<Point> = (0..3).flat_map(|j| (0..columns).map(move |i| at(i, j))).collect();
    let element = |e: usize| -> String {
        let each = (0..9).map(|k| (2 * e + k % 3 + (k / 3) * columns).to_string());
        format!("[{}]", each.collect::<Vec<_>>().join(", "))
    };
    let elements: Vec<String> = (0..n).map(element).collect();
    let part = |from: usize, to: usize| -> Contour {
        let (first, last) = (2 * from, 2 * to);
        let mut points: Vec<Point> = (first..last).map(|i| at(i, 0)).collect();
        points.extend([at(last, 0), at(last, 1)]);
        points.extend((first + 1..=last).rev().map(|i| at(i, 2)));
        points.extend([at(first, 2), at(first, 1)]);
        closed(&points)
    };
    Made {
        shape: format!(
            "mesh = {{ nodes = {}, elements = [{}] }}",
            list(&nodes),
            elements.join(", ")
        ),
        rigid: false,
        contours: vec![part(0, n)],
        ends: Some([part(0, 2 * n / 5), part(n - 2 * n / 5, n)]),
    }
}

/// The scene of some solids; `more` is added to the lines of each.
pub(super) fn text(solids: &[Made], contact: &str, more: &dyn Fn(usize) -> String) -> String {
    let mut text = String::from(
        "title = \"made\"\nunits = { length = \"mm\", stress = \"kPa\" }\n\
         materials = [{ name = \"m\", law = \"neo-hookean\", young = 1.0, poisson = 0.3 }]\n",
    );
    for (k, solid) in solids.iter().enumerate() {
        let material = if solid.rigid { "" } else { "material = \"m\"\n" };
        let more = more(k);
        text += &format!("[[solids]]\nname = \"s{k}\"\n{material}{}\n{more}\n", solid.shape);
    }
    text + contact
}

/// The point of arcs farthest along a direction, and how far: each arc's height is quadratic.
fn support(contours: &[Contour], way: Point) -> (Point, f64) {
    let mut best = ([0.0; 2], f64::NEG_INFINITY);
    for [a, b, c] in contours.iter().flatten() {
        let height = |p: Point| way[0] * p[0] + way[1] * p[1];
        let [low, mid, high] = [a, b, c].map(|p| height(*p));
        let (slope, bend) = (0.5 * (high - low), high + low - 2.0 * mid);
        for u in [-1.0, 1.0, (-slope / bend).clamp(-1.0, 1.0)]
            .into_iter()
            .filter(|u| u.is_finite())
        {
            let at = |k: usize| 0.5 * u * (u - 1.0) * a[k] + (1.0 - u * u) * b[k] + 0.5 * u * (u + 1.0) * c[k];
            let p = [at(0), at(1)];
            if height(p) > best.1 {
                best = (p, height(p));
            }
        }
    }
    best
}

/// A bar whose long side is tangent to what is there, but for a gap.
fn facing(random: &mut Random, other: &Made, gap: f64) -> Made {
    let angle = random.between(0.0, TAU);
    let way = [angle.cos(), angle.sin()];
    let (point, _) = support(&other.contours, way);
    let (long, thin) = (random.between(0.2, 2.0), random.small(1e-2, 0.3).abs());
    let along = random.between(-0.8, 0.8) * long;
    let off = gap + thin;
    let centre = [
        point[0] + way[0] * off - way[1] * along,
        point[1] + way[1] * off + way[0] * along,
    ];
    bar(centre, [thin, long], angle)
}

fn some(random: &mut Random, centre: Point) -> Made {
    let half = [random.between(0.3, 1.0), random.between(0.3, 1.0)];
    let (angle, n) = (random.between(0.0, TAU), 1 + random.below(3));
    match random.below(4) {
        0 => bar(centre, half, angle),
        1 => ring(centre, [0.7 * half[0], half[0]], 3 + random.below(6)),
        _ => organ(centre, half, angle, [n, n]),
    }
}

/// A needle: long, and as thin as can be.
fn needle(random: &mut Random) -> Made {
    let centre = [random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
    let half = [random.between(0.2, 6.0), random.small(1e-6, 0.05).abs()];
    bar(centre, half, random.between(0.0, TAU))
}

/// Scene number `k`: solids of size about 1 about the origin.
pub(super) fn solids(random: &mut Random) -> Vec<Made> {
    let place = |random: &mut Random, far: f64| [random.between(-far, far), random.between(-far, far)];
    match random.below(6) {
        0 => vec![some(random, [0.0, 0.0]), needle(random)],
        1 => {
            let other = some(random, [0.0, 0.0]);
            let gap = random.small(1e-9, 0.1);
            vec![facing(random, &other, gap), other]
        }
        2 => {
            // In a ring, near its hole's edge, through it, or round it.
            let (outer, n) = (random.between(1.0, 2.0), 3 + random.below(12));
            let hole = ring([0.0, 0.0], [0.8 * outer, outer], n);
            let at = place(random, 0.7);
            vec![hole, some(random, at)]
        }
        3 => {
            // A ring in a ring, a hair from touching: the same angles, so that arcs run along one another.
            let (n, gap) = (3 + random.below(12), random.small(1e-9, 0.1));
            vec![ring([0.0, 0.0], [1.0, 1.2], n), ring([0.0, 0.0], [0.7, 1.0 - gap], n)]
        }
        4 => {
            let at = place(random, 1.6);
            vec![some(random, [0.0, 0.0]), some(random, at)]
        }
        _ => {
            let (thick, gap) = (random.between(0.05, 0.3), random.small(1e-9, 0.3));
            let turn = random.between(0.9, 1.1) * TAU;
            // At full turns the end stands over the beginning.
            let rise = if turn > TAU { (thick + gap) * turn / TAU } else { gap };
            vec![strip([turn, rise, thick], 10 + random.below(6))]
        }
    }
}
